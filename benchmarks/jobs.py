"""What processes that share a run cost and save: bumpy bodies of 1,280 triangles, by one process and by several.

`python -m benchmarks.jobs [JOBS [BODIES [SECONDS]]]` (2, 44 and 20 if not given) runs `closecall run` with its default
options, and with `--log certificate`, by one process and by JOBS; it compares the bytes, and prints CPU and wall-clock
seconds, CPU being summed over all processes. The serial part is the CPU time of the process that reads the scene,
merges what the others tell, takes the snapshots and writes, as a share of what one process takes for all.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from subprocess import run
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

from .peers import Rocks

_CHILD = """\
import atexit, json, resource, sys
def tell():
    usages = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    print(json.dumps([usage.ru_utime + usage.ru_stime for usage in usages]))
atexit.register(tell)
from closecall.cli.main import main
main()
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
    done = run([sys.executable, "-c", _CHILD, *options], capture_output=True, text=True, check=True)
    wall = perf_counter() - began
    own, children = json.loads(done.stdout)
    return Cost(own, children, wall, log.read_bytes())


def main(jobs: int = 2, bodies: int = 44, seconds: float = 20.0) -> None:
    """Print a row a kind of log."""
    with TemporaryDirectory() as name:
        scene = Rocks(bodies).write(Path(name), seconds)
        print(f"{bodies} bodies, {bodies * (bodies - 1) // 2} pairs, {seconds:g} s")
        for kind in ("full", "certificate"):
            alone, shared = cost(scene, 1, kind), cost(scene, jobs, kind)
            bytes_told = "the same bytes" if alone.log == shared.log else "OTHER BYTES"
            print(
                f"--log {kind}: {bytes_told}; CPU {alone.cpu:.1f} s by one process, {shared.cpu:.1f} s by {jobs}: "
                f"{shared.cpu / alone.cpu:.2f} times; serial {shared.own:.1f} s: {shared.own / alone.cpu:.1%}; "
                f"wall {alone.wall:.1f} s and {shared.wall:.1f} s",
                flush=True,
            )


if __name__ == "__main__":
    main(*(kind(given) for kind, given in zip((int, int, float), sys.argv[1:], strict=False)))
