"""`closecall report`: a log as an HTML page."""

from __future__ import annotations

from pathlib import Path

import click

from ...formats.log.container.output import REPORT, destination, published
from ...formats.log.container.pipe import STDOUT
from ..faults import exit_code_of, faults_reported, raise_interrupts
from ..options import FILE_NAME
from ..terminal import say


@click.command("report")
@click.argument("log", type=FILE_NAME)
@click.option(
    "-o",
    "--output",
    type=FILE_NAME,
    metavar="PAGE",
    help="Write the page to this file; - means standard output.  [default: LOG with the suffix .html]",
)
@click.option("-q", "--quiet", is_flag=True, help="Do not print the name of the page.")
def command(log: Path, output: Path | None, quiet: bool) -> int:
    """Write the results in LOG as one HTML page, which needs no network. Lengths are in the unit of the scene.

    \b
    Examples:
      closecall report out.mcap
      closecall report out.mcap -o page.html
    """
    from ...formats.report.gathering import gather
    from ...formats.report.page import page

    target = log.parent / f"{log.stem}.html" if output is None else output
    with faults_reported():
        raise_interrupts()
        place = destination(target, [log], REPORT)
        gathered = gather(log)
        data = page(gathered).encode()
        with published(place) as stream:
            stream.write(data)
        if not quiet and target != STDOUT:
            say(f"{target}: {len(data) / 1e6:.1f} MB")
        return exit_code_of(gathered.found.loss or gathered.loss)
