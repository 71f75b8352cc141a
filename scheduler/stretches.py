"""What has been decided of a pair, stretch by stretch, and the spans that neighbours of one verdict make up."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from .events import PairKey, Span, Verdict

#: Untold stretches that are kept apart at most: of more, neighbours of one verdict become one.
MOST_STRETCHES = 1 << 16


class Stretch(NamedTuple):
    """The time between two neighbouring measurements of a pair, s.

    Attributes:
        clearance: m, certified lower bound on the distance inside, both ends included; 0 where nothing is certain.
        depth_limit: m, as of a span.
        nearest: m, upper bound on the least distance at its ends; inf where nothing exact was measured.
    """

    start: float
    end: float
    verdict: Verdict
    clearance: float
    depth_limit: float
    nearest: float

    def joined(self, after: Stretch) -> Stretch:
        """Return this stretch and the one after it, of the same verdict, as one."""
        return Stretch(
            self.start,
            after.end,
            self.verdict,
            min(self.clearance, after.clearance),
            max(self.depth_limit, after.depth_limit),
            min(self.nearest, after.nearest),
        )


class Cleared(NamedTuple):
    """Up to `end` (s) two bodies' swept boxes are at least `clearance` (m) apart."""

    end: float
    clearance: float


class SpanRecord:
    """The growing last span of a pair: neighbours of one verdict become one span.

    Spans are told as they end once the pair has touched. Until then they wait for the pair's end: what is known of
    the least distance may still raise their clearance.

    Attributes:
        untold: the stretches that wait.
        touched: whether the pair has ever been in contact.
        end: s, up to when all is decided.
    """

    def __init__(self, key: PairKey, start: float, error: float = 0.0) -> None:
        """Begin at `start`, s; `error` (m) is that of the pair's distances."""
        self.untold: list[Stretch] = []
        self.touched = False
        self._key = key
        self._error = error
        self.end = start
        self._last: Stretch | None = None

    def extend(
        self, until: float, verdict: Verdict, clearance: float, depth_limit: float, nearest: float
    ) -> Iterator[Span]:
        """Add the stretch up to `until`, s; yield the spans that it ends."""
        if until <= self.end:
            return
        self.untold.append(Stretch(self.end, until, verdict, clearance, depth_limit, nearest))
        self.end = until
        self.touched |= verdict is Verdict.CONTACT
        if self.touched:
            yield from self._tell()
        elif len(self.untold) > MOST_STRETCHES:
            self.untold = _coarser(self.untold)

    def finish(self) -> Iterator[Span]:
        """Yield the spans that are left."""
        yield from self._tell()
        if self._last is not None:
            yield self._span(self._last)
            self._last = None

    def _tell(self) -> Iterator[Span]:
        """Join the waiting stretches to the last span, and yield each span that another follows."""
        for stretch in self.untold:
            if self._last is None:
                self._last = stretch
            elif stretch.verdict is self._last.verdict:
                self._last = self._last.joined(stretch)
            else:
                yield self._span(self._last)
                self._last = stretch
        self.untold.clear()

    def _span(self, last: Stretch) -> Span:
        return Span(self._key, last.verdict, last.start, last.end, last.clearance, last.depth_limit, self._error)


def _coarser(stretches: list[Stretch]) -> list[Stretch]:
    """Return the stretches with every two neighbours of one verdict joined."""
    joined: list[Stretch] = []
    apart = True
    for stretch in stretches:
        if apart or joined[-1].verdict is not stretch.verdict:
            joined.append(stretch)
            apart = False
        else:
            joined[-1] = joined[-1].joined(stretch)
            apart = True
    return joined
