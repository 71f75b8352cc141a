"""Inside and outside of closed meshes, and the connected parts of a mesh: what surface distances cannot tell."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from .distinct import distinct_points
from .rotation import FloatArray
from .scene import Mesh, used_vertices


def winding_number(point: FloatArray, corners: FloatArray) -> float:
    """Return how often the triangles wind around `point`: the sum of their solid angles over 4 pi.

    Args:
        point: (3,) m.
        corners: (m, 3, 3) m, the corners of each triangle.

    Source: van Oosterom and Strackee, "The solid angle of a plane triangle" (1983).
    """
    a, b, c = (corners[:, corner] - point for corner in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", p, q) for p, q in ((a, b), (b, c), (c, a)))
    angles = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
    return float(np.sum(angles)) / (4.0 * np.pi)


def component_points(mesh: Mesh) -> FloatArray:
    """Return one vertex of each connected part of the mesh's surface, (k, 3) m; equal vertices are one vertex."""
    _, merged = distinct_points(mesh.vertices)
    corners = np.ascontiguousarray(merged[mesh.triangles].T)
    labels = np.arange(len(mesh.vertices))
    while True:
        of_corners = labels[corners]
        least = of_corners.min(axis=0)
        if (of_corners == least).all():
            break
        for label in of_corners:  # what a label stands for gets the least label of its triangles
            np.minimum.at(labels, label, least)
        while not np.array_equal(labels, following := labels[labels]):
            labels = following
    _, firsts = np.unique(least, return_index=True)
    points: FloatArray = mesh.vertices[mesh.triangles[firsts, 0]]
    return points


class Interior:
    """The inside of a closed mesh."""

    def __init__(self, mesh: Mesh) -> None:
        """Take a solid mesh."""
        self._mesh = mesh
        used = used_vertices(mesh)
        self._low, self._high = used.min(axis=0), used.max(axis=0)

    @cached_property
    def _corners(self) -> FloatArray:
        corners: FloatArray = self._mesh.vertices[self._mesh.triangles]
        return corners

    def contains(self, points: FloatArray) -> FloatArray | None:
        """Return the first of the points (k, 3), in the mesh's frame, with |winding number| > 0.5; None if all are out.

        No point may lie on the surface itself.
        """
        boxed = points[np.all((points >= self._low) & (points <= self._high), axis=1)]
        for point in boxed:
            if abs(winding_number(point, self._corners)) > 0.5:
                inside: FloatArray = point
                return inside
        return None
