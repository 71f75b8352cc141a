"""What processes that share a run cost and save: rocks of 1,280 triangles, by one process and by several.

`python -m benchmarks.jobs [JOBS [BODIES [SECONDS]]]` runs `closecall run` with `--log certificate`, and with its
default options, by one process and by JOBS, and compares the bytes. CPU is that of all processes. The serial part is
the CPU time of the process that reads the scene, merges what others tell and writes, as a share of what one process
takes for all.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from subprocess import run
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

from .command import PLAIN
from .rocks import Rocks
from .table import Row

MOST_CPU = 1.2
MOST_SERIAL = 0.1

_CHILD = """\
import atexit, json, resource
def tell():
    usages = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    print(json.dumps([usage.ru_utime + usage.ru_stime for usage in usages]))
atexit.register(tell)
"""


class Cost(NamedTuple):
    """CPU seconds of the process itself and of its children, wall-clock seconds, and the log."""

    own: float
    children: float
    wall: float
    log: bytes

    @property
    def cpu(self) -> float:
        """CPU seconds of all processes."""
        return self.own + self.children


def cost(scene: Path, jobs: int, kind: str) -> Cost:
    """Run the command in a child of its own."""
    log = scene.with_name("out.mcap")
    options = ["run", str(scene), "-o", str(log), "-q", "--jobs", str(jobs), "--log", kind]
    began = perf_counter()
    done = run([sys.executable, "-c", _CHILD + PLAIN, *options], capture_output=True, text=True, check=True)
    wall = perf_counter() - began
    own, children = json.loads(done.stdout)
    return Cost(own, children, wall, log.read_bytes())


def rows(jobs: int, bodies: int, seconds: float) -> Iterator[Row]:
    """Yield CPU and serial part for each kind of log."""
    with TemporaryDirectory() as name:
        scene = Rocks(bodies).write(Path(name), seconds)
        for kind in ("certificate", "full"):
            alone, shared = cost(scene, 1, kind), cost(scene, jobs, kind)
            case = f"`--jobs {jobs} --log {kind}`, {bodies} rocks, {seconds:g} s"
            same = alone.log == shared.log
            took = f"{'the same bytes' if same else 'OTHER BYTES'}, {alone.cpu:.1f} s CPU and {shared.cpu:.1f} s"
            took += f", {alone.wall:.1f} s wall and {shared.wall:.1f} s"
            times, serial = shared.cpu / alone.cpu, shared.own / alone.cpu
            yield Row(case, f"{times:.2f} times; {took}", f"at most {MOST_CPU}", same and times <= MOST_CPU)
            yield Row(
                f"its serial part, {shared.own:.1f} s",
                f"{serial:.1%}",
                f"at most {MOST_SERIAL:.0%}",
                serial <= MOST_SERIAL,
            )


if __name__ == "__main__":
    kinds = (int, int, float)
    given = [kind(text) for kind, text in zip(kinds, sys.argv[1:], strict=False)]
    for row in rows(*[*given, *(2, 44, 30.0)[len(given) :]]):
        print(row.markdown(), flush=True)
