"""The translation of keyframes: a polynomial from each key to the next, and bounds over any stretch of them."""

from __future__ import annotations

import numpy as np

from ..geometry.arrays import BoolArray, FloatArray
from ..geometry.vector import ZERO, Vector, norm, subtract
from .acceleration_set import STILL, AccelerationSet
from .bernstein import EPSILON, Arc, cell_matrix
from .key_interval import Boxes, RunningSum, Span

#: Segments are prepared this many at a time, which bounds the memory that it takes.
CHUNK = 4096


class Path:
    """Points sum coefficients[key, k] since^k, since s after the key; at rest after the last key.

    Attributes:
        jumps: (keys - 1,) whether the next key is jumped to.
        extent: m, upper bound on the sum of the sizes of all terms anywhere.
        fastest: m/s, upper bound on the speed anywhere.
    """

    __slots__ = (
        "_boxes",
        "_coefficients",
        "_durations",
        "_recent",
        "_row",
        "_sizes",
        "_speeds",
        "_travelled",
        "extent",
        "fastest",
        "jumps",
    )

    def __init__(self, coefficients: FloatArray, sizes: FloatArray, durations: FloatArray, jumps: BoolArray) -> None:
        """Take the segments.

        Args:
            coefficients: (keys, degree + 1, 3) m/s^k, degree 0, 1 or 3; of the last key all but the first are 0.
            sizes: (keys, degree + 1), at least the norm of every term that went into each coefficient.
            durations: (keys - 1,) s.
            jumps: (keys - 1,) bool, whether the next key is jumped to.
        """
        self._coefficients, self._sizes, self.jumps = coefficients, sizes, jumps
        self._durations = np.append(durations, 1.0)
        degree = coefficients.shape[1] - 1
        terms = sizes * self._durations[:, None] ** np.arange(degree + 1)
        self.extent = float(np.max(np.sum(terms, axis=1)))
        self._recent: list[tuple[int, float, Arc, Arc]] = []
        self._row: tuple[int, list[list[float]]] = -1, []
        self._speeds: list[float] | None = None
        if degree < 2:
            speeds = np.linalg.norm(coefficients[:, 1], axis=1) if degree else np.zeros(len(coefficients))
            self._speeds = speeds.tolist()
            self.fastest = float(np.max(speeds))
            self._travelled = RunningSum(speeds[:-1] * durations)
            self._boxes = Boxes(coefficients[:, 0], coefficients[:, 0])
        else:
            lengths, low, high, self.fastest = _whole_segments(coefficients, sizes, self._durations)
            self._travelled = RunningSum(lengths[:-1])
            self._boxes = Boxes(low, high)

    @property
    def start(self) -> FloatArray:
        """The first key's place, (3,) m."""
        return np.asarray(self._coefficients[0, 0])

    @property
    def limit(self) -> FloatArray:
        """The place just before the last key, (3,) m."""
        return np.asarray(self._coefficients[-2 if np.any(self.jumps[-1:]) else -1, 0])

    def position(self, key: int, since: float) -> Vector:
        """Return the place, m."""
        terms = self._terms(key)
        x, y, z = terms[-1]
        for a, b, c in terms[-2::-1]:
            x, y, z = x * since + a, y * since + b, z * since + c
        return (x, y, z)

    def velocity(self, key: int, since: float) -> Vector:
        """Return m/s, right-hand at a key."""
        terms = self._terms(key)
        x = y = z = 0.0
        for order in range(len(terms) - 1, 0, -1):
            a, b, c = terms[order]
            x, y, z = x * since + order * a, y * since + order * b, z * since + order * c
        return (x, y, z)

    def rates(self, key: int, since: float, duration: float) -> tuple[float, Vector, AccelerationSet]:
        """Return the supremum of speed from `since` s after a key, up to the next at most; and the acceleration there.

        That is what is steady of it, and where the rest may be.
        """
        if self._speeds is not None:
            return self._speeds[key], ZERO, STILL
        _, velocity = self._from(key, since)
        duration = min(duration, max(0.0, float(self._durations[key]) - since))
        return velocity.supremum(duration), *velocity.derivative().spread(duration)

    def length(self, span: Span) -> float:
        """Return an upper bound (m) on the way gone over the span, jumps left out."""
        first, since_first, last, since_last = span
        if first == last:
            return self._stretch(first, since_first, since_last - since_first)
        rest = self._stretch(first, since_first, float(self._durations[first]) - since_first)
        return rest + self._travelled.between(first + 1, last) + self._stretch(last, 0.0, since_last)

    def displacement(self, span: Span) -> float:
        """Return the better of the bounds (m) on the distance from the span's start, without jumps in it."""
        departure = self.departure(span)
        return departure if span.first == span.last else min(departure, self.length(span))

    def departure(self, span: Span) -> float:
        """Return an upper bound (m) on the distance from the span's start, without jumps in it."""
        first, since_first, last, since_last = span
        if self._speeds is not None:
            if first == last or self._coefficients.shape[1] == 1:
                return self._stretch(first, since_first, since_last - since_first)
            return self.farthest(self.position(first, since_first), Span(first + 1, 0.0, last, since_last))
        arc, _ = self._from(first, since_first)
        if first == last:
            return arc.supremum(max(0.0, since_last - since_first))
        rest = arc.supremum(max(0.0, float(self._durations[first]) - since_first))
        return max(rest, self._farthest_onwards(self.position(first, since_first), first, last, since_last))

    def farthest(self, place: Vector, span: Span) -> float:
        """Return an upper bound (m) on the distance of a place (m) from any point of the span."""
        first, since_first, last, since_last = span
        if self._speeds is not None:
            ends = (self.position(first, since_first), self.position(last, since_last))
            nearby = max(norm(subtract(end, place)) for end in ends)
            return max(nearby, self._boxes.farthest(place, first + 1, last + 1))
        if first == last:
            return self._farthest_within(place, first, since_first, since_last - since_first)
        rest = self._farthest_within(place, first, since_first, float(self._durations[first]) - since_first)
        return max(rest, self._farthest_onwards(place, first, last, since_last))

    def _farthest_onwards(self, place: Vector, first: int, last: int, since_last: float) -> float:
        """Return the distance (m) of a place from the segments after `first` and part of the last."""
        whole = self._boxes.farthest(place, first + 1, last)
        return max(whole, self._farthest_within(place, last, 0.0, since_last))

    def _stretch(self, key: int, since: float, duration: float) -> float:
        """Return the way gone (m) within one segment."""
        duration = max(0.0, duration)
        if self._speeds is not None:
            return self._speeds[key] * duration
        velocity = self._arc(key).derivative() if since == 0.0 else self._from(key, since)[1]
        return velocity.integral(duration)

    def _farthest_within(self, place: Vector, key: int, since: float, duration: float) -> float:
        """Return the distance (m) of a place from part of one segment."""
        arc = self._arc(key) if since == 0.0 else self._arc(key).shifted(since)
        return arc.away_from(np.array(place), self.extent).supremum(max(0.0, duration))

    def _terms(self, key: int) -> list[list[float]]:
        """Return a segment's coefficients; the last are kept."""
        if self._row[0] != key:
            self._row = key, self._coefficients[key].tolist()
        return self._row[1]

    def _arc(self, key: int) -> Arc:
        return Arc(self._coefficients[key], self._sizes[key], float(self._durations[key]))

    def _from(self, key: int, since: float) -> tuple[Arc, Arc]:
        """Return the way from a point of the path and the velocity, as arcs that begin there; the last are kept."""
        for known_key, known_since, arc, velocity in self._recent[:1]:
            if known_key == key and known_since == since:
                return arc, velocity
        arc = self._arc(key).shifted(since).from_start()
        velocity = arc.derivative()
        self._recent[:] = [(key, since, arc, velocity)]
        return arc, velocity


def _whole_segments(
    coefficients: FloatArray, sizes: FloatArray, durations: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Return upper bounds for whole segments: lengths (keys,) m, corners of boxes (keys, 3) m, the greatest speed m/s.

    The same cells as `Arc` takes for a whole segment.
    """
    count = coefficients.shape[1]
    orders = np.arange(count)
    lengths, lows, highs, fastest = [], [], [], 0.0
    for start in range(0, len(coefficients), CHUNK):
        part = slice(start, start + CHUNK)
        powers = durations[part, None] ** orders
        rounding = 4.0 * (count + 1.0) * EPSILON * np.sum(sizes[part] * powers, axis=1)
        points = cell_matrix(count) @ (coefficients[part] * powers[:, :, None])
        lows.append(np.min(points, axis=1) - rounding[:, None])
        highs.append(np.max(points, axis=1) + rounding[:, None])
        # the velocity times the duration, so that its terms are lengths like the path's own
        ways = cell_matrix(count - 1) @ (orders[1:, None] * coefficients[part, 1:] * powers[:, 1:, None])
        norms = np.linalg.norm(ways, axis=2)
        lengths.append(np.mean(norms, axis=1) + count * rounding)
        fastest = max(fastest, float(np.max((np.max(norms, axis=1) + count * rounding) / durations[part])))
    return np.concatenate(lengths), np.vstack(lows), np.vstack(highs), fastest
