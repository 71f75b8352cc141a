"""What travels with a log, found by its index."""

from __future__ import annotations

import os
from pathlib import Path
from typing import IO, cast

from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import AttachmentIndex
from mcap.summary import Summary as Index
from mcap.writer import MCAP0_MAGIC

from ..errors import DamagedLogError, LogError
from .records import DAMAGE, RECORD_HEAD, RecordFile, read_attachment_record, reading

NAME_A_LOG = "name a log that closecall wrote"


def read_attachment(path: Path, name: str) -> bytes:
    """Return a file that travels with a finished log, its checksum verified.

    Raises:
        LogError: for a file that is missing, unfinished, damaged, or holds no such attachment.
    """
    with reading(path), opened(path) as file:
        _require_both_ends(path, file)
        try:
            index = next((index for index in read_index(path, file).attachment_indexes if index.name == name), None)
            if index is None:
                raise _foreign(path)
            return _read_indexed(path, file, index)
        except DAMAGE as error:
            raise _damaged(path, "its index cannot be read") from error


def opened(path: Path) -> IO[bytes]:
    """Return a log, open.

    Raises:
        LogError: for what is no plain file, or cannot be read.
    """
    with reading(path):
        if not path.is_file():
            problem = "is not a plain file" if path.exists() else "does not exist"
            raise LogError(path, problem, NAME_A_LOG)
        return path.open("rb")


def read_index(path: Path, file: IO[bytes]) -> Index:
    """Return the index at the end of a finished log, empty where it has none.

    Raises:
        one of `DAMAGE`: for an index that cannot be read.
    """
    RecordFile(path, file).require_index()
    file.seek(0)
    return SeekingReader(cast(IO[bytes], _BoundedFile(file))).get_summary() or Index()


class _BoundedFile:
    """A file that reads no more than it has, for `read(length)` sets aside `length` bytes, however wrong."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._size = os.fstat(file.fileno()).st_size
        self.seek = file.seek
        self.tell = file.tell

    def read(self, length: int) -> bytes:
        return self._file.read(max(0, min(length, self._size - self._file.tell())))


def _require_both_ends(path: Path, file: IO[bytes]) -> None:
    magic = MCAP0_MAGIC
    if file.read(len(magic)) != magic:
        raise LogError(path, "is not an MCAP file", NAME_A_LOG)
    file.seek(-len(magic), os.SEEK_END)
    if file.tell() == 0 or file.read(len(magic)) != magic:
        remedy = "run the scene again, or recover what is left with `mcap recover`"
        raise DamagedLogError(path, "is unfinished: the run that wrote it did not finish", remedy)


def _read_indexed(path: Path, file: IO[bytes], index: AttachmentIndex) -> bytes:
    records = RecordFile(path, file)
    record = records.at(index.offset)
    if record.opcode != Opcode.ATTACHMENT or RECORD_HEAD.size + record.length != index.length:
        raise _damaged(path, f"its index has a wrong place for {index.name}")
    try:
        attachment = read_attachment_record(records.body(record))
    except ValueError as error:
        raise _damaged(path, f"the checksum of {index.name} does not match") from error
    if attachment.name != index.name:
        raise _damaged(path, f"its index has a wrong place for {index.name}")
    return attachment.data


def _damaged(path: Path, problem: str) -> DamagedLogError:
    return DamagedLogError(
        path, f"is damaged: {problem}", "run the scene again, or recover what is left with `mcap recover`"
    )


def _foreign(path: Path) -> LogError:
    return LogError(path, "is an MCAP file, but closecall did not write it", NAME_A_LOG)
