"""JSON with lines.

libyaml does not read all of it: not surrogate pairs, keys over 1024 characters, or a colon in the line after its key.
"""

from __future__ import annotations

import json
import re
from bisect import bisect_right
from typing import NoReturn

from ..limits import DEEPEST_NESTING
from .document import NULL, Document, Position, Value, refuse
from .errors import Where, quoted
from .scalars import NotFiniteError, number

_SPACE = re.compile(r"[ \t\n\r]*")
_SURROGATE = re.compile("[\ud800-\udfff]")


def read_json(text: str, file: str) -> Document:
    """Parse one JSON document without duplicate keys.

    Args:
        text: the document, decoded.
        file: its name, for messages.

    Raises:
        SceneError: with the position of the first thing that cannot be read.
    """
    return _Reader(text, file).document()


def _not_finite(text: str) -> NoReturn:
    raise NotFiniteError(text)


_SCALARS = json.JSONDecoder(parse_int=number, parse_float=number, parse_constant=_not_finite)


class _Reader:
    """A descent over the text; recursion goes no deeper than DEEPEST_NESTING."""

    def __init__(self, text: str, file: str) -> None:
        self._text = text
        self._file = file
        self._at = 0
        self._lines = [0, *(found.end() for found in re.finditer("\n", text))]
        self._values: dict[Where, Position] = {}
        self._keys: dict[Where, Position] = {}

    def document(self) -> Document:
        """Return the whole text as a document."""
        if not self._text.strip(" \t\n\r"):
            self._refuse((), 'the file is empty, a scene begins with {"closecall": 1')
        value = self._value((), 0)
        if self._next():
            self._refuse((), "more text follows the end of the document")
        return Document(self._file, value, self._values, self._keys)

    def _value(self, where: Where, depth: int) -> Value:
        first = self._next()
        self._values[where] = self._position()
        if first not in ("{", "["):
            return self._scalar(where)
        if depth == DEEPEST_NESTING:
            self._refuse(where, f"nested more than {DEEPEST_NESTING} deep")
        self._at += 1
        return self._mapping(where, depth) if first == "{" else self._list(where, depth)

    def _mapping(self, where: Where, depth: int) -> dict[str, Value]:
        values: dict[str, Value] = {}
        while self._another(where, "}", bool(values)):
            if self._next() != '"':
                self._refuse(where, "not valid JSON: expected a key in double quotes")
            position = self._position()
            key = str(self._scalar(where))
            if key in values:
                self._refuse_at(position, (*where, key), f"the key {quoted(key)} appears twice, remove one")
            inner = (*where, key)
            self._keys[inner] = position
            if self._next() != ":":
                self._refuse(where, "not valid JSON: expected ':' after the key")
            self._at += 1
            values[key] = self._value(inner, depth + 1)
        return values

    def _list(self, where: Where, depth: int) -> tuple[Value, ...]:
        values: list[Value] = []
        while self._another(where, "]", bool(values)):
            values.append(self._value((*where, len(values)), depth + 1))
        return tuple(values)

    def _another(self, where: Where, end: str, after_one: bool) -> bool:
        """Step over the comma before the next item, or over `end`, and tell which it was."""
        found = self._next()
        if found == end:
            self._at += 1
            return False
        if after_one:
            if found != ",":
                self._refuse(where, f"not valid JSON: expected ',' or '{end}'")
            self._at += 1
        return True

    def _scalar(self, where: Where) -> Value:
        try:
            value, end = _SCALARS.raw_decode(self._text, self._at)
        except NotFiniteError:
            self._refuse(where, "expected a finite number")
        except json.JSONDecodeError as error:
            self._at = error.pos
            self._refuse(where, f"not valid JSON: {error.msg.lower()}")
        if value is None:
            self._refuse(where, NULL)
        if isinstance(value, str) and _SURROGATE.search(value):
            self._refuse(where, "half of a surrogate pair is not a character")
        self._at = end
        scalar: Value = value
        return scalar

    def _next(self) -> str:
        """Skip white space; return the character that follows, empty at the end."""
        found = _SPACE.match(self._text, self._at)
        self._at = found.end() if found else self._at
        return self._text[self._at : self._at + 1]

    def _position(self) -> Position:
        line = bisect_right(self._lines, self._at)
        return line, self._at - self._lines[line - 1] + 1

    def _refuse(self, where: Where, message: str) -> NoReturn:
        self._refuse_at(self._position(), where, message)

    def _refuse_at(self, position: Position, where: Where, message: str) -> NoReturn:
        refuse(self._file, position, where, message)
