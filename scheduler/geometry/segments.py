"""The sides of triangles, and segments against segments, many at a time."""

from __future__ import annotations

import numpy as np

from .arrays import FloatArray
from .transform import crossed

#: Segments whose directions differ by less (the squared sine) count as parallel.
PARALLEL_EDGES = 1e-12
#: The next corner of each.
NEXT = [1, 2, 0]


def sides_of(triangles: FloatArray) -> FloatArray:
    """Return the sides (k, 3, 3) m of triangles (k, 3, 3) m, from each corner to the next."""
    sides: FloatArray = triangles[:, NEXT] - triangles
    return sides


def dots(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a . b of vectors (..., 3)."""
    product: FloatArray = np.einsum("...d,...d->...", a, b)
    return product


def parts(length: FloatArray, of: FloatArray) -> FloatArray:
    """Return length / of, 0 to 1; 0 where `of` is 0."""
    quotient: FloatArray = np.divide(
        length, of, out=np.zeros(np.broadcast_shapes(length.shape, of.shape)), where=of > 0
    )
    return quotient.clip(0.0, 1.0)


def nearest_on_segments(p: FloatArray, d: FloatArray, q: FloatArray, e: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the nearest points of segments p + [0, 1] d and q + [0, 1] e, all (..., 3) m, inside of both.

    Where they are nearest at an end of one, there may be nearer points. Where the lines are nearest is badly known of
    nearly parallel ones: by the share s of d, to about u |r| / (|d| sin^2), with r between the segments. The
    distance hardly changes there, and each point is then taken nearest to the other.
    """
    r, n = q - p, crossed(d, e)
    s = parts(dots(crossed(r, e), n), dots(n, n))
    t = parts(dots(s[..., None] * d - r, e), dots(e, e))
    s = parts(dots(r + t[..., None] * e, d), dots(d, d))
    return p + s[..., None] * d, q + t[..., None] * e


def ways_between(p: FloatArray, d: FloatArray, q: FloatArray, e: FloatArray) -> FloatArray:
    """Return the way from the nearest point of each segment p + [0, 1] d to that of q + [0, 1] e, all (..., 3) m.

    Of nearly parallel segments it may not be the shortest: quicker, for directions, which need not be the best.
    Source: Ericson, "Real-Time Collision Detection" (2005), section 5.1.9.
    """
    r = p - q
    dd, ee, de = (d * d).sum(-1), (e * e).sum(-1), (d * e).sum(-1)
    dr, er = (d * r).sum(-1), (e * r).sum(-1)
    determinant = dd * ee - de * de
    crossing = determinant > PARALLEL_EDGES * dd * ee
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.where(crossing, (de * er - dr * ee) / determinant, 0.0).clip(0.0, 1.0)
        t = np.where(ee > 0.0, (de * s + er) / ee, 0.0).clip(0.0, 1.0)
        s = np.where(dd > 0.0, (de * t - dr) / dd, 0.0).clip(0.0, 1.0)
    ways: FloatArray = (q + t[..., None] * e) - (p + s[..., None] * d)
    return ways
