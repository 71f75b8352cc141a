"""Points without repetition: exactly equal points become one."""

from __future__ import annotations

import numpy as np

from .arrays import FloatArray, IntArray


def distinct_points(points: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the rows of the distinct points of (n, 3), each where it first stands, and which of these each point is.

    0.0 and -0.0 are equal, nothing else that differs is. Both are in the order of the points: (k,) and (n,).
    """
    plain = points + 0.0
    order = np.lexsort(plain.T)  # stable: the first of equals stays in front
    follows = plain[order]
    begins = np.ones(len(points), dtype=bool)
    begins[1:] = (follows[1:] != follows[:-1]).any(axis=1)
    firsts = order[begins]
    by_place = np.argsort(firsts)
    ranks = np.empty_like(by_place)
    ranks[by_place] = np.arange(len(by_place))
    places = np.empty_like(order)
    places[order] = ranks[np.cumsum(begins) - 1]
    return firsts[by_place], places
