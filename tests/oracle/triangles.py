"""The exact distance of two triangles, for many pairs at once.

Arrays put the coordinate FIRST: a batch of N triangles is (3 coordinates, N, 3 corners), so that a dot product is
three contiguous multiplications.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .rigid import FloatArray

FLAT = 1e-20
"""A triangle whose normal's square is below this share of (longest edge)^4 has no face: a point or a segment."""

PARALLEL = 1e-28
"""Edges whose cross product's square is below this share of the lengths' squares have no one crossing point."""


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    out: FloatArray = a[0] * b[0]
    out += a[1] * b[1]
    out += a[2] * b[2]
    return out


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    out = np.empty((3, *np.broadcast_shapes(a.shape[1:], b.shape[1:])))
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[y], b[z], out=out[x])
        out[x] -= a[z] * b[y]
    return out


def divide(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a / b, 0 where b is 0."""
    return np.divide(a, b, out=np.zeros(np.broadcast_shapes(a.shape, b.shape), np.result_type(a, b)), where=b > 0.0)


def separation(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return (N,) m: distances of triangle pairs a, b (3, N, 3), or minus a depth where the triangles cross.

    The depth is the margin of the crossing that pierces best: how far one triangle may move, at least, before that
    edge no longer pierces that face. Its purpose is to tell a real crossing from one within rounding errors.
    """
    edges_a, edges_b = np.roll(a, -1, axis=2) - a, np.roll(b, -1, axis=2) - b
    gaps = edge_gaps(a, edges_a, b, edges_b)
    face_b, depth_a = against_face(a, edges_a, b, edges_b, gaps.min(axis=2))
    face_a, depth_b = against_face(b, edges_b, a, edges_a, gaps.min(axis=1))
    nearest = np.sqrt(np.minimum(gaps.min(axis=(1, 2)), np.minimum(face_a, face_b)))
    depth = np.maximum(depth_a, depth_b)
    return np.where(depth >= 0.0, -np.maximum(depth, 0.0), nearest)


def edge_gaps(a: FloatArray, edges_a: FloatArray, b: FloatArray, edges_b: FloatArray) -> FloatArray:
    """Return (N, 3, 3) m^2: squared distances of every edge of a to every edge of b.

    The minimum over both ends of each edge against the other edge, and over the crossing of the two lines where it
    lies within both edges. Each candidate is a distance of two actual points, so none is too small.
    """
    p, d = a[:, :, :, None], edges_a[:, :, :, None]
    q, e = b[:, :, None, :], edges_b[:, :, None, :]
    r = q - p
    dd, ee = dot(d, d), dot(e, e)
    corners_a, corners_b = point_gap(r, e, ee), point_gap(-r, d, dd)
    n = cross(d, e)
    nn = dot(n, n)
    skew = nn > PARALLEL * dd * ee
    inverse = divide(skew.astype(float), nn)
    s, t = dot(cross(r, e), n) * inverse, dot(cross(r, d), n) * inverse
    inside = skew & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    between = r + t * e - s * d
    out = np.where(inside, dot(between, between), np.inf)
    for ends in (corners_a, np.roll(corners_a, -1, axis=1), corners_b, np.roll(corners_b, -1, axis=2)):
        np.minimum(out, ends, out=out)
    return out


def point_gap(r: FloatArray, d: FloatArray, dd: FloatArray) -> FloatArray:
    """Return squared distances to the segment q + t d, t in [0, 1], of points q - r; `dd` is d.d."""
    t = np.clip(divide(-dot(r, d), dd), 0.0, 1.0)
    between = r + t * d
    return dot(between, between)


def against_face(
    a: FloatArray, edges_a: FloatArray, b: FloatArray, edges_b: FloatArray, to_rim: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Hold corners and edges of a against the faces of b.

    Args:
        a, edges_a, b, edges_b: (3, N, 3) m.
        to_rim: (N, 3) m^2, squared distances of each edge of a to the edges of b.

    Returns:
        (N,) m^2, squared distances of the nearest corner above a face (inf: none), and (N,) m, the margin of the best
        piercing edge (-inf: none).
    """
    n = cross(edges_b[:, :, 0], edges_b[:, :, 1])
    nn = dot(n, n)
    longest = dot(edges_b, edges_b).max(axis=1)
    has_face = (nn > FLAT * longest**2)[:, None]
    n = n * divide(np.ones_like(nn), np.sqrt(nn))
    height = dot(n[:, :, None], a - b[:, :, :1])
    above = has_face & over_face(a, b, edges_b, n)
    corner = np.where(above, height**2, np.inf).min(axis=1)
    next_height = np.roll(height, -1, axis=1)
    changes = has_face & (height * next_height < 0.0)
    part = divide(np.abs(height), np.abs(height) + np.abs(next_height))
    pierced = changes & over_face(a + part * edges_a, b, edges_b, n)
    margin = np.minimum(np.sqrt(to_rim), np.minimum(np.abs(height), np.abs(next_height)))
    return corner, np.where(pierced, margin, -np.inf).max(axis=1)


def over_face(points: FloatArray, b: FloatArray, edges_b: FloatArray, n: FloatArray) -> NDArray[np.bool_]:
    """Tell for points (3, N, 3) whether they project into the faces b with normals n (3, N)."""
    inside = np.ones(points.shape[1:], dtype=bool)
    for corner in range(3):
        inward = cross(n, edges_b[:, :, corner])[:, :, None]
        inside &= dot(inward, points - b[:, :, corner, None]) >= 0.0
    return inside
