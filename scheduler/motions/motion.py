"""Motions and their bounds: where a frame is at time t, and how far its points can get over an interval.

Every bound here is an upper bound, in exact arithmetic, over ALL points within `LeverArms`; `rounding_scale` says how
far floating point may fall short. Docstrings name rows of the table of motion bounds in docs/guarantees.md. SI units,
radians; t in scene seconds. A motion acts in its rest frame (world_from_parent * pose), in which its vectors are
expressed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import NamedTuple, Protocol

from ..geometry.arrays import FloatArray
from ..geometry.transform import IDENTITY, transform
from ..geometry.vector import ZERO, Vector
from .acceleration_set import STILL, AccelerationSet

Interval = tuple[float, float]
"""From and to, scene s."""


class Axis(NamedTuple):
    """The line through `point` (m) along the unit vector `direction`."""

    point: Vector
    direction: Vector


class LeverArms(NamedTuple):
    """Upper bounds (m) on how far a set of points, fixed in the moved frame, lies from its origin and from the axis."""

    radius: float
    axis_radius: float


class Rates(NamedTuple):
    """Suprema over an interval: of the frame origin's motion and of the frame's turning, in the rest frame.

    Attributes:
        speed: m/s.
        varying: m/s^2, where the acceleration may be about `steady`.
        angular_speed: rad/s.
        angular_acceleration: rad/s^2.
        steady: m/s^2, a constant vector.
        axis: the unit vector that the frame turns about throughout, None where it may change.
    """

    speed: float
    varying: AccelerationSet
    angular_speed: float
    angular_acceleration: float
    steady: Vector = ZERO
    axis: Vector | None = None

    @property
    def acceleration(self) -> float:
        """Above |a - steady|, m/s^2."""
        return self.varying.norm_bound


class Motion(Protocol):
    """What every motion provides."""

    @property
    def axis(self) -> Axis | None:
        """The fixed axis that the frame turns about, which `axis_radius` is measured from; None: the origin."""
        ...

    def pose(self, t: float) -> FloatArray:
        """Return rest_from_moved at t, 4x4; at a jump the pose after it."""
        ...

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Return D >= |x(t + s) - x(t)| (m) of every point in reach, 0 <= s <= duration; non-decreasing in duration.

        No jump may lie in (t, t + duration]. A jump at t + duration itself is left out.
        """
        ...

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """Return L >= the arc length (m) that any point in reach travels over [t, t + duration]; jumps left out."""
        ...

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return the frame origin's velocity (m/s) and the angular velocity (rad/s) at t, right-hand at a knot."""
        ...

    def rates(self, t: float, duration: float) -> Rates:
        """Return suprema over [t, t + duration], which holds no knot inside."""
        ...

    def knot_after(self, t: float) -> float:
        """Return the first time > t at which a rate jumps (inf: none)."""
        ...

    def stop_after(self, t: float) -> float:
        """Return the first time > t where every pair must wake: a jump, or the last float before it (inf: none)."""
        ...

    def extent(self, times: Interval) -> float:
        """Return an upper bound (m) on the sum of the absolute terms of the translation at any of the times."""
        ...

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """Return the length (m) that, times 8 eps, bounds the error of a point within `radius` at any of the times."""
        ...


def farthest_from_zero(times: Interval) -> float:
    """Return the largest |t| (s) of the times."""
    return max(abs(times[0]), abs(times[1]))


class Smooth:
    """A motion without knots or jumps."""

    __slots__ = ()

    def knot_after(self, t: float) -> float:
        """Return inf."""
        return inf

    def stop_after(self, t: float) -> float:
        """Return inf."""
        return inf


@dataclass(frozen=True, slots=True)
class Fixed(Smooth):
    """No motion at all."""

    @property
    def axis(self) -> Axis | None:
        """None."""
        return None

    def pose(self, t: float) -> FloatArray:
        """Return the identity."""
        return transform(IDENTITY, ZERO)

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Return 0."""
        return 0.0

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """Return 0."""
        return 0.0

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return zeros."""
        return ZERO, ZERO

    def rates(self, t: float, duration: float) -> Rates:
        """Return zeros."""
        return Rates(0.0, STILL, 0.0, 0.0)

    def extent(self, times: Interval) -> float:
        """Return 0."""
        return 0.0

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """Return 0."""
        return 0.0
