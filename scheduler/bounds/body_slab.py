"""A slab between two whole bodies: a separating axis along which they stay apart for some time.

A convex body lies on one side of the plane through its nearest triangle. Many other bodies nearly do, close to that
triangle. Then one axis serves all triangles, near and far, and the bound is exact up to the acceleration.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.rounding import RELATIVE_ROUNDING
from ..kinematics.chain import Twist
from ..kinematics.relative_motion import RelativeRates
from ..narrow.slivers import EPSILON
from .triangle_slabs import axes_between, roots

#: Widths err by no more than this many eps times the points' coordinates.
SLAB_ROUNDING = 16.0 * EPSILON
#: The first trial lies this share below the root, where the width is just above zero.
TRIAL_ROUNDING = 1e-9
#: How often the time that the slab lasts is bracketed tighter.
STEPS = 12


class Points(NamedTuple):
    """The points (n, 3) m that span a body, each rounded by its radius (n,) m, and how they move."""

    places: FloatArray
    radii: FloatArray
    twist: Twist


@dataclass(frozen=True, slots=True, eq=False)
class BodySlab:
    """A slab between two bodies, across an axis.

    Its width after s is the least of the one body's n.q + n.v s less the most of the other's, less what accelerations
    may do: a concave function of s, so that it is positive from now up to wherever it is found to be.

    Attributes:
        horizon: s, how far ahead it may be asked of.
        low, approach: m, m/s, (n,): where the points of the first body that may be the foremost are, and their speeds.
        high, retreat: m, m/s, (n,): the same of the other body.
        bend: m/s^2, how fast the closing speed may grow.
        lost: m, by which the placed points may be wrong.
        slack: m/s, by which the velocities may be wrong.
        guess: s, > 0: how long it lasts, by the points that are the foremost now.
    """

    horizon: float
    low: FloatArray
    approach: FloatArray
    high: FloatArray
    retreat: FloatArray
    bend: float
    lost: float
    slack: float
    guess: float

    def _width(self, since: float) -> float:
        """Return a lower bound (m) on the distance `since` s later, at most the horizon; the slab's, if positive."""
        other = float((self.high + self.retreat * since).min())
        one = float((self.low + self.approach * since).max())
        closed = self.lost + self.slack * since + 0.5 * self.bend * since**2
        return (other - one) * (1.0 - RELATIVE_ROUNDING) - closed * (1.0 + RELATIVE_ROUNDING)

    def sleep(self, spare: float) -> float:
        """Return how long (s, <= horizon) it stays wider than `spare` m; errs low."""
        if self._width(0.0) <= spare:
            return 0.0
        if self._width(self.horizon) > spare:
            return self.horizon
        low, high = 0.0, self.horizon
        middle = self.guess * (1.0 - TRIAL_ROUNDING)
        for _ in range(STEPS):
            if self._width(middle) > spare:
                low = middle
            else:
                high = middle
            middle = 0.5 * (low + high)
        return low * (1.0 - RELATIVE_ROUNDING)

    def clearance(self, duration: float) -> float:
        """Return a lower bound (m) on the distance over the next `duration` s; -inf past the horizon."""
        if duration > self.horizon:
            return -inf
        return min(self._width(0.0), self._width(duration))


def lasting_slab(
    one: Points,
    other: Points,
    nearest: tuple[FloatArray, FloatArray],
    error: float,
    beyond: float,
    near_future: RelativeRates,
    slack: float,
) -> BodySlab | None:
    """Return the slab that lasts longest, of those along the axes of two bodies' nearest triangles; None without one.

    Args:
        one, other: the bodies' points.
        nearest: the corners (3, 3) m of the triangle of each that is nearest to the other body.
        error: m, by which placed points may be wrong.
        beyond: m, the width that the slab is chosen to keep.
        near_future: how any point of the one accelerates relative to any of the other, and until when.
        slack: m/s, by which the velocities may be wrong.
    """
    horizon = near_future.horizon
    lost = error + SLAB_ROUNDING * max(float(np.abs(points.places).max()) for points in (one, other))
    axes = axes_between(nearest[0][None], nearest[1][None])[0]
    low, high = axes @ one.places.T + one.radii, axes @ other.places.T - other.radii
    widths = high.min(axis=1) - low.max(axis=1) - lost
    wide = widths > max(beyond, 0.0)
    if not wide.any():
        return None
    axes, low, high = axes[wide], low[wide], high[wide]
    approach, retreat = one.twist.along(axes, one.places), other.twist.along(axes, other.places)
    closings = approach.max(axis=1) - retreat.min(axis=1) + slack
    bends = np.maximum(0.0, axes @ np.array(near_future.steady) + near_future.varying.supports(axes))
    lasting = roots(widths[wide] - beyond, closings, bends)
    best = int(lasting.argmax())
    if lasting[best] <= 0.0:
        return None
    first = _foremost(low[best], approach[best], horizon)
    last, retreats = _foremost(-high[best], -retreat[best], horizon)
    return BodySlab(horizon, *first, -last, -retreats, float(bends[best]), lost, slack, float(lasting[best]))


def _foremost(places: FloatArray, speeds: FloatArray, horizon: float) -> tuple[FloatArray, FloatArray]:
    """Return those of points (n,) m on a line, moving at (n,) m/s, that may be the foremost at times until then."""
    after = places + speeds * horizon
    overtaken = np.maximum(places, after) < np.minimum(places, after).max()
    return places[~overtaken], speeds[~overtaken]
