"""Turn faults into lines on stderr and exit codes. A traceback is always a bug."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import StringIO
from pathlib import Path
from shlex import quote
from types import FrameType
from typing import TYPE_CHECKING, NoReturn

import click

from .application.errors import WorkerError
from .terminal import say

if TYPE_CHECKING:
    from ..formats.log.reader import Loss


#: Exit code of a command that could not read all of a log.
WITH_LOSS = 3


class Terminated(BaseException):
    """The process received SIGTERM."""


def end_at_interrupts() -> None:
    """Let Ctrl-C end the process at once: start-up writes nothing, and library imports can swallow Ctrl-C."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def raise_interrupts() -> None:
    """Let Ctrl-C raise KeyboardInterrupt again, so that commands can clean up."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _end(number: int, frame: FrameType | None) -> NoReturn:
    os.write(2, b"interrupted\n")
    os._exit(128 + signal.SIGINT)


@contextmanager
def faults_reported(output: Path | None = None) -> Iterator[None]:
    """Print one line per fault and exit with 2; 3 for an unreadable log; 130 or 143 after an interrupt.

    Args:
        output: the log that the command writes; after an interrupt a line names its partial file.
    """
    from ..formats.log.container.pipe import ClosedPipeError
    from ..formats.log.errors import DamagedLogError, LogError
    from ..formats.scene.text.errors import SceneError

    signal.signal(signal.SIGTERM, _terminate)
    try:
        yield
    except ClosedPipeError:
        sys.exit(128 + signal.SIGPIPE)
    except (SceneError, LogError, WorkerError) as fault:
        report(fault, output)
        sys.exit(WITH_LOSS if isinstance(fault, DamagedLogError) else 2)
    except MemoryError:
        say("out of memory: the scene or the log is too large for this machine", to_stderr=True)
        sys.exit(2)
    except KeyboardInterrupt:
        say("interrupted" + _how_to_recover(output), to_stderr=True)
        sys.exit(128 + signal.SIGINT)
    except Terminated:
        say("terminated" + _how_to_recover(output), to_stderr=True)
        sys.exit(128 + signal.SIGTERM)


def exit_code_of(*losses: Loss | None, otherwise: int = 0) -> int:
    """Print one line per log that could not be read completely; return the exit code."""
    lost = [loss for loss in losses if loss is not None]
    for loss in lost:
        say(str(loss), to_stderr=True)
    return WITH_LOSS if lost else otherwise


def report(fault: Exception, output: Path | None) -> None:
    """Print each fault as one line on stderr; for an interrupted log, add where the partial log is."""
    from ..formats.log.errors import LogError
    from ..formats.scene.text.errors import SceneError

    if isinstance(fault, SceneError):
        for line in fault.lines:
            say(line, to_stderr=True)
        return
    cut_short = isinstance(fault, LogError) and fault.path == Path(f"{output}.partial")
    say(str(fault) + (_how_to_recover(output) if cut_short else ""), to_stderr=True)


def report_misuse(error: click.ClickException) -> None:
    """Print click's text about a wrong command line on stderr."""
    words = StringIO()
    error.show(words)
    for line in words.getvalue().rstrip("\n").split("\n"):
        say(line.expandtabs(), to_stderr=True)


def _terminate(number: int, frame: FrameType | None) -> NoReturn:
    """Turn SIGTERM into an exception, so that the command can clean up."""
    raise Terminated


def _how_to_recover(output: Path | None) -> str:
    """Return where the partial log is, if it exists."""
    partial = Path(f"{output}.partial")
    if output is None or not os.path.exists(partial):  # Path.exists raises an error for a name that is too long
        return ""
    named = quote(str(partial))
    mended = f"repair it with the MCAP tool: mcap recover {named} -o recovered.mcap"
    return f"; the partial log is {partial}: print it with closecall summary {named}; {mended}"
