"""Which triangles of one mesh meet, other than at corners and edges that they share."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..geometry.arrays import BoolArray, FloatArray, IntArray

#: Neighbouring triangles that share a box.
GROUP = 4
#: Pairs of boxes that are compared at once.
BATCH = 1 << 18
#: Into so many steps each axis is cut to put neighbours together; and how 20 bits are spread to every third one.
STEPS = 2.0**20 - 1.0
SPREADS = (
    (32, 0x1F00000000FFFF),
    (16, 0x1F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)
#: Axes that may part two triangles.
AXES = 17
#: By this share of the coordinates about a pair's own corner, times an axis' length, projections on it may be wrong.
CROSSING_ROUNDING = 64.0 * 2.0**-52


def near_each_other(corners: FloatArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield the pairs i, j of triangles (m, 3, 3) whose boxes meet, each pair once."""
    low, high = (np.ascontiguousarray(ends(corners, axis=1).T) for ends in (np.min, np.max))
    order = _neighbours_together(low + 0.5 * (high - low))
    levels = [np.stack((low[:, order], high[:, order]))]  # (low or high, axis, box)
    while levels[-1].shape[2] > 1:
        low, high = levels[-1]
        starts = np.arange(0, low.shape[1], GROUP)
        levels.append(np.stack((np.minimum.reduceat(low, starts, axis=1), np.maximum.reduceat(high, starts, axis=1))))
    top = np.zeros(1, dtype=np.int64)
    for i, j in _descended(levels, len(levels) - 1, top, top):
        yield order[i], order[j]


def _neighbours_together(centres: FloatArray) -> IntArray:
    """Return an order of points (3, m) along a curve that fills space (Morton's)."""
    low = centres.min(axis=1, keepdims=True)
    cells = (centres - low) * (STEPS / np.maximum((centres - low).max(), 2.0**-1022))
    code = np.zeros(centres.shape[1], dtype=np.int64)
    for axis, along in enumerate(cells.astype(np.int64)):
        spread = along
        for shift, mask in SPREADS:
            spread = (spread | spread << shift) & mask
        code |= spread << axis
    return np.argsort(code, kind="stable")


def _descended(levels: list[FloatArray], level: int, i: IntArray, j: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield the pairs i < j of boxes of the finest level that meet, below pairs i <= j of a level."""
    if level == 0:
        different = i != j
        yield i[different], j[different]
        return
    low, high = levels[level - 1]
    within = np.arange(GROUP)
    for begin in range(0, len(i), BATCH // GROUP**2):
        batch = slice(begin, begin + BATCH // GROUP**2)
        ones = (i[batch, None, None] * GROUP + within[:, None]).repeat(GROUP, axis=2).reshape(-1)
        others = (j[batch, None, None] * GROUP + within).repeat(GROUP, axis=1).reshape(-1)
        there = (ones <= others) & (others < low.shape[1])
        ones, others = ones[there], others[there]
        for axis in range(3):
            meet = (low[axis, ones] <= high[axis, others]) & (low[axis, others] <= high[axis, ones])
            ones, others = ones[meet], others[meet]
        yield from _descended(levels, level - 1, ones, others)


def apart(one: FloatArray, other: FloatArray) -> BoolArray:
    """Return which pairs of triangles (k, 3, 3), (k, 3, 3) certainly share no point; points and segments too.

    Convex sets are apart where they are along one of: both normals, the cross products of edges, and the directions
    across edges in both planes.
    """
    found = np.zeros(len(one), dtype=bool)
    left = np.arange(len(one))
    for number in range(AXES):
        if not len(left):
            break
        a = one[left] - one[left, :1]
        b = other[left] - one[left, :1]
        axis = _axis(a, b, number)
        p, q = np.einsum("kij,kj->ki", a, axis), np.einsum("kij,kj->ki", b, axis)
        gap = np.maximum(q.min(axis=1) - p.max(axis=1), p.min(axis=1) - q.max(axis=1))
        size = np.maximum(np.abs(a).max(axis=(1, 2)), np.abs(b).max(axis=(1, 2)))
        clear = gap > CROSSING_ROUNDING * size * np.abs(axis).sum(axis=1)
        found[left[clear]] = True
        left = left[~clear]
    return found


def _axis(a: FloatArray, b: FloatArray, number: int) -> FloatArray:
    """Return one of the axes (k, 3) that may part triangles (k, 3, 3), (k, 3, 3), the likeliest first."""
    if number < 2:
        return _normal(b if number else a)
    if number < 8:
        of = a if number < 5 else b
        return np.cross(_normal(of), _edge(of, number % 3))
    return np.cross(_edge(a, (number - 8) // 3), _edge(b, (number - 8) % 3))


def _edge(corners: FloatArray, k: int) -> FloatArray:
    side: FloatArray = corners[:, (k + 1) % 3] - corners[:, k]
    return side


def _normal(corners: FloatArray) -> FloatArray:
    return np.cross(_edge(corners, 0), _edge(corners, 1))


def embedded_stars(corners: FloatArray, vertices: IntArray) -> BoolArray:
    """Tell (m, 3) at which corners no two triangles that share it meet again: seen from above they lie side by side.

    Args:
        corners: (m, 3, 3), wound alike around each closed skin.
        vertices: (m, 3) numbers of corners, different in different skins.
    """
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    units: FloatArray = normals / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    numbers, flat = np.unique(vertices.reshape(-1), return_inverse=True)
    sums: FloatArray = np.stack(
        [np.bincount(flat, np.repeat(units[:, k], 3), len(numbers)).astype(np.float64) for k in range(3)], axis=1
    )
    sums = sums / np.maximum(np.linalg.norm(sums, axis=1), 1e-300)[:, None]
    up = sums[flat].reshape(-1, 3, 3)
    good = np.einsum("mkj,mj->mk", up, units) > 1e-6
    angles = np.empty(vertices.shape)
    for k in range(3):
        a, b = (corners[:, (k + turn) % 3] - corners[:, k] for turn in (1, 2))
        n = up[:, k]
        a, b = (side - np.einsum("ij,ij->i", side, n)[:, None] * n for side in (a, b))
        angles[:, k] = np.arctan2(np.einsum("ij,ij->i", np.cross(a, b), n), np.einsum("ij,ij->i", a, b))
    all_good = np.bincount(flat, ~good.reshape(-1), len(numbers)) == 0
    once = np.bincount(flat, angles.reshape(-1), len(numbers)) < 3.0 * np.pi
    found: BoolArray = (all_good & once)[flat].reshape(-1, 3)
    return found


def meets_itself(vertices: FloatArray, triangles: IntArray, most: int) -> bool:
    """Return whether a skin of triangles (m, 3) over vertices (n, 3) m may touch or cross itself.

    It may, for all that is known, where the boxes of more than `most` pairs of triangles meet.
    """
    corners = vertices[triangles]
    stars = embedded_stars(corners, triangles)
    looked = 0
    for i, j in near_each_other(corners):
        looked += len(i)
        if looked > most or meet_again(vertices, triangles[i], triangles[j], stars[i]).any():
            return True
    return False


def meet_again(vertices: FloatArray, one: IntArray, other: IntArray, stars: BoolArray) -> BoolArray:
    """Return which pairs of triangles (k, 3), (k, 3) may share a point beside the corners and edges that they share.

    Args:
        vertices: (n, 3) m.
        one, other: vertex indices.
        stars: (k, 3) at which corners of the one no two triangles meet again.
    """
    same = one[:, :, None] == other[:, None, :]
    shared = same.sum(axis=(1, 2))
    harmless = (same.any(axis=2) & stars).any(axis=1)
    found = np.zeros(len(one), dtype=bool)
    free = np.flatnonzero(shared == 0)
    found[free] = ~apart(vertices[one[free]], vertices[other[free]])
    corner = np.flatnonzero((shared == 1) & ~harmless)
    edge = np.flatnonzero((shared == 2) & ~harmless)
    for mine, theirs, lie in ((one, other, same), (other, one, same.transpose(0, 2, 1))):
        across = _turned_to(mine[corner], lie[corner].any(axis=2).argmax(axis=1))[:, [1, 2, 2]]
        found[corner] |= ~apart(vertices[across], vertices[theirs[corner]])
    if len(edge):
        mine = _turned_to(one[edge], (~same[edge].any(axis=2)).argmax(axis=1))
        theirs = _turned_to(other[edge], (~same[edge].any(axis=1)).argmax(axis=1))
        found[edge] = _folded(*(vertices[corners] for corners in (mine[:, 1], mine[:, 2], mine[:, 0], theirs[:, 0])))
    return found


def _turned_to(triangles: IntArray, first: IntArray) -> IntArray:
    """Return triangles (k, 3) with their corners turned so that the given ones come first."""
    turned: IntArray = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    return turned


def _folded(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> BoolArray:
    """Return which triangles a, b, c and a, b, d (k, 3) may lie on each other."""
    edge, one, other = b - a, c - a, d - a
    normal, other_normal = np.cross(edge, one), np.cross(edge, other)
    size = np.abs(np.concatenate((edge, one, other), axis=1)).max(axis=1)
    volume = np.abs(np.einsum("ij,ij->i", normal, other))
    found: BoolArray = (np.einsum("ij,ij->i", normal, other_normal) > 0.0) & (
        volume <= 8.0 * CROSSING_ROUNDING * size**3
    )
    return found


def meeting_points(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return (k, 3) m about the middle of what pairs of triangles (k, 3, 3), (k, 3, 3) share."""
    total, weight = np.zeros((len(one), 3)), np.zeros(len(one))
    for a, b in ((one, other), (other, one)):
        normal = np.cross(b[:, 1] - b[:, 0], b[:, 2] - b[:, 0])
        heights = np.einsum("kij,kj->ki", a - b[:, :1], normal)
        for k in range(3):
            begin, end = heights[:, k], heights[:, (k + 1) % 3]
            with np.errstate(all="ignore"):
                share = np.where(begin == end, 0.5, begin / (begin - end))
            point = a[:, k] + share[:, None] * (a[:, (k + 1) % 3] - a[:, k])
            inside = (share >= 0.0) & (share <= 1.0)
            for m in range(3):
                side = np.cross(b[:, (m + 1) % 3] - b[:, m], point - b[:, m])
                inside &= np.einsum("ij,ij->i", side, normal) >= -1e-9 * np.einsum("ij,ij->i", normal, normal)
            total[inside] += point[inside]
            weight += inside
    low = np.maximum(one.min(axis=1), other.min(axis=1))
    high = np.minimum(one.max(axis=1), other.max(axis=1))
    found: FloatArray = np.where(weight[:, None] > 0.0, total / np.maximum(weight, 1.0)[:, None], 0.5 * (low + high))
    return found
