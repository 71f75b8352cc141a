"""`closecall extract`: part of a log as a log, or a file attached to it."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from ..faults import exit_code_of, faults_reported, raise_interrupts
from ..options import FILE_NAME, choice_of, choice_options
from ..terminal import say


@click.command("extract")
@click.argument("log", type=FILE_NAME)
@click.argument("name", required=False)
@choice_options
@click.option("-o", "--output", type=FILE_NAME, metavar="FILE", help="Write the log or the attached file to this file.")
@click.option("-q", "--quiet", is_flag=True, help="Do not print the number of messages.")
def command(
    log: Path,
    name: str | None,
    output: Path | None,
    quiet: bool,
    topics: tuple[str, ...],
    pairs: tuple[str, ...],
    start: float | None,
    end: float | None,
) -> int:
    """Extract part of LOG as a new log, or the attached file NAME. Without options, list the attached files.

    The part holds the messages of the selected time, pairs and topics. It keeps whole every span and contact that
    overlaps the selected time.

    \b
    Examples:
      closecall extract out.mcap --from 1 --to 1.5 -o part.mcap
      closecall extract out.mcap --pair 'arm|*' --topic '/spans' --topic '/collisions' -o part.mcap
      closecall extract out.mcap
      closecall extract out.mcap scene -o scene_again.yaml
      closecall extract out.mcap settings.json
    """
    choice = choice_of(topics, pairs, start, end)
    chosen = bool(topics or pairs or start is not None or end is not None)
    if name is not None and chosen:
        raise click.UsageError("Select either an attached file, or messages by time, pair or topic.")
    if chosen and output is None:
        raise click.UsageError("Give -o FILE for the extracted log.")
    with faults_reported():
        raise_interrupts()
        if name is not None:
            return _take_file(log, name, output)
        if output is None:
            return _list_files(log)
        from ...formats.log.extract import write_part
        from ...formats.log.filters import require_pairs, require_topics
        from ...formats.log.result import read_found

        require_topics(log, topics)
        if pairs:
            require_pairs(log, pairs, read_found(log))
        part = write_part(log, output, choice)
        if not quiet:
            say(f"{output}: {part.messages} of {part.of} messages")
            if pairs and not part.pairs and part.loss is None:
                say("no listed pair matches in this time", to_stderr=True)
        return exit_code_of(part.loss)


def _list_files(log: Path) -> int:
    """Print the attached files: bytes, type, name. Report what cannot be read in the log."""
    from ...formats.log.reader import LogReader

    with LogReader(log) as reader:
        for file in reader.attachments():
            say(f"{len(file.data):>12}  {file.media_type:<24}  {file.name}")
        loss = reader.loss
        for _ in reader.facts():
            pass
        return exit_code_of(loss or reader.loss)


def _take_file(log: Path, name: str, output: Path | None) -> int:
    """Write an attached file, by default to standard output."""
    from ...formats.log.container.pipe import STDOUT
    from ...formats.log.errors import DamagedLogError, LogError
    from ...formats.log.reader import LogReader

    with LogReader(log) as reader:
        file = next(reader.attachments(name), None)
    if file is None:
        kind = LogError if reader.loss is None else DamagedLogError
        raise kind(log, f"has no complete attached file {name!r}", f"list the files with closecall extract {log}")
    if output is None or output == STDOUT:
        sys.stdout.buffer.write(file.data)
        return 0
    from ...formats.log.container.output import FILE, Output, published

    with published(Output(output, [log], FILE)) as stream:
        stream.write(file.data)
    return 0
