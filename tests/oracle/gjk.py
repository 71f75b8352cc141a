"""Distances of convex sets given by their support functions (Gilbert, Johnson and Keerthi, 1988), many at once.

Whatever rounding does, a distance found is one of two actual points of the sets, so that none is too small.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from .rigid import FloatArray, IntArray

Support = Callable[[FloatArray, IntArray], FloatArray]
"""From directions (n, 3) and the numbers (n,) of the sets they are asked of, to the farthest points (n, 3)."""

STEPS = 80
PATIENCE = 6
"""Steps without progress that end the search too."""

ACCURACY = 1e-11
"""Relative to (1 m + the distance): a lower bound this near to the distance ends the search."""

SUBSETS = [[0, *one] for size in range(4) for one in combinations((1, 2, 3), size)]
"""Of a simplex's corners: those with the newest, which stands first."""


def distances(support_a: Support, support_b: Support, count: int, start: FloatArray) -> FloatArray:
    """Return (n,) m: the distance of each of `count` pairs of sets, or minus a depth where they overlap.

    Args:
        support_a, support_b: of the sets a and b.
        count: how many.
        start: (n, 3) m, any point of a less any point of b.
    """
    items = np.arange(count)
    v = start.copy()
    out = np.linalg.norm(v, axis=1)
    corners, held = np.zeros((count, 3, 3)), np.zeros((count, 3), dtype=bool)
    corners[:, 0], held[:, 0] = v, True
    lower = np.full(count, -np.inf)
    stalled = np.zeros(count, dtype=np.int64)
    for _ in range(STEPS):
        length = np.linalg.norm(v, axis=1)
        w = support_a(-v, items) - support_b(v, items)
        np.maximum(lower, dot(v, w) / np.maximum(length, 1e-300), out=lower)
        open_ = (out[items] - lower > ACCURACY * (1.0 + length)) & (length > 0.0)
        items, corners, held, lower, w = items[open_], corners[open_], held[open_], lower[open_], w[open_]
        corners = np.concatenate([w[:, None], corners], axis=1)
        held = np.concatenate([np.ones((len(items), 1), dtype=bool), held], axis=1)
        v, used = nearest_to_origin(corners, held)
        full = used.all(axis=1)
        out[items[full]] = -depths(corners[full])
        found = np.linalg.norm(v, axis=1)
        stalled[items[found < out[items] - 0.1 * ACCURACY]] = 0
        stalled[items] += 1
        go_on = ~full & (stalled[items] < PATIENCE)
        if not go_on.any():
            return out
        items, lower, v, used = items[go_on], lower[go_on], v[go_on], used[go_on]
        out[items] = np.minimum(out[items], found[go_on])
        order = np.argsort(~used, axis=1, kind="stable")[:, :3]
        corners = np.take_along_axis(corners[go_on], order[:, :, None], axis=1)
        held = np.take_along_axis(used, order, axis=1)
    return out


def nearest_to_origin(corners: FloatArray, held: NDArray[np.bool_]) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the point (n, 3) of each simplex nearest to the origin, and which corners (n, 4) it needs.

    Sought among the parts of the simplex that have its first corner. All four needed: the origin is inside.

    Args:
        corners: (n, 4, 3).
        held: (n, 4), those that are in use, the first among them.
    """
    best = np.full(len(corners), np.inf)
    point = np.zeros((len(corners), 3))
    used = np.zeros_like(held)
    for subset in SUBSETS:
        rows = np.flatnonzero(held[:, subset].all(axis=1))
        if not len(rows):
            continue
        shares = barycentric(corners[rows][:, subset])
        inside = (shares >= 0.0).all(axis=1) & np.isfinite(shares).all(axis=1)
        rows, shares = rows[inside], shares[inside]
        found = np.einsum("nk,nkx->nx", shares, corners[rows][:, subset])
        square = dot(found, found)
        if len(subset) == 4:
            square[:] = 0.0
        better = square < best[rows]
        rows = rows[better]
        best[rows], point[rows] = square[better], found[better]
        used[rows] = False
        used[np.ix_(rows, np.array(subset))] = True
    return point, used


def barycentric(corners: FloatArray) -> FloatArray:
    """Return (n, k) shares that sum to 1: of the point nearest to the origin in the affine hull of (n, k, 3)."""
    n, k, _ = corners.shape
    if k == 1:
        return np.ones((n, 1))
    base, edges = corners[:, 0], corners[:, 1:] - corners[:, :1]
    with np.errstate(all="ignore"):
        if k == 2:
            rest = -(dot(edges[:, 0], base) / dot(edges[:, 0], edges[:, 0]))[:, None]
        elif k == 3:
            one, other = edges[:, 0], edges[:, 1]
            normal = cross(one, other)
            parts = (cross(other, base), cross(base, one))
            rest = np.stack([dot(part, normal) for part in parts], axis=1) / dot(normal, normal)[:, None]
        else:
            a, b, c = (edges[:, i] for i in range(3))
            parts = (cross(b, c), cross(c, a), cross(a, b))
            rest = -np.stack([dot(base, part) for part in parts], axis=1) / dot(a, parts[0])[:, None]
        return np.column_stack([1.0 - rest.sum(axis=1), rest])


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.einsum("nx,nx->n", a, b)


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a x b, (n, 3): several times faster than numpy's own for few."""
    out = np.empty_like(a)
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[:, x] = a[:, y] * b[:, z] - a[:, z] * b[:, y]
    return out


def depths(corners: FloatArray) -> FloatArray:
    """Return (n,) m: how deep the origin lies inside tetrahedra (n, 4, 3)."""
    found = []
    for face in combinations(range(4), 3):
        a, b, c = (corners[:, i] for i in face)
        normal = cross(b - a, c - a)
        length = np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
        found.append(np.abs(dot(normal, a)) / length)
    return np.minimum.reduce(found)
