"""How long spheres inside two solids go on overlapping, so that a deep contact sleeps.

The spheres lie inside the solids, about the middles of their bounds. While the spheres overlap, so do the solids.
Turning a sphere changes nothing, so only the motion of its middle counts. This is the counterpart of the slab between
bounding spheres.
"""

from __future__ import annotations

from math import ulp

from ..geometry.rounding import RELATIVE_ROUNDING
from ..geometry.vector import Vector, add, norm, scale, subtract
from ..kinematics.chain import Part
from ..kinematics.relative_motion import PairState, RelativeMotion, RelativeRates

#: So many times a motion may change its law before the balls are looked at anew.
MOST_LEGS = 64
#: How often the time that they go on is halved in search of its end.
HALVINGS = 32


class InscribedSpheres:
    """Two balls about the middles of a pair's bodies, inside them."""

    def __init__(self, motion: RelativeMotion, radii: float) -> None:
        """Take the pair's motion, its paths known, and both radii together (m), errors taken off."""
        self._motion = motion
        self._radii = radii

    def sleep(self, state: PairState, horizon: float, worth: float = 0.0) -> float:
        """Return how long (s, <= horizon) they go on meeting, 0 if they do not meet; errs low.

        Where a motion changes its law they are looked at again; up to there, displacement is what is certain.

        Args:
            moments: of the pair now.
            horizon: s, before the next stop.
            worth: s, how long there are to be between two such looks, on the average.
        """
        motion, start, since, late = self._motion, state.time, 0.0, 0.0
        for legs in range(MOST_LEGS):
            wanted = horizon - since + late
            leg = _Leg(motion, state, wanted)
            lasts = leg.lasts(self._radii)
            slept = since + max(0.0, lasts - late)
            if lasts < leg.horizon:
                return slept
            if leg.horizon >= wanted:
                return horizon
            late = 4.0 * ulp(abs(start) + horizon)
            knot, moved = motion.crossing(state, leg.horizon, late)
            if not leg.apart(leg.horizon) + moved <= self._radii or slept < legs * worth:
                return slept
            if knot - start > horizon:
                return horizon
            state, since = motion.at(knot), knot - start
        return since


class _Leg:
    """How far apart the middles get from one time on, while no motion changes its law.

    Attributes:
        horizon: s, until when.
    """

    def __init__(self, motion: RelativeMotion, state: PairState, duration: float) -> None:
        near: RelativeRates = motion.approach(state, duration, Part.CENTRE)
        a, b = state.a, state.b
        self.horizon = near.horizon
        self._apart: Vector = subtract(b.centre, a.centre)
        self._parting: Vector = subtract(b.twist.of(b.centre), a.twist.of(a.centre))
        self._slack = motion.slack(state)
        self._bend = near.acceleration

    def apart(self, since: float) -> float:
        """Return how far (m) apart they are at most `since` s later; convex."""
        now = norm(add(self._apart, scale(since, self._parting)))
        return (now + self._slack * since + 0.5 * self._bend * since**2) * (1.0 + RELATIVE_ROUNDING)

    def lasts(self, most: float) -> float:
        """Return how long (s, <= horizon) they stay within `most` m of each other; errs low."""
        if self.apart(0.0) > most:
            return 0.0
        if self.apart(self.horizon) <= most:
            return self.horizon
        low, high = 0.0, self.horizon
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.apart(middle) <= most else (low, middle)
        return low
