"""Faults become lines on stderr and exit codes; a traceback is always a bug."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click


@contextmanager
def faults_reported(output: Path | None = None) -> Iterator[None]:
    """Report what the user can mend, a line each, and exit 2; exit 130 where the user interrupts.

    Args:
        output: the log under way, whose partial file an interrupted user is told of.
    """
    from ..formats.log.errors import LogError
    from ..formats.scene.errors import SceneError

    try:
        yield
    except (SceneError, LogError) as fault:
        click.echo(str(fault), err=True)
        sys.exit(2)
    except MemoryError:
        click.echo("out of memory: the scene is too large for this machine", err=True)
        sys.exit(2)
    except KeyboardInterrupt:
        click.echo("interrupted" + _how_to_recover(output), err=True)
        sys.exit(130)


def _how_to_recover(output: Path | None) -> str:
    """Return where the log so far is, if there is one."""
    partial = Path(f"{output}.partial")
    if output is None or not partial.exists():
        return ""
    return f"; the log so far is in {partial}: mcap recover {partial} -o recovered.mcap"
