"""The windows that have begun, and until when they clear two bodies of each other."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from math import hypot, inf, nextafter

import numpy as np

from ..geometry.rounding import spendable
from ..pairs.span_record import Cleared
from .windows import Windows

_FIELDS = 9
_LOW, _HIGH = slice(3, 6), slice(6, 9)


class WindowHistory:
    """All windows that have begun, by body: start, end, guard, and the corners of the box."""

    def __init__(self, bodies: int) -> None:
        """Start with none."""
        self._rows: list[list[int]] = [[] for _ in range(bodies)]
        self._values = array("d")

    def add(self, windows: Windows) -> None:
        """Keep the next windows of bodies."""
        row = len(self._values)
        for body in windows.bodies.tolist():
            self._rows[body].append(row)
            row += _FIELDS
        columns = (windows.starts, windows.ends, windows.guards, windows.low, windows.high)
        self._values.frombytes(np.column_stack(columns).tobytes())

    def cleared_until(self, a: int, b: int, time: float) -> float:
        """Return until when (s) the last windows of two bodies clear them, from `time` (s) on; -inf if they do not."""
        if not (self._rows[a] and self._rows[b]):
            return -inf
        one, other = self._row(self._rows[a][-1]), self._row(self._rows[b][-1])
        if max(one[0], other[0]) > nextafter(time, inf) or _meet(one, other):
            return -inf
        return min(one[1], other[1])

    def clearances(self, a: int, b: int, since: float, until: float) -> Iterator[Cleared]:
        """Yield what windows cleared two bodies by from `since` to `until` (s), during which no two boxes met.

        A jump parts two that follow each other: then the second begins at the next float.
        """
        one, other = self._from(a, since), self._from(b, since)
        row_a, row_b = next(one), next(other)
        while True:
            end_a, end_b = row_a[1], row_b[1]
            end = min(end_a, end_b, until)
            if end > since:
                yield Cleared(end, spendable(_gap(row_a, row_b)))
            if end >= until:
                return
            row_a = next(one) if end_a == end else row_a
            row_b = next(other) if end_b == end else row_b

    def _from(self, body: int, since: float) -> Iterator[list[float]]:
        """Yield a body's windows in order, from the last that begins at `since` (s) or before."""
        rows = self._rows[body]
        low, high = 0, len(rows)
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self._values[rows[middle]] <= since else (low, middle)
        for row in rows[low:]:
            yield self._row(row)

    def _row(self, row: int) -> list[float]:
        return self._values[row : row + _FIELDS].tolist()


def _meet(one: list[float], other: list[float]) -> bool:
    """Return whether two boxes, widened by their guards, have a point in common."""
    sides = zip(one[_LOW], one[_HIGH], other[_LOW], other[_HIGH], strict=True)
    guard, others = one[2], other[2]
    return all(low - guard <= top + others and bottom - others <= high + guard for low, high, bottom, top in sides)


def _gap(one: list[float], other: list[float]) -> float:
    """Return the distance (m) of two boxes."""
    sides = zip(one[_LOW], one[_HIGH], other[_LOW], other[_HIGH], strict=True)
    return hypot(*(max(0.0, low - top, bottom - high) for low, high, bottom, top in sides))
