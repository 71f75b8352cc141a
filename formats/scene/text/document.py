"""A document as plain Python values, with the line and column of every key and value."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import NamedTuple, NoReturn

from .errors import Fault, SceneError, Where, place_text, suggestion

Value = str | int | float | bool | dict[str, "Value"] | tuple["Value", ...]
"""What a document holds: lists are tuples, and nothing is null."""

NULL = "nothing is written here, give a value ({} for an empty mapping) or leave the key out"

MOST_COMPARISONS = 30_000
"""Names compared for suggestions in one reading, about a second's work. Thousands of faults are told without."""

Position = tuple[int, int]
"""Line and column, both from 1."""


@dataclass(frozen=True, slots=True)
class Document:
    """A parsed scene file.

    Attributes:
        file: its name, for messages.
        value: the root value.
        values: where each value begins.
        keys: where the key of each value in a mapping begins.
    """

    file: str
    value: Value
    values: Mapping[Where, Position]
    keys: Mapping[Where, Position]

    def value_position(self, where: Where) -> Position:
        """Return where the value at `where` begins, or the nearest value around it."""
        while where not in self.values and where:
            where = where[:-1]
        return self.values.get(where, (1, 1))

    def key_position(self, where: Where) -> Position:
        """Return where the key of the value at `where` begins, or the value itself if it has none."""
        return self.keys.get(where) or self.value_position(where)


class Loose(NamedTuple):
    """A rotation that is not quite one: where, how far it stretches, less 1, and what is off."""

    where: Where
    stretch: float
    told: str


class Findings:
    """What is wrong with a document and what is doubtful, gathered so that one reading tells all of it."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.loose_rotations: list[Loose] = []
        self.faults: list[Fault] = []
        self.warnings: list[Fault] = []
        self._comparisons_left = MOST_COMPARISONS

    def fault(self, where: Where, message: str) -> None:
        """Record that the value at `where` is wrong."""
        self.faults.append(self._located(self.document.value_position(where), where, message))

    def fault_at_key(self, where: Where, message: str, place: Where | None = None) -> None:
        """Record a fault of the key at `where`, naming `place` (default: `where`)."""
        position = self.document.key_position(where)
        self.faults.append(self._located(position, where if place is None else place, message))

    def warn(self, where: Where, message: str) -> None:
        """Record that the value at `where` is doubtful."""
        self.warnings.append(self._located(self.document.value_position(where), where, message))

    def loose(self, where: Where, stretch: float, told: str) -> None:
        """Record a rotation that is not quite one; what that moves is known only when all is read."""
        self.loose_rotations.append(Loose(where, stretch, told))

    def suggestion(self, name: str, candidates: Collection[str]) -> str:
        """Return ` (did you mean 'x'?)` for the nearest of the names that there are, while there is time to look."""
        self._comparisons_left -= len(candidates)
        return suggestion(name, candidates) if self._comparisons_left >= 0 else ""

    def stop_if_faulty(self) -> None:
        """Raise SceneError if any fault was found."""
        if self.faults:
            raise SceneError(self.faults)

    def _located(self, position: Position, where: Where, message: str) -> Fault:
        return Fault(self.document.file, *position, place_text(where), message)


def refuse(file: str, position: Position, where: Where, message: str) -> NoReturn:
    """Raise SceneError with one fault."""
    raise SceneError((Fault(file, *position, place_text(where), message),))
