"""Snapshots of the whole scene at regular ticks and at every collision, woven into the stream of events."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import floor, inf

import numpy as np

from .chain import parents_first
from .events import Collision, Event, Nearness, Phase, Snapshot, Verdict, Wakeup
from .extent import body_extent
from .pair import Pair
from .rotation import FloatArray, mapped
from .scene import Body, Scene
from .vector import ZERO


class Observer:
    """Takes snapshots: every body's pose, and the nearest pairs, exactly measured at that instant."""

    def __init__(self, scene: Scene, pairs: Sequence[Pair], most_pairs: int) -> None:
        """Observe the scene's pairs; a snapshot names at most `most_pairs` >= 1 of them."""
        self._bodies = scene.bodies
        self._order = parents_first(scene.bodies)
        self._pairs = pairs
        self._most_pairs = most_pairs
        balls = [body_extent(body).ball if body.shapes else None for body in scene.bodies]
        self._centres = [ball.centre if ball else ZERO for ball in balls]
        radii = np.array([ball.radius if ball else 0.0 for ball in balls])
        self._first = np.array([pair.key.a for pair in pairs], dtype=np.int64)
        self._second = np.array([pair.key.b for pair in pairs], dtype=np.int64)
        self._radii = radii[self._first] + radii[self._second]
        self._starts = np.array([pair.start for pair in pairs])
        self._ends = np.array([pair.end for pair in pairs])
        self._possible = np.array([pair.possible for pair in pairs], dtype=bool)

    def at(self, time: float, touching: frozenset[int], occasion: Collision | None = None) -> Snapshot:
        """Return the snapshot at `time` (s), while the pairs with ids in `touching` are in contact."""
        poses = world_poses(self._bodies, self._order, time)
        nearest = tuple(self._nearest(time, poses, touching))
        return Snapshot(time, poses, nearest, len(touching), occasion)

    def _nearest(self, time: float, poses: FloatArray, touching: frozenset[int]) -> list[Nearness]:
        """Measure pairs in order of their bounding balls' gap until no other can be among the nearest."""
        centres = np.array([mapped(pose, centre) for pose, centre in zip(poses, self._centres, strict=True)])
        gaps = np.linalg.norm(centres[self._first] - centres[self._second], axis=1) - self._radii
        gaps[self._possible] = -inf  # the ball that stands for an unknown place may be nearer than the body drawn
        gaps[(time < self._starts) | (time > self._ends)] = inf
        found: list[Nearness] = []
        for index in np.argsort(gaps, kind="stable"):
            if gaps[index] == inf:
                break
            if len(found) >= self._most_pairs and gaps[index] > found[-1].distance:
                break
            pair = self._pairs[index]
            found.append(_nearness(pair, time, pair.key.id in touching))
            found.sort(key=lambda near: (near.distance, near.pair.id))
            del found[self._most_pairs :]
        return found


def observed(
    events: Iterable[Event], observer: Observer, scene: Scene, rate: float, time_resolution: float
) -> Iterator[Event]:
    """Yield the events with snapshots between them: at start, every 1/rate s, at the end, and at each collision.

    A tick is taken once every pair is decided up to it: no wakeup goes back by more than one time resolution.

    Args:
        events: of `run`.
        observer: of the same scene.
        scene: whose times bound the ticks.
        rate: 1/s; 0 leaves collisions alone.
        time_resolution: s, of the run.
    """
    touching: set[int] = set()
    ticks = tick_times(scene.start, scene.end, rate)
    tick = next(ticks, None)
    for event in events:
        if isinstance(event, Wakeup):
            while tick is not None and tick < event.time - time_resolution:
                yield observer.at(tick, frozenset(touching))
                tick = next(ticks, None)
        yield event
        if isinstance(event, Collision):
            touching.add(event.pair.id)  # at either end of a contact, at its own time, the pair touches
            yield observer.at(event.time, frozenset(touching), event)
            if event.phase is Phase.END:
                touching.discard(event.pair.id)
    while tick is not None:
        yield observer.at(tick, frozenset(touching))
        tick = next(ticks, None)


def tick_times(start: float, end: float, rate: float) -> Iterator[float]:
    """Yield start, start + 1/rate, ... and the end, s; nothing for rate 0."""
    if rate <= 0.0:
        return
    for index in range(floor((end - start) * rate * (1.0 - 1e-12)) + 1):
        yield start + index / rate
    yield end


def world_poses(bodies: tuple[Body, ...], order: Sequence[int], time: float) -> FloatArray:
    """Return world_from_body of every body, (n, 4, 4); `order` names parents before their children."""
    poses = np.empty((len(bodies), 4, 4))
    for index in order:
        body = bodies[index]
        local = body.pose @ body.motion.pose(time)
        poses[index] = local if body.parent is None else poses[body.parent] @ local
    return poses


def _nearness(pair: Pair, time: float, touching: bool) -> Nearness:
    """Measure a pair exactly; one known to be in contact reads 0 even where its surfaces are apart."""
    told = pair.distance(pair.measure_exactly(time))
    assert told is not None
    if pair.possible:
        verdict = Verdict.POSSIBLE if told.distance <= pair.margin else Verdict.CLEAR
        return Nearness(pair.key, told.distance, verdict, told.witness_a, told.witness_b)
    if touching or told.distance == 0.0:
        return Nearness(pair.key, 0.0, Verdict.CONTACT, told.witness_a, told.witness_b)
    verdict = Verdict.BREACH if told.distance < pair.margin else Verdict.CLEAR
    return Nearness(pair.key, told.distance, verdict, told.witness_a, told.witness_b)
