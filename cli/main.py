"""The entry point: runs the command line, and ends every failure in one line and its exit code."""

from __future__ import annotations

import sys
from io import TextIOWrapper
from typing import NoReturn

import click

from .faults import end_at_interrupts, report_misuse
from .group import VARIABLE, group


def main() -> NoReturn:
    """Run the command line; every failure ends in one line and its exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # which a name may hold more than its encoding knows
            stream.reconfigure(errors="backslashreplace")
    try:
        end_at_interrupts()
        code = group.main(standalone_mode=False, complete_var=VARIABLE)
    except click.ClickException as error:
        report_misuse(error)
        sys.exit(2)
    except (click.Abort, KeyboardInterrupt):
        sys.exit(130)
    sys.exit(code)
