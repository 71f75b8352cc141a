"""Exact queries against the greedy ideal, for pairs of 40 bumpy bodies that never touch.

The ideal measures a pair exactly, and sleeps for as long as the true displacement of all vertices relative to each
other stays below that distance, but at least for the time resolution. No bound on displacement can sleep longer; one
that looks at directions can. The displacement is sampled densely, which takes long, so that only some pairs are tried.

`python -m benchmarks.ideal [BODIES [SECONDS [PAIRS]]]` prints how many times more often the scheduler measures exactly,
and beside it what the search for least distances and the pictures for viewers add. Pairs that bounding spheres settle
throughout are left out: there the scheduler needs no exact query at all.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import fcl
import numpy as np

from closecall.cli.application.rate import snapshot_rate
from closecall.formats.scene.reader import read_scene
from closecall.scheduler.model.events import Level, Reason, Span, Verdict, Wakeup
from closecall.scheduler.model.scene import Body
from closecall.scheduler.narrow.closest_points import ClosestPoints
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import PairFactory
from closecall.scheduler.run import run
from closecall.scheduler.snapshots.schedule import observed, snapshot_times
from closecall.scheduler.snapshots.snapshot import Observer

from .peers import STEP, fcl_model
from .rocks import Rocks
from .table import Row

#: s: how densely displacements are sampled before the end of a sleep is found by halving.
SPACING = 0.02
#: Pairs of a picture, the default of `--viz-pairs`.
VIZ_PAIRS = 10
#: Of the ideal's exact queries, how many the scheduler may take.
MOST = 1.5

Key = tuple[int, int]


class CountingPhase(NarrowPhase):
    """A narrow phase that counts what is asked of it."""

    def __init__(self, bodies: tuple[Body, ...]) -> None:
        """Begin at 0."""
        super().__init__(bodies)
        self.queries = 0

    def nearest(self, a: int, b: int, pose_a: np.ndarray, pose_b: np.ndarray) -> ClosestPoints:
        """Measure, and count it."""
        self.queries += 1
        return super().nearest(a, b, pose_a, pose_b)


@dataclass(frozen=True, slots=True)
class Queries:
    """A run's exact queries: of each pair by the scheduler and by the search, and of all pictures; what is clear."""

    scheduled: Counter[Key]
    searched: Counter[Key]
    pictured: int
    clear: set[Key]


def counted(rocks: Rocks, seconds: float) -> Queries:
    """Run the rocks with default settings and count."""
    with TemporaryDirectory() as name:
        loaded = read_scene(rocks.write(Path(name), seconds))
    scene, settings = loaded.scene, loaded.settings
    narrow_phase, camera = NarrowPhase(scene.bodies), CountingPhase(scene.bodies)
    pairs = tuple(PairFactory(scene, narrow_phase, settings.margin).all())
    scheduled: Counter[Key] = Counter()
    searched: Counter[Key] = Counter()
    clear = {(pair.key.a, pair.key.b) for pair in pairs}
    observer = Observer(scene, pairs, VIZ_PAIRS, camera)
    times = snapshot_times(scene, snapshot_rate(seconds, None))
    for event in observed(run(pairs, settings, None), observer, times, settings.time_resolution):
        if isinstance(event, Wakeup) and event.level is Level.MESH:
            counts = searched if event.reason is Reason.MINIMUM else scheduled
            counts[event.pair.a, event.pair.b] += 1
        elif isinstance(event, Span) and event.verdict is not Verdict.CLEAR:
            clear.discard((event.pair.a, event.pair.b))
    return Queries(scheduled, searched, camera.queries, clear)


def ideal(rocks: Rocks, a: int, b: int, seconds: float) -> int:
    """Return how many exact queries the ideal takes of a pair that never touches."""
    model = fcl_model(rocks)
    objects = [fcl.CollisionObject(model, fcl.Transform()) for _ in range(2)]
    vertices = np.asarray(rocks.mesh.convex_hull.vertices)
    time, queries = 0.0, 0

    def placed(at: float) -> tuple[np.ndarray, np.ndarray]:
        poses = rocks.poses(at)[[a, b]]
        one, other = (vertices @ pose[:3, :3].T + pose[:3, 3] for pose in poses)
        return one, other

    while time < seconds:
        for thing, pose in zip(objects, rocks.poses(time)[[a, b]], strict=True):
            thing.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
        distance = fcl.distance(*objects, fcl.DistanceRequest(), fcl.DistanceResult())
        queries += 1
        start = placed(time)

        def moved(at: float, start: tuple[np.ndarray, np.ndarray] = start) -> float:
            one, other = (now - then for now, then in zip(placed(at), start, strict=True))
            squares = (one**2).sum(axis=1)[:, None] + (other**2).sum(axis=1) - 2.0 * one @ other.T
            return float(np.sqrt(max(0.0, squares.max())))

        low = high = time
        while high < seconds and moved(high) < distance:
            low, high = high, high + SPACING
        while high - low > 1e-6:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if moved(middle) < distance else (low, middle)
        time = max(low, time + STEP)
    return queries


def rows(count: int, seconds: float, most: int) -> Iterator[Row]:
    """Yield the rows of the table: of `most` pairs at most, evenly chosen, the exact queries over the ideal's."""
    rocks = Rocks(count)
    queries = counted(rocks, seconds)
    near = sorted(pair for pair in queries.clear if queries.scheduled[pair])
    chosen = near[:: -(-len(near) // most) or 1]
    ideals = sum(ideal(rocks, a, b, seconds) for a, b in chosen)
    ours = sum(queries.scheduled[pair] for pair in chosen)
    searched = sum(queries.searched[pair] for pair in chosen)
    case = f"exact queries of {len(chosen)} clear pairs of {count} rocks, {seconds:g} s"
    ratio = ours / max(1, ideals)
    measured = f"{ours} of the scheduler, {ideals} of the ideal: {ratio:.2f} times"
    yield Row(f"{case}, against the greedy ideal", measured, f"{MOST} times at most", ratio <= MOST)
    total, minima = sum(queries.scheduled.values()), sum(queries.searched.values())
    yield Row(f"{case}: for their least distances besides", str(searched))
    yield Row(
        "exact queries of all pairs", f"{total} of the scheduler, {minima} for minima, {queries.pictured} of pictures"
    )


if __name__ == "__main__":
    kinds = (int, float, int)
    given = [kind(text) for kind, text in zip(kinds, sys.argv[1:], strict=False)]
    for row in rows(*given, *(40, 5.0, 100)[len(given) :]):
        print(row.markdown())
