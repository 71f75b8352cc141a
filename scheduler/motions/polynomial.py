"""A translation that is a polynomial in time, with a constant spin."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.transform import chord, transform, turn
from ..geometry.vector import ZERO, Vector, add, norm, scale, unit
from .acceleration_set import STILL, between
from .bernstein import Arc
from .motion import Axis, Interval, LeverArms, Rates, Smooth, farthest_from_zero


@dataclass(frozen=True, slots=True)
class Polynomial(Smooth):
    """translate(sum coefficients[k] t^k) * rotate(angular_velocity t).

    Attributes:
        coefficients: m/s^k, at least one.
        angular_velocity: rad/s.
    """

    coefficients: tuple[Vector, ...]
    angular_velocity: Vector
    _arc: Arc = field(init=False, repr=False, compare=False)
    _recent: list[tuple[float, Arc, Arc]] = field(init=False, repr=False, compare=False)  # at most one, see _local

    def __post_init__(self) -> None:
        """Prepare the bounds."""
        sizes = np.array([norm(c) for c in self.coefficients])
        object.__setattr__(self, "_arc", Arc(np.array(self.coefficients), sizes))
        object.__setattr__(self, "_recent", [])

    @property
    def axis(self) -> Axis | None:
        """The spin axis, through the origin."""
        return Axis(ZERO, unit(self.angular_velocity))

    def pose(self, t: float) -> FloatArray:
        """Return rest_from_moved, 4x4."""
        spin = norm(self.angular_velocity)
        return transform(turn(unit(self.angular_velocity), spin * t), self._place(t))

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Row `Polynomial`: control points, and the chord of the spin."""
        swept = chord(norm(self.angular_velocity) * duration, reach.axis_radius)
        way, before, after = self._local(t)[0], *_either_side(t, duration)
        if after == 0.0:
            return way.supremum(duration) + swept
        place = np.array(self._place(t))
        rest = self._arc.away_from(place, self.extent((t, 0.0))).supremum(after)
        return max(way.supremum(before), rest) + swept

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """Row `Polynomial`: the mean norm of the velocity's control points, and the arc of the spin."""
        swept = norm(self.angular_velocity) * duration * reach.axis_radius
        before, after = _either_side(t, duration)
        gone = self._local(t)[1].integral(before)
        return (gone + self._arc.derivative().integral(after) if after > 0.0 else gone) + swept

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return v(t) of the origin and the constant spin."""
        x, y, z = self._local(t)[1].coefficients[0].tolist()
        return (x, y, z), self.angular_velocity

    def rates(self, t: float, duration: float) -> Rates:
        """Row `Polynomial`; up to the second degree the acceleration is all steady."""
        velocity, spin = self._local(t)[1], norm(self.angular_velocity)
        before, after = _either_side(t, duration)
        speed = velocity.supremum(before)
        if after > 0.0:
            speed = max(speed, self._arc.derivative().supremum(after))
        acceleration, axis = velocity.derivative(), unit(self.angular_velocity)
        if len(self.coefficients) <= 3:
            x, y, z = acceleration.coefficients[0].tolist()
            return Rates(speed, STILL, spin, 0.0, (x, y, z), axis)
        steady, varying = acceleration.spread(before)
        if after > 0.0:
            middle, varying_after = self._arc.derivative().derivative().spread(after)
            steady, apart = between(steady, middle)
            varying = apart.plus(varying).plus(varying_after)
        return Rates(speed, varying, spin, 0.0, steady, axis)

    def extent(self, times: Interval) -> float:
        """Return the sum of every term's size."""
        latest = farthest_from_zero(times)
        return sum(norm(c) * latest**k for k, c in enumerate(self.coefficients))

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """The terms, each rounded twice a degree, and the spin's angle at `radius`."""
        terms = self.extent(times) * (1.0 + 0.25 * len(self.coefficients))
        return terms + radius * (1.0 + norm(self.angular_velocity) * farthest_from_zero(times))

    def _place(self, t: float) -> Vector:
        """Return the translation (Horner)."""
        place = ZERO
        for coefficient in reversed(self.coefficients):
            place = add(scale(t, place), coefficient)
        return place

    def _local(self, t: float) -> tuple[Arc, Arc]:
        """Return the way from p(t) and the velocity, as arcs that begin at t; kept, since a wakeup asks ten times."""
        for known, arc, velocity in self._recent[:1]:
            if known == t:
                return arc, velocity
        arc = self._arc.shifted(t).from_start()
        velocity = arc.derivative()
        self._recent[:] = [(t, arc, velocity)]
        return arc, velocity


def _either_side(t: float, duration: float) -> tuple[float, float]:
    """Return the parts of [t, t + duration] before and after t = 0; all before where it does not pass 0.

    Counted from a negative t, the terms grow as (|t| + s)^k. Past 0 the curve's own do better, as s^k.
    """
    return (-t, t + duration) if t < 0.0 < t + duration else (duration, 0.0)
