"""`closecall summary`: the results in a log."""

from __future__ import annotations

from pathlib import Path

import click

from ..faults import exit_code_of, faults_reported
from ..options import FILE_NAME, FINDINGS, one_or_more_of

VERDICTS = (*FINDINGS, "clear")
SORTS = ("severity", "distance", "time", "name", "wakeups")


@click.command("summary")
@click.argument("log", type=FILE_NAME)
@click.option("--pair", "patterns", multiple=True, metavar="GLOB", help="Select pairs ('arm|*') or bodies ('tool*').")
@click.option(
    "--verdict",
    "verdicts",
    callback=one_or_more_of(VERDICTS),
    metavar="VERDICTS",
    help=f"Select pairs with one of these verdicts: {','.join(VERDICTS)}.",
)
@click.option(
    "--sort", type=click.Choice(SORTS), default="severity", show_default=True, help="Sort the pairs by this key."
)
@click.option("--limit", type=click.IntRange(1), help="Print at most this many pairs.  [default: 20; all with --json]")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON, with lengths in metres.")
def command(
    log: Path, patterns: tuple[str, ...], verdicts: tuple[str, ...], sort: str, limit: int | None, as_json: bool
) -> int:
    """Print the results in LOG, worst pairs first. Of an incomplete or damaged log, print what can be read.

    The table gives lengths in the unit of the scene.

    \b
    Examples:
      closecall summary out.mcap
      closecall summary out.mcap --json
      closecall summary out.mcap --pair 'arm|*' --verdict contact,breach
      closecall summary out.mcap --sort distance --limit 5
    """
    from ...formats.log.filters import require_pairs
    from ...formats.log.message_filter import is_pair_among
    from ...formats.log.result import read_found
    from ..show import MOST_ROWS, ORDERS, print_json, print_summary

    with faults_reported():
        found = read_found(log)
        require_pairs(log, patterns, found)
        pairs = [
            pair
            for pair in found.summary["pairs"]
            if (not patterns or is_pair_among(pair["pair"], patterns)) and (not verdicts or pair["verdict"] in verdicts)
        ]
        if as_json and sort == "severity":
            shown = pairs if limit is None else sorted(pairs, key=ORDERS[sort])[:limit]
        else:
            shown = sorted(pairs, key=ORDERS[sort])[: limit or (None if as_json else MOST_ROWS)]
        if as_json:
            print_json({**found.summary, "pairs": shown})
        else:
            print_summary(found.summary, found.length_unit, shown, len(pairs))
        return exit_code_of(found.loss)
