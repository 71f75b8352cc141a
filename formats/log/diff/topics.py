"""Two logs compared message by message, in whatever order each has them: for `diff --all`."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from math import isnan, nan
from typing import Any

from google.protobuf.descriptor import Descriptor, FieldDescriptor

from ..container.clock import NANOSECONDS_PER_SECOND
from ..container.sources import Source
from ..reader import LogReader
from .difference import Cause, Difference, Ignored, Tolerances

# Messages of one log that wait for their like in the other: some hundred bytes each. The oldest are given up.
_MOST_WAITING = 50_000

_TIMES = frozenset(("start", "end", "time_clear", "time_touching", "sleep"))

# Ranks of pairs shift where bodies come or go; pairs are known by name.
_RENUMBERED = frozenset(("pair_id",))

_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
_VERSION = re.compile(r"^closecall \S+ runs ")

_Key = tuple[str, str, int]  # topic, subject, step of time
_Told = tuple[Source, int, bytes, Any]  # where from, ns since the epoch, the message as bytes and as itself


@dataclass(slots=True)
class _Tally:
    """Differences of one kind, counted."""

    golden: float | str | None
    new: float | str | None
    change: float
    unit: str
    time: float
    count: int = 1


@dataclass(slots=True)
class _Side:
    """One of the two logs, and its messages that wait for their like in the other."""

    cause: Cause
    messages: Iterator[_Told]
    waiting: dict[_Key, deque[tuple[int, bytes]]] = field(default_factory=dict)
    count: int = 0


class TopicDiff:
    """Compares two logs' messages: those of one topic and pair (or body) at one time are each other's like.

    Memory holds messages without their like, up to a limit, and a count for each pair and field that differ.
    """

    def __init__(self, golden: LogReader, new: LogReader, tolerances: Tolerances, ignored: Ignored) -> None:
        self._tolerances = tolerances
        self._ignored = ignored
        self._step = max(1, round(tolerances.times(golden.identity.end) * NANOSECONDS_PER_SECOND))
        self._sides = (_Side(Cause.MISSING, self._relative(golden)), _Side(Cause.EXTRA, self._relative(new)))
        self._tallies: dict[tuple[Cause, str], _Tally] = {}

    def differences(self) -> Iterator[Difference]:
        """Read both logs to their ends, and yield what differs: by topic, field and pair, with how often."""
        golden, new = self._sides
        one, other = next(golden.messages, None), next(new.messages, None)
        while one is not None or other is not None:
            if one is not None and other is not None and one[1:3] == other[1:3] and one[0].topic == other[0].topic:
                one, other = next(golden.messages, None), next(new.messages, None)
            elif other is None or (one is not None and one[1] <= other[1]):
                assert one is not None
                self._take(one, golden, new)
                one = next(golden.messages, None)
            else:
                self._take(other, new, golden)
                other = next(new.messages, None)
        for side in self._sides:
            self._give_up(side, 0)
        for (cause, subject), tally in self._tallies.items():
            told = tally.golden, tally.new, tally.change, tally.unit, tally.time
            yield Difference(cause, subject, *told, count=tally.count)

    def _relative(self, log: LogReader) -> Iterator[_Told]:
        """Yield a log's messages with their times since its epoch, those that say what cannot be left out."""
        epoch = log.identity.epoch
        wanted: dict[str, bool] = {}
        for source, log_time, data in log.messages():
            if source.topic not in wanted:
                wanted[source.topic] = source.kind is not None and not self._ignored.topic(source.topic)
            message = log.fact(source, log_time, data) if wanted[source.topic] else None
            if message is not None:
                yield source, log_time - epoch, data, message

    def _take(self, told: _Told, side: _Side, opposite: _Side) -> None:
        """Compare a message with its like if that waits, else let it wait."""
        source, time, data, decoded = told
        assert source.kind is not None
        subject = getattr(decoded, "pair", "") if source.topic != "/world" else ""
        subject = subject or getattr(decoded, "body", "")
        if self._ignored.patterns and "|" in subject and self._ignored.pair(subject):
            return
        step = time // self._step
        for near in (step, step - 1, step + 1):
            waiting = opposite.waiting.get((source.topic, subject, near))
            found = None if waiting is None else self._nearest(waiting, time)
            if waiting is not None and found is not None:
                like = source.kind.FromString(waiting[found][1])
                del waiting[found]
                opposite.count -= 1
                if not waiting:
                    del opposite.waiting[source.topic, subject, near]
                pair = (like, decoded) if side.cause is Cause.EXTRA else (decoded, like)
                self._compare(source.topic, subject, time / NANOSECONDS_PER_SECOND, *pair)
                return
        side.waiting.setdefault((source.topic, subject, step), deque()).append((time, data))
        side.count += 1
        if side.count > _MOST_WAITING:
            self._give_up(side, _MOST_WAITING // 2)

    def _nearest(self, waiting: deque[tuple[int, bytes]], time: int) -> int | None:
        for index, (waited, _) in enumerate(waiting):
            if abs(waited - time) <= max(
                self._tolerances.times(time / NANOSECONDS_PER_SECOND) * NANOSECONDS_PER_SECOND, 1.0
            ):
                return index
        return None

    def _give_up(self, side: _Side, most: int) -> None:
        """Count the messages that wait longest as differences, until no more than `most` wait."""
        for key in list(side.waiting):
            if side.count <= most:
                return
            topic, subject, _ = key
            for time, _ in side.waiting.pop(key):
                side.count -= 1
                seconds = time / NANOSECONDS_PER_SECOND
                self._tally(side.cause, f"{topic} {subject}".rstrip(), None, None, nan, "", seconds)

    def _compare(self, topic: str, subject: str, time: float, golden: Any, new: Any) -> None:
        if topic == "/log":
            if not self._same_text(golden.message, new.message):
                self._tally(Cause.FIELD, "/log.message", golden.message, new.message, nan, "", time)
            return
        for name, old, now in _changes(golden, new, ""):
            field_name = name.rsplit(".", 1)[-1]
            unit = "s" if field_name in _TIMES else "m"
            if isinstance(old, float) and isinstance(now, float):
                allowed = self._tolerances.times(old) if unit == "s" else self._tolerances.distances(old)
                if abs(now - old) <= allowed or (isnan(old) and isnan(now)):
                    continue
            if not self._ignored.field(topic, name):
                numbers = isinstance(old, float) and isinstance(now, float)
                change = now - old if numbers else nan
                self._tally(Cause.FIELD, f"{topic}.{name} {subject}".rstrip(), old, now, change, unit * numbers, time)

    def _same_text(self, golden: str, new: str) -> bool:
        """Tell whether two lines say the same, but for the version and what numbers may differ by."""
        golden, new = _VERSION.sub("", golden), _VERSION.sub("", new)
        if _NUMBER.sub("#", golden) != _NUMBER.sub("#", new):
            return False
        numbers, new_numbers = _NUMBER.findall(golden), _NUMBER.findall(new)
        pairs = zip(numbers, new_numbers, strict=False)
        return len(numbers) == len(new_numbers) and all(
            a == b or abs(float(a) - float(b)) <= self._tolerances.times(float(a)) for a, b in pairs
        )

    def _tally(self, cause: Cause, subject: str, golden: Any, new: Any, change: float, unit: str, time: float) -> None:
        tally = self._tallies.get((cause, subject))
        if tally is None:
            self._tallies[cause, subject] = _Tally(golden, new, change, unit, time)
            return
        tally.count += 1
        tally.time = min(tally.time, time)
        if abs(change) > abs(tally.change):
            tally.golden, tally.new, tally.change = golden, new, change


def _changes(golden: Any, new: Any, prefix: str) -> Iterator[tuple[str, Any, Any]]:
    """Yield the fields of two messages that are not equal, by name; enums by their names, timestamps left out."""
    for name, repeated, kind, enum in _plan(golden.DESCRIPTOR):
        old, now = getattr(golden, name), getattr(new, name)
        if old == now:
            continue
        full = f"{prefix}{name}"
        if repeated:
            if len(old) != len(now):
                yield full, f"{len(old)} of them", f"{len(now)} of them"
            elif kind:
                for one, other in zip(old, now, strict=True):
                    yield from _changes(one, other, f"{full}.")
            else:
                yield from ((full, one, other) for one, other in zip(old, now, strict=True) if one != other)
        elif kind:
            yield from _changes(old, now, f"{full}.")
        elif enum is not None:
            yield full, enum.get(old, str(old)), enum.get(now, str(now))
        else:
            yield full, old if isinstance(old, float) else str(old), now if isinstance(now, float) else str(now)


@cache
def _plan(descriptor: Descriptor) -> list[tuple[str, bool, bool, dict[int, str] | None]]:
    """Return of each field that counts its name, whether it is repeated, whether a message, and its enum's names."""
    plan = []
    for one in descriptor.fields:
        message = one.message_type
        if one.name in _RENUMBERED or (message is not None and message.full_name == "google.protobuf.Timestamp"):
            continue
        names = None
        if one.enum_type is not None:
            names = {number: value.name for number, value in one.enum_type.values_by_number.items()}
        plan.append((one.name, _repeated(one), message is not None, names))
    return plan


def _repeated(one: Any) -> bool:
    """Tell whether a field is a list, as the protobufs of all years say it."""
    flag = getattr(one, "is_repeated", None)
    return bool(one.label == FieldDescriptor.LABEL_REPEATED if flag is None else flag)
