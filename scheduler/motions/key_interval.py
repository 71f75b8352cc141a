"""Intervals of the keys' time and sums over whole segments, for keyed translations and rotations."""

from __future__ import annotations

from math import fsum, inf, nextafter
from typing import NamedTuple

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.vector import Vector


class Span(NamedTuple):
    """From `since_first` s after key `first` to `since_last` s after key `last`."""

    first: int
    since_first: float
    last: int
    since_last: float


def end_of(t: float, duration: float) -> float:
    """Return a time (s) that `t + duration` is not past: the float nearest to it, or the next one."""
    end = t + duration
    return nextafter(end, inf) if fsum((t, duration, -end)) > 0.0 else end


class RunningSum:
    """Sums of the first n of some lengths, kept in two floats each, so that differences of far sums stay exact."""

    __slots__ = ("_high", "_low")

    def __init__(self, lengths: FloatArray) -> None:
        """Add up `lengths`, (n,)."""
        self._high, self._low = [0.0], [0.0]
        for length in lengths.tolist():
            high = self._high[-1] + length
            rest = high - self._high[-1]
            self._high.append(high)
            self._low.append(self._low[-1] + ((self._high[-2] - (high - rest)) + (length - rest)))

    def between(self, first: int, last: int) -> float:
        """Return the sum of lengths[first:last]."""
        return (self._high[last] - self._high[first]) + (self._low[last] - self._low[first])


class Boxes:
    """Boxes along the axes, and the boxes around 2, 4, 8 ... neighbours: any run of them is at most 2 a level."""

    __slots__ = ("_high", "_low", "_starts")

    def __init__(self, low: FloatArray, high: FloatArray) -> None:
        """Take the corners, (n, 3) m each."""
        lows, highs, self._starts = [low], [high], [0]
        while len(low) > 1:
            self._starts.append(self._starts[-1] + len(low))
            even = len(low) // 2 * 2
            low = np.vstack((np.minimum(low[0:even:2], low[1:even:2]), low[even:]))
            high = np.vstack((np.maximum(high[0:even:2], high[1:even:2]), high[even:]))
            lows.append(low)
            highs.append(high)
        self._low, self._high = np.vstack(lows), np.vstack(highs)

    def farthest(self, point: Vector, first: int, last: int) -> float:
        """Return an upper bound (m) on the distance from `point` to any point of boxes[first:last]; 0 for none."""
        nodes: list[int] = []
        for start in self._starts:
            if first >= last:
                break
            if first % 2:
                nodes.append(start + first)
                first += 1
            if last % 2:
                last -= 1
                nodes.append(start + last)
            first, last = first // 2, last // 2
        if not nodes:
            return 0.0
        away = np.maximum(np.abs(self._low[nodes] - point), np.abs(self._high[nodes] - point))
        return float(np.sqrt(np.max(np.einsum("nd,nd->n", away, away))))
