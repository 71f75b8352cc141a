"""The records of an MCAP file, whatever its bytes say: no length is believed before it is checked."""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from struct import Struct
from struct import error as StructError  # noqa: N812
from typing import IO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Chunk, DataEnd
from mcap.writer import MCAP0_MAGIC

from .compression import uncompressed
from .errors import LogError

RECORD_HEAD = Struct("<BQ")  # opcode, length
_FOOTER = Struct("<BQQQI")  # opcode, length, where the index and the groups in it begin, checksum
_FOOTER_BYTES = 8 + 8 + 4
_CRC_BYTES = 4

# Uncompressed. Larger chunks are refused: the writer's are 512 KiB, but for one with all meshes of a scene.
MOST_CHUNK_BYTES = 512 * 2**20

# Of a record that is no file: such a chunk, with what compression adds where it finds nothing, and its head.
MOST_RECORD_BYTES = MOST_CHUNK_BYTES + MOST_CHUNK_BYTES // 128 + 2**16

# So much is read at a time of what nobody asked for.
_PIECE_BYTES = 2**20

_OPCODES = frozenset(int(opcode) for opcode in Opcode)


class DamageError(Exception):
    """A place of a log that cannot be read.

    Attributes:
        offset: byte where what cannot be read begins.
        problem: what is wrong there.
        cut: whether the file ends too soon, as that of a run under way or cut short does.
    """

    def __init__(self, offset: int, problem: str, cut: bool = False) -> None:
        super().__init__(f"byte {offset}: {problem}")
        self.offset = offset
        self.problem = problem
        self.cut = cut


# What mcap raises on bytes that are no MCAP, and what a length gone wrong makes of them.
DAMAGE = (
    McapError,
    StructError,
    ValueError,
    TypeError,
    LookupError,
    OverflowError,
    MemoryError,
    RuntimeError,
    zstandard.ZstdError,
    DamageError,
)


@dataclass(frozen=True, slots=True)
class Record:
    """A record that lies wholly inside the file: its opcode, and where (bytes) it begins and what it holds."""

    opcode: int
    offset: int
    length: int

    @property
    def body(self) -> int:
        """Where its content begins."""
        return self.offset + RECORD_HEAD.size

    @property
    def end(self) -> int:
        """Where the next record begins."""
        return self.body + self.length


class RecordFile:
    """An MCAP file as records. Takes memory for one record at a time, and time that grows with the file alone.

    Raises:
        LogError: from any method, where the system refuses to read.
    """

    def __init__(self, path: Path, file: IO[bytes]) -> None:
        self._path = path
        self._file = file
        self.size = os.fstat(file.fileno()).st_size

    def begins_well(self) -> bool:
        """Tell whether the file begins as an MCAP file does."""
        return self._bytes(0, len(MCAP0_MAGIC)) == MCAP0_MAGIC

    def heads(self) -> Iterator[Record]:
        """Yield the records of the data section, the last of which is its DataEnd.

        Raises:
            DamageError: where the file is cut short, or what follows is no record.
        """
        offset = len(MCAP0_MAGIC)
        while True:
            record = self._head(offset)
            yield record
            if record.opcode == Opcode.DATA_END:
                return
            offset = record.end

    def at(self, offset: int) -> Record:
        """Return the record that begins at a byte.

        Raises:
            DamageError: where there is none.
        """
        if not len(MCAP0_MAGIC) <= offset <= self.size:
            raise DamageError(offset, "there is no record")
        return self._head(offset)

    def body(self, record: Record) -> bytes:
        """Return what a record holds.

        Raises:
            DamageError: for one that is no file and larger than any may be: a file with holes holds it in no room.
        """
        if record.length > MOST_RECORD_BYTES and record.opcode != Opcode.ATTACHMENT:
            raise DamageError(record.offset, f"a record of {record.length} bytes is too large")
        return self._bytes(record.body, record.length)

    def checksum(self, record: Record, before: int) -> int:
        """Return the CRC-32 of the file up to a record's end, given that up to its beginning."""
        return self._crc_between(record.offset, record.end, before)

    def require_whole(self, data_end: Record, crc: int) -> None:
        """Check the checksum of the data, of which 0 is none, and what follows them.

        Raises:
            DamageError: for the first thing that is wrong.
        """
        told = DataEnd.read(read_stream(self.body(data_end))).data_section_crc
        if told not in (0, crc):
            raise DamageError(0, "the checksum of the whole does not match: not the facts, but an index or a file")
        self.require_index(data_end.end)

    def require_index(self, begins: int | None = None) -> None:
        """Check the end of the file: that it is there, and the checksum of the index, of which 0 is none.

        Args:
            begins: byte where the index must begin, where that is known.

        Raises:
            DamageError: for the first thing that is wrong.
        """
        magic = self.size - len(MCAP0_MAGIC)
        offset = magic - RECORD_HEAD.size - _FOOTER_BYTES
        if offset < len(MCAP0_MAGIC) or self._bytes(magic, len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            raise DamageError(self.size, "it ends in its index, its facts are whole", cut=True)
        footer = self._bytes(offset, RECORD_HEAD.size + _FOOTER_BYTES)
        opcode, length, index, _, told = _FOOTER.unpack(footer)
        start = index or offset  # 0 where there is no index
        crc = zlib.crc32(footer[:-_CRC_BYTES], self._crc_between(start, offset, 0))
        misplaced = begins not in (None, start) or not 0 <= start <= offset
        if (opcode, length) != (Opcode.FOOTER, _FOOTER_BYTES) or misplaced or told not in (0, crc):
            raise DamageError(start, "its index is damaged, its facts are whole")

    def _head(self, offset: int) -> Record:
        head = self._bytes(offset, RECORD_HEAD.size)
        if len(head) < RECORD_HEAD.size:
            raise DamageError(self.size, "the run that wrote it was cut short", cut=True)
        opcode, length = RECORD_HEAD.unpack(head)
        record = Record(opcode, offset, length)
        if opcode not in _OPCODES or opcode == Opcode.FOOTER or (opcode == Opcode.DATA_END and length != _CRC_BYTES):
            raise DamageError(offset, "what follows is no record")
        if record.end > self.size:
            raise DamageError(offset, "it ends in the middle of a record", cut=True)
        return record

    def _crc_between(self, start: int, end: int, crc: int) -> int:
        for offset in range(start, end, _PIECE_BYTES):
            crc = zlib.crc32(self._bytes(offset, min(_PIECE_BYTES, end - offset)), crc)
        return crc

    def _bytes(self, offset: int, length: int) -> bytes:
        with reading(self._path):
            self._file.seek(offset)
            return self._file.read(max(0, min(length, self.size - offset)))


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Let what the system refuses while a log is opened or read be one line.

    Raises:
        LogError: for an OSError.
    """
    try:
        yield
    except OSError as error:
        raise LogError(path, f"cannot read: {error.strerror or error}", "check the file and its folder") from error


def chunk_content(body: bytes) -> bytes:
    """Return the records inside a chunk, uncompressed, its checksum verified.

    Raises:
        ValueError, or another of `DAMAGE`: for a chunk that is not as it says.
    """
    chunk = Chunk.read(read_stream(body))
    size = chunk.uncompressed_size
    if size > MOST_CHUNK_BYTES:
        raise ValueError(f"a chunk of {size} bytes is too large")
    data = uncompressed(chunk.compression, chunk.data, size)
    if chunk.uncompressed_crc not in (0, zlib.crc32(data)):
        raise ValueError("a chunk's checksum does not match")
    return data


def read_attachment_record(body: bytes) -> Attachment:
    """Return a file that travels with a log, its checksum verified; one of 0 is none.

    Raises:
        ValueError, or another of `DAMAGE`: for an attachment that is not as it says.
    """
    crc = int.from_bytes(body[-_CRC_BYTES:], "little")
    if crc not in (0, zlib.crc32(body[:-_CRC_BYTES])):
        raise ValueError("the checksum does not match")
    attachment: Attachment = Attachment.read(read_stream(body))
    return attachment


def read_stream(data: bytes) -> ReadDataStream:
    """Return bytes as mcap's records read them; whatever they say, no more is read than there is."""
    return ReadDataStream(BytesIO(data))
