"""Segments against segments and triangles, many at a time."""

from __future__ import annotations

import numpy as np

from .rotation import FloatArray

#: Segments whose directions differ by less (the squared sine) count as parallel.
PARALLEL = 1e-12
#: Relative loss granted to the arithmetic of margins.
ROUNDING = 1e-9


def ways_between(p: FloatArray, d: FloatArray, q: FloatArray, e: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the way from the nearest point of each segment p + [0, 1] d to that of q + [0, 1] e, all (..., 3) m.

    The second value tells which are not too nearly parallel for the way to be the shortest.
    Source: Ericson, "Real-Time Collision Detection" (2005), section 5.1.9.
    """
    r = p - q
    dd, ee, de = (d * d).sum(-1), (e * e).sum(-1), (d * e).sum(-1)
    dr, er = (d * r).sum(-1), (e * r).sum(-1)
    determinant = dd * ee - de * de
    crossing = determinant > PARALLEL * dd * ee
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.where(crossing, (de * er - dr * ee) / determinant, 0.0).clip(0.0, 1.0)
        t = np.where(ee > 0.0, (de * s + er) / ee, 0.0).clip(0.0, 1.0)
        s = np.where(dd > 0.0, (de * t - dr) / dd, 0.0).clip(0.0, 1.0)
    ways: FloatArray = (q + t[..., None] * e) - (p + s[..., None] * d)
    return ways, crossing


def piercing_margin(one: FloatArray, other: FloatArray) -> float:
    """Return how far (m) triangles may move against each other with some edge of the one still through the other.

    The largest over all pairs of triangles (k, 3, 3), (k, 3, 3) m and their edges of
    min(distance of the edge to the triangle's edges, of its ends to the triangle's plane); errs low, 0 where no
    edge pierces. The intersection of a segment and a triangle cannot vanish before the segment meets the triangle's
    border or an end of it the triangle.
    """
    if not len(one):
        return 0.0
    return max(_margin(one, other), _margin(other, one))


def _margin(edges_of: FloatArray, faces: FloatArray) -> float:
    begins, sides = edges_of, np.roll(edges_of, -1, axis=1) - edges_of
    borders = np.roll(faces, -1, axis=1) - faces
    normals = np.cross(borders[:, 0], borders[:, 1])
    lengths = np.linalg.norm(normals, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        normals = np.where(lengths[:, None] > 0.0, normals / lengths[:, None], 0.0)
    first = np.einsum("kec,kc->ke", begins - faces[:, :1], normals)  # signed distances of each edge's ends
    last = np.roll(first, -1, axis=1)
    face, edge = np.nonzero(first * last < 0.0)
    first, last = first[face, edge], last[face, edge]
    begins, sides, corners, borders = begins[face, edge], sides[face, edge], faces[face], borders[face]
    crossings = begins + (first / (first - last))[:, None] * sides
    arms = crossings[:, None] - corners  # (crossing edges, corner, 3)
    inside = np.all(np.einsum("xfc,xc->xf", np.cross(borders, arms), normals[face]) > 0.0, axis=1)
    if not inside.any():
        return 0.0
    begins, sides, corners, borders = begins[inside], sides[inside], corners[inside], borders[inside]
    ways, crossing = ways_between(begins[:, None], sides[:, None], corners, borders)
    clear = np.where(crossing, np.linalg.norm(ways, axis=-1), 0.0).min(axis=1)
    ends = np.minimum(np.abs(first), np.abs(last))[inside]
    return float(np.minimum(ends, clear).max()) * (1.0 - ROUNDING)
