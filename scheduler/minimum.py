"""The least distance of a pair over its run, as a bracket: branch and bound over the stretches between its wakeups.

The scheme proves that a pair stays apart, not by how much: a sleep spends all the clearance there is. Once the pair is
decided, the stretches that may hold its least distance are gone through again, by the same bounds, but the pair sleeps
only while it provably stays above a target: the least distance measured so far, less the tolerance.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from math import inf

from .events import Bound, Distance, Reason, Verdict, Wakeup
from .outlook import Outlook
from .pair import Measurement, Pair
from .stretches import Stretch
from .valley import Tangent, Valley

#: m: least distances are never known better than this.
LEAST_TOLERANCE = 1e-6
#: No better than this many times the error of measurement either: the target stays below what is measured.
ERRORS = 8.0
#: Measurements a pair at most; the bracket stays wider where they do not suffice.
MOST_MEASUREMENTS = 4_000
#: A descent goes on while it may find so large a share of the tolerance more.
WORTH_A_STEP = 0.25
#: Bounding spheres settle a measurement above this many times the target.
SPHERES_SUFFICE = 1.25

Found = Wakeup | Distance


class LeastDistance:
    """The search for the least distance of a pair that never touches.

    Attributes:
        upper: m, upper bound on the least distance: the least one measured, its error added.
    """

    def __init__(self, pair: Pair, stretches: list[Stretch], share: float, floor: float) -> None:
        """Take a decided pair.

        Args:
            pair: the pair.
            stretches: of the whole time of the pair; their clearances are to be raised.
            share: of the least distance, how far the bracket's ends may lie apart.
            floor: s, sleeps of fewer than some of these are worth a directional bound.
        """
        self._pair = pair
        self._share = share
        self._floor = floor
        self._stretches = stretches
        self._left = MOST_MEASUREMENTS
        self.upper = min((stretch.nearest for stretch in stretches), default=inf)

    @property
    def target(self) -> float:
        """The distance (m) that every stretch is to be certified above; it only falls. inf before anything is known."""
        if self.upper == inf:
            return inf
        tolerance = max(self._share * self.upper, LEAST_TOLERANCE, ERRORS * self._pair.error)
        return max(0.0, self.upper - tolerance)

    def narrow(self) -> Generator[Found, None, None]:
        """Go through the stretches that may hold the least distance; yield what is measured.

        Nothing can be gained where a stretch is unresolved.
        """
        stretches = self._stretches
        if any(stretch.clearance <= 0.0 for stretch in stretches):
            return
        if all(stretch.clearance >= self.target for stretch in stretches):
            return
        lowest = min(stretches, key=lambda stretch: (stretch.nearest, stretch.clearance))
        yield from self._descend((yield from self._probe(lowest.start)), lowest.start, lowest.end)
        first = 0
        while first < len(stretches):
            last = first
            while last < len(stretches) and stretches[last].clearance < self.target:
                last += 1
            if last > first:
                if not (yield from self._advance(stretches[first].start, stretches[last - 1].end)):
                    return
                stretches[first:last] = [self._kept(stretch) for stretch in stretches[first:last]]
            first = last + 1

    def _kept(self, stretch: Stretch) -> Stretch:
        """Return a stretch that stays above the target; what grazed its margin may turn out to have kept it."""
        clearance = max(stretch.clearance, self.target)
        verdict = Verdict.CLEAR if clearance > self._pair.margin else stretch.verdict
        return stretch._replace(verdict=verdict, clearance=clearance)

    def _descend(self, measurement: Measurement, early: float, late: float) -> Generator[Found, None, None]:
        """Measure where the distance seems to be least: a lower target is proved with fewer steps.

        Args:
            measurement: exact, where to begin.
            early, late: s, between which to look.
        """
        valley = Valley(early, late)
        while self._left > 0:
            time = valley.next(Tangent.at(measurement), WORTH_A_STEP * (self.upper - self.target))
            if time is None:
                return
            measurement = yield from self._probe(time)

    def _probe(self, time: float) -> Generator[Found, None, Measurement]:
        """Measure exactly at a time, whatever was before and comes after."""
        measurement = self._measured(time, inf)
        yield from self._told(measurement, Bound.NONE, 0.0)
        return measurement

    def _advance(self, time: float, end: float) -> Generator[Found, None, bool]:
        """Prove the time (s) until `end`, both included, to stay above the target; return whether that was done.

        It ends because each sleep is worth at least the tolerance, and because measurements are limited.
        """
        while True:
            before = self.upper
            measurement = self._measured(time, SPHERES_SUFFICE * self.target)
            if measurement.above < before:
                yield from self._descend(measurement, time, end)
            stop = min(end, self._pair.motion.stop_after(time))  # joined stretches may hold jumps
            ahead = stop - time
            sleep, bound = 0.0, Bound.NONE
            if time < end:
                sleep, bound = Outlook(self._pair, measurement, self.target).sleep(ahead, self._floor)
            yield from self._told(measurement, bound, sleep)
            if time >= end:
                return True
            woken = stop if sleep >= ahead else min(time + sleep, stop)
            if woken == time or self._left <= 0:
                return False
            time = woken

    def _measured(self, time: float, far: float) -> Measurement:
        """Measure the pair, by bounding spheres where they are farther apart than `far` m."""
        self._left -= 1
        measurement = self._pair.measure_beyond(time, far)
        self.upper = min(self.upper, measurement.above)
        return measurement

    def _told(self, measurement: Measurement, bound: Bound, sleep: float) -> Iterator[Found]:
        """Yield a measurement, and the sleep (s) that a bound allows after it."""
        if (distance := self._pair.distance(measurement)) is not None:
            yield distance
        time, level, clearance = measurement.time, measurement.level, measurement.clearance
        yield Wakeup(time, self._pair.key, Reason.MINIMUM, level, bound, clearance, sleep)
