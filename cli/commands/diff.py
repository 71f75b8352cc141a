"""`closecall diff`: compare a new log with a golden one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..faults import exit_code_of, faults_reported
from ..options import FILE_NAME, LENGTH

if TYPE_CHECKING:
    from ...formats.log.diff.findings import Rules


def _tolerance(name: str, unit: str, default: float, text: str) -> Callable[[Any], Any]:
    kind = LENGTH if unit == "LENGTH" else click.FloatRange(0.0)
    return click.option(name, type=kind, default=default, show_default=True, metavar=unit, help=text)


@click.command("diff")
@click.argument("golden", type=FILE_NAME)
@click.argument("new", type=FILE_NAME)
@_tolerance("--time-tol", "S", 1e-6, "Allow times to differ by this many seconds.")
@_tolerance("--time-rtol", "FRACTION", 0.0, "Also allow this fraction of the golden time.")
@_tolerance(
    "--distance-tol", "LENGTH", 1e-6, "Allow distances to differ by this length: 0.01mm; a bare number is in metres."
)
@_tolerance("--distance-rtol", "FRACTION", 0.0, "Also allow this fraction of the golden distance.")
@click.option(
    "--within-brackets", is_flag=True, help="Accept different minimum distances if the certified brackets overlap."
)
@click.option(
    "--ignore",
    multiple=True,
    metavar="GLOB",
    help="Ignore a pair ('arm|*'), a body ('tool*'), a topic ('/viz/*') or a field ('/wakeups.sleep').",
)
@click.option("--all", "every_topic", is_flag=True, help="Compare all messages, not only the results.")
@click.option(
    "--limit", type=click.IntRange(1), default=10, show_default=True, help="Print at most this many differences."
)
@click.option("--json", "as_json", is_flag=True, help="Print all differences as JSON, with lengths in metres.")
@click.option("--junit", type=FILE_NAME, metavar="FILE", help="Write a JUnit report with one test case per pair.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing; only set the exit code.")
def command(
    golden: Path,
    new: Path,
    every_topic: bool,
    limit: int,
    as_json: bool,
    junit: Path | None,
    quiet: bool,
    **given: Any,
) -> int:
    """Compare the results of the log NEW with those of the log GOLDEN: verdicts, contacts, minimum distances.

    Chunks, compression, channels, epoch and version may differ. Exit code: 0 for equal results, 1 for different
    results, 2 for logs that cannot be compared, 3 for a damaged log. The table gives lengths in the unit of the
    golden log's scene.

    \b
    Examples:
      closecall diff golden.mcap new.mcap
      closecall diff golden.mcap new.mcap --time-tol 1e-4 --distance-tol 1e-5 --ignore 'arm|*'
      closecall diff golden.mcap new.mcap --all --ignore '/viz/*' --json
      closecall diff golden.mcap new.mcap --junit report.xml
    """
    from ...formats.log.container.output import JUNIT, Output
    from ...formats.log.diff.compare import compare
    from ...formats.log.diff.junit import write_junit
    from ..show import print_json
    from ..show_diff import as_values, print_comparison

    with faults_reported():
        output = None if junit is None else Output(junit, [golden, new], JUNIT, "--junit")
        comparison = compare(golden, new, _rules(**given), every_topic)
        if output is not None:
            write_junit(output, comparison, golden, new)
        if as_json:
            print_json(as_values(comparison, golden, new))
        elif not quiet:
            print_comparison(comparison, limit)
        return exit_code_of(*comparison.losses, otherwise=int(bool(comparison.differences)))


def _rules(
    time_tol: float,
    time_rtol: float,
    distance_tol: float,
    distance_rtol: float,
    within_brackets: bool,
    ignore: tuple[str, ...],
) -> Rules:
    from ...formats.log.diff.difference import Ignored, Tolerances
    from ...formats.log.diff.findings import Rules

    return Rules(Tolerances(time_tol, distance_tol, time_rtol, distance_rtol), Ignored(ignore), within_brackets)
