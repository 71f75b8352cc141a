"""A log read once from end to end, as far as it can be: finished, under way, cut short or damaged."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from struct import Struct
from types import TracebackType
from typing import Any, Self

from google.protobuf.message import DecodeError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Metadata, Schema
from mcap.writer import MCAP0_MAGIC

from ..scene.errors import counted
from .attachments import NAME_A_LOG, opened, read_index
from .checks import FactChecks, FactError
from .clock import seconds_told
from .contents import LOST, METADATA, METADATA_AT_START
from .errors import DamagedLogError, LogError
from .identity import Identity
from .identity_reading import read_identity
from .records import (
    DAMAGE,
    RECORD_HEAD,
    DamageError,
    Record,
    RecordFile,
    chunk_content,
    read_attachment_record,
    read_stream,
)
from .sources import Source, Sources

_MESSAGE_HEAD = Struct("<HIQQ")  # channel, sequence, log time, publish time
_MESSAGE_OPCODES = frozenset((Opcode.CHUNK, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE))

_ATTACHMENT_TIMES_BYTES = 8 + 8
_ATTACHMENT_HEAD_BYTES = 64 * 1024  # the times, and a name that no writer makes longer

_OF_THE_RUN = (METADATA_AT_START, METADATA)


@dataclass(frozen=True, slots=True)
class Loss:
    """What of a log could not be read.

    Attributes:
        offset: byte of the first place.
        problem: what is wrong there.
        cut: whether the file merely ends too soon.
        places: how many places there are.
        read_to: s, the latest fact that was read before reading had to end; None where the rest was read.
        inherited: whether all of the file was read, but the log it is a part of had lost this already.
    """

    path: Path
    offset: int
    problem: str
    cut: bool
    places: int
    read_to: float | None
    inherited: bool = False

    def __str__(self) -> str:
        return f"{self.path}: {self.told}"

    @property
    def told(self) -> str:
        """The same without the file's name, which it does not keep."""
        if self.inherited:
            return self.problem
        what = "unfinished" if self.cut else "damaged"
        more = f" (and {counted(self.places - 1, 'more place')})" if self.places > 1 else ""
        rest = "the rest was read" if self.read_to is None else f"read up to {seconds_told(self.read_to, 7)} s"
        return f"{what} at byte {self.offset}: {self.problem}{more}; {rest}"


class LogReader:
    """Reads a log, as a context manager; memory holds one chunk at a time.

    A chunk that is damaged is passed over, and reading ends where the records do: `loss` says so afterwards.

    Attributes:
        path: of the log.
        identity: what the log says of its run.
        values: the same, as the log has it.

    Raises:
        LogError: for a file that is missing, or not a log of closecall.
    """

    identity: Identity
    values: dict[str, str]

    def __init__(self, path: Path) -> None:
        self.path = path
        self._open = ExitStack()
        self._begin()

    def _begin(self) -> None:
        """Forget what an earlier pass over the log found."""
        self._sources = Sources(frozenset(), self.doubt)
        self._checks: FactChecks | None = None
        self._fault: DamageError | None = None
        self._places = 0
        self._inherited: Loss | None = None
        self._stopped = False
        self._offset = 0
        self._latest = 0

    def __enter__(self) -> Self:
        self._file = self._open.enter_context(opened(self.path))
        try:
            self._records = RecordFile(self.path, self._file)
            if not self._records.begins_well():
                raise LogError(self.path, "is not an MCAP file", NAME_A_LOG)
            self.identity = self._find_identity()
        except BaseException:
            self._open.close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> bool | None:
        return self._open.__exit__(kind, fault, trace)

    @property
    def loss(self) -> Loss | None:
        """What could not be read, known once the messages (or attachments) were; None where nothing is lost."""
        first = self._fault
        if first is None:
            return self._inherited
        read_to = self.identity.seconds(max(self._latest, self.identity.epoch)) if self._stopped else None
        return Loss(self.path, first.offset, first.problem, first.cut, self._places, read_to)

    def messages(self, *topics: str) -> Iterator[tuple[Source, int, bytes]]:
        """Yield each message's source, log time in ns and bytes, in the order of the file: by time within a chunk.

        Args:
            topics: those wanted, of topics by body without the body (`/distances`); all topics if none are named.
        """
        self._begin()
        self._sources = Sources(frozenset(topics), self.doubt)
        for record, body in self._data():
            try:
                if record.opcode == Opcode.CHUNK:
                    yield from self._inner(chunk_content(body))
                else:
                    yield from self._inner(RECORD_HEAD.pack(record.opcode, record.length) + body)
            except DAMAGE as error:
                self._add_fault(DamageError(record.offset, str(error) or "a record cannot be read"))

    def facts(self, *topics: str) -> Iterator[tuple[Source, int, Any]]:
        """Yield each message's source, log time in ns and the message itself; types that are not known are passed over.

        Args:
            topics: as for `messages`.
        """
        for source, log_time, data in self.messages(*topics):
            message = self.fact(source, log_time, data)
            if message is not None:
                yield source, log_time, message

    def fact(self, source: Source, log_time: int, data: bytes) -> Any | None:
        """Return a message that `messages` yielded; None, and a doubt, for one that says what cannot be."""
        if source.kind is None:
            return None
        if self._checks is None:
            self._checks = FactChecks(self.identity.bodies)
        try:
            message = source.kind.FromString(data)
            self._checks.require(message, log_time)
        except DecodeError:
            self.doubt(f"a message of {source.topic} cannot be decoded")
            return None
        except FactError as error:
            self.doubt(f"a message of {source.topic}: {error}")
            return None
        return message

    def doubt(self, problem: str) -> None:
        """Take note that something in the record under way cannot be true."""
        self._add_fault(DamageError(self._offset, problem))

    def _add_fault(self, fault: DamageError) -> None:
        self._fault = self._fault or fault
        self._places += 1

    def attachments(self, *names: str) -> Iterator[Attachment]:
        """Yield the files that travel with the log, whether or not its index is whole; those not whole are passed over.

        Args:
            names: those wanted; all if none are named.
        """
        self._begin()
        try:
            for record in self._records.heads():
                self._offset = record.offset
                if record.opcode == Opcode.ATTACHMENT:
                    try:
                        if not names or self._attachment_name(record) in names:
                            yield read_attachment_record(self._records.body(record))
                    except DAMAGE:
                        self.doubt("a file that travels with it is damaged")
        except DamageError as error:
            self._add_fault(error)

    def _attachment_name(self, record: Record) -> str:
        head = self._records.body(replace(record, length=min(record.length, _ATTACHMENT_HEAD_BYTES)))
        return read_stream(head[_ATTACHMENT_TIMES_BYTES:]).read_prefixed_string()

    def _find_identity(self) -> Identity:
        """Return what the log says of its run, from the first of its two records that can be read."""
        problem = ""
        try:
            for record in self._records.heads():
                if record.opcode == Opcode.METADATA:
                    try:
                        metadata = self._metadata(record)
                    except DAMAGE:
                        problem = f"byte {record.offset}: what it says of its run cannot be read"
                        continue
                    if metadata.name in _OF_THE_RUN:
                        try:
                            self.values = dict(metadata.metadata)
                            return read_identity(self.values)
                        except ValueError as error:
                            problem = f"byte {record.offset}: what it says of its run cannot be: {error}"
        except DamageError as error:
            problem = problem or str(error)
        if problem:
            raise DamagedLogError(self.path, f"nothing can be read of it: {problem}", "run it again")
        raise LogError(self.path, "is an MCAP file, but says nothing of a run of closecall", NAME_A_LOG)

    def _data(self) -> Iterator[tuple[Record, bytes]]:
        """Yield the records that hold messages or tell of them; check all others, and the end."""
        crc = zlib.crc32(MCAP0_MAGIC)
        try:
            for record in self._records.heads():
                self._offset = record.offset
                if record.opcode in _MESSAGE_OPCODES:
                    try:
                        body = self._records.body(record)
                    except DamageError as error:
                        self._add_fault(error)
                        continue
                    crc = zlib.crc32(body, zlib.crc32(RECORD_HEAD.pack(record.opcode, record.length), crc))
                    yield record, body
                elif record.opcode != Opcode.DATA_END:
                    crc = self._records.checksum(record, crc)
                    if record.opcode == Opcode.METADATA:
                        self._compare_metadata(record)
                elif self._fault is None:  # for the checksum would not match again
                    self._check_end(record, crc)
        except DamageError as error:
            self._add_fault(error)
            self._stopped = True

    def _metadata(self, record: Record) -> Metadata:
        metadata: Metadata = Metadata.read(read_stream(self._records.body(record)))
        return metadata

    def _compare_metadata(self, record: Record) -> None:
        """Hold the records of the run against each other, and take note of what was lost of a log that this is part of.

        The checksum of the whole proves a record.
        """
        try:
            metadata = self._metadata(record)
        except DAMAGE:
            return
        if metadata.name in _OF_THE_RUN:
            try:
                same = read_identity(metadata.metadata) == self.identity
            except ValueError as error:
                self.doubt(f"what it says of its run cannot be: {error}")
                return
            if not same:
                self.doubt("what it says of its run at its start and at its end are not the same")
        lost = metadata.metadata.get(LOST)
        if lost is not None:
            told = f"part of a log that was {lost}"
            self._inherited = Loss(self.path, record.offset, told, cut=False, places=1, read_to=None, inherited=True)

    def _check_end(self, data_end: Record, crc: int) -> None:
        try:
            self._records.require_whole(data_end, crc)
        except DamageError as error:
            self._add_fault(error)

    def _inner(self, data: bytes) -> Iterator[tuple[Source, int, bytes]]:
        """Yield the messages wanted among records without damage, and take note of the channels.

        Raises:
            one of `DAMAGE`: for records that are not as they say.
        """
        offset, size = 0, len(data)
        while offset < size:
            opcode, length = RECORD_HEAD.unpack_from(data, offset)
            offset += RECORD_HEAD.size
            end = offset + length
            if end > size:
                raise ValueError("a message ends outside its chunk")
            if opcode == Opcode.MESSAGE:
                if length < _MESSAGE_HEAD.size:
                    raise ValueError("a message is shorter than its head")
                channel, _, log_time, _ = _MESSAGE_HEAD.unpack_from(data, offset)
                if log_time > self._latest:
                    self._latest = log_time
                if not self._sources.knows(channel):
                    self._look_up(channel)
                source = self._sources.wanted(channel)
                if source is not None:
                    yield source, log_time, data[offset + _MESSAGE_HEAD.size : end]
            elif opcode == Opcode.SCHEMA:
                self._sources.add_schema(Schema.read(read_stream(data[offset:end])))
            elif opcode == Opcode.CHANNEL:
                self._sources.add_channel(Channel.read(read_stream(data[offset:end])))
            else:
                raise ValueError(f"a record of kind {opcode} is inside a chunk")
            offset = end

    def _look_up(self, channel: int) -> None:
        """Take note of the channels by the index at the end, for the chunk that told of this one was lost."""
        index = read_index(self.path, self._file)
        for schema in index.schemas.values():
            self._sources.add_schema(schema)
        for told in index.channels.values():
            self._sources.add_channel(told)
        if channel not in index.channels:
            raise ValueError("a message is of a topic that is told nowhere")
