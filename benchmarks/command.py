"""`closecall run` in a child of its own, and what it took."""

from __future__ import annotations

import json
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from subprocess import PIPE, Popen
from time import perf_counter
from typing import Any

#: Python that runs the command as `pip install closecall` has it: without SciPy, which only tests need, but which
#: trimesh imports where it is.
PLAIN = "import sys; sys.modules['scipy'] = None; from closecall.cli.main import main; main()"


@dataclass(frozen=True, slots=True)
class Ran:
    """What a run took and told.

    Attributes:
        cpu, wall: s, of the child with its own children.
        memory: MB, at its peak.
        told: the command's JSON, with wall-clock `seconds` of its parts.
    """

    cpu: float
    wall: float
    memory: float
    told: dict[str, Any]


def run_command(scene: Path, log: Path, *options: str) -> Ran:
    """Run the installed command on a scene into a log."""
    command = [sys.executable, "-c", PLAIN, "run", str(scene), "-o", str(log), "--json", *options]
    began = perf_counter()
    child = Popen(command, stdout=PIPE)
    assert child.stdout is not None
    told = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    assert child.returncode == 0
    return Ran(usage.ru_utime + usage.ru_stime, perf_counter() - began, usage.ru_maxrss / 1e3, json.loads(told))
