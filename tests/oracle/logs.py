"""A log as plain values, read with the mcap libraries and the descriptors inside the log, not with closecall."""

from __future__ import annotations

from collections.abc import Callable, MutableSequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from google.protobuf.message import Message
from google.protobuf.message_factory import GetMessageClass
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

Values = dict[str, Any]

TOPICS = ("wakeups", "distances", "collisions", "spans", "windows", "world", "tf")
"""What the oracle reads of a log; what viewers draw is left out."""


@dataclass
class Log:
    """A decoded log.

    Attributes:
        topics: for each topic without its slash ("spans", "distances", "tf", ...) its messages in the log's order, as
            plain values: enums by name, timestamps in integer ns, points as {"x", "y", "z"}. Each also has
            "log_time" and "publish_time", ns. Topics by body ("/distances/<body>") are put together.
        metadata: by record name.
        attachments: by name.
    """

    topics: dict[str, list[Values]] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)

    def of(self, topic: str) -> list[Values]:
        """Return a topic's messages, none if the log does not have it."""
        return self.topics.get(topic, [])

    def by_pair(self, topic: str) -> dict[str, list[Values]]:
        """Return a topic's messages by the name of their pair, in the log's order."""
        out: dict[str, list[Values]] = {}
        for message in self.of(topic):
            out.setdefault(message["pair"], []).append(message)
        return out


def read_log(path: Path) -> Log:
    """Read a whole log; damaged records raise what the mcap library raises."""
    log = Log()
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        channels = [] if summary is None else summary.channels.values()
        wanted = [one.topic for one in channels if topic_of(one.topic) in TOPICS]
        for _, channel, record, message in reader.iter_decoded_messages(wanted):
            times = {"log_time": record.log_time, "publish_time": record.publish_time}
            log.topics.setdefault(topic_of(channel.topic), []).append(values(message) | times)
        log.metadata = {record.name: dict(record.metadata) for record in reader.iter_metadata()}
        log.attachments = {record.name: record.data for record in reader.iter_attachments()}
    return log


def topic_of(name: str) -> str:
    """Return a topic without its slash, and without its body."""
    topic = name.removeprefix("/")
    return topic.split("/")[0] if topic.startswith(("wakeups", "distances", "collisions")) else topic


def values(message: Message) -> Values:
    """Return a message's fields by name, defaults included."""
    out: Values = {}
    for name, repeated, convert in plan(message.DESCRIPTOR):
        value = getattr(message, name)
        if convert is not None:
            value = [convert(item) for item in value] if repeated else convert(value)
        out[name] = list(value) if repeated else value
    return out


@lru_cache
def plan(descriptor: Any) -> list[tuple[str, bool, Callable[[Any], Any] | None]]:
    """Return of each field its name, whether it is repeated, and what makes a value plain, None if it is already."""
    probe = GetMessageClass(descriptor)()
    return [
        (one.name, isinstance(getattr(probe, one.name), MutableSequence), plainer(one)) for one in descriptor.fields
    ]


def plainer(field_: Any) -> Callable[[Any], Any] | None:
    """Return how a field is made plain: enums to names (unknown numbers stay numbers), timestamps to ns."""
    if field_.enum_type is not None:
        names = {number: value.name for number, value in field_.enum_type.values_by_number.items()}
        return lambda number: names.get(number, number)
    if field_.message_type is None:
        return None
    if field_.message_type.full_name in ("google.protobuf.Timestamp", "google.protobuf.Duration"):
        return lambda time: time.seconds * 1_000_000_000 + time.nanos
    return values
