"""A log's messages as rows of tables: one table a topic, its columns the fields of the messages."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from math import isfinite
from operator import attrgetter
from typing import Any

from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import Message

from .. import messages_pb2 as pb
from ..container.identity import Identity

Cell = float | int | str | None
Row = tuple[Cell, ...]


@dataclass(frozen=True, slots=True)
class Column:
    """A column: its name, and whether it holds "double", "int64", "uint64" or "string"."""

    name: str
    kind: str


@dataclass(frozen=True, slots=True)
class Table:
    """The rows that messages of one topic make.

    Attributes:
        name: of the topic, without its slash.
        rows: the cells of each row that a message makes, after the two of its time. What is unknown is None.
    """

    name: str
    columns: tuple[Column, ...]
    rows: Callable[[Any], Iterator[Row]]

    def timed_rows(self, identity: Identity, log_time: int, message: Any) -> Iterator[Row]:
        """Yield the rows of a message, its time in s and its log time in ns first."""
        for row in self.rows(message):
            yield identity.seconds(log_time), log_time, *row


_TIMES = (Column("time", "double"), Column("log_time", "int64"))
_KINDS = {
    FieldDescriptor.CPPTYPE_DOUBLE: "double",
    FieldDescriptor.CPPTYPE_UINT32: "uint64",
    FieldDescriptor.CPPTYPE_UINT64: "uint64",
    FieldDescriptor.CPPTYPE_STRING: "string",
    FieldDescriptor.CPPTYPE_ENUM: "string",
}


def table_of(topic: str) -> Table | None:
    """Return the table of a topic; None for what is drawn, which makes no rows."""
    if topic.startswith("/distances/"):
        topic = "/distances"
    return tables().get(topic)


@cache
def tables() -> dict[str, Table]:
    """Return all tables, by topic."""
    flat: dict[str, type[Message]] = {
        "/wakeups": pb.Wakeup,
        "/distances": pb.Distance,
        "/collisions": pb.Collision,
        "/spans": pb.Span,
        "/windows": pb.Window,
    }
    made = {topic: _flat_table(topic, kind.DESCRIPTOR) for topic, kind in flat.items()}
    return made | {"/world": _WORLD, "/tf": _FRAMES, "/log": _LOG}


def _flat_table(topic: str, descriptor: Any) -> Table:
    """Return the table of messages whose every field makes a column."""
    fields = list(_leaves(descriptor, ""))
    names = [path.replace(".", "_") for path, _ in fields]
    columns = tuple(Column(name, _KINDS[one.cpp_type]) for name, (_, one) in zip(names, fields, strict=True))
    read = attrgetter(*(path for path, _ in fields))
    plain = [_plain(one) for _, one in fields]

    def rows(message: Any) -> Iterator[Row]:
        yield tuple(value if one is None else one(value) for one, value in zip(plain, read(message), strict=True))

    return Table(topic[1:], (*_TIMES, *columns), rows)


def _leaves(descriptor: Any, prefix: str) -> Iterator[tuple[str, FieldDescriptor]]:
    """Yield the fields that hold values, with the dotted path to each; the stamp is a column already."""
    for one in descriptor.fields:
        if one.message_type is None:
            yield f"{prefix}{one.name}", one
        elif one.message_type.full_name != "google.protobuf.Timestamp":
            yield from _leaves(one.message_type, f"{prefix}{one.name}.")


def _plain(one: FieldDescriptor) -> Callable[[Any], Cell] | None:
    """Return what makes a field's value a cell, None where it is one already."""
    if one.enum_type is not None:
        names = {number: value.name for number, value in one.enum_type.values_by_number.items()}
        return lambda number: names.get(number, str(number))
    return _known if one.cpp_type == FieldDescriptor.CPPTYPE_DOUBLE else None


def _known(value: float) -> float | None:
    """Return a number, None for one that says nothing."""
    return value if isfinite(value) else None


def _world_rows(message: Any) -> Iterator[Row]:
    nearest = [{"pair": one.pair, "distance": _known(one.distance), "verdict": one.verdict} for one in message.pairs]
    yield _known(message.min_distance), message.pair, message.contacts, json.dumps(nearest, ensure_ascii=False)


def _frame_rows(message: Any) -> Iterator[Row]:
    for one in message.transforms:
        at, turn = one.translation, one.rotation
        yield one.parent_frame_id, one.child_frame_id, at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w


def _log_rows(message: Any) -> Iterator[Row]:
    names = message.DESCRIPTOR.fields_by_name["level"].enum_type.values_by_number
    yield names[message.level].name if message.level in names else str(message.level), message.message


def _columns(kind: str, *names: str) -> tuple[Column, ...]:
    return tuple(Column(name, kind) for name in names)


_WORLD = Table(
    "world",
    (
        *_TIMES,
        *_columns("double", "min_distance"),
        *_columns("string", "pair"),
        *_columns("uint64", "contacts"),
        *_columns("string", "pairs"),
    ),
    _world_rows,
)
_FRAMES = Table(
    "tf",
    (
        *_TIMES,
        *_columns("string", "parent_frame_id", "child_frame_id"),
        *_columns("double", "x", "y", "z", "qx", "qy", "qz", "qw"),
    ),
    _frame_rows,
)
_LOG = Table("log", (*_TIMES, *_columns("string", "level", "message")), _log_rows)
