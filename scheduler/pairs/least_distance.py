"""The least distance of a pair over its run, as a bracket: branch and bound over the stretches between its wakeups.

The scheme proves that a pair stays apart, but not by how much: a sleep spends all of the clearance. Once the pair is
decided, a second pass visits the stretches that may hold the least distance. It uses the same bounds, but the pair
sleeps only while it provably stays above a goal. The goal is the least distance measured so far, less the tolerance. If
that would take too many measurements, the goal is the largest share of it that they allow.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from math import inf

import numpy as np

from ..model.events import Bound, Distance, Reason, Verdict, Wakeup
from .pair import Measurement, Pair
from .separation import SeparationSleep, Tuning
from .span_record import Stretch
from .tangent_search import Tangent, TangentSearch

#: m: least distances are never known better than this.
LEAST_TOLERANCE = 1e-6
#: No better than this many times the error of measurement either: the target stays below what is measured.
ERRORS = 8.0
#: Measurements a pair at most; the bracket stays wider where they do not suffice.
MOST_MEASUREMENTS = 5_000
#: So many of them are left to raise the bound as far as they allow, where the others were spent in vain.
RESERVE = 1_000
#: Shares of the least distance that are aimed at where the whole would take more than are left,
SHARES = tuple(0.05 * share for share in range(19, 0, -1))
#: and the least one that is worth going through the stretches again.
WORTH_A_SWEEP = 0.1
#: After so many stretches the goal is chosen again, by the measurements left.
STRETCHES_BETWEEN = 16
#: After so many, what is left of the whole is tried on only if it will hardly take more than there are.
TRIAL = 500
#: A descent goes on while it may find so large a share of the tolerance more.
WORTH_A_STEP = 0.25
#: Bounding spheres settle a measurement above this many times the target.
FAR_IN_TARGETS = 1.25

Found = Wakeup | Distance


class LeastDistance:
    """The search for the least distance of a pair that never touches.

    Attributes:
        upper: m, upper bound on the least distance: the least one measured, its error added.
    """

    def __init__(self, pair: Pair, stretches: Sequence[Stretch], share: float, floor: float, tuning: Tuning) -> None:
        """Take a decided pair.

        Args:
            pair: the pair.
            stretches: of the whole time of the pair.
            share: of the least distance, how far the bracket's ends may lie apart.
            floor: s, sleeps of fewer than some of these are worth a slab.
            tuning: of the pair's bounds.
        """
        self._pair = pair
        self._share = share
        self._floor = floor
        self._stretches = list(stretches)
        self._tuning = tuning
        self._left = MOST_MEASUREMENTS
        self._reserve = 0
        self.upper = min((stretch.nearest for stretch in stretches), default=inf)

    @property
    def target(self) -> float:
        """The distance (m) that every stretch is to be certified above; it only falls. inf before anything is known."""
        if self.upper == inf:
            return inf
        tolerance = max(self._share * self.upper, LEAST_TOLERANCE, ERRORS * self._pair.error)
        return max(0.0, self.upper - tolerance)

    def narrowed(self) -> Generator[Found, None, list[Stretch]]:
        """Go through the stretches that may hold the least distance; yield what is measured.

        Return the stretches, their clearances raised. Nothing can be gained where a stretch is unresolved.
        """
        yield from self._narrow()
        return self._stretches

    def _narrow(self) -> Generator[Found, None, None]:
        stretches = self._stretches
        if any(stretch.clearance <= 0.0 for stretch in stretches):
            return
        if all(stretch.clearance >= self.target for stretch in stretches):
            return
        lowest = min(stretches, key=lambda stretch: (stretch.nearest, stretch.clearance))
        yield from self._descend((yield from self._probe(lowest.start)), lowest.start, lowest.end)
        self._reserve = RESERVE
        if (yield from self._sweep(self.target)):
            return
        self._reserve = 0
        while True:
            least = min(stretch.clearance for stretch in stretches)
            goal = self._affordable(0)
            if goal - least < WORTH_A_SWEEP * self.upper or not (yield from self._sweep(goal)):
                return

    def _sweep(self, goal: float) -> Generator[Found, None, bool]:
        """Raise the stretches that are not above a goal (m), or a lower one; return whether that was done."""
        stretches = self._stretches
        first, whole = 0, self._guess(0, goal)
        while first < len(stretches):
            goal = min(goal, self.target)
            last = first
            while last < min(len(stretches), first + STRETCHES_BETWEEN) and stretches[last].clearance < goal:
                last += 1
            if last == first:
                first += 1
                continue
            if self._reserve:
                goal = goal if self._hopeful(first, whole) else 0.0
            else:
                goal = min(goal, self._affordable(first))
            if goal <= 0.0 or not (yield from self._advance(stretches[first].start, stretches[last - 1].end, goal)):
                return False
            kept = min(goal, self.target)
            stretches[first:last] = [self._kept(stretch, kept) for stretch in stretches[first:last]]
            first = last
        return True

    def _hopeful(self, first: int, whole: float) -> bool:
        """Return whether the stretches from one on may be raised above the target, by what those before took.

        `whole` is the guess for all.
        """
        taken, left = MOST_MEASUREMENTS - self._left, self._guess(first, self.target)
        return taken < TRIAL or taken * left <= (self._left - self._reserve) * max(0.0, whole - left)

    def _affordable(self, first: int) -> float:
        """Return the highest goal (m) that the measurements left seem to allow for the stretches from one on, or 0."""
        goals = (self.target, *(share * self.upper for share in SHARES))
        return next((goal for goal in goals if goal <= self.target and self._guess(first, goal) <= self._left), 0.0)

    def _guess(self, first: int, goal: float) -> float:
        """Guess how many measurements it takes to raise the stretches from one on above a goal (m).

        Each has spent what it had, its distance; above the goal there is so much less to spend. Nothing rests on it.
        """
        low = [stretch.nearest for stretch in self._stretches[first:] if stretch.clearance < goal]
        nearest = np.maximum(low, self.upper)
        spare = np.maximum(nearest - goal, self.upper - self.target)
        return float(np.divide(nearest, spare, out=np.ones(len(spare)), where=np.isfinite(spare)).sum())

    def _kept(self, stretch: Stretch, above: float) -> Stretch:
        """Return a stretch that stays above some m; what grazed its margin may turn out to have kept it."""
        clearance = max(stretch.clearance, above)
        verdict = Verdict.CLEAR if clearance > self._pair.margin else stretch.verdict
        return stretch._replace(verdict=verdict, clearance=clearance)

    def _descend(self, measurement: Measurement, early: float, late: float) -> Generator[Found, None, None]:
        """Measure where the distance seems to be least: a lower target is proved with fewer steps.

        Args:
            measurement: exact, where to begin.
            early, late: s, between which to look.
        """
        valley = TangentSearch(early, late)
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

    def _advance(self, time: float, end: float, goal: float) -> Generator[Found, None, bool]:
        """Prove the time (s) until `end`, both included, to stay above the goal (m), or above the target where that
        falls below it; return whether that was done.

        It ends because each sleep is worth at least the tolerance, and because measurements are limited.
        """
        while True:
            before, threshold = self.upper, min(goal, self.target)
            measurement = self._measured(time, FAR_IN_TARGETS * threshold)
            if measurement.above < before:
                yield from self._descend(measurement, time, end)
                threshold = min(goal, self.target)
            stop = min(end, self._pair.motion.stop_after(time))  # joined stretches may hold jumps
            ahead = stop - time
            sleep, bound = 0.0, Bound.NONE
            if time < end:
                sleep, bound = SeparationSleep(self._pair, measurement, threshold, self._tuning).sleep(
                    ahead, self._floor
                )
            yield from self._told(measurement, bound, sleep)
            if time >= end:
                return True
            woken = stop if sleep >= ahead else min(time + sleep, stop)
            if woken == time or self._left <= self._reserve:
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
