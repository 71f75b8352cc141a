"""What a shape looks like: its triangles, with the rounding of balls and capsules, inflated a little for overlays."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ....scheduler.model.scene import Shape

# Of the round part of a capsule: meridians about its axis, and rings from the equator to the pole.
_MERIDIANS = 24
_RINGS = 6

# Unit vectors to the faces, edges and corners of a cube, (26, 3).
_DIRECTIONS = np.array([direction for direction in product((-1.0, 0.0, 1.0), repeat=3) if any(direction)])
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Triangles (m, 3) over points (n, 3), m, in the frame of the shape's mesh."""

    points: FloatArray
    triangles: IntArray

    @property
    def centre(self) -> FloatArray:
        """The middle of the points' bounds, (3,) m."""
        centre: FloatArray = 0.5 * (self.points.min(axis=0) + self.points.max(axis=0))
        return centre


def ball_centre(shape: Shape) -> FloatArray | None:
    """Return the centre (3,) of a sphere, in its mesh's frame, m; None for other shapes."""
    ends = _ends(shape)
    return ends[0] if ends is not None and np.array_equal(*ends) else None


def surface(shape: Shape, inflation: float = 0.0) -> Surface:
    """Return the shape's surface, every point `inflation` (m) further out."""
    radius = shape.radius + inflation
    ends = _ends(shape)
    if ends is not None:
        return _capsule(*ends, radius)
    plain = Surface(shape.mesh.vertices, shape.mesh.triangles)
    return plain if radius == 0.0 else _inflated(plain, radius)


def outermost(points: FloatArray) -> FloatArray:
    """Return the points farthest out in each of 26 directions, (26, 3), of points (n, 3)."""
    farthest: FloatArray = points[np.argmax(_DIRECTIONS @ points.T, axis=1)]
    return farthest


def outline(shape: Shape) -> FloatArray:
    """Return points (26, 3) of the shape in its body's frame, m, which span it and reach its bounding box."""
    placed = shape.mesh.vertices @ shape.pose[:3, :3].T + shape.pose[:3, 3]
    return outermost(placed) + shape.radius * _DIRECTIONS


def triangle_count(shape: Shape) -> int:
    """Return how many triangles `surface` has; none for a ball, which viewers draw by themselves."""
    if ball_centre(shape) is not None:
        return 0
    return len(shape.mesh.triangles) if _ends(shape) is None else len(_tube(2 * _RINGS + 2))


def _ends(shape: Shape) -> tuple[FloatArray, FloatArray] | None:
    """Return both ends of the segment that is the core of a ball (equal ends) or a capsule; None for other shapes."""
    if shape.radius == 0.0 or len(shape.mesh.triangles) != 1:
        return None
    corners = np.unique(shape.mesh.triangles)
    return (shape.mesh.vertices[corners[0]], shape.mesh.vertices[corners[-1]]) if len(corners) < 3 else None


def _inflated(plain: Surface, distance: float) -> Surface:
    """Move every point along its normal, which equal points share, so that no seam opens."""
    points, where = np.unique(plain.points, axis=0, return_inverse=True)
    triangles: IntArray = where.reshape(-1)[plain.triangles]
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    normals = np.zeros_like(points)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], np.cross(b - a, c - a))
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    outward = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    return Surface(points + distance * outward, triangles)


def _capsule(start: FloatArray, end: FloatArray, radius: float) -> Surface:
    """Return the capsule from `start` to `end`, or the ball where they are equal: rings from pole to pole."""
    length = np.linalg.norm(end - start)
    axis = (end - start) / length if length > 0.0 else np.array((0.0, 0.0, 1.0))
    side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    side /= np.linalg.norm(side)
    around = 2.0 * np.pi * np.arange(_MERIDIANS) / _MERIDIANS
    directions = np.outer(np.cos(around), side) + np.outer(np.sin(around), np.cross(axis, side))
    rings = []
    for centre, latitudes in ((start, np.linspace(-0.5, 0.0, _RINGS + 1)), (end, np.linspace(0.0, 0.5, _RINGS + 1))):
        rings += [
            centre + radius * (np.sin(np.pi * latitude) * axis + np.cos(np.pi * latitude) * directions)
            for latitude in latitudes
        ]
    return Surface(np.vstack(rings), _tube(len(rings)))


def _tube(rings: int) -> IntArray:
    """Return the triangles between rings of points, outward where the rings turn right-handed and advance."""
    low = np.arange((rings - 1) * _MERIDIANS).reshape(rings - 1, _MERIDIANS)
    beside, high = np.roll(low, -1, axis=1), low + _MERIDIANS
    above = beside + _MERIDIANS
    quads = np.stack((low, beside, above, low, above, high), axis=-1)
    return quads.reshape(-1, 3)
