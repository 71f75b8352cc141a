"""Free flight: constant acceleration and constant spin."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, sqrt

from ..geometry.arrays import FloatArray
from ..geometry.transform import IDENTITY, chord, transform, turn
from ..geometry.vector import ZERO, Vector, add, dot, norm, scale, subtract, unit
from .acceleration_set import STILL
from .motion import Axis, Interval, LeverArms, Rates, Smooth, farthest_from_zero


@dataclass(frozen=True, slots=True)
class Ballistic(Smooth):
    """translate(velocity t + acceleration t^2 / 2) * rotate(angular_velocity t)."""

    velocity: Vector
    acceleration: Vector
    angular_velocity: Vector

    @property
    def axis(self) -> Axis | None:
        """The spin axis, through the origin."""
        return Axis(ZERO, unit(self.angular_velocity))

    @property
    def turns(self) -> bool:
        """Whether it spins."""
        return self.angular_velocity != ZERO

    def pose(self, t: float) -> FloatArray:
        """Return rest_from_moved, 4x4."""
        path = add(scale(t, self.velocity), scale(0.5 * t * t, self.acceleration))
        if not self.turns:
            return transform(IDENTITY, path)
        spin = norm(self.angular_velocity)
        return transform(turn(unit(self.angular_velocity), spin * t), path)

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Row `Ballistic`: the path, and the chord of the spin; without acceleration row `Ballistic, a = 0`."""
        velocity, _ = self.velocities(t)
        swept = chord(norm(self.angular_velocity) * duration, reach.axis_radius)
        if self.acceleration == ZERO:
            along, across = _split(velocity, self.angular_velocity)
            return hypot(along * duration, across * duration + swept)
        return _ballistic_displacement(velocity, self.acceleration, duration) + swept

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """Speed is convex in t, so the trapezoid over its ends is above its integral."""
        spin = norm(self.angular_velocity) * reach.axis_radius
        if self.acceleration == ZERO:
            along, across = _split(self.velocity, self.angular_velocity)
            return hypot(along, across + spin) * duration
        first, last = norm(self.velocities(t)[0]), norm(self.velocities(t + duration)[0])
        return (0.5 * (first + last) + spin) * duration

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return v(t) of the origin and the constant spin."""
        return add(self.velocity, scale(t, self.acceleration)), self.angular_velocity

    def rates(self, t: float, duration: float) -> Rates:
        """Row `Ballistic`: the speed's maximum is at one end; the acceleration is all steady."""
        speed = max(norm(self.velocities(t)[0]), norm(self.velocities(t + duration)[0]))
        spin = norm(self.angular_velocity)
        return Rates(speed, STILL, spin, 0.0, self.acceleration, unit(self.angular_velocity))

    def extent(self, times: Interval) -> float:
        """Return |v| t + |a| t^2 / 2."""
        latest = farthest_from_zero(times)
        return norm(self.velocity) * latest + 0.5 * norm(self.acceleration) * latest * latest

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """The translation's terms, and the spin's angle at `radius`."""
        return self.extent(times) + radius * (1.0 + norm(self.angular_velocity) * farthest_from_zero(times))


def Constant(velocity: Vector, angular_velocity: Vector) -> Ballistic:  # noqa: N802
    """Return translate(velocity t) * rotate(angular_velocity t), the ballistic motion without acceleration."""
    return Ballistic(velocity, ZERO, angular_velocity)


def _split(v: Vector, axis: Vector) -> tuple[float, float]:
    """Return |v| along and across `axis`; all across where the axis is zero."""
    if axis == ZERO:
        return 0.0, norm(v)
    direction = unit(axis)
    along = dot(v, direction)
    return abs(along), norm(subtract(v, scale(along, direction)))


def _ballistic_displacement(v: Vector, a: Vector, duration: float) -> float:
    """Return the largest |v s + a s^2 / 2| over [0, duration]: at the end, or where its derivative vanishes."""

    def offset(s: float) -> float:
        return norm(add(scale(s, v), scale(0.5 * s * s, a)))

    aa, va, vv = dot(a, a), dot(v, a), dot(v, v)
    largest = offset(duration)
    discriminant = 9.0 * va * va - 8.0 * aa * vv
    if va < 0.0 < aa and discriminant >= 0.0:
        for sign in (-1.0, 1.0):
            root = (-3.0 * va + sign * sqrt(discriminant)) / (2.0 * aa)
            if 0.0 < root < duration:
                largest = max(largest, offset(root))
    return largest
