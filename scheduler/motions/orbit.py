"""A circle around the rest origin, the body's orientation fixed or turning with it."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin

from ..geometry.arrays import FloatArray
from ..geometry.transform import IDENTITY, chord, transform, turn
from ..geometry.vector import ZERO, Vector, add, cross, scale
from .acceleration_set import disc
from .motion import Axis, Interval, LeverArms, Rates, Smooth, farthest_from_zero


@dataclass(frozen=True, slots=True)
class Orbit(Smooth):
    """translate(radius (cos a start + sin a axis x start)), a = rate t + phase; `facing` also turns the body by a.

    Attributes:
        axis_direction: unit, what the orbit runs around, right-handed.
        start: unit, perpendicular to the axis; where the body is at a = 0.
        radius: m.
        rate: rad/s.
        phase: rad.
        facing: whether the body turns about its origin by the same angle, as if it were bolted to the rest origin.
    """

    axis_direction: Vector
    start: Vector
    radius: float
    rate: float
    phase: float
    facing: bool

    @property
    def axis(self) -> Axis | None:
        """Facing: the orbit's axis, which in the moved frame passes through -radius start; None: nothing turns."""
        return Axis(scale(-self.radius, self.start), self.axis_direction) if self.facing else None

    def pose(self, t: float) -> FloatArray:
        """Return rest_from_moved, 4x4."""
        angle = self.rate * t + self.phase
        rows = turn(self.axis_direction, angle) if self.facing else IDENTITY
        return transform(rows, scale(self.radius, self._radial(angle)))

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Row `Orbit` (exact)."""
        return chord(abs(self.rate) * duration, self._arm(reach))

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """The arc (exact)."""
        return abs(self.rate) * duration * self._arm(reach)

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return the origin's velocity along the circle, and the constant spin if the body faces the axis."""
        radial = self._radial(self.rate * t + self.phase)
        spin = scale(self.rate, self.axis_direction)
        return scale(self.radius, cross(spin, radial)), spin if self.facing else ZERO

    def rates(self, t: float, duration: float) -> Rates:
        """The origin runs on a circle: speed w R, acceleration w^2 R, both constant."""
        radius, rate = abs(self.radius), abs(self.rate)
        bend = disc(self.axis_direction, rate * rate * radius)
        return Rates(rate * radius, bend, rate if self.facing else 0.0, 0.0, axis=self.axis_direction)

    def extent(self, times: Interval) -> float:
        """Return both terms' radii."""
        return 2.0 * abs(self.radius)

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """The angle's terms at the orbit's radius; at the points' too where they turn."""
        farthest = abs(self.radius) + (radius if self.facing else 0.0)
        angle = abs(self.rate) * farthest_from_zero(times) + abs(self.phase)
        return self.extent(times) + farthest * (1.0 + angle)

    def _radial(self, angle: float) -> Vector:
        """Return the unit vector from the rest origin to the body."""
        return add(scale(cos(angle), self.start), scale(sin(angle), cross(self.axis_direction, self.start)))

    def _arm(self, reach: LeverArms) -> float:
        """Return the radius (m) of the largest circle that any point runs on."""
        return reach.axis_radius if self.facing else abs(self.radius)
