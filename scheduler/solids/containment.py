"""Whether a point is inside a closed mesh, and the connected parts of a mesh: what surface distances do not show."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.unique_points import distinct_points
from ..model.scene import Mesh, Solid
from .components import components
from .line_crossings import Surroundings
from .triangle_crossings import meets_itself
from .winding import winding_numbers

#: So many pairs of triangles whose boxes meet are looked at to decide whether a skin crosses itself.
MOST_PAIRS = 100_000_000


def component_points(mesh: Mesh) -> FloatArray:
    """Return one vertex of each connected part of the mesh's surface, (k, 3) m.

    Triangles that share an edge are of one part; those that share a corner alone are not. Equal vertices are one.
    """
    _, merged = distinct_points(mesh.vertices)
    triangles = merged[mesh.triangles]
    begins, ends = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    keys = np.minimum(begins, ends) * len(mesh.vertices) + np.maximum(begins, ends)
    order = np.argsort(keys, kind="stable")
    like = np.flatnonzero(keys[order[1:]] == keys[order[:-1]])
    parts = components(len(triangles), order[like] // 3, order[like + 1] // 3)
    points: FloatArray = mesh.vertices[mesh.triangles[np.unique(parts), 0]]
    return points


class Interior:
    """The inside of a mesh: that of each of its solids."""

    def __init__(self, mesh: Mesh) -> None:
        """Take a mesh that encloses something."""
        solids = mesh.solids or (Solid(mesh.triangles, (), crossed=False),)
        self._parts = [_Part(mesh, solid) for solid in solids]
        self._low = np.array([part.low for part in self._parts])
        self._high = np.array([part.high for part in self._parts])

    def contains(self, points: FloatArray) -> FloatArray | None:
        """Return the first of the points (k, 3), in the mesh's frame, that is inside; None if all are out.

        A point of which this is not certain counts as inside. None may lie on the surface itself.
        """
        for point in points:
            for index in np.flatnonzero(((point >= self._low) & (point <= self._high)).all(axis=1)):
                if self._parts[index].holds(point):
                    inside: FloatArray = point
                    return inside
        return None


class _Part:
    """One solid of a mesh, and the box around it."""

    def __init__(self, mesh: Mesh, solid: Solid) -> None:
        self._vertices, self._solid = mesh.vertices, solid
        self._crossed = solid.crossed
        used = mesh.vertices[np.unique(solid.skin)]
        self.low, self.high = used.min(axis=0), used.max(axis=0)

    @cached_property
    def _corners(self) -> FloatArray:
        corners: FloatArray = self._vertices[self._solid.skin]
        return corners

    @cached_property
    def _surroundings(self) -> Surroundings:
        return Surroundings(self._corners)

    def holds(self, point: FloatArray) -> bool:
        """Return whether a point (3,) is inside, or whether that is not certain."""
        if abs(_winding(point, self._corners)) <= 0.5:
            return self._crossed is not False and not self._is_outside(point)
        return not any(abs(_winding(point, self._vertices[cavity])) > 0.5 for cavity in self._solid.cavities)

    def _is_outside(self, point: FloatArray) -> bool:
        """Return whether it is certain that a point (3,) that the skin winds around 0 times is outside."""
        if self._surroundings.open(point[None])[0]:
            return True
        if self._crossed is None:
            self._crossed = meets_itself(self._vertices, self._solid.skin, MOST_PAIRS)
        return not self._crossed


def _winding(point: FloatArray, corners: FloatArray) -> float:
    return float(winding_numbers(point[None], corners)[0])
