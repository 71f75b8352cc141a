"""`closecall summary`: what a log found."""

from __future__ import annotations

from pathlib import Path

import click

from .faults import exit_code_of, faults_reported


@click.command("summary")
@click.argument("log", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON instead of a table.")
def command(log: Path, as_json: bool) -> int:
    """Print what LOG found, worst pairs first.

    Example: closecall summary gears.mcap --json
    """
    from ..formats.log.found import read_found
    from .show import print_json, print_summary

    with faults_reported():
        found = read_found(log)
    if as_json:
        print_json(found.summary)
    else:
        print_summary(found.summary)
    return exit_code_of(found.loss)
