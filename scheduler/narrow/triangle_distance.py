"""The distance of two cores, triangle by triangle: right up to rounding however the triangles lie."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.segments import dots, nearest_on_segments, parts, sides_of
from ..geometry.transform import crossed
from ..geometry.vector import Vector
from .triangle_pairs import Rows, Triangles, near_rows, placed_rows


class Cores(NamedTuple):
    """How far apart two shapes' cores are (m), the points and triangles of them that are nearest."""

    distance: float
    witness_a: Vector
    witness_b: Vector
    triangle_a: int
    triangle_b: int


def cores_within(
    one: Triangles, other: Triangles, pose_one: FloatArray, pose_other: FloatArray, reach: float
) -> Cores | None:
    """Return how far apart placed triangles are, None if farther than `reach` m; errs as `nearest_of`.

    Where too many are near to be looked at together, the halves of one are looked at in turn.
    """
    rows = near_rows(one, other, pose_one, pose_other, reach)
    if rows is not None:
        if not len(rows[0]):
            return None
        corners = placed_rows(one, other, pose_one, pose_other, rows)
        found = nearest_of(*corners, (one.order[rows[0]], other.order[rows[1]]))
        return found if found.distance <= reach else None
    nearest: Cores | None = None
    for part, rest in _halved(one, other):
        closer = cores_within(part, rest, pose_one, pose_other, reach)
        if closer is not None:
            nearest, reach = closer, closer.distance
    return nearest


def _halved(one: Triangles, other: Triangles) -> list[tuple[Triangles, Triangles]]:
    """Return the same pairs of triangles in two parts, of the mesh with more of them."""
    if len(one.corners) >= len(other.corners):
        return [(half, other) for half in one.halves()]
    return [(one, half) for half in other.halves()]


def nearest_of(one: FloatArray, other: FloatArray, indices: Rows) -> Cores:
    """Return the nearest of pairs of triangles (k, 3, 3) m, k > 0, of these indices; segments are triangles too.

    The distance errs by at most 8 u times the pair's longest sides and itself. *Why:* each candidate is the distance of
    a point of the one triangle from a point of the other, so that none is too small. They are: a corner, or the point
    where an edge pierces the other's plane, and the other's nearest point; the nearest points of two edges. In one of
    these two triangles are nearest, or meet. What thin triangles and nearly parallel edges hide is where along the
    other the nearest point lies, to w (m). Of points h apart that makes w^2 / 2 h at most; and h w is bounded by
    rounding, for the worse that is known, the narrower is the triangle, or the less the edges part.
    """
    origin = one[:, :1]
    one, other = one - origin, other - origin
    sides, others = sides_of(one), sides_of(other)
    ours, on_theirs = _against_triangle(one, sides, other, others)
    theirs, on_ours = _against_triangle(other, others, one, sides)
    crossings = nearest_on_segments(one[:, :, None], sides[:, :, None], other[:, None], others[:, None])
    edge_ours, edge_theirs = (points.reshape(-1, 9, 3) for points in crossings)
    ours = np.concatenate((ours, on_ours, edge_ours), axis=1)
    theirs = np.concatenate((on_theirs, theirs, edge_theirs), axis=1)
    ways = theirs - ours
    squares = dots(ways, ways)
    pair, candidate = divmod(int(squares.argmin()), squares.shape[1])
    (ax, ay, az), (bx, by, bz) = ((points[pair, candidate] + origin[pair, 0]).tolist() for points in (ours, theirs))
    distance = sqrt(squares[pair, candidate])
    return Cores(distance, (ax, ay, az), (bx, by, bz), int(indices[0][pair]), int(indices[1][pair]))


def _against_triangle(
    one: FloatArray, sides: FloatArray, other: FloatArray, others: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return points (k, 15, 3) of triangles and the other triangles' points that may be nearest to them.

    The corners with the nearest points of the sides and the face, and where edges pierce the plane, of the face.
    """
    arms = one[:, :, None] - other[:, None]  # (k, corner, side, 3)
    along = others[:, None] * parts(dots(arms, others[:, None]), dots(others, others)[:, None])[..., None]
    on_sides = (other[:, None] + along).reshape(-1, 9, 3)
    normal = crossed(others[:, 0], _height_of(others))
    heights = dots(arms[:, :, 0], normal[:, None])
    drops = heights - heights[:, [1, 2, 0]]
    pierces = np.sign(heights) * np.sign(heights[:, [1, 2, 0]]) < 0.0
    shares = np.divide(heights, drops, out=np.zeros_like(heights), where=pierces)
    points = np.concatenate((one, one + shares[..., None] * sides), axis=1)
    return np.concatenate((np.repeat(one, 3, axis=1), points), axis=1), np.concatenate(
        (on_sides, _on_face(points, other, others)), axis=1
    )


def _height_of(sides: FloatArray) -> FloatArray:
    """Return the part (k, 3) m of triangles' second sides (k, 3, 3) that is upright on the first.

    It is taken twice: of a thin triangle the first leaves much of the side.
    """
    first, height = sides[:, 0], sides[:, 1]
    square = dots(first, first)
    for _ in range(2):
        share = np.divide(dots(height, first), square, out=np.zeros_like(square), where=square > 0.0)
        height = height - share[:, None] * first
    return height


def _on_face(points: FloatArray, triangles: FloatArray, sides: FloatArray) -> FloatArray:
    """Return the points (k, n, 3) of triangles' faces that points are above, a corner where they are above none.

    A height direction known to w rad moves what is found by w times how far above the point is, and by no more than the
    height: by h w, and less than u |side| / w.
    """
    first, second, height = sides[:, :1], sides[:, 1:2], _height_of(sides)[:, None]
    arms = points - triangles[:, 1:2]
    upright, square = dots(height, height), dots(first, first)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = dots(arms, height) / upright
        s = (dots(arms, first) - t * dots(second, first)) / square  # from the second corner
    above = (t >= 0.0) & (s <= 0.0) & (s + 1.0 - t >= 0.0)
    s, t = (np.where(above, share, 0.0)[..., None] for share in (s, t))
    on_face: FloatArray = triangles[:, 1:2] + s * first + t * second
    return on_face
