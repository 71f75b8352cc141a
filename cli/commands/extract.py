"""`closecall extract`: a part of a log as a log, or a file that travels with it."""

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
@click.option("-o", "--output", type=FILE_NAME, metavar="FILE", help="The log or file to write.")
@click.option("-q", "--quiet", is_flag=True, help="Do not tell what was taken.")
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
    """Take a part of LOG as a log of its own; or the file NAME that travels with it; or list such files.

    A part holds what is of its time, pairs and topics; spans and contacts that reach into the time are kept whole.

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
        raise click.UsageError("A file that travels with the log has no time, pairs or topics.")
    if chosen and output is None:
        raise click.UsageError("Give -o FILE for the part.")
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
                say("no listed pair matches in that time", to_stderr=True)
        return exit_code_of(part.loss)


def _list_files(log: Path) -> int:
    """Print the files that travel with a log: bytes, type, name. Tell what of the log cannot be read, too."""
    from ...formats.log.reader import LogReader

    with LogReader(log) as reader:
        for file in reader.attachments():
            say(f"{len(file.data):>12}  {file.media_type:<24}  {file.name}")
        loss = reader.loss
        for _ in reader.facts():
            pass
        return exit_code_of(loss or reader.loss)


def _take_file(log: Path, name: str, output: Path | None) -> int:
    """Write a file that travels with a log, to standard output if nowhere else."""
    from ...formats.log.container.pipe import STDOUT
    from ...formats.log.errors import DamagedLogError, LogError
    from ...formats.log.reader import LogReader

    with LogReader(log) as reader:
        file = next(reader.attachments(name), None)
    if file is None:
        kind = LogError if reader.loss is None else DamagedLogError
        raise kind(log, f"no file {name!r} travels with it, or not whole", f"see closecall extract {log}")
    if output is None or output == STDOUT:
        sys.stdout.buffer.write(file.data)
        return 0
    from ...formats.log.container.output import FILE, Output, published

    with published(Output(output, [log], FILE)) as stream:
        stream.write(file.data)
    return 0
