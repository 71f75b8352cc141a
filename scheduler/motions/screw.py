"""Turning about an axis at a constant rate, advancing along it."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, pi

from ..geometry.arrays import FloatArray
from ..geometry.transform import apply, chord, turn, turned_about
from ..geometry.vector import ZERO, Vector, add, cross, distance_to_line, norm, scale
from .acceleration_set import disc
from .motion import Axis, Interval, LeverArms, Rates, Smooth, farthest_from_zero


@dataclass(frozen=True, slots=True)
class Screw(Smooth):
    """Turn about the unit `axis_direction` through `point` at `rate` rad/s, advancing `pitch` m per positive turn."""

    axis_direction: Vector
    point: Vector
    rate: float
    pitch: float

    @property
    def axis(self) -> Axis | None:
        """The screw's axis."""
        return Axis(self.point, self.axis_direction)

    def pose(self, t: float) -> FloatArray:
        """Return rest_from_moved, 4x4."""
        angle = self.rate * t
        advance = scale(self.pitch * angle / (2.0 * pi), self.axis_direction)
        return turned_about(self.axis_direction, self.point, angle, advance)

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Row `Screw`."""
        return hypot(self._advance_rate * duration, chord(abs(self.rate) * duration, reach.axis_radius))

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """Row `Screw`: the speed is w sqrt(h^2 + rho^2), exactly."""
        return hypot(self._advance_rate, self.rate * reach.axis_radius) * duration

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return the origin's velocity on its helix and the constant spin."""
        spin = scale(self.rate, self.axis_direction)
        arm = apply(turn(self.axis_direction, self.rate * t), scale(-1.0, self.point))
        advance = scale(self.pitch * self.rate / (2.0 * pi), self.axis_direction)
        return add(cross(spin, arm), advance), spin

    def rates(self, t: float, duration: float) -> Rates:
        """The origin runs on a helix of radius rho_o: speed w sqrt(h^2 + rho_o^2), acceleration w^2 rho_o."""
        radius = distance_to_line(ZERO, self.point, self.axis_direction)
        speed = hypot(self._advance_rate, self.rate * radius)
        bend = disc(self.axis_direction, self.rate**2 * radius)
        return Rates(speed, bend, abs(self.rate), 0.0, axis=self.axis_direction)

    def extent(self, times: Interval) -> float:
        """Return 2 |point| + |h w| t."""
        return 2.0 * norm(self.point) + self._advance_rate * farthest_from_zero(times)

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """The translation's terms, and the angle at the farthest of the points and the axis point."""
        angle = abs(self.rate) * farthest_from_zero(times)
        return self.extent(times) + (radius + norm(self.point)) * (1.0 + angle)

    @property
    def _advance_rate(self) -> float:
        return abs(self.pitch * self.rate) / (2.0 * pi)
