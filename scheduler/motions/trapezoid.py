"""A point-to-point move: a slide or a turn with a trapezoidal speed, at rest before and after."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from itertools import pairwise
from math import copysign, hypot, inf, nextafter, sqrt

from ..geometry.arrays import FloatArray
from ..geometry.transform import IDENTITY, apply, chord, transform, turn, turned_about
from ..geometry.vector import ZERO, Vector, cross, distance_to_line, norm, scale
from .acceleration_set import STILL, disc
from .key_interval import end_of
from .motion import Axis, Interval, LeverArms, Rates


@dataclass(frozen=True, slots=True)
class Trapezoid:
    """Slide along, or turn about, an axis from `begin` to `end` by a trapezoid (a triangle where it is too short).

    The speed rises from the first knot to the second, stays to the third and falls to the fourth. The knots are floats;
    the speed between them is what covers the distance exactly, so that the move has no gaps. It differs from the real
    numbers' trapezoid by the way gone in the time that the knots were rounded by.

    Attributes:
        turns: turn about the axis; else slide along it.
        axis_direction: unit.
        point: m, on the axis; of no effect on a slide.
        begin: m or rad, before the move.
        end: m or rad, after it.
        max_velocity: m/s or rad/s, > 0.
        max_acceleration: m/s^2 or rad/s^2, > 0, finite.
        start_time: s, when the move begins.
    """

    turns: bool
    axis_direction: Vector
    point: Vector
    begin: float
    end: float
    max_velocity: float
    max_acceleration: float
    start_time: float
    _knots: tuple[float, float, float, float] = field(init=False, repr=False, compare=False)
    _top: float = field(init=False, repr=False, compare=False)  # m/s or rad/s, >= 0, between the middle knots

    def __post_init__(self) -> None:
        """Place the knots, at least a float apart where the speed changes between them."""
        travel, begin = abs(self.end - self.begin), self.start_time
        ramp, triangle = self.max_velocity / self.max_acceleration, sqrt(travel) / sqrt(self.max_acceleration)
        cruise = travel / self.max_velocity - ramp if ramp < triangle else 0.0
        ramp = min(ramp, triangle)
        risen = max(begin + ramp, nextafter(begin, inf))
        braking = risen if cruise == 0.0 else max(begin + (ramp + cruise), risen)
        stopped = max(begin + (2.0 * ramp + cruise), nextafter(braking, inf))
        object.__setattr__(self, "_knots", (begin, risen, braking, stopped))
        mean_time = 0.5 * (risen - begin) + (braking - risen) + 0.5 * (stopped - braking)
        object.__setattr__(self, "_top", travel / mean_time if travel > 0.0 else 0.0)

    @property
    def axis(self) -> Axis | None:
        """The axis of a turn; None for a slide."""
        return Axis(self.point, self.axis_direction) if self.turns else None

    def pose(self, t: float) -> FloatArray:
        """Return rest_from_moved, 4x4."""
        if self.turns:
            return turned_about(self.axis_direction, self.point, self._value(t), ZERO)
        return transform(IDENTITY, scale(self._value(t), self.axis_direction))

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Row `Trapezoid`: it never turns back, so the length travelled, or its chord (exact)."""
        travelled = self._travelled(t, duration)
        return chord(travelled, reach.axis_radius) if self.turns else travelled

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """Return the length travelled, or its arc (exact)."""
        travelled = self._travelled(t, duration)
        return travelled * reach.axis_radius if self.turns else travelled

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return the origin's velocity and the angular velocity, continuous at the knots."""
        along = scale(copysign(self._speed(t), self.end - self.begin), self.axis_direction)
        if not self.turns:
            return along, ZERO
        arm = apply(turn(self.axis_direction, self._value(t)), scale(-1.0, self.point))
        return cross(along, arm), along

    def rates(self, t: float, duration: float) -> Rates:
        """Row `Trapezoid`: the speed's maximum is at one end, the acceleration that of the phase, steady."""
        last = min(t + duration, self.knot_after(t))
        speed, acceleration = max(self._speed(t), self._speed(last)), abs(self._acceleration(t))
        if not self.turns:
            along = copysign(self._acceleration(t), self._acceleration(t) * (self.end - self.begin))
            return Rates(speed, STILL, 0.0, 0.0, scale(along, self.axis_direction))
        radius = distance_to_line(ZERO, self.point, self.axis_direction)
        bend = disc(self.axis_direction, radius * hypot(acceleration, speed * speed))
        return Rates(radius * speed, bend, speed, acceleration, axis=self.axis_direction)

    def knot_after(self, t: float) -> float:
        """Return the time at which the acceleration changes next (inf: never)."""
        return next((knot for knot in self._knots if knot > t), inf)

    def stop_after(self, t: float) -> float:
        """Return inf: no jumps."""
        return inf

    def extent(self, times: Interval) -> float:
        """Return 2 |point|, or the larger of the two ends and the way between."""
        return 2.0 * norm(self.point) if self.turns else abs(self.begin) + abs(self.end - self.begin)

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """The value's terms, and the way gone in the time that the knots are rounded by; of a turn its arc."""
        first, _, _, last = self._knots
        late = 0.5 * self._top * max(abs(first), abs(last))
        value = 2.0 * abs(self.begin) + 2.0 * abs(self.end - self.begin) + late
        if not self.turns:
            return value
        return self.extent(times) + (radius + norm(self.point)) * (1.0 + value)

    def _phase(self, t: float) -> int:
        """Return how many knots lie at or before t: 0 before, 1 rising, 2 cruising, 3 braking, 4 after."""
        return bisect_right(self._knots, t)

    def _value(self, t: float) -> float:
        """Return the place (m) or angle (rad)."""
        begin, risen, braking, stopped = self._knots
        top, travel = self._top, abs(self.end - self.begin)
        match self._phase(t):
            case 0:
                return self.begin
            case 1:
                gone = 0.5 * top * (t - begin) * ((t - begin) / (risen - begin))
            case 2:
                gone = top * (0.5 * (risen - begin) + (t - risen))
            case 3:
                gone = travel - 0.5 * top * (stopped - t) * ((stopped - t) / (stopped - braking))
            case _:
                return self.end
        return self.begin + copysign(gone, self.end - self.begin)

    def _speed(self, t: float) -> float:
        """Return m/s or rad/s, >= 0."""
        begin, risen, braking, stopped = self._knots
        match self._phase(t):
            case 1:
                return self._top * ((t - begin) / (risen - begin))
            case 2:
                return self._top
            case 3:
                return self._top * ((stopped - t) / (stopped - braking))
            case _:
                return 0.0

    def _acceleration(self, t: float) -> float:
        """Return how the speed rises, m/s^2 or rad/s^2, right-hand at a knot."""
        begin, risen, braking, stopped = self._knots
        match self._phase(t):
            case 1:
                return self._top / (risen - begin)
            case 3:
                return -self._top / (stopped - braking)
            case _:
                return 0.0

    def _travelled(self, t: float, duration: float) -> float:
        """Return m or rad over [t, t + duration], up to the float after its end.

        Summed phase by phase from the mean speed of each, which does not cancel as a difference of places would.
        """
        end = end_of(t, duration)
        marks = (t, *(knot for knot in self._knots if t < knot < end), end)
        total = 0.0
        for first, last in pairwise(marks):
            total += 0.5 * (self._speed(first) + self._speed(last)) * (last - first)
        return total
