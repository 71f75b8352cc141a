"""The rows of a PLY file's elements, in ASCII and in binary: no more and no fewer than its header says."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Sequence
from functools import lru_cache
from struct import Struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ..text.errors import quoted
from .obj import coordinate, vertex_index
from .ply_header import Element, Header
from .surface import MeshError

_Parts = Sequence[Sequence[Any]]
"""The values of each property of a row: one, or as many as its list has."""


class AsciiRows:
    """The elements of an ASCII file, to be taken in the header's order: each row is a line."""

    def __init__(self, data: bytes, header: Header) -> None:
        lines = data[header.size :].splitlines()
        self._most = len(lines)
        self._lines = enumerate(lines, start=header.lines + 1)

    def vertices(self, element: Element, columns: tuple[int, int, int]) -> FloatArray:
        """Return the finite (n, 3) values of three scalar properties, given by their places."""
        values = array("d")
        if element.has_lists:
            for line, parts in self._rows(element):
                values.extend([coordinate(parts[column][0], line) for column in columns])
        else:
            x, y, z = columns
            for line, words in self._words(element):
                if len(words) != len(element.properties):
                    raise _misfit(element, words, line)
                values.extend((coordinate(words[x], line), coordinate(words[y], line), coordinate(words[z], line)))
        return np.array(values, dtype=np.float64).reshape(-1, 3)

    def polygons(self, element: Element, column: int) -> tuple[IntArray, IntArray, Sequence[int]]:
        """Return the values of a list, their number in each row, and each row's line."""
        corners, sizes, lines = array("q"), array("q"), array("q")
        for line, parts in self._rows(element):
            corners.extend([vertex_index(word, line) for word in parts[column]])
            sizes.append(len(parts[column]))
            lines.append(line)
        return np.array(corners, dtype=np.int64), np.array(sizes, dtype=np.int64), lines

    def skip(self, element: Element) -> None:
        """Pass over the element's rows."""
        for _ in self._rows(element):
            pass

    def finish(self) -> None:
        """Refuse anything but blanks after the last element."""
        for line, text in self._lines:
            if text.strip():
                raise MeshError("the header's counts end before this line", line)

    def _rows(self, element: Element) -> Iterator[tuple[int, _Parts]]:
        """Yield each row's line and the words of its properties."""
        for line, words in self._words(element):
            parts = _parts(words, element, line)
            if parts is None:
                raise _misfit(element, words, line)
            yield line, parts

    def _words(self, element: Element) -> Iterator[tuple[int, list[bytes]]]:
        """Yield the words of each row, with its line."""
        if element.count > self._most:
            raise MeshError(_cut_short(element, f"{self._most} lines follow"))
        row = 0
        while row < element.count:
            line, text = next(self._lines, (0, b""))
            if not line:
                raise MeshError(_cut_short(element, f"it holds {row}"))
            words = text.split()
            if words:
                row += 1
                yield line, words


def _misfit(element: Element, words: list[bytes], line: int) -> MeshError:
    numbers = "1 number does" if len(words) == 1 else f"{len(words)} numbers do"
    return MeshError(f"{numbers} not make one {element.shown} as the header declares it", line)


def _parts(words: list[bytes], element: Element, line: int) -> _Parts | None:
    """Return the words of each property, those of a list after its count; None if they are too few or too many."""
    parts: list[list[bytes]] = []
    place = 0
    for part in element.properties:
        count = 1
        if part.count_code and place < len(words):
            count = vertex_index(words[place], line)
            place += 1
        if count < 0 or place + count > len(words):
            return None
        parts.append(words[place : place + count])
        place += count
    return parts if place == len(words) else None


class BinaryRows:
    """The elements of a binary file, to be taken in the header's order."""

    def __init__(self, data: bytes, header: Header) -> None:
        self._data = data
        self._place = header.size
        self._order = header.order

    def vertices(self, element: Element, columns: tuple[int, int, int]) -> FloatArray:
        """Return the finite (n, 3) values of three scalar properties, given by their places."""
        table = self._table(element)
        if table is None:
            rows = [[parts[column][0] for column in columns] for parts in self._rows(element)]
            values: FloatArray = np.array(rows, dtype=np.float64).reshape(-1, 3)
        else:
            with np.errstate(invalid="ignore"):  # a signalling NaN, which is refused with all others
                parts = [table[f"values {column}"].astype(np.float64).reshape(-1) for column in columns]
            values = np.column_stack(parts)
        bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
        if len(bad):
            raise MeshError(f"vertex {bad[0] + 1} of {len(values)} has a coordinate that is not finite")
        return values

    def polygons(self, element: Element, column: int) -> tuple[IntArray, IntArray, Sequence[int]]:
        """Return the values of a list, their number in each row, and each row's line: none, bytes have no lines."""
        table = self._table(element)
        if table is not None:
            polygons: IntArray = table[f"values {column}"].astype(np.int64)
            return polygons.reshape(-1), np.full(len(polygons), polygons.shape[1]), ()
        corners, sizes = array("q"), array("q")
        for parts in self._rows(element):
            corners.extend(parts[column])
            sizes.append(len(parts[column]))
        return np.array(corners, dtype=np.int64), np.array(sizes, dtype=np.int64), ()

    def skip(self, element: Element) -> None:
        """Pass over the element's rows."""
        if self._table(element) is None:
            for _ in self._rows(element):
                pass

    def finish(self) -> None:
        """Refuse anything but blanks after the last element."""
        rest = self._data[self._place :]
        if rest.strip(b"\0 \t\r\n"):
            raise MeshError(f"{len(rest)} bytes follow what the header's counts say")

    def _table(self, element: Element) -> NDArray[np.void] | None:
        """Return the rows as a structured array over the file and pass over them; None if lists differ in length."""
        if element.count * element.least_size > len(self._data) - self._place:
            whole = (len(self._data) - self._place) // element.least_size
            raise MeshError(_cut_short(element, f"at most {whole} fit"))
        begin = self._place
        first = next(self._rows(element), ((),) * len(element.properties))
        self._place = begin
        fields: list[Any] = []
        for column, (part, values) in enumerate(zip(element.properties, first, strict=True)):
            if part.count_code:
                fields.append((f"count {column}", self._order + part.count_code))
            fields.append((f"values {column}", self._order + part.code, (len(values),)))
        layout = np.dtype(fields)
        end = begin + element.count * layout.itemsize
        if end > len(self._data):
            return None
        table: NDArray[np.void] = np.ndarray(element.count, layout, self._data, begin)
        for column, (part, values) in enumerate(zip(element.properties, first, strict=True)):
            if part.count_code and (table[f"count {column}"] != len(values)).any():
                return None
        self._place = end
        return table

    def _rows(self, element: Element) -> Iterator[_Parts]:
        """Yield the values of each row's properties, and pass over it."""
        for row in range(element.count):
            parts: list[tuple[Any, ...]] = []
            for part in element.properties:
                count = self._values(part.count_code, 1, element, row)[0] if part.count_code else 1
                parts.append(self._values(part.code, count, element, row))
            yield parts

    def _values(self, code: str, count: int, element: Element, row: int) -> tuple[Any, ...]:
        if count < 0:
            raise MeshError(f"{element.shown} {row + 1} of {element.count} has a list of {count} values")
        if count > len(self._data) - self._place:
            raise MeshError(_cut_short(element, f"it holds {row}"))
        layout = _layout(f"{self._order}{count}{code}")
        begin, self._place = self._place, self._place + layout.size
        if self._place > len(self._data):
            raise MeshError(_cut_short(element, f"it holds {row}"))
        return layout.unpack_from(self._data, begin)


@lru_cache(maxsize=1024)
def _layout(code: str) -> Struct:
    return Struct(code)


def _cut_short(element: Element, held: str) -> str:
    declared = quoted(f"element {element.name} {element.count}")
    return f"the file is cut short: its header says {declared}, {held}"
