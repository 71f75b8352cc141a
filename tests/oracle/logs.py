"""A log as plain values, read with the mcap libraries and the descriptors inside the log, not with closecall."""

from __future__ import annotations

from collections.abc import MutableSequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from google.protobuf.message import Message
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

Values = dict[str, Any]


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
        for _, channel, record, message in reader.iter_decoded_messages():
            times = {"log_time": record.log_time, "publish_time": record.publish_time}
            topic = channel.topic.removeprefix("/")
            topic = topic.split("/")[0] if topic.startswith(("wakeups", "distances", "collisions")) else topic
            log.topics.setdefault(topic, []).append(values(message) | times)
        log.metadata = {record.name: dict(record.metadata) for record in reader.iter_metadata()}
        log.attachments = {record.name: record.data for record in reader.iter_attachments()}
    return log


def values(message: Message) -> Values:
    """Return a message's fields by name, defaults included."""
    out: Values = {}
    for one in message.DESCRIPTOR.fields:
        value = getattr(message, one.name)
        repeated = isinstance(value, MutableSequence)
        out[one.name] = [plain(one, item) for item in value] if repeated else plain(one, value)
    return out


def plain(field_: Any, value: Any) -> Any:
    """Return one value of a field: enums as their names (unknown numbers stay numbers), timestamps in ns."""
    if field_.enum_type is not None:
        named = field_.enum_type.values_by_number.get(value)
        return value if named is None else named.name
    if field_.message_type is None:
        return value
    if field_.message_type.full_name in ("google.protobuf.Timestamp", "google.protobuf.Duration"):
        return value.seconds * 1_000_000_000 + value.nanos
    return values(value)
