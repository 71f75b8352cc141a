"""The result of a distance query: the distance and the closest points of two surfaces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from ..geometry.vector import Vector, add, norm, scale, subtract, unit
from ..model.events import Feature


class Rounded(NamedTuple):
    """A core's nearest point (m), what finds the feature that holds it, and the radius (m) that rounds it."""

    point: Vector
    feature: Callable[[], Feature]
    radius: float


@dataclass(frozen=True, slots=True)
class ClosestPoints:
    """How near two bodies' surfaces are.

    Attributes:
        distance: m between the surfaces (rounding radii off), 0 where they meet.
        witness_a, witness_b: m, the nearest points, or twice one point where they meet; in the frame of the poses.
        feature_a, feature_b: find what holds them, which takes as long as finding the points.
    """

    distance: float
    witness_a: Vector
    witness_b: Vector
    feature_a: Callable[[], Feature]
    feature_b: Callable[[], Feature]

    @staticmethod
    def of_rounded(one: Rounded, other: Rounded) -> ClosestPoints:
        """Return the proximity of two shapes whose cores' nearest points these are.

        Shapes that overlap meet half-way between their surfaces, in a point of the segment between the cores: it lies
        in both.
        """
        across = subtract(other.point, one.point)
        length = norm(across)
        direction = unit(across)
        gap = length - one.radius - other.radius
        if gap > 0.0:
            on_a = add(one.point, scale(one.radius, direction))
            on_b = subtract(other.point, scale(other.radius, direction))
            return ClosestPoints(gap, on_a, on_b, one.feature, other.feature)
        middle = 0.5 * (length + one.radius - other.radius)
        met = add(one.point, scale(min(length, max(0.0, middle)), direction))
        return ClosestPoints(0.0, met, met, one.feature, other.feature)

    def moved(self, offset: Vector) -> ClosestPoints:
        """Return the same, seen from a frame whose origin lies at minus `offset` (m)."""
        return ClosestPoints(
            self.distance,
            add(self.witness_a, offset),
            add(self.witness_b, offset),
            self.feature_a,
            self.feature_b,
        )
