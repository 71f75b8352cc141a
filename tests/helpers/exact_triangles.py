"""The distance of two triangles in exact rational arithmetic."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product
from math import isqrt

import numpy as np

Exact = tuple[Fraction, Fraction, Fraction]
Corners = tuple[Exact, ...]

ZERO = Fraction(0)


def exactly(corners: np.ndarray) -> Corners:
    """Return the floats of corners (3, 3) as they are."""
    return tuple((Fraction(x), Fraction(y), Fraction(z)) for x, y, z in corners.tolist())


def less(a: Exact, b: Exact) -> Exact:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def dot(a: Exact, b: Exact) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Exact, b: Exact) -> Exact:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def along(p: Exact, d: Exact, share: Fraction) -> Exact:
    return p[0] + share * d[0], p[1] + share * d[1], p[2] + share * d[2]


def square(a: Exact) -> Fraction:
    return dot(a, a)


def edges(corners: Corners) -> list[tuple[Exact, Exact]]:
    return list(pairwise((*corners, corners[0])))


def inside(point: Exact, corners: Corners, normal: Exact) -> bool:
    """Tell whether a point is straight above a triangle, its border too."""
    return all(dot(cross(less(b, a), less(point, a)), normal) >= 0 for a, b in edges(corners))


def to_edge(point: Exact, a: Exact, b: Exact) -> Fraction:
    d = less(b, a)
    share = dot(less(point, a), d) / dd if (dd := square(d)) else ZERO
    return square(less(along(a, d, min(Fraction(1), max(ZERO, share))), point))


def between_lines(a: Exact, b: Exact, c: Exact, d: Exact) -> Fraction | None:
    """Return the squared distance of two edges' lines where they are nearest inside of both, None if nowhere."""
    p, q, r = less(b, a), less(d, c), less(c, a)
    n = cross(p, q)
    if not (nn := square(n)):
        return None
    s, t = dot(cross(r, q), n) / nn, dot(cross(r, p), n) / nn
    return dot(r, n) ** 2 / nn if 0 <= s <= 1 and 0 <= t <= 1 else None


def against_face(one: Corners, other: Corners) -> list[Fraction]:
    """Return the squared heights of corners above the other's face, and 0 for each edge that pierces it."""
    normal = cross(less(other[1], other[0]), less(other[2], other[0]))
    if not (nn := square(normal)):
        return []
    heights = [dot(less(corner, other[0]), normal) for corner in one]
    found = [h**2 / nn for h, corner in zip(heights, one, strict=True) if inside(corner, other, normal)]
    for (a, b), (h, k) in zip(edges(one), pairwise((*heights, heights[0])), strict=True):
        if h * k < 0 and inside(along(a, less(b, a), h / (h - k)), other, normal):
            found.append(ZERO)
    return found


def squared_distance(one: np.ndarray, other: np.ndarray) -> Fraction:
    """Return the squared distance of two triangles with corners (3, 3), exactly."""
    a, b = exactly(one), exactly(other)
    found = [*against_face(a, b), *against_face(b, a)]
    found += [to_edge(p, *edge) for p, edge in product(a, edges(b))]
    found += [to_edge(p, *edge) for p, edge in product(b, edges(a))]
    found += [near for e, f in product(edges(a), edges(b)) if (near := between_lines(*e, *f)) is not None]
    return min(found)


def root(value: Fraction) -> float:
    """Return the square root of a rational, right to the last bit but one."""
    if not value:
        return 0.0
    shift = max(0, 120 - (value.numerator.bit_length() - value.denominator.bit_length()))
    shift += shift % 2
    return float(Fraction(isqrt((value.numerator << shift) // value.denominator), 1 << (shift // 2)))
