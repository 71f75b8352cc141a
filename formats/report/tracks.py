"""What is drawn of each pair over time, thinned to a budget: extremes are kept, and bounds err low."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...scheduler.geometry.arrays import FloatArray
from ..log import messages_pb2 as pb

# Points and spans kept in all while a log is read, 16 to 25 bytes each, and in the page, 8 to 13 bytes each.
_MOST_KEPT = 4_000_000
_MOST_DRAWN = 600_000

# Parts of the run of which each keeps its extremes, at first and at the least.
_PARTS = 2048
_FEWEST_PARTS = 8

# Verdicts by their numbers in the log, from best to worst, and how bad each number's is.
_BY_BADNESS = np.array(
    (pb.Span.UNKNOWN, pb.Span.CLEAR, pb.Span.POSSIBLE, pb.Span.UNRESOLVED, pb.Span.BREACH, pb.Span.CONTACT)
)
_BADNESS = np.argsort(_BY_BADNESS)

Indices = NDArray[np.int64]


class Track:
    """One pair's points and spans so far.

    Attributes:
        measured: s and m in turn, exact distances.
        bounds: s and m in turn, distances certified at an instant, where none was measured.
        spans: s, s, the verdict's number and the certified clearance, m, in turn.
    """

    __slots__ = ("bounds", "measured", "spans")

    def __init__(self) -> None:
        self.measured = array("d")
        self.bounds = array("d")
        self.spans = array("d")


@dataclass(frozen=True, slots=True)
class Curve:
    """A pair's points (n,) and spans (m,), by time.

    Attributes:
        measured: (n, 2) s, m.
        bounds: (n, 2) s, m.
        spans: (m, 4) start and end in s, verdict, clearance in m.
    """

    measured: FloatArray
    bounds: FloatArray
    spans: FloatArray


class Tracks:
    """The tracks of some pairs over [start, end], s. Memory does not grow with the log."""

    def __init__(self, pairs: int, start: float, end: float) -> None:
        self._tracks = [Track() for _ in range(pairs)]
        self._start = start
        self._length = (end - start) or 1.0
        self._parts = _PARTS
        self._kept = 0

    def add_measured(self, pair: int, time: float, distance: float) -> None:
        """Add an exact distance, m, at a time, s."""
        self._tracks[pair].measured.extend((time, distance))
        self._count()

    def add_bound(self, pair: int, time: float, clearance: float) -> None:
        """Add a certified lower bound, m, on the distance at a time, s."""
        self._tracks[pair].bounds.extend((time, clearance))
        self._count()

    def add_span(self, pair: int, span: tuple[float, float, int, float]) -> None:
        """Add a span: start and end in s, verdict, clearance in m."""
        self._tracks[pair].spans.extend(span)
        self._count()

    def curves(self) -> Iterator[Curve]:
        """Yield what is drawn of each pair, few enough for a page."""
        self._thin(_MOST_DRAWN)
        for track in self._tracks:
            yield Curve(_rows(track.measured, 2), _rows(track.bounds, 2), _rows(track.spans, 4))

    def _count(self) -> None:
        self._kept += 1
        if self._kept > _MOST_KEPT:
            self._thin(_MOST_KEPT // 2)

    def _thin(self, most: int) -> None:
        """Sort all tracks, and thin them until at most so many points and spans are left, or as few as can be."""
        self._sort()
        while self._kept > most:
            self._kept = sum(self._thin_track(track) for track in self._tracks)
            if self._parts == _FEWEST_PARTS:
                return
            if self._kept > most:
                self._parts //= 2

    def _sort(self) -> None:
        for track in self._tracks:
            track.measured = _sorted(track.measured, 2)
            track.bounds = _sorted(track.bounds, 2)
            track.spans = _sorted(track.spans, 4)

    def _thin_track(self, track: Track) -> int:
        """Thin one pair's points and spans, sorted; return how many are left."""
        measured = _rows(track.measured, 2)
        bounds = _rows(track.bounds, 2)
        track.measured = array("d", measured[self._extremes(measured, highest=True)].tobytes())
        track.bounds = array("d", bounds[self._extremes(bounds, highest=False)].tobytes())
        track.spans = array("d", self._joined(_rows(track.spans, 4)).tobytes())
        return len(track.measured) // 2 + len(track.bounds) // 2 + len(track.spans) // 4

    def _part(self, times: FloatArray) -> Indices:
        """Return in which part of the run times are."""
        within = np.clip((times - self._start) / self._length, -1.0, 2.0)
        return (within * self._parts).astype(np.int64)

    def _extremes(self, points: FloatArray, highest: bool) -> Indices:
        """Return which points (n, 2) are the lowest of their part, or the highest if those are asked for."""
        if len(points) == 0:
            return np.zeros(0, dtype=np.int64)
        part = self._part(points[:, 0])
        order = np.lexsort((points[:, 1], part))
        first = np.flatnonzero(np.diff(part[order], prepend=part[order[0]] - 1))
        kept = order[first]
        if highest:
            last = np.append(first[1:], len(order)) - 1
            kept = np.union1d(kept, order[last])
        return np.sort(kept)

    def _joined(self, spans: FloatArray) -> FloatArray:
        """Return spans (n, 4), those within one part of the run as one, with the worst verdict and least clearance."""
        if len(spans) == 0:
            return spans
        first, last = self._part(spans[:, 0]), self._part(spans[:, 1])
        within = first == last
        follows = within[1:] & within[:-1] & (first[1:] == first[:-1])
        begins = np.flatnonzero(np.append(True, ~follows))
        badness = _BADNESS[spans[:, 2].astype(np.int64)]
        return np.column_stack(
            (
                spans[begins, 0],
                np.maximum.reduceat(spans[:, 1], begins),
                _BY_BADNESS[np.maximum.reduceat(badness, begins)],
                np.minimum.reduceat(spans[:, 3], begins),
            )
        )


def _rows(values: array[float], columns: int) -> FloatArray:
    rows: FloatArray = np.frombuffer(values, dtype=np.float64).reshape(-1, columns)
    return rows


def _sorted(values: array[float], columns: int) -> array[float]:
    rows = _rows(values, columns)
    if np.all(rows[1:, 0] >= rows[:-1, 0]):
        return values
    return array("d", rows[np.argsort(rows[:, 0], kind="stable")].tobytes())
