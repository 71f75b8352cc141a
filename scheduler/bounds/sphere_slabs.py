"""Slabs between bounding spheres: separating axes that turning bodies do not narrow.

A sphere looks the same however it turns, so only the motion of its middle counts. The bound needs a few numbers of the
pair, and no points.
"""

from __future__ import annotations

from math import inf, ulp
from typing import NamedTuple

from ..geometry.rounding import RELATIVE_ROUNDING
from ..geometry.vector import Vector, dot, norm, scale, subtract, unit
from ..kinematics.chain import Part
from ..kinematics.relative_motion import PairState, RelativeMotion, RelativeRates
from .closed_form import longest_sleep, time_bound

#: So many slabs follow each other at most, and on the average each is to last for so small a share of what is asked.
MOST_SLABS = 64


class Gap(NamedTuple):
    """A slab's width (m), how fast (m/s) it shrinks now, and above how fast (m/s^2) that grows until the horizon."""

    width: float
    closing: float
    bend: float

    def lasts(self, spare: float) -> float:
        """Return how long (s) it stays wider than `spare` m; errs low."""
        left = self.width - spare
        return time_bound(left, self.closing, self.bend) * (1.0 - RELATIVE_ROUNDING) if left > 0.0 else 0.0

    def least(self, duration: float) -> float:
        """Return a lower bound (m) on the width over the next `duration` s."""
        lost = max(0.0, self.closing * duration + 0.5 * self.bend * duration**2)
        return self.width - lost * (1.0 + RELATIVE_ROUNDING)


class SphereSlab:
    """The slab between two balls at one time that lasts longest of two, or of two that last, stays widest.

    One lies across the way between the middles now, the other across that way when they are nearest, as they go on.

    Attributes:
        horizon: s, how far ahead it may be asked of.
    """

    def __init__(
        self, apart: Vector, taken: float, closing: Vector, beyond: float, near_future: RelativeRates, slack: float
    ) -> None:
        """Take the balls.

        Args:
            apart: m, from the middle of the first ball to that of the second.
            taken: m, both radii and the error of placing them.
            closing: m/s, the velocity of the first middle less that of the second.
            beyond: m, the width that the slab is chosen to keep.
            near_future: how the one middle accelerates relative to the other, and until when.
            slack: m/s, by which the velocities may be wrong.
        """
        self.horizon = near_future.horizon
        self._lost = taken + RELATIVE_ROUNDING * (norm(apart) + taken)
        self._slack = slack
        self._near = near_future
        speed = norm(closing)
        nearest = dot(apart, unit(closing)) / speed if speed > 0.0 else 0.0
        meeting = subtract(apart, scale(min(max(0.0, nearest), self.horizon), closing))
        gaps = (self._across(unit(way), apart, closing) for way in (apart, meeting))
        self._gap = max(gaps, key=lambda gap: (min(gap.lasts(beyond), self.horizon), gap.least(self.horizon)))

    def sleep(self, spare: float) -> float:
        """Return how long (s, <= horizon) the slab stays wider than `spare` m; errs low."""
        return min(self._gap.lasts(spare), self.horizon)

    def clearance(self, duration: float) -> float:
        """Return a lower bound (m) on the distance over the next `duration` s, -inf past the horizon."""
        return self._gap.least(duration) if duration <= self.horizon else -inf

    def _across(self, way: Vector, apart: Vector, closing: Vector) -> Gap:
        """Return the gap between the balls along a unit vector."""
        bend = dot(way, self._near.steady) + self._near.varying.support(way)
        return Gap(dot(way, apart) - self._lost, dot(way, closing) + self._slack, max(0.0, bend))


class Stay(NamedTuple):
    """How far apart two balls certainly stay, in any direction, across any number of knots.

    Attributes:
        horizon: s, how far ahead it may be asked of.
        left: m, lower bound on the distance until then.
    """

    horizon: float
    left: float

    def sleep(self, spare: float) -> float:
        """Return how long (s, <= horizon) the balls stay more than `spare` m apart; errs low."""
        return self.horizon if self.left > spare else 0.0

    def clearance(self, duration: float) -> float:
        """Return a lower bound (m) on the distance over the next `duration` s, -inf past the horizon."""
        return self.left if duration <= self.horizon else -inf


class _Stage(NamedTuple):
    """One of several slabs, or stays.

    Attributes:
        since: s after the first one, when it begins.
        late: s, by how much later than it seems a time since then may be.
        wanted: s, from then until the last time that may be asked of.
        kept: m, lower bound on the distance until it begins.
    """

    since: float
    late: float
    wanted: float
    kept: float
    slab: SphereSlab | Stay


class SphereSlabs:
    """Slabs between the bounding balls of a pair, one after the other: a new one wherever a motion changes its law.

    Where it changes so often that slabs would be too many, what the balls are displaced by leads on instead, past any
    number of knots. Where balls are is known by heart: no measurement is needed on the way.
    """

    def __init__(self, motion: RelativeMotion, error: float, state: PairState, duration: float, beyond: float) -> None:
        """Look ahead from a time.

        Args:
            motion: of the pair, whose balls are meant.
            error: m, by which a distance may be wrong.
            moments: of the pair at that time.
            duration: s, how far ahead they may be asked of, before the next stop.
            beyond: m, the width that slabs are chosen to keep; past where one does not there is none.
        """
        start, since, late, kept = state.time, 0.0, 0.0, inf
        self._duration = duration
        self._stages: list[_Stage] = []
        while True:
            wanted = duration - since + late if since < duration else 0.0
            slab: SphereSlab | Stay = _slab_between(motion, error, state, wanted, beyond)
            if MOST_SLABS * slab.horizon < wanted and slab.sleep(beyond) == slab.horizon:
                stay = _stay_of(motion, error, state, wanted, beyond)
                slab = stay if stay.horizon > slab.horizon else slab
            self._stages.append(_Stage(since, late, wanted, kept, slab))
            if slab.horizon >= wanted or slab.sleep(beyond) < slab.horizon or self._are_many(since + slab.horizon):
                return
            late = 4.0 * ulp(abs(start) + duration)
            if isinstance(slab, Stay):
                following, moved = state.time + (slab.horizon - late), 0.0
            else:
                following, moved = motion.crossing(state, slab.horizon, late)
            kept = min(kept, slab.clearance(slab.horizon) - moved)
            if following - start > duration or following <= state.time or kept <= beyond:
                return
            state, since = motion.at(following), following - start

    def _are_many(self, reached: float) -> bool:
        """Return whether there are too many to go on, or too many for how far (s) they have reached."""
        count = len(self._stages)
        return count == MOST_SLABS or MOST_SLABS * reached < (count - 1) * self._duration

    def sleep(self, spare: float) -> float:
        """Return how long (s) slabs stay wider than `spare` m; errs low."""
        sleep = 0.0
        for since, late, wanted, kept, slab in self._stages:
            if kept <= spare:
                break
            lasts = slab.sleep(spare)
            if lasts >= wanted:
                return self._duration
            sleep = since + max(0.0, lasts - late)
        return sleep

    def clearance(self, duration: float) -> float:
        """Return a lower bound (m) on the distance over the next `duration` s, -inf where no slab reaches so far."""
        if duration <= self._duration:
            for since, late, wanted, kept, slab in self._stages:
                lasts = min(max(0.0, duration - since + late), wanted)
                if lasts <= slab.horizon:
                    return min(kept, slab.clearance(lasts))
        return -inf


def _slab_between(motion: RelativeMotion, error: float, state: PairState, duration: float, beyond: float) -> SphereSlab:
    """Return the slab between the bounding balls of a pair at one time, up to where a motion changes its law."""
    a, b = state.a, state.b
    near = motion.approach(state, duration, Part.CENTRE)
    closing = subtract(a.twist.of(a.centre), b.twist.of(b.centre))
    taken = motion.radii + motion.spread(state.time) + error
    return SphereSlab(subtract(b.centre, a.centre), taken, closing, beyond, near, motion.slack(state))


def _stay_of(motion: RelativeMotion, error: float, state: PairState, duration: float, beyond: float) -> Stay:
    """Return for how long the bounding balls of a pair spend no more than half of what they are apart beyond `beyond`.

    The other half keeps those that are far apart known to be so, and is spent by the stays that follow.
    """
    t = state.time
    taken = motion.radii + motion.spread(t) + error
    gap = norm(subtract(state.b.centre, state.a.centre)) * (1.0 - RELATIVE_ROUNDING)
    gap -= taken * (1.0 + RELATIVE_ROUNDING)
    middles = motion.middles
    now = middles.at(t)

    def moved(duration: float) -> float:
        return middles.displacement(now, duration) * (1.0 + RELATIVE_ROUNDING)

    spend, horizon = 0.5 * (gap - beyond), min(duration, motion.stop_after(t) - t)
    lasts = longest_sleep(moved, spend, horizon, 0.5 * horizon) if spend > 0.0 else 0.0
    return Stay(lasts, gap - moved(lasts))
