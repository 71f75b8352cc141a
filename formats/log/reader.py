"""Finished logs read back: their attachments and their summary."""

from __future__ import annotations

import json
import os
import zlib
from io import BytesIO
from pathlib import Path
from struct import error as StructError  # noqa: N812
from typing import IO, NoReturn, cast

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.reader import SeekingReader
from mcap.records import Attachment, AttachmentIndex
from mcap.writer import MCAP0_MAGIC

from .contents import SUMMARY
from .errors import LogError
from .summary import Summary

# What mcap raises on bytes that are no MCAP, and what a length gone wrong makes of them.
_DAMAGE = (
    McapError,
    StructError,
    ValueError,
    TypeError,
    LookupError,
    OverflowError,
    MemoryError,
    RuntimeError,
)

_RECORD_HEAD_BYTES = 1 + 8  # opcode, length
_CRC_BYTES = 4


def read_summary(path: Path) -> Summary:
    """Return the summary that a finished log carries.

    Raises:
        LogError: for a file that is missing, unfinished, damaged, or not a log of closecall.
    """
    data = read_attachment(path, SUMMARY)
    try:
        summary = json.loads(data, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise _damaged(path, f"{SUMMARY} is not JSON") from error
    if not isinstance(summary, dict) or not Summary.__required_keys__ <= summary.keys():
        raise _foreign(path)
    return cast(Summary, summary)


def read_attachment(path: Path, name: str) -> bytes:
    """Return a file that travels with a finished log, its checksum verified.

    Raises:
        LogError: for a file that is missing, unfinished, damaged, or holds no such attachment.
    """
    try:
        if not path.is_file():
            problem = "is not a plain file" if path.exists() else "does not exist"
            raise LogError(path, problem, "name a log that closecall wrote")
        with path.open("rb") as file:
            _require_both_ends(path, file)
            return _attachment_data(path, file, name)
    except OSError as error:
        raise LogError(path, f"cannot read: {error.strerror or error}", "check the file and its folder") from error


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
        raise LogError(path, "is not an MCAP file", "name a log that closecall wrote")
    file.seek(-len(magic), os.SEEK_END)
    if file.tell() == 0 or file.read(len(magic)) != magic:
        remedy = "run it again, or read what is there with `mcap recover`"
        raise LogError(path, "is unfinished: the run that wrote it was cut short", remedy)


def _attachment_data(path: Path, file: IO[bytes], name: str) -> bytes:
    try:
        file.seek(0)
        summary = SeekingReader(cast(IO[bytes], _BoundedFile(file))).get_summary()
        indexes = [] if summary is None else summary.attachment_indexes
        index = next((index for index in indexes if index.name == name), None)
        if index is None:
            raise _foreign(path)
        return _read_indexed(path, file, index)
    except _DAMAGE as error:
        raise _damaged(path, "its index cannot be read") from error


def _read_indexed(path: Path, file: IO[bytes], index: AttachmentIndex) -> bytes:
    file.seek(index.offset)
    record = _BoundedFile(file).read(index.length)[_RECORD_HEAD_BYTES:]
    content, crc = record[:-_CRC_BYTES], record[-_CRC_BYTES:]
    if zlib.crc32(content) != int.from_bytes(crc, "little"):
        raise _damaged(path, f"the checksum of {index.name} does not match")
    return cast(bytes, Attachment.read(ReadDataStream(BytesIO(record))).data)


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not JSON")


def _damaged(path: Path, problem: str) -> LogError:
    return LogError(path, f"is damaged: {problem}", "run it again, or read what is there with `mcap recover`")


def _foreign(path: Path) -> LogError:
    return LogError(path, "is an MCAP file, but closecall did not write it", "name a log that closecall wrote")
