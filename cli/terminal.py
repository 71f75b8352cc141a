"""The one door by which text reaches a terminal: what could steer it, or start a line of its own, is escaped here.

Names come from scenes and logs that others wrote, and from the command line.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ..formats.scene.text.errors import printable

if TYPE_CHECKING:
    from rich.text import Text


def say(line: str, to_stderr: bool = False) -> None:
    """Print one line, whatever it holds."""
    click.echo(printable(line), err=to_stderr)


def cell(text: str, style: str = "") -> Text:
    """Return text for a table or a console, whatever it holds, as one line."""
    from rich.text import Text

    return Text(printable(text), style)
