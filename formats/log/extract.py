"""A part of a log as a log of its own."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from closecall import __version__

from . import messages_pb2 as pb
from .container.chunks import Channel, ChunkWriter, Compression
from .container.contents import LOST, METADATA, METADATA_AT_START, SUMMARY
from .container.identity import Identity
from .container.output import LOG, Output, published
from .message_filter import Choice, is_pair_among
from .reader import LogReader, Loss
from .result import Folding
from .summary import to_json

# What viewers need of the time before a part begins: what the bodies look like.
_STANDING = frozenset(("/scene/meshes", "/scene/boxes"))

_FOLDED = (pb.Wakeup, pb.Distance, pb.Collision, pb.Span)


@dataclass(frozen=True, slots=True)
class Part:
    """What was taken: how many messages of how many, of how many pairs, and what of the log could not be read."""

    messages: int
    of: int
    pairs: int
    loss: Loss | None


@dataclass(slots=True)
class _Contents:
    """What a part must be known to hold before it is written: pairs, whether these are all, and when they touch, s."""

    pairs: set[str] = field(default_factory=set)
    complete: bool = True
    contacts: dict[str, list[tuple[float, float]]] = field(default_factory=lambda: defaultdict(list))

    def touches(self, pair: str, time: float) -> bool:
        """Tell whether a pair is in one of its contacts at a time, s."""
        return any(start <= time <= end for start, end in self.contacts.get(pair, ()))


def write_part(log: Path, target: Path, choice: Choice) -> Part:
    """Write the messages that are chosen, and what travels with the log, as a log of that time and those pairs.

    Messages stay as they are. Spans, windows and contacts that reach into the time are kept whole, so that the part
    says of its time what the log said. Its summary is of the part; of a log that could not all be read there is none,
    and whoever reads the part is told so.

    Raises:
        LogError: for what is no log of closecall, and for an output that cannot be written.
    """
    output = Output(target, [log], LOG)
    contents = _contents(log, choice)
    with LogReader(log) as reader:
        identity = _identity(reader.identity, choice, contents)
        with published(output) as stream:
            return _write(reader, identity, choice, contents, ChunkWriter(stream, Compression.ZSTD, _library()))


def _library() -> str:
    return f"closecall {__version__}"


def _contents(log: Path, choice: Choice) -> _Contents:
    contents = _Contents()
    with LogReader(log) as reader:
        for _, log_time, message in reader.facts("/spans"):
            if choice.wants(message, reader.identity.seconds(log_time)):
                contents.pairs.add(message.pair)
                if message.verdict == pb.Span.CONTACT:
                    contents.contacts[message.pair].append((message.start, message.end))
        contents.complete = reader.loss is None
    return contents


def _identity(whole: Identity, choice: Choice, contents: _Contents) -> Identity:
    """Return the part's identity: its own time, and, where pairs were chosen and all are known, no more of them."""
    return replace(
        whole,
        start=max(whole.start, min(choice.start, whole.end)),
        end=min(whole.end, max(choice.end, whole.start)),
        pairs_total=len(contents.pairs) if choice.pairs and contents.complete else whole.pairs_total,
    )


def _write(reader: LogReader, identity: Identity, choice: Choice, contents: _Contents, chunks: ChunkWriter) -> Part:
    changed = {
        "start": repr(identity.start),
        "end": repr(identity.end),
        "count/pairs": str(identity.pairs_total),
        "part": _told(choice),
    }
    values = {key: value for key, value in reader.values.items() if not key.startswith("count/")}
    values |= {"count/bodies": str(identity.bodies), "count/ignored": str(identity.pairs_ignored), **changed}
    chunks.add_metadata(METADATA_AT_START, values)
    for attachment in reader.attachments():
        if attachment.name != SUMMARY:
            chunks.add_attachment(attachment.name, attachment.media_type, attachment.data, attachment.log_time)
    folding = Folding(identity)
    channels: dict[str, Channel] = {}
    taken = count = 0
    for source, log_time, message in reader.facts():
        count += 1
        time = identity.seconds(log_time)
        if not choice.wants_topic(source.shared_topic) or not _is_wanted(message, source.topic, time, choice, contents):
            continue
        if isinstance(message, _FOLDED):
            folding.add(message, time)
        channel = channels.get(source.topic)
        if channel is None:
            channel = channels[source.topic] = Channel(source.topic, type(message))
        chunks.add_serialized(channel, message.SerializeToString(), log_time)
        taken += 1
    chunks.flush()
    summary, loss = folding.found(None).summary, reader.loss
    counts = {f"count{name}": str(one.written) for name, one in channels.items()}
    chunks.add_metadata(METADATA, values | counts | ({} if loss is None else {LOST: loss.told}))
    if loss is None and summary["pairs_total"] == identity.pairs_total:  # a foreign log may name more than it counts
        data = to_json(summary).encode()
        chunks.add_attachment(SUMMARY, "application/json", data, identity.log_time(identity.end))
    chunks.finish()
    return Part(taken, count, len(contents.pairs), loss)


def _is_wanted(message: Any, topic: str, time: float, choice: Choice, contents: _Contents) -> bool:
    if topic in _STANDING:
        return time <= choice.end
    if isinstance(message, pb.Collision):
        if choice.pairs and not is_pair_among(message.pair, choice.pairs):
            return False
        return choice.wants(message, time) or contents.touches(message.pair, message.time_touching)
    if isinstance(message, _FOLDED):
        return choice.wants(message, time)
    return replace(choice, pairs=()).wants(message, time)


def _told(choice: Choice) -> str:
    """Return what was chosen, for the record."""
    named = [*choice.topics, *choice.pairs]
    return f"{choice.start!r} s to {choice.end!r} s{', ' if named else ''}{', '.join(named)}"
