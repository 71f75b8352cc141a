"""The sides of triangles, and segments against segments, many at a time."""

from __future__ import annotations

import numpy as np

from .rotation import FloatArray

#: Segments whose directions differ by less (the squared sine) count as parallel.
PARALLEL = 1e-12
#: The next corner of each.
NEXT = [1, 2, 0]


def sides_of(triangles: FloatArray) -> FloatArray:
    """Return the sides (k, 3, 3) m of triangles (k, 3, 3) m, from each corner to the next."""
    sides: FloatArray = triangles[:, NEXT] - triangles
    return sides


def ways_between(p: FloatArray, d: FloatArray, q: FloatArray, e: FloatArray) -> FloatArray:
    """Return the way from the nearest point of each segment p + [0, 1] d to that of q + [0, 1] e, all (..., 3) m.

    Of nearly parallel segments it may not be the shortest.
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
    return ways
