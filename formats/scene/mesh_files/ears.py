"""Triangles of a hollow polygon, cut off ear by ear (Meisters, 1975)."""

from __future__ import annotations

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray


def ears(vertices: FloatArray, tolerance: float) -> IntArray | None:
    """Return n - 2 triangles (places among the corners) that cover a polygon and nothing else; None if none are found.

    None of them turns against the polygon, seen along the direction that it has on the whole. Then they cover just the
    points around which the outline goes: how often it does is the sum of what the triangles say, whatever order they
    are cut off in. Outlines that do not cross themselves always have such triangles.

    Args:
        vertices: (n, 3) the corners in order.
        tolerance: the share of the polygon's area below which a triangle has none.
    """
    normal = 0.5 * np.cross(vertices - vertices[0], np.roll(vertices, -1, axis=0) - vertices[0]).sum(axis=0)
    area = float(np.linalg.norm(normal))
    if not 0.0 < area < np.inf:
        return None
    points, flat = _seen_along(vertices, normal / area), tolerance * area
    ring = list(range(len(points)))
    found: list[tuple[int, int, int]] = []
    while len(ring) > 2:
        place = _ear(points[ring], flat)
        if place is None:
            return None
        found.append((ring[place - 1], ring[place], ring[(place + 1) % len(ring)]))
        del ring[place]
    return np.array(found, dtype=np.int64)


def _seen_along(vertices: FloatArray, unit: FloatArray) -> FloatArray:
    """Return the points (n, 2) of the plane across a unit vector, which points towards who looks."""
    across = np.cross(unit, np.eye(3)[int(np.argmin(np.abs(unit)))])
    across /= np.linalg.norm(across)
    seen: FloatArray = (vertices - vertices[0]) @ np.column_stack((across, np.cross(unit, across)))
    return seen


def _ear(points: FloatArray, flat: float) -> int | None:
    """Return the corner of a polygon (n, 2) to cut off next: a bulge that holds no other corner, else a mere line."""
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    areas = 0.5 * _cross(points - before, after - points)
    hollow = points[areas <= flat]  # only such corners can lie in an ear
    for place in np.flatnonzero(areas > flat).tolist():
        corners = np.stack((before[place], points[place], after[place]))
        if not _holds(corners, hollow):
            return place
    lines = np.flatnonzero(np.abs(areas) <= flat)
    return int(lines[0]) if len(lines) else None


def _holds(corners: FloatArray, points: FloatArray) -> bool:
    """Tell whether a triangle (3, 2) that turns left holds a point (n, 2) that is none of its corners."""
    inside = np.ones(len(points), dtype=bool)
    for corner, other in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        inside &= _cross(other - corner, points - corner) >= 0.0
        inside &= (points != corner).any(axis=1)
    return bool(inside.any())


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the third components (...) of the cross products of vectors (..., 2) of the plane."""
    product: FloatArray = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product
