"""closecall from Python: load a scene, run it, open its log. No command line is involved.

from closecall import api

result = api.run("scene.yaml", "out.mcap", margin=0.002)
print(result.summary["totals"]["pairs"])
"""

from __future__ import annotations

from pathlib import Path

from closecall.cli.application.errors import OptionError, WorkerError
from closecall.cli.application.options import RunOptions
from closecall.cli.application.run import Result, run
from closecall.cli.application.scenes import load
from closecall.formats.log.errors import LogError
from closecall.formats.log.result import Found, read_found
from closecall.formats.scene.loaded import LoadedScene
from closecall.formats.scene.text.errors import SceneError

__all__ = [
    "Found",
    "LoadedScene",
    "LogError",
    "OptionError",
    "Result",
    "RunOptions",
    "SceneError",
    "WorkerError",
    "load",
    "open_log",
    "run",
]


def open_log(path: str | Path) -> Found:
    """Return what a log found, in SI units; of a log that is cut short or damaged, what can be read.

    Raises:
        LogError: for a file that is missing, is not a log of closecall, or holds nothing that can be read.
    """
    return read_found(Path(path))
