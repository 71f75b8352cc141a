"""Sinusoidal motions: sliding along a direction, swinging about a hinge."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor, fmod, hypot, pi, sin, sqrt

from ..geometry.arrays import FloatArray
from ..geometry.transform import IDENTITY, apply, chord, transform, turn, turned_about
from ..geometry.vector import ZERO, Vector, cross, distance_to_line, norm, scale
from .acceleration_set import between, disc
from .motion import Axis, Interval, LeverArms, Rates, Smooth


@dataclass(frozen=True, slots=True)
class Harmonic(Smooth):
    """translate(direction * amplitude * sin(2 pi t / period + phase)); `direction` is a unit vector."""

    direction: Vector
    amplitude: float
    period: float
    phase: float

    @property
    def axis(self) -> Axis | None:
        """None: nothing turns."""
        return None

    def pose(self, t: float) -> FloatArray:
        """Return rest_from_moved, 4x4."""
        offset = self.amplitude * sin(_phase(self, t))
        return transform(IDENTITY, scale(offset, self.direction))

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Row `Harmonic` (exact)."""
        return abs(self.amplitude) * _sine_departure(*_phases(self, t, duration))

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """The sine's total variation (exact)."""
        return abs(self.amplitude) * _sine_variation(*_phases(self, t, duration))

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return amplitude w cos(...) along the direction, no spin."""
        rate = self.amplitude * _frequency(self) * sin(_phase(self, t) + 0.5 * pi)
        return scale(rate, self.direction), ZERO

    def rates(self, t: float, duration: float) -> Rates:
        """Speed by the largest |cos| over the interval; the acceleration runs along the line as far as the sine."""
        w, phases = _frequency(self), _phases(self, t, duration)
        _, largest_cos, _ = _phase_extremes(*phases)
        steepest = -self.amplitude * w * w
        one, other = (scale(steepest * sine, self.direction) for sine in _sine_range(*phases))
        steady, varying = between(one, other)
        return Rates(abs(self.amplitude) * w * largest_cos, varying, 0.0, 0.0, steady)

    def extent(self, times: Interval) -> float:
        """Return the amplitude."""
        return abs(self.amplitude)

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """The amplitude times the phase's size."""
        return abs(self.amplitude) * (1.0 + 2.0 * pi + abs(self.phase)) + radius


@dataclass(frozen=True, slots=True)
class Swing(Smooth):
    """Rotate about the unit `axis_direction` through `point` by amplitude (rad) * sin(2 pi t / period + phase)."""

    axis_direction: Vector
    point: Vector
    amplitude: float
    period: float
    phase: float

    @property
    def axis(self) -> Axis | None:
        """The hinge."""
        return Axis(self.point, self.axis_direction)

    def pose(self, t: float) -> FloatArray:
        """Return rest_from_moved, 4x4."""
        return turned_about(self.axis_direction, self.point, self._angle(t), ZERO)

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Row `Swing`: the angle as the harmonic, the chord it subtends."""
        angle = abs(self.amplitude) * _sine_departure(*_phases(self, t, duration))
        return chord(angle, reach.axis_radius)

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """The angle's total variation times the radius (exact)."""
        angle = abs(self.amplitude) * _sine_variation(*_phases(self, t, duration))
        return angle * reach.axis_radius

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return the origin's velocity on its arc and the angular velocity."""
        rate = self.amplitude * _frequency(self) * sin(_phase(self, t) + 0.5 * pi)
        spin = scale(rate, self.axis_direction)
        arm = apply(turn(self.axis_direction, self._angle(t)), scale(-1.0, self.point))
        return cross(spin, arm), spin

    def rates(self, t: float, duration: float) -> Rates:
        """Row `Swing`: the acceleration squared is convex in x = sin^2 of the phase: the ends of x's range decide."""
        w, size = _frequency(self), abs(self.amplitude)
        radius = distance_to_line(ZERO, self.point, self.axis_direction)
        largest_sin, largest_cos, least_sin = _phase_extremes(*_phases(self, t, duration))

        def acceleration(x: float) -> float:
            return radius * hypot(size * w * w * sqrt(x), (size * w) ** 2 * (1.0 - x))

        bound = max(acceleration(largest_sin**2), acceleration(least_sin**2))
        spin = size * w * largest_cos
        bend = disc(self.axis_direction, bound)
        return Rates(radius * spin, bend, spin, size * w * w * largest_sin, axis=self.axis_direction)

    def extent(self, times: Interval) -> float:
        """Return 2 |point|."""
        return 2.0 * norm(self.point)

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """The swing's arc times the phase's size, at the farthest of the points and the axis point."""
        size = abs(self.amplitude)
        farthest = radius + norm(self.point)
        return self.extent(times) + farthest * (1.0 + size * (2.0 + 2.0 * pi + abs(self.phase)))

    def _angle(self, t: float) -> float:
        return self.amplitude * sin(_phase(self, t))


def _frequency(motion: Harmonic | Swing) -> float:
    """Return rad/s."""
    return 2.0 * pi / motion.period


def _phase(motion: Harmonic | Swing, t: float) -> float:
    """Return the sine's argument, rad; whole periods are taken off exactly, so that it does not coarsen with time."""
    return 2.0 * pi * fmod(t, motion.period) / motion.period + motion.phase


def _phases(motion: Harmonic | Swing, t: float, duration: float) -> tuple[float, float]:
    """Return the sine's arguments, rad, at both ends of [t, t + duration]."""
    first = _phase(motion, t)
    return first, first + _frequency(motion) * duration


def _crosses(first: float, last: float, offset: float, step: float) -> bool:
    """Return whether offset + k step lies in [first, last] for some integer k."""
    return offset + step * ceil((first - offset) / step) <= last


def _sine_departure(first: float, last: float) -> float:
    """Return the largest |sin(x) - sin(first)| over x in [first, last]."""
    here, (lowest, highest) = sin(first), _sine_range(first, last)
    return max(highest - here, here - lowest)


def _sine_range(first: float, last: float) -> tuple[float, float]:
    """Return the least and the largest sin over [first, last]."""
    here, there = sin(first), sin(last)
    highest = 1.0 if _crosses(first, last, 0.5 * pi, 2.0 * pi) else max(here, there)
    lowest = -1.0 if _crosses(first, last, -0.5 * pi, 2.0 * pi) else min(here, there)
    return lowest, highest


def _sine_variation(first: float, last: float) -> float:
    """Return the integral of |cos| over [first, last]."""

    def variation(x: float) -> float:
        half_turns = floor(x / pi + 0.5)
        return 2.0 * half_turns + (sin(x) if half_turns % 2 == 0 else -sin(x))

    return max(0.0, variation(last) - variation(first))


def _phase_extremes(first: float, last: float) -> tuple[float, float, float]:
    """Return the largest |sin|, the largest |cos| and the least |sin| over [first, last]."""
    sines = abs(sin(first)), abs(sin(last))
    cosines = abs(sin(first + 0.5 * pi)), abs(sin(last + 0.5 * pi))
    largest_sin = 1.0 if _crosses(first, last, 0.5 * pi, pi) else max(sines)
    crosses_zero = _crosses(first, last, 0.0, pi)
    return largest_sin, 1.0 if crosses_zero else max(cosines), 0.0 if crosses_zero else min(sines)
