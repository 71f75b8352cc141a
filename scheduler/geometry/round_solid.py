"""Exact cylinders, cones and ellipsoids; distances are measured between polyhedra that enclose them."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot

from .vector import Vector


@dataclass(frozen=True, slots=True)
class RoundSolid:
    """A solid of revolution between two ends, or an ellipsoid, about its mesh's origin.

    Attributes:
        radii: m, of the solid at z = -half and at z = +half, straight between; None of an ellipsoid.
        half: m, half its length.
        axes: m, the half axes of an ellipsoid; None else.
    """

    radii: tuple[float, float] | None = None
    half: float = 0.0
    axes: Vector | None = None

    def held(self, point: Vector) -> Vector:
        """Return a point (m) that the solid holds, near a point of the polyhedron around it, in the mesh's frame."""
        x, y, z = point
        if self.axes is not None:
            a, b, c = self.axes
            out = max(1.0, hypot(x / a, y / b, z / c))
            return x / out, y / out, z / out
        assert self.radii is not None
        z = min(max(-self.half, z), self.half)
        share = 0.5 * (z / self.half + 1.0)
        radius = (1.0 - share) * self.radii[0] + share * self.radii[1]
        away = hypot(x, y)
        shrink = min(1.0, radius / away) if away > 0.0 else 1.0
        return x * shrink, y * shrink, z
