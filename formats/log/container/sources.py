"""The topics of a log: which channel is which, and whether its messages are what closecall writes there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from google.protobuf.message import Message
from mcap.records import Channel, Schema
from mcap.well_known import MessageEncoding, SchemaEncoding

from ...scene.text.errors import quoted
from .checks import TYPES


@dataclass(frozen=True, slots=True)
class Source:
    """Where messages come from: a topic, and the type of its messages, None where that is not what closecall writes."""

    topic: str
    kind: type[Message] | None

    @property
    def shared_topic(self) -> str:
        """The topic, of those by body without the body."""
        return _shared(self.topic)


class Sources:
    """The channels that a log has named so far.

    Args:
        wanted: topics, of those by body without the body; all if there are none.
        doubt: is told what is wrong with a schema or a channel.
    """

    def __init__(self, wanted: frozenset[str], doubt: Callable[[str], None]) -> None:
        self._wanted = wanted
        self._doubt = doubt
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._sources: dict[int, Source] = {}

    def knows(self, channel: int) -> bool:
        """Tell whether the log has named a channel."""
        return channel in self._channels

    def wanted(self, channel: int) -> Source | None:
        """Return a channel's source; None where its topic is not wanted."""
        return self._sources.get(channel)

    def add_schema(self, schema: Schema) -> None:
        """Take note of a schema."""
        if self._schemas.setdefault(schema.id, schema) != schema:
            self._doubt(f"schema {schema.id} has two different definitions")

    def add_channel(self, channel: Channel) -> None:
        """Take note of a channel; its schema comes first."""
        if channel.id in self._channels:
            if self._channels[channel.id] != channel:
                self._doubt(f"channel {channel.id} has two different definitions")
            return
        self._channels[channel.id] = channel
        kind = self._kind(channel)
        if not self._wanted or _shared(channel.topic) in self._wanted:
            self._sources[channel.id] = Source(channel.topic, kind)

    def _kind(self, channel: Channel) -> type[Message] | None:
        """Return the type of a channel's messages; None for topics of others, and, with a doubt, for a wrong type."""
        kind = TYPES.get(_shared(channel.topic))
        if kind is None:
            return None
        schema = self._schemas.get(channel.schema_id)
        told = (schema and schema.name, schema and schema.encoding, channel.message_encoding)
        right = (kind.DESCRIPTOR.full_name, SchemaEncoding.Protobuf, MessageEncoding.Protobuf)
        for one, other in zip(told, right, strict=True):
            if one != other:
                self._doubt(
                    f"topic {quoted(channel.topic)} has the type {quoted(one or 'no schema')}, expected {other}"
                )
                return None
        return kind


def _shared(topic: str) -> str:
    return "/distances" if topic.startswith("/distances/") else topic
