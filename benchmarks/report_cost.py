"""What a report costs: of a log of a million messages, of 142 bodies and all their 10,011 pairs, for 5 s.

`python -m benchmarks.report_cost [FOLDER]` prints the messages, the CPU seconds and the memory that the page takes, and
its size; log and page are kept in FOLDER. The facts are made up here, and prove nothing: it is the page alone that is
measured.
"""

from __future__ import annotations

import resource
import sys
from collections.abc import Iterator
from itertools import chain, combinations, pairwise
from math import pi, sin
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from benchmarks.viewer_cost import SECONDS, scene_of, snapshots
from closecall.formats.log.viewer.viewer import ViewerOptions
from closecall.formats.log.writer import LogOptions, LogWriter
from closecall.formats.report.gathering import gather
from closecall.formats.report.page import page
from closecall.formats.scene.loaded import LoadedScene
from closecall.scheduler.model.events import (
    Bound,
    Collision,
    ContactKind,
    Distance,
    Event,
    Feature,
    FeatureKind,
    Level,
    PairKey,
    Phase,
    Reason,
    Span,
    Verdict,
    Wakeup,
)
from closecall.scheduler.model.scene import Settings

BODIES = 142
LOOKS = 48
"""Wakeups of a pair, each with an exact distance."""

_BRACKET = 5e-7
_FEATURE = Feature(FeatureKind.VERTEX, 0, 0, 0)


def facts(key: PairKey, rng: np.random.Generator) -> Iterator[Event]:
    """Yield what might have been found of a pair: it swings, and one in fifty touches."""
    middle, period = float(rng.uniform(1.5, 60.0)), float(rng.uniform(0.5, 5.0))
    touches = key.id % 50 == 0
    times = np.linspace(0.0, SECONDS, LOOKS)
    for time in times.tolist():
        distance = middle + sin(2.0 * pi * time / period)
        yield Wakeup(time, key, Reason.TIME_BOUND, Level.MESH, Bound.DISPLACEMENT, distance, SECONDS / LOOKS)
        yield Distance(time, key, distance, (0.0, 0.0, 0.0), (distance, 0.0, 0.0), _FEATURE, _FEATURE)
    cuts = times[:: LOOKS // 9].tolist()
    for index, (start, end) in enumerate(pairwise(cuts)):
        if touches and index == 4:
            for phase, at in ((Phase.BEGIN, start), (Phase.END, end)):
                clear = at + (_BRACKET if phase is Phase.END else -_BRACKET)
                yield Collision(key, phase, clear, at, ContactKind.SURFACE, _FEATURE, _FEATURE, (0.0, 0.0, 0.0))
            yield Span(key, Verdict.CONTACT, start, end, 0.0, float("nan"))
        else:
            yield Span(key, Verdict.CLEAR, start, end, middle - 1.0, 0.0)


def write_log(path: Path, bodies: int = BODIES) -> int:
    """Write a log of made-up facts; return how many messages it has."""
    scene = scene_of(bodies)
    source = path.with_suffix(".yaml")
    source.write_bytes(b"closecall: 1\n")
    loaded = LoadedScene(source, source.read_bytes(), scene, Settings(), (), ())
    pairs = [PairKey(index, a, b) for index, (a, b) in enumerate(combinations(range(bodies), 2))]
    rng = np.random.default_rng(1)
    count = 0
    with LogWriter(path, loaded, Settings(), len(pairs), LogOptions(viewer=ViewerOptions())) as log:
        for event in chain(snapshots(scene, 30.0), *(facts(key, rng) for key in pairs)):
            log.write(event)
            count += 1
    return count


def measure(folder: Path) -> None:
    """Write a log and its page into a folder, and print what they are and take."""
    log, target = folder / "million.mcap", folder / "million.html"
    count = write_log(log)
    began = process_time()
    data = page(gather(log)).encode()
    taken = process_time() - began
    target.write_bytes(data)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(f"{count} messages, {log.stat().st_size / 1e6:.1f} MB: a page of {len(data) / 1e6:.1f} MB", end=" ")
    print(f"in {taken:.1f} s of CPU time, {memory:.0f} MB of memory with the making of the log")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        measure(Path(sys.argv[1]))
    else:
        with TemporaryDirectory() as scratch:
            measure(Path(scratch))
