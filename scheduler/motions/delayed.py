"""A motion that runs on a clock of its own."""

from __future__ import annotations

from dataclasses import dataclass

from ..geometry.arrays import FloatArray
from ..geometry.vector import Vector
from .motion import Axis, Interval, LeverArms, Motion, Rates, Smooth, farthest_from_zero


@dataclass(frozen=True, slots=True)
class Delayed(Smooth):
    """pose(t) = motion.pose(t - delay), for motions without knots; those with knots have their times moved instead.

    Attributes:
        motion: a `Smooth` one.
        delay: s, the scene time at which the motion's own clock stands at 0.
    """

    motion: Motion
    delay: float

    def __post_init__(self) -> None:
        """Hold to the contract: rounded clocks could not agree on the knots."""
        assert isinstance(self.motion, Smooth)

    @property
    def axis(self) -> Axis | None:
        """The motion's own."""
        return self.motion.axis

    def pose(self, t: float) -> FloatArray:
        """Return rest_from_moved, 4x4."""
        return self.motion.pose(t - self.delay)

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Return the motion's bound at its own time."""
        return self.motion.displacement(t - self.delay, duration, reach)

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """Return the motion's bound at its own time."""
        return self.motion.path_length(t - self.delay, duration, reach)

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return the motion's at its own time."""
        return self.motion.velocities(t - self.delay)

    def rates(self, t: float, duration: float) -> Rates:
        """Return the motion's at its own time."""
        return self.motion.rates(t - self.delay, duration)

    def extent(self, times: Interval) -> float:
        """Return the motion's at its own times."""
        return self.motion.extent(self._own(times))

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """The motion's own, and the way that any point goes in the time that t - delay is rounded by.

        That is half a spacing of floats at t - delay, not at t: the nearer both are, the less is lost.
        """
        first, last = own = self._own(times)
        rates = self.motion.rates(first, last - first)
        speed = rates.speed + rates.angular_speed * radius
        return self.motion.rounding_scale(own, radius) + speed * farthest_from_zero(own)

    def _own(self, times: Interval) -> Interval:
        """Return what the motion's own clock shows at both ends."""
        return times[0] - self.delay, times[1] - self.delay
