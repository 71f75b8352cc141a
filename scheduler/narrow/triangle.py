"""One or two triangles: which feature holds a point, and where two triangles meet."""

from __future__ import annotations

from ..geometry.vector import ZERO, Vector, add, cross, dot, norm, scale, subtract
from ..model.events import FeatureKind

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


def meeting_point(one: Triangle, other: Triangle) -> Vector:
    """Return a point (m) common to two triangles that meet: amid their crossings, or where they are nearest."""
    crossings = [*_crossings(one, other), *_crossings(other, one)]
    if not crossings:
        return _nearest_point(one, other)
    total = ZERO
    for crossing in crossings:
        total = add(total, crossing)
    return scale(1.0 / len(crossings), total)


def _nearest_point(one: Triangle, other: Triangle) -> Vector:
    """Return where triangles that do not cross are nearest: a corner over a face, or a point of an edge at an edge.

    Those that meet lie in one plane, or one only touches the other, to rounding.
    """
    found = [
        (_height(corner, face), corner)
        for corners, face in ((one, other), (other, one))
        for corner in corners
        if _over(corner, face)
    ]
    found += [_nearest_on_edges(one[a], one[b], other[c], other[d]) for a, b in _EDGES for c, d in _EDGES]
    return min(found, key=lambda near: near[0])[1]


def _nearest_on_edges(p: Vector, q: Vector, r: Vector, s: Vector) -> tuple[float, Vector]:
    """Return the distance (m) of the segments pq and rs where their lines cross or at an end, and the point of pq."""
    along, across, between = subtract(q, p), subtract(s, r), subtract(r, p)
    normal = cross(along, across)
    candidates = [0.0, 1.0, *(_share(subtract(end, p), along) for end in (r, s))]
    if (size := dot(normal, normal)) > 0.0:
        candidates.append(min(1.0, max(0.0, dot(cross(between, across), normal) / size)))
    points = [add(p, scale(share, along)) for share in candidates]
    return min((_distance_to_segment(point, r, s), point) for point in points)


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
        if _over(point, face):
            found.append(point)
    return found


def _height(point: Vector, face: Triangle) -> float:
    """Return the distance (m) of a point from a triangle's plane."""
    normal = cross(subtract(face[1], face[0]), subtract(face[2], face[0]))
    return abs(dot(subtract(point, face[0]), normal)) / norm(normal)


def _over(point: Vector, face: Triangle) -> bool:
    """Return whether a point projects into a triangle."""
    normal = cross(subtract(face[1], face[0]), subtract(face[2], face[0]))
    sides = [dot(cross(subtract(face[b], face[a]), subtract(point, face[a])), normal) for a, b in _EDGES]
    return normal != ZERO and min(sides) >= 0.0


def _share(arm: Vector, along: Vector) -> float:
    """Return where on a segment `along` (m) from its start the point nearest to the end of `arm` lies, 0 to 1."""
    length = dot(along, along)
    return min(1.0, max(0.0, dot(arm, along) / length)) if length > 0.0 else 0.0


def _distance_to_segment(point: Vector, start: Vector, end: Vector) -> float:
    """Return the distance (m) of a point from a segment."""
    along, arm = subtract(end, start), subtract(point, start)
    return norm(subtract(arm, scale(_share(arm, along), along)))
