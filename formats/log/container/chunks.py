"""Messages into chunks: sorted by time within each, and handed to the system one chunk at a time."""

from __future__ import annotations

from enum import Enum
from operator import itemgetter
from typing import IO, Generic, TypeVar, cast

from google.protobuf.descriptor import FileDescriptor
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import Message
from google.protobuf.timestamp_pb2 import Timestamp
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, Writer

from .clock import NANOSECONDS_PER_SECOND

MessageT = TypeVar("MessageT", bound=Message)

# Uncompressed bytes: between 256 KiB, below which zstd loses, and 1 MiB, above which viewers read too much
# for one instant. It also bounds what a SIGKILL can lose and what waits in memory to be sorted.
CHUNK_BYTES = 512 * 1024

# Opcode, length, channel, sequence and two times: what a record adds to its message.
MESSAGE_OVERHEAD_BYTES = 1 + 8 + 2 + 4 + 8 + 8


class Compression(Enum):
    """How chunks are compressed."""

    NONE = "none"
    LZ4 = "lz4"
    ZSTD = "zstd"


class Channel:
    """A topic and the schema of its messages.

    Attributes:
        kind: the type of the messages.
        written: how many messages were added, which is also the last one's sequence number.
        id: in the file, None until the topic's first message is written.
    """

    def __init__(self, name: str, kind: type[Message]) -> None:
        self.name = name
        self.kind = kind
        self.written = 0
        self.id: int | None = None


class Topic(Channel, Generic[MessageT]):
    """A topic with the one message that is filled again for each of its records.

    Attributes:
        timestamp: the message's own timestamp field.
    """

    def __init__(self, name: str, message: MessageT, timestamp: Timestamp) -> None:
        super().__init__(name, type(message))
        self.message = message
        self.timestamp = timestamp


class ChunkWriter:
    """An MCAP file in the making, on a stream that it never closes.

    A fact found late goes into the chunk under way, sorted into it; across chunks the index keeps time order.
    Memory holds one chunk's messages, and the index: about 300 bytes a chunk.
    """

    def __init__(self, stream: IO[bytes], compression: Compression, library: str) -> None:
        self._stream = stream
        self._mcap = Writer(
            stream,
            compression=CompressionType[compression.name],
            enable_data_crcs=True,
            chunk_size=2 * CHUNK_BYTES,
        )
        self._mcap.start(profile="", library=library)
        self._schemas: dict[str, int] = {}
        self._waiting: list[tuple[int, Channel, int, bytes]] = []
        self._waiting_bytes = 0
        self._whole = True

    def add_message(self, topic: Topic[MessageT], log_time: int) -> None:
        """Add the topic's message as it is now, stamped with the log time, ns >= 0."""
        topic.timestamp.seconds, topic.timestamp.nanos = divmod(log_time, NANOSECONDS_PER_SECOND)
        self.add_serialized(topic, topic.message.SerializeToString(), log_time)

    def add_serialized(self, channel: Channel, data: bytes, log_time: int) -> None:
        """Add a message that is bytes already, and holds its own timestamps."""
        channel.written += 1
        self._waiting.append((log_time, channel, channel.written, data))
        self._waiting_bytes += len(data) + MESSAGE_OVERHEAD_BYTES
        if self._waiting_bytes >= CHUNK_BYTES:
            self.flush()

    def add_attachment(self, name: str, media_type: str, data: bytes, log_time: int) -> None:
        """Add a file that travels with the log."""
        self._mcap.add_attachment(create_time=0, log_time=log_time, name=name, media_type=media_type, data=data)

    def add_metadata(self, name: str, values: dict[str, str]) -> None:
        """Add a record of strings, in the order of their keys."""
        self._mcap.add_metadata(name, dict(sorted(values.items())))

    def flush(self) -> None:
        """Write what waits as one chunk, and hand all to the system: a killed process loses none of it."""
        self._whole = False
        self._waiting.sort(key=itemgetter(0))
        add_message = self._mcap.add_message
        for log_time, channel, sequence, data in self._waiting:
            if channel.id is None:
                channel.id = self._register(channel)
            add_message(channel.id, log_time, data, log_time, sequence)
        self._waiting.clear()
        self._waiting_bytes = 0
        self._mcap.flush()  # type: ignore[no-untyped-call]
        self._whole = True

    def salvage(self) -> None:
        """After a fault, write what waits; not where it cut a chunk short, for the rest would be garbled."""
        if self._whole:
            self.flush()

    def finish(self) -> None:
        """Write the last chunk and the index that makes the file whole."""
        self.flush()
        self._mcap.finish()  # type: ignore[no-untyped-call]

    def _register(self, channel: Channel) -> int:
        schema = channel.kind.DESCRIPTOR.full_name
        if schema not in self._schemas:
            data = descriptor_set(channel.kind).SerializeToString()
            self._schemas[schema] = self._mcap.register_schema(schema, SchemaEncoding.Protobuf, data)
        return self._mcap.register_channel(channel.name, MessageEncoding.Protobuf, self._schemas[schema])


def descriptor_set(kind: type[Message]) -> FileDescriptorSet:
    """Return the definition of a type of messages and all that it imports, imports first."""
    files: dict[str, FileDescriptor] = {}

    def collect(file: FileDescriptor) -> None:
        for imported in file.dependencies:
            collect(imported)
        files.setdefault(file.name, file)

    collect(cast(FileDescriptor, kind.DESCRIPTOR.file))
    definition = FileDescriptorSet()
    for file in files.values():
        file.CopyToProto(definition.file.add())
    return definition
