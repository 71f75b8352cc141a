"""The decided stretches of a pair; neighbours of one verdict make up a span."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ..model.events import PairKey, Span, Verdict

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

    @property
    def grazes(self) -> bool:
        """Whether contact is excluded, and the margin neither kept nor broken for certain."""
        return self.verdict is Verdict.UNRESOLVED and self.clearance > 0.0

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

    Spans are yielded as they end once the pair has touched. Until then they wait for the pair's end: what is known of
    the least distance may still raise their clearance.

    Beside its margin's crossing a pair may be proved apart, but neither within the margin nor beyond. Such a sliver
    belongs to the breach beside it: between two if no longer than the time resolution, so that one breach is one
    one; else if no longer than a crossing's tolerance.

    Attributes:
        touched: whether the pair has ever been in contact.
        end: s, up to when all is decided.
    """

    def __init__(self, key: PairKey, start: float, error: float, resolution: float, crossing: float) -> None:
        """Begin at `start`, s; `error` (m) is that of the pair's distances.

        `resolution` and `crossing`, s, limit the slivers that belong to breaches.
        """
        self._waiting: list[Stretch] = []
        self.touched = False
        self._key = key
        self._error = error
        self.end = start
        self._resolution, self._crossing = resolution, crossing
        self._last: list[Stretch] = []  # the span that grows; before a sliver, the breach that it may belong to

    @property
    def waiting(self) -> tuple[Stretch, ...]:
        """The stretches that are not yielded yet."""
        return tuple(self._waiting)

    def replace(self, stretches: Sequence[Stretch]) -> None:
        """Put stretches in the place of those that wait."""
        self._waiting = list(stretches)

    def extend(
        self, until: float, verdict: Verdict, clearance: float, depth_limit: float, nearest: float
    ) -> Iterator[Span]:
        """Add the stretch up to `until`, s; yield the spans that it ends."""
        if until <= self.end:
            return
        self._waiting.append(Stretch(self.end, until, verdict, clearance, depth_limit, nearest))
        self.end = until
        self.touched |= verdict is Verdict.CONTACT
        if self.touched:
            yield from self._tell()
        elif len(self._waiting) > MOST_STRETCHES:
            self._waiting = _coarser(self._waiting)

    def finish(self) -> Iterator[Span]:
        """Yield the spans that are left."""
        yield from self._tell()
        self._give_sliver_to_breach(None)
        yield from self._end()

    def _tell(self) -> Iterator[Span]:
        """Join the waiting stretches to the last span, and yield each span that another follows."""
        for stretch in self._waiting:
            if self._last and stretch.verdict is not self._last[-1].verdict:
                self._give_sliver_to_breach(stretch.verdict)
            if self._last and stretch.verdict is self._last[-1].verdict:
                self._last[-1] = self._last[-1].joined(stretch)
                continue
            if not (self._last and self._last[-1].verdict is Verdict.BREACH and stretch.grazes):
                yield from self._end()
            self._last.append(stretch)
        self._waiting.clear()

    def _give_sliver_to_breach(self, following: Verdict | None) -> None:
        """Make the last span part of the breach beside it if it is a sliver that belongs there."""
        after = following is Verdict.BREACH
        if not self._last or not self._last[-1].grazes or not (after or len(self._last) > 1):
            return
        sliver = self._last[-1]
        if sliver.end - sliver.start <= (self._resolution if after and len(self._last) > 1 else self._crossing):
            part = self._last.pop()._replace(verdict=Verdict.BREACH)
            self._last = [self._last[0].joined(part)] if self._last else [part]

    def _end(self) -> Iterator[Span]:
        """Yield what is known to be whole."""
        for last in self._last:
            yield Span(self._key, last.verdict, last.start, last.end, last.clearance, last.depth_limit, self._error)
        self._last = []


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
