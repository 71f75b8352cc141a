"""What `closecall diff` takes on two long logs, against mcap's stream reader over both in the same run.

    python -m benchmarks.diff_speed [messages of each log, 1000000] [pairs, 100]

The logs are written first: wakeups and distances of pairs of bodies by turns, in the writer's own chunks, some contacts
and spans. The new one has every contact 3.2 ms later; so have two more, one of another epoch, and one in which hardly
any message has its like. Each program runs by itself; CPU s and peak memory are its own.
"""

from __future__ import annotations

import json
import subprocess
import sys
from math import sin
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast

import numpy as np

from closecall.formats.log.writer import LogOptions, LogWriter
from closecall.formats.scene.loaded import LoadedScene
from closecall.scheduler.model.events import (
    Bound,
    Collision,
    ContactKind,
    Distance,
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
from closecall.scheduler.model.scene import Body, PairRules, Scene, Settings, pair_id

_END = 100.0  # s
_FACE = Feature(FeatureKind.FACE, 0, 0, 0)
_READ = """
import sys
from mcap.stream_reader import StreamReader
for path in sys.argv[1:]:
    with open(path, "rb") as file:
        for record in StreamReader(file).records:
            pass
"""


def write_log(path: Path, messages: int, pairs: int, later: float, shift: float = 0.0, epoch: int = 0) -> None:
    """Write a log of about so many messages, of so many pairs.

    Args:
        later: s, by which contacts begin later.
        shift: s, by which pairs wake later.
        epoch: ns, of the log.
    """
    bodies = tuple(Body(f"body_{i}", None, np.eye(4), cast(Any, None), ()) for i in range(pairs + 1))
    source = path.with_suffix(".yaml")
    source.write_bytes(b"closecall: 1\n")
    loaded = LoadedScene(source, source.read_bytes(), Scene(bodies, 0.0, _END, PairRules()), Settings(), (), ())
    keys = [PairKey(pair_id(0, i, len(bodies)), 0, i) for i in range(1, pairs + 1)]
    steps = messages // (2 * pairs)
    with LogWriter(path, loaded, Settings(), pairs, LogOptions(epoch=epoch)) as log:
        for step in range(steps):
            for number, pair in enumerate(keys):
                time = min(_END, _END * (step + number / pairs) / steps + shift)
                distance = 0.5 + 0.1 * sin(time + number)
                point = (time, distance, 0.0)
                log.write(Wakeup(time, pair, Reason.TIME_BOUND, Level.MESH, Bound.DISPLACEMENT, distance, _END / steps))
                log.write(Distance(time, pair, distance, point, point, _FACE, _FACE))
        for pair in keys:
            begin, end = 50.0 + later, 60.0
            bounds = [
                (Verdict.CLEAR, 0.0, begin, 0.39),
                (Verdict.CONTACT, begin, end, 0.0),
                (Verdict.CLEAR, end, _END, 0.39),
            ]
            for phase, time, before in ((Phase.BEGIN, begin, begin - 1e-7), (Phase.END, end, end + 1e-7)):
                log.write(Collision(pair, phase, before, time, ContactKind.SURFACE, _FACE, _FACE, (0.0, 0.0, 0.0)))
            for verdict, start, stop, clearance in bounds:
                log.write(Span(pair, verdict, start, stop, clearance, 0.0))


def taken(*command: str) -> tuple[float, float, str]:
    """Run a command by itself; return its CPU time (s), peak memory (MB) and what it printed."""
    code = "import resource, subprocess, sys; p = subprocess.run(sys.argv[1:], stdout=subprocess.PIPE, text=True); "
    code += "u = resource.getrusage(resource.RUSAGE_CHILDREN); import json; "
    code += "print(json.dumps([u.ru_utime + u.ru_stime, u.ru_maxrss / 1024, p.stdout]))"
    done = subprocess.run([sys.executable, "-c", code, *command], capture_output=True, text=True, check=True)
    seconds, megabytes, printed = json.loads(done.stdout)
    return seconds, megabytes, printed


def main() -> None:
    """Write the logs, read and compare them, print what each took."""
    messages = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    pairs = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    with TemporaryDirectory() as folder:
        golden, new, epoch, other = (Path(folder, f"{name}.mcap") for name in ("golden", "new", "epoch", "other"))
        write_log(golden, messages, pairs, 0.0)
        write_log(new, messages, pairs, 0.0032)
        write_log(epoch, messages, pairs, 0.0032, epoch=10**18)
        write_log(other, messages, pairs, 0.0032, shift=1e-4)
        print(f"logs of {messages} messages, {pairs} pairs, {golden.stat().st_size / 2**20:.0f} MB each")
        reader, memory, _ = taken(sys.executable, "-c", _READ, str(golden), str(new))
        print(f"mcap's stream reader over two of them: {reader:.1f} s of CPU, {memory:.0f} MB")
        for name, log, options in (
            ("closecall diff", new, []),
            ("closecall diff --all", new, ["--all"]),
            ("closecall diff --all, another epoch", epoch, ["--all"]),
            ("closecall diff --all, nothing has its like", other, ["--all"]),
        ):
            diff = [sys.executable, "-m", "closecall", "diff", str(golden), str(log), *options]
            seconds, memory, printed = taken(*diff)
            print(f"{name}: {seconds:.1f} s of CPU, {memory:.0f} MB, {seconds / reader:.2f} times")
            print("    " + printed.splitlines()[-1])


if __name__ == "__main__":
    main()
