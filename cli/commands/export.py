"""`closecall export`: the messages of a log as tables."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

import click

from ..faults import exit_code_of, faults_reported, raise_interrupts
from ..options import FILE_NAME, choice_of, choice_options
from ..terminal import say


@click.command("export")
@click.argument("log", type=FILE_NAME)
@click.option(
    "--format",
    "kind",
    type=click.Choice(["csv", "ndjson", "parquet"]),
    default="csv",
    show_default=True,
    help="Write tables in this format.",
)
@choice_options
@click.option("-o", "--output", type=FILE_NAME, metavar="DIR", help="Write one file per table into this folder.")
@click.option("-q", "--quiet", is_flag=True, help="Do not print the names of the files.")
def command(
    log: Path,
    kind: str,
    output: Path | None,
    quiet: bool,
    topics: tuple[str, ...],
    pairs: tuple[str, ...],
    start: float | None,
    end: float | None,
) -> int:
    """Convert the messages of LOG to tables: one topic to standard output, or one file per topic.

    The tables are wakeups, distances, collisions, spans, windows, world, tf and log, in SI units. docs/tables.md
    describes their columns.

    \b
    Examples:
      closecall export out.mcap --topic /distances
      closecall export out.mcap --topic /spans --pair 'arm|*' --from 1 --to 2 --format ndjson
      closecall export out.mcap --format parquet -o tables
    """
    from ...formats.log.filters import require_pairs
    from ...formats.log.message_filter import Choice
    from ...formats.log.result import read_found
    from ...formats.log.tables.export import chosen_tables, export_table, export_tables

    if kind == "parquet" and find_spec("pyarrow") is None:
        raise click.ClickException("Parquet needs pyarrow: pip install 'closecall[parquet]'")
    choice = choice_of(topics, pairs, start, end)
    tables = chosen_tables(choice)
    if not tables:
        names = ", ".join(f"/{table.name}" for table in chosen_tables(Choice()))
        raise click.BadParameter(f"matches no topic; choose from {names}.", param_hint="--topic")
    if output is None and (len(tables) > 1 or kind == "parquet"):
        raise click.UsageError("Give one --topic or -o DIR." if len(tables) > 1 else "Parquet needs -o DIR.")
    with faults_reported():
        raise_interrupts()
        if pairs:
            require_pairs(log, pairs, read_found(log))
        if output is None:
            done = export_table(log, kind, choice, sys.stdout.buffer)
        else:
            done = export_tables(log, kind, choice, output)
            if not quiet:
                for name, rows in sorted(done.rows.items()):
                    say(f"{output / f'{name}.{kind}'}: {rows} rows")
        if not (quiet or done.loss or any(done.rows.values())):
            say("no messages match", to_stderr=True)
        return exit_code_of(done.loss)
