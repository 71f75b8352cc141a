"""Faults become lines on stderr and exit codes; a traceback is always a bug."""

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
    """SIGTERM came."""


def end_at_interrupts() -> None:
    """Have Ctrl-C end the process at once: while it starts nothing is written, and imports of libraries swallow it."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def raise_interrupts() -> None:
    """Have Ctrl-C raise KeyboardInterrupt again, so that what is under way is left in order."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _end(number: int, frame: FrameType | None) -> NoReturn:
    os.write(2, b"interrupted\n")
    os._exit(128 + signal.SIGINT)


@contextmanager
def faults_reported(output: Path | None = None) -> Iterator[None]:
    """Report what the user can mend, a line each, and exit 2; 3 for a log beyond reading; 130 or 143 if interrupted.

    Args:
        output: the log under way, whose partial file an interrupted user is told of.
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
    """Tell on stderr what could not be read of logs, a line each; return the exit code."""
    lost = [loss for loss in losses if loss is not None]
    for loss in lost:
        say(str(loss), to_stderr=True)
    return WITH_LOSS if lost else otherwise


def report(fault: Exception, output: Path | None) -> None:
    """Print a fault on stderr, a line each where there are several, and where the log is that it cut short."""
    from ..formats.log.errors import LogError
    from ..formats.scene.text.errors import SceneError

    if isinstance(fault, SceneError):
        for line in fault.lines:
            say(line, to_stderr=True)
        return
    cut_short = isinstance(fault, LogError) and fault.path == Path(f"{output}.partial")
    say(str(fault) + (_how_to_recover(output) if cut_short else ""), to_stderr=True)


def report_misuse(error: click.ClickException) -> None:
    """Print what is wrong with a command line, as click words it, on stderr."""
    words = StringIO()
    error.show(words)
    for line in words.getvalue().rstrip("\n").split("\n"):
        say(line.expandtabs(), to_stderr=True)


def _terminate(number: int, frame: FrameType | None) -> NoReturn:
    """Turn SIGTERM into an exception, so that the log is left in order."""
    raise Terminated


def _how_to_recover(output: Path | None) -> str:
    """Return where the log so far is, if there is one."""
    partial = Path(f"{output}.partial")
    if output is None or not os.path.exists(partial):  # of which Path makes an error where a name is too long
        return ""
    named = quote(str(partial))
    mended = f"the MCAP command line tool mends it: mcap recover {named} -o recovered.mcap"
    return f"; the log so far is in {partial}: closecall summary {named} tells it; {mended}"
