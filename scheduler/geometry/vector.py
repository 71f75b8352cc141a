"""Vectors of three floats as tuples: faster than arrays for one vector at a time."""

from __future__ import annotations

from math import hypot

Vector = tuple[float, float, float]

ZERO: Vector = (0.0, 0.0, 0.0)
#: Shorter vectors are made longer before they are divided by their length, which has lost digits.
SHORT = 1e-290
#: How much longer: a power of 2, so that nothing is rounded.
LONGER = 2.0**600


def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def norm(a: Vector) -> float:
    """Return |a|."""
    return hypot(a[0], a[1], a[2])


def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def subtract(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(factor: float, a: Vector) -> Vector:
    """Return factor a."""
    return (factor * a[0], factor * a[1], factor * a[2])


def unit(a: Vector) -> Vector:
    """Return a / |a|; the x axis for the zero vector, whose direction never matters."""
    length = norm(a)
    if 0.0 < length < SHORT:
        return unit(scale(LONGER, a))
    return (a[0] / length, a[1] / length, a[2] / length) if length > 0.0 else (1.0, 0.0, 0.0)


def distance_to_line(q: Vector, point: Vector, direction: Vector) -> float:
    """Return the distance in m of q from the line through `point` along the unit vector `direction`."""
    return norm(cross(subtract(q, point), direction))
