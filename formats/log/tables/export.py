"""Tables into files: CSV, NDJSON, Parquet, row by row."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Protocol

from ..container.output import TABLE, Output, published
from ..errors import LogError
from ..message_filter import Choice
from ..reader import LogReader, Loss
from .escapes import csv_text, json_text
from .tables import Row, Table, table_of, tables

# Rows of Parquet that are held until they make a batch.
_BATCH_ROWS = 16_384


class RowWriter(Protocol):
    """Writes one table's rows to a stream."""

    def write(self, row: Row) -> None:
        """Write a row."""

    def close(self) -> None:
        """Write what is left; the stream stays open."""


class CsvWriter:
    """Comma-separated values with a head line; what is unknown is empty. Floats are told in full."""

    def __init__(self, stream: IO[bytes], table: Table) -> None:
        self._rows = csv.writer(_Utf8(stream), lineterminator="\n")
        self._rows.writerow([column.name for column in table.columns])

    def write(self, row: Row) -> None:
        """Write a row."""
        self._rows.writerow([csv_text(value) if isinstance(value, str) else value for value in row])

    def close(self) -> None:
        """Nothing is left."""


class NdjsonWriter:
    """A JSON object a line; what is unknown is null."""

    def __init__(self, stream: IO[bytes], table: Table) -> None:
        self._stream = stream
        self._names = [column.name for column in table.columns]

    def write(self, row: Row) -> None:
        """Write a row."""
        values = dict(zip(self._names, row, strict=True))
        self._stream.write(json_text(values).encode() + b"\n")

    def close(self) -> None:
        """Nothing is left."""


class ParquetWriter:
    """Parquet, zstd, in row groups; what is unknown is null."""

    def __init__(self, stream: IO[bytes], table: Table) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        kinds = {"double": pa.float64(), "int64": pa.int64(), "uint64": pa.uint64(), "string": pa.string()}
        self._arrow: Any = pa
        self._schema = pa.schema([(column.name, kinds[column.kind]) for column in table.columns])
        self._file = pq.ParquetWriter(stream, self._schema, compression="zstd")
        self._batch: list[Row] = []

    def write(self, row: Row) -> None:
        """Take a row; a batch is written at a time."""
        self._batch.append(row)
        if len(self._batch) >= _BATCH_ROWS:
            self._flush()

    def close(self) -> None:
        """Write the last batch and the footer."""
        self._flush()
        self._file.close()

    def _flush(self) -> None:
        if self._batch:
            columns = zip(*self._batch, strict=True)
            arrays = [self._arrow.array(c, one.type) for c, one in zip(columns, self._schema, strict=True)]
            self._file.write_batch(self._arrow.record_batch(arrays, schema=self._schema))
            self._batch.clear()


FORMATS: dict[str, Callable[[IO[bytes], Table], RowWriter]] = {
    "csv": CsvWriter,
    "ndjson": NdjsonWriter,
    "parquet": ParquetWriter,
}


@dataclass(slots=True)
class Exported:
    """What an export wrote: rows by table, and what of the log could not be read."""

    rows: dict[str, int] = field(default_factory=dict)
    loss: Loss | None = None


def export_table(log: Path, kind: str, choice: Choice, stream: IO[bytes]) -> Exported:
    """Write the one table that is chosen to a stream.

    Raises:
        LogError: for what is no log of closecall.
    """
    (table,) = chosen_tables(choice)
    done = Exported({table.name: 0})
    with LogReader(log) as reader:
        writer = FORMATS[kind](stream, table)
        for _, row in _rows(reader, choice):
            writer.write(row)
            done.rows[table.name] += 1
        writer.close()
        done.loss = reader.loss
    return done


def export_tables(log: Path, kind: str, choice: Choice, folder: Path) -> Exported:
    """Write each table that is chosen, and has rows, to a file of its own in a folder.

    Files are there only when all are whole; those of an earlier export are replaced. Without rows there is no folder.

    Raises:
        LogError: for what is no log of closecall, and for what cannot be written.
    """
    done = Exported()
    writers: dict[str, RowWriter] = {}
    with LogReader(log) as reader, ExitStack() as files:
        for table, row in _rows(reader, choice):
            if table.name not in writers:
                _make(folder)
                output = Output(folder / f"{table.name}.{kind}", [log], TABLE)
                writers[table.name] = FORMATS[kind](files.enter_context(published(output)), table)
            writers[table.name].write(row)
            done.rows[table.name] = done.rows.get(table.name, 0) + 1
        done.loss = reader.loss
        for writer in writers.values():
            writer.close()
    return done


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        raise LogError(folder, "is not a folder", "choose another with -o") from error
    except OSError as error:
        raise LogError(
            folder, f"cannot be created: {error.strerror or error}", "choose another folder with -o"
        ) from error


def chosen_tables(choice: Choice) -> list[Table]:
    """Return the tables whose topics are wanted."""
    return [table for topic, table in tables().items() if choice.wants_topic(topic)]


def _rows(reader: LogReader, choice: Choice) -> Iterator[tuple[Table, Row]]:
    """Yield the rows that are wanted, in the order of the log, with their tables."""
    topics = [topic for topic in tables() if choice.wants_topic(topic)]
    for source, log_time, message in reader.facts(*topics):
        table = table_of(source.topic)
        if table is not None and choice.wants(message, reader.identity.seconds(log_time)):
            for row in table.timed_rows(reader.identity, log_time, message):
                yield table, row


class _Utf8:
    """A stream of bytes that takes text."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write text as UTF-8."""
        return self._stream.write(text.encode())
