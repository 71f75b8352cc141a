"""One or two triangles: which feature holds a point, and where two triangles meet."""

from __future__ import annotations

from .events import FeatureKind
from .vector import ZERO, Vector, add, cross, dot, norm, scale, subtract

#: Relative to a triangle's size: a point nearer than this to a corner or an edge counts as on it.
FEATURE_TOLERANCE = 1e-9

Triangle = tuple[Vector, Vector, Vector]

_EDGES = ((0, 1), (1, 2), (2, 0))


def feature_at(point: Vector, corners: Triangle) -> tuple[FeatureKind, int]:
    """Return which feature of a triangle (m) holds a point of it (m), and its index.

    A corner's index is its own, an edge's that of the corner it starts at, a face's 0. Degenerate triangles are points
    or segments: their corners and edges come first.
    """
    arms = [norm(subtract(corner, point)) for corner in corners]
    tolerance = FEATURE_TOLERANCE * max(arms)
    for index in range(3):
        if arms[index] <= tolerance:
            return FeatureKind.VERTEX, index
    for start, end in _EDGES:
        if _distance_to_segment(point, corners[start], corners[end]) <= tolerance:
            return FeatureKind.EDGE, start
    return FeatureKind.FACE, 0


def meeting_point(one: Triangle, other: Triangle) -> Vector | None:
    """Return a point (m) common to two triangles that cross, None where they are coplanar or do not cross."""
    crossings = [*_crossings(one, other), *_crossings(other, one)]
    if not crossings:
        return None
    total = ZERO
    for crossing in crossings:
        total = add(total, crossing)
    return scale(1.0 / len(crossings), total)


def _crossings(edges_of: Triangle, face: Triangle) -> list[Vector]:
    """Return the points where the edges of one triangle pierce the other."""
    normal = cross(subtract(face[1], face[0]), subtract(face[2], face[0]))
    heights = [dot(subtract(corner, face[0]), normal) for corner in edges_of]
    found = []
    for start, end in _EDGES:
        if heights[start] * heights[end] > 0.0 or heights[start] == heights[end]:
            continue
        share = heights[start] / (heights[start] - heights[end])
        point = add(edges_of[start], scale(share, subtract(edges_of[end], edges_of[start])))
        if all(dot(cross(subtract(face[b], face[a]), subtract(point, face[a])), normal) >= 0.0 for a, b in _EDGES):
            found.append(point)
    return found


def _distance_to_segment(point: Vector, start: Vector, end: Vector) -> float:
    """Return the distance (m) of a point from a segment."""
    along, arm = subtract(end, start), subtract(point, start)
    length = dot(along, along)
    share = min(1.0, max(0.0, dot(arm, along) / length)) if length > 0.0 else 0.0
    return norm(subtract(arm, scale(share, along)))
