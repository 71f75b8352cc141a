"""The directional bound for bounding balls: a slab between them, which turning bodies do not narrow.

A ball looks the same however it turns, so that its middle's motion alone counts: numbers of one pair, no points.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

from .bounds import RELATIVE_ROUNDING, time_bound
from .relative import Approach
from .vector import Vector, dot, norm, scale, subtract, unit


class Gap(NamedTuple):
    """A slab's width (m), how fast (m/s) it shrinks now, and above how fast (m/s^2) that grows until the horizon."""

    width: float
    closing: float
    bend: float

    def lasts(self, spare: float) -> float:
        """Return how long (s) it stays wider than `spare` m; errs low."""
        left = self.width - spare
        return time_bound(left, self.closing, self.bend) * (1.0 - RELATIVE_ROUNDING) if left > 0.0 else 0.0


class BallSlab:
    """The slab between two balls at one time that lasts longest of two.

    One lies across the way between the middles now, the other across that way when they are nearest, as they go on.

    Attributes:
        horizon: s, how far ahead it may be asked of.
    """

    def __init__(
        self, apart: Vector, taken: float, closing: Vector, beyond: float, near_future: Approach, slack: float
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
        nearest = dot(apart, closing) / speed**2 if speed > 0.0 else 0.0
        meeting = subtract(apart, scale(min(max(0.0, nearest), self.horizon), closing))
        gaps = (self._across(unit(way), apart, closing) for way in (apart, meeting))
        self._gap = max(gaps, key=lambda gap: (min(gap.lasts(beyond), self.horizon), -gap.closing))

    def sleep(self, spare: float) -> float:
        """Return how long (s, <= horizon) the slab stays wider than `spare` m; errs low."""
        return min(self._gap.lasts(spare), self.horizon)

    def clearance(self, duration: float) -> float:
        """Return a lower bound (m) on the distance over the next `duration` s, -inf past the horizon."""
        if duration > self.horizon:
            return -inf
        lost = max(0.0, self._gap.closing * duration + 0.5 * self._gap.bend * duration**2)
        return self._gap.width - lost * (1.0 + RELATIVE_ROUNDING)

    def _across(self, way: Vector, apart: Vector, closing: Vector) -> Gap:
        """Return the gap between the balls along a unit vector."""
        bend = dot(way, self._near.steady) + self._near.varying.reach(way)
        return Gap(dot(way, apart) - self._lost, dot(way, closing) + self._slack, max(0.0, bend))
