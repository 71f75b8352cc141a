"""The units of a scene file, and the only place where they become SI."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from ....scheduler.geometry.arrays import FloatArray

# (numerator, denominator) of a unit in metres: exact, so that 35 mm is 0.035 m and not 0.035000000000000003.
# An inch is 25.4 mm by definition since 1959, a foot is 12 inches.
METRES = {
    "m": (1, 1),
    "cm": (1, 100),
    "mm": (1, 1000),
    "um": (1, 1_000_000),
    "in": (127, 5000),
    "ft": (381, 1250),
}


def metres(value: float, unit: str) -> float:
    """Return `value`, a length in `unit` (a key of METRES), in m."""
    numerator, denominator = METRES[unit]
    return value * numerator / denominator


def metres_of(values: FloatArray, unit: str) -> FloatArray:
    """Return an array of lengths in `unit`, of any shape, in m."""
    numerator, denominator = METRES[unit]
    return values * numerator / denominator


def in_unit(value: float, unit: str) -> float:
    """Return a length in m in `unit`."""
    numerator, denominator = METRES[unit]
    return value * denominator / numerator


@dataclass(frozen=True, slots=True)
class Scale:
    """The units of one file: conversions of its numbers to SI."""

    length_unit: str
    angle_unit: str

    def length(self, value: float) -> float:
        """Return a length in m; so too a velocity in m/s and an acceleration in m/s^2."""
        return metres(value, self.length_unit)

    def lengths(self, values: Iterable[float]) -> tuple[float, float, float]:
        """Return a vector of three lengths in m, velocities in m/s or accelerations in m/s^2."""
        x, y, z = map(self.length, values)
        return x, y, z

    def angle(self, value: float) -> float:
        """Return an angle in rad; so too a rate in rad/s."""
        return math.radians(value) if self.angle_unit == "deg" else float(value)

    def turn(self, value: float, turns: int = 1) -> float:
        """Return the angle of a turn that is at rest in rad; in degrees so many whole ones are taken off exactly."""
        return self.angle(math.fmod(value, 360.0 * turns) if self.angle_unit == "deg" else value)

    def angles(self, values: Iterable[float]) -> tuple[float, float, float]:
        """Return three angles in rad or rates in rad/s."""
        x, y, z = map(self.angle, values)
        return x, y, z
