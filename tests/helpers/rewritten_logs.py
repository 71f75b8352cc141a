"""Logs written again with mcap's own writer: other chunks, other channels, other or fewer messages."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from mcap.reader import make_reader
from mcap.records import Channel, Message
from mcap.writer import CompressionType, Writer

Change = Callable[[Channel, Message], Iterable[Message]]


def unchanged(channel: Channel, message: Message) -> Iterable[Message]:
    return [message]


def rewrite(
    source: Path,
    target: Path,
    change: Change = unchanged,
    *,
    chunk_size: int = 4096,
    compression: CompressionType = CompressionType.LZ4,
    in_file_order: bool = True,
    first_channel: int = 1,
    metadata: Callable[[str, dict[str, str]], dict[str, str] | None] = lambda name, values: values,
    attachments: bool = True,
) -> None:
    """Write a log again; `change` returns what takes the place of a message, `metadata` None to leave a record out."""
    with source.open("rb") as file, target.open("wb") as out:
        reader = make_reader(file)
        writer = Writer(out, chunk_size=chunk_size, compression=compression)
        writer.start(library="another program")
        for record in reader.iter_metadata():
            values = metadata(record.name, dict(record.metadata))
            if values is not None:
                writer.add_metadata(record.name, values)
        index = reader.get_summary()
        assert index is not None
        channels: dict[int, int] = {}
        for number in range(1, first_channel):
            writer.register_channel(f"/other/{number}", "json", 0)
        for channel in sorted(index.channels.values(), key=lambda one: (first_channel > 1) * -one.id):
            schema = index.schemas[channel.schema_id]
            new = writer.register_schema(schema.name, schema.encoding, schema.data)
            channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, new)
        for _, channel, message in reader.iter_messages(log_time_order=not in_file_order):
            for one in change(channel, message):
                writer.add_message(channels[channel.id], one.log_time, one.data, one.publish_time, one.sequence)
        for attachment in reader.iter_attachments() if attachments else ():
            writer.add_attachment(
                attachment.create_time, attachment.log_time, attachment.name, attachment.media_type, attachment.data
            )
        writer.finish()
