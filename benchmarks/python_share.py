"""Python per wakeup outside fcl and numpy: 40 bumpy bodies for 5 s, scheduled with default settings.

`python -m benchmarks.python_share [BODIES [SECONDS]]` takes the CPU time from each wakeup to the next, less what FCL
took of it, and prints the median. That still holds numpy's kernels. So py-spy samples the same in a child, native
frames and all: a sample whose innermost Python frame has called into a library (numpy, BLAS, FCL) is the library's. The
median times Python's share of the samples outside FCL is what is asked for, if that share is everywhere the same.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from subprocess import DEVNULL, run
from tempfile import TemporaryDirectory
from time import thread_time

from closecall.formats.scene.reader import read_scene
from closecall.scheduler.model.events import Wakeup
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import PairFactory
from closecall.scheduler.run import run as scheduled

from .rocks import Rocks
from .table import Row

#: s.
MOST = 60e-6
#: Hz, of py-spy.
RATE = 250
SCHEDULED = "scheduler/run.py"
LIBRARIES = ("numpy", "blas", "fcl")


def between_wakeups(count: int, seconds: float) -> list[float]:
    """Return the CPU seconds from each wakeup to the next, without FCL's."""
    with TemporaryDirectory() as name:
        loaded = read_scene(Rocks(count).write(Path(name), seconds))
    narrow_phase = NarrowPhase(loaded.scene.bodies)
    pairs = tuple(PairFactory(loaded.scene, narrow_phase, loaded.settings.margin).all())
    found: list[float] = []
    began, measuring = thread_time(), narrow_phase.seconds
    for event in scheduled(pairs, loaded.settings, None):
        if isinstance(event, Wakeup):
            found.append(thread_time() - began - (narrow_phase.seconds - measuring))
            began, measuring = thread_time(), narrow_phase.seconds
    return found


def python_share(count: int, seconds: float) -> float | None:
    """Return the share of Python in the scheduler's samples outside FCL; None where py-spy is not to be had."""
    spy = shutil.which("py-spy", path=f"{Path(sys.executable).parent}") or shutil.which("py-spy")
    if spy is None:
        return None
    with TemporaryDirectory() as name:
        samples = Path(name) / "samples"
        sampler = [spy, "record", "--native", "--format", "raw", "--rate", str(RATE), "--output", str(samples), "--"]
        child = [sys.executable, "-m", "benchmarks.python_share", str(count), str(seconds), "alone"]
        if run([*sampler, *child], stdout=DEVNULL, stderr=DEVNULL, check=False).returncode:
            return None
        counts = {"python": 0, "library": 0, "fcl": 0}
        for line in samples.read_text().splitlines():
            stack, _, times = line.rpartition(" ")
            if SCHEDULED in stack:
                counts[_whose(stack)] += int(times)
    return counts["python"] / max(1, counts["python"] + counts["library"])


def _whose(stack: str) -> str:
    """Return whose a sample is, of frames from the outermost to the innermost, parted by `;`."""
    frames = stack.split(";")
    innermost = max(index for index, frame in enumerate(frames) if ".py:" in frame)
    called = " ".join(frames[innermost + 1 :])
    if "fcl" in called:
        return "fcl"
    return "library" if any(library in called for library in LIBRARIES) else "python"


def rows(count: int, seconds: float) -> Iterator[Row]:
    """Yield the rows of the table."""
    found = between_wakeups(count, seconds)
    case = f"CPU per wakeup outside FCL, {count} rocks, {len(found)} wakeups"
    middle, mean = median(found), sum(found) / len(found)
    yield Row(f"{case}: numpy and Python", f"median {1e6 * middle:.0f} us, mean {1e6 * mean:.0f} us")
    share = python_share(count, seconds)
    if share is None:
        yield Row(f"{case}: Python", "py-spy is not installed", f"median {1e6 * MOST:.0f} us at most")
    else:
        measured = f"{share:.0%} of the samples: median {1e6 * share * middle:.0f} us"
        yield Row(f"{case}: Python", measured, f"median {1e6 * MOST:.0f} us at most", share * middle <= MOST)


if __name__ == "__main__":
    kinds = (int, float)
    size, duration = (kind(text) for kind, text in zip(kinds, sys.argv[1:] or ("40", "5"), strict=False))
    if sys.argv[3:] == ["alone"]:
        between_wakeups(int(size), duration)
    else:
        for row in rows(int(size), duration):
            print(row.markdown())
