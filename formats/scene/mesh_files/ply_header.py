"""The header of a PLY file: which elements follow, in what encoding, with what properties."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from ..text.errors import quoted
from .surface import MeshError

_CODES = {
    "char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H", "uint16": "H",
    "int": "i", "int32": "i", "uint": "I", "uint32": "I", "float": "f", "float32": "f", "double": "d", "float64": "d",
}  # fmt: skip
"""The type names of PLY, old and new, and the letters of Python's struct and of numpy for them."""

_SIZES = {"b": 1, "B": 1, "h": 2, "H": 2, "i": 4, "I": 4, "f": 4, "d": 8}
_INTEGERS = frozenset("bBhHiI")
_ENCODINGS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_MOST_DIGITS = 18
_LONGEST_NAME = 32
_FIRST_LINE = re.compile(rb"ply[ \t]*(\r\n|\n|\r)")


@dataclass(frozen=True, slots=True)
class Property:
    """One property of an element: its type's letter, and that of the count if it is a list."""

    name: str
    code: str
    count_code: str | None

    @property
    def least_size(self) -> int:
        """Bytes of the value in binary files, or of an empty list."""
        return _SIZES[self.count_code or self.code]

    @property
    def is_list_of_integers(self) -> bool:
        """Whether it can be the corners of a polygon."""
        return self.count_code is not None and self.code in _INTEGERS


@dataclass(frozen=True, slots=True)
class Element:
    """Rows of one kind, `count` of them, each with these properties in this order."""

    name: str
    count: int
    properties: tuple[Property, ...]

    @property
    def shown(self) -> str:
        """The name as messages show it."""
        return self.name if self.name.isidentifier() and len(self.name) < _LONGEST_NAME else quoted(self.name)

    @property
    def has_lists(self) -> bool:
        """Whether rows differ in length."""
        return any(part.count_code for part in self.properties)

    @property
    def least_size(self) -> int:
        """Bytes of a row with empty lists in binary files: a bound on how many rows a file can hold."""
        return sum(part.least_size for part in self.properties)


@dataclass(frozen=True, slots=True)
class Header:
    """What the header says.

    Attributes:
        order: `<` or `>` for binary files, empty for ASCII.
        elements: in the file's order.
        size: bytes of the header itself.
        lines: of the header itself.
    """

    order: str
    elements: tuple[Element, ...]
    size: int
    lines: int


def read_header(data: bytes) -> Header:
    """Return the header of a PLY file.

    Raises:
        MeshError: it is none, is cut short, or says what PLY does not know.
    """
    first = _FIRST_LINE.match(data)
    if first is None:
        raise MeshError("expected 'ply' on the first line", 1)
    last = re.search(rb"[\r\n]end_header[ \t]*" + re.escape(first[1]), data)
    if last is None:
        raise MeshError("the header is cut short: expected 'end_header'")
    lines = data[: last.end()].splitlines()
    order, elements = _declarations(lines[1:-1])
    if order is None:
        raise MeshError("the header has no 'format', expected one of " + ", ".join(_ENCODINGS))
    return Header(order, tuple(elements), last.end(), len(lines))


def _declarations(lines: list[bytes]) -> tuple[str | None, list[Element]]:
    """Return the byte order (None without `format`) and the elements."""
    order: str | None = None
    elements: list[Element] = []
    properties: list[Property] = []
    for line, (keyword, words) in _statements(lines):
        if keyword == "format":
            order = _order(words, line)
        elif keyword == "element":
            properties = []
            elements.append(_element(words, elements, line))
        elif keyword == "property":
            if not elements:
                raise MeshError("expected an 'element' before the first 'property'", line)
            properties.append(_property(words, line))
            if sum(part.name == properties[-1].name for part in properties) > 1:
                raise MeshError(f"property {quoted(properties[-1].name)} is declared twice", line)
            elements[-1] = Element(elements[-1].name, elements[-1].count, tuple(properties))
        else:
            expected = "'format', 'comment', 'obj_info', 'element' or 'property'"
            raise MeshError(f"expected {expected}, got {quoted(keyword)}", line)
    hollow = next((element for element in elements if element.count and not element.properties), None)
    if hollow is not None:
        raise MeshError(f"the header declares rows of {hollow.shown} without any property")
    return order, elements


def _statements(lines: list[bytes]) -> Iterator[tuple[int, tuple[str, list[str]]]]:
    """Yield the lines that declare something, numbered in the file: keyword and what follows."""
    for line, text in enumerate(lines, start=2):
        words = text.decode(errors="replace").split()
        if words and words[0] not in ("comment", "obj_info"):
            yield line, (words[0], words[1:])


def _order(words: list[str], line: int) -> str:
    if len(words) != 2 or words[0] not in _ENCODINGS or words[1] != "1.0":
        expected = ", ".join(_ENCODINGS)
        raise MeshError(f"expected one of {expected}, version 1.0, got {quoted(' '.join(words))}", line)
    return _ENCODINGS[words[0]]


def _element(words: list[str], known: list[Element], line: int) -> Element:
    if len(words) != 2 or not _is_count(words[1]):
        raise MeshError(f"expected an element's name and count, got {quoted(' '.join(words))}", line)
    if any(element.name == words[0] for element in known):
        raise MeshError(f"element {quoted(words[0])} is declared twice", line)
    return Element(words[0], int(words[1]), ())


def _is_count(word: str) -> bool:
    return word.isascii() and word.isdigit() and len(word) <= _MOST_DIGITS


def _property(words: list[str], line: int) -> Property:
    """Return the property of `TYPE NAME` or `list COUNT_TYPE TYPE NAME`."""
    types = words[1:-1] if words[:1] == ["list"] else words[:-1]
    if len(types) != (2 if words[:1] == ["list"] else 1):
        raise MeshError(f"expected a property's type and name, got {quoted(' '.join(words))}", line)
    for kind in types:
        if kind not in _CODES:
            raise MeshError(f"unknown type {quoted(kind)}, expected one of {', '.join(_CODES)}", line)
    count_code = _CODES[types[0]] if len(types) == 2 else None
    if count_code is not None and count_code not in _INTEGERS:
        raise MeshError(f"expected an integer type for the count of a list, got {quoted(types[0])}", line)
    return Property(words[-1], _CODES[types[-1]], count_code)
