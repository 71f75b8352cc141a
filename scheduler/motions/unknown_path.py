"""A path that is unknown except for its limits: how far it can have led by a given time."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from ..geometry.arrays import FloatArray
from ..geometry.transform import IDENTITY, transform
from ..geometry.vector import ZERO, Vector
from .acceleration_set import ball
from .motion import Axis, Interval, LeverArms, Rates, Smooth


@dataclass(frozen=True, slots=True)
class Limits(Smooth):
    """Anywhere that the frame's origin can get to from the rest pose, turned in any way.

    Where it is can only be bounded: it has no bounds of a path of its own, and `pose` is where it was last known to be.

    Attributes:
        begin: s, until when it stands at the rest pose.
        speed: m/s of the origin at `begin`.
        max_speed: m/s of the origin, >= `speed`; inf if unlimited.
        max_acceleration: m/s^2 of the origin; inf if unlimited, but not both.
    """

    begin: float
    speed: float
    max_speed: float
    max_acceleration: float

    @property
    def axis(self) -> Axis | None:
        """None."""
        return None

    def pose(self, t: float) -> FloatArray:
        """Return the identity: the rest pose."""
        return transform(IDENTITY, ZERO)

    def reach(self, t: float) -> float:
        """Return how far (m) the origin may be from its rest place at t; never decreases.

        The integral of min(speed + max_acceleration s, max_speed) over the time since `begin`.
        """
        since = max(0.0, t - self.begin)
        if since == 0.0:
            return 0.0
        if self.max_acceleration == inf:
            return self.max_speed * since
        rising = since
        if self.max_acceleration > 0.0:
            rising = min(since, (self.max_speed - self.speed) / self.max_acceleration)
        risen = self.speed * rising + 0.5 * self.max_acceleration * rising * rising
        return risen if rising == since else risen + self.max_speed * (since - rising)

    def speed_at(self, t: float) -> float:
        """Return the most (m/s) that the reach grows by at t, or just after."""
        since = t - self.begin
        if since < 0.0:
            return 0.0
        if self.max_acceleration == inf:
            return self.max_speed
        return min(self.speed + self.max_acceleration * since, self.max_speed)

    def acceleration_after(self, t: float) -> float:
        """Return the most (m/s^2) that this speed rises by from t on, until the next knot."""
        still = t < self.begin or self.speed_at(t) >= self.max_speed
        return 0.0 if still else self.max_acceleration

    def knot_after(self, t: float) -> float:
        """Return when the origin may begin to move, for t before."""
        return self.begin if t < self.begin else inf

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Return inf: nothing is known of any point from one time to another."""
        return inf

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """Return inf."""
        return inf

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return zeros: where it is last known to be, it rests."""
        return ZERO, ZERO

    def rates(self, t: float, duration: float) -> Rates:
        """Return the limits; how it turns is not limited."""
        return Rates(self.speed_at(t + duration), ball(self.max_acceleration), inf, inf)

    def extent(self, times: Interval) -> float:
        """Return the reach at the last of the times."""
        return self.reach(times[1])

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """Return the reach at the last of the times, and the radius."""
        return self.reach(times[1]) + radius
