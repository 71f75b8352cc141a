"""Slabs between triangles: every two triangles within reach stay on their sides of a slab between them.

Triangles are convex. If a direction n separates two of them by a gap, they stay apart until their corners have closed
the gap along n. Motion perpendicular to n does not close it. The direction between the bodies' closest points is tried
for every pair of triangles within reach; the pairs that it bounds worst then get separating axes of their own. All
other pairs of triangles are farther apart than the displacement bound needs.

Sources: Zhang, Redon, Lee, Kim, "CATCH" (2007); Tang, Kim, Manocha, "C2A" (2009).
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import FloatArray
from ..geometry.rounding import RELATIVE_ROUNDING
from ..geometry.segments import sides_of, ways_between
from ..geometry.transform import crossed
from ..geometry.vector import Vector
from ..kinematics.chain import Twist
from ..kinematics.relative_motion import RelativeRates
from ..narrow.triangle_pairs import NearTriangles

#: Vectors shorter than this (m, m^2) point nowhere. Longer ones that are noise do no harm: each gap is measured anew.
SHORTEST = 1e-150
#: So many pairs of triangles get directions of their own at first; twice as many each time that is not enough.
FIRST_PAIRS = 64
#: Directions of a pair's own: two normals, nine cross products of edges, the way between the nearest points.
OWN_DIRECTIONS = 12


class Gaps(NamedTuple):
    """Gaps between triangles of k pairs along d directions of each.

    Attributes:
        widths: (k, d, 9) m, from each corner of the one to each of the other.
        closings: (k, d, 9) m/s, how fast each closes now.
        bends: (k, d, 1) m/s^2, above how fast that grows until the horizon.
    """

    widths: FloatArray
    closings: FloatArray
    bends: FloatArray


class TriangleSlabs:
    """Gaps between all triangles of two bodies that are within reach of each other, at one time.

    Attributes:
        reach: m, whatever is not among the pairs is at least this far apart.
        horizon: s, how far ahead the slabs may be asked of.
    """

    def __init__(
        self,
        near: NearTriangles,
        twists: tuple[Twist, Twist],
        direction: Vector,
        error: float,
        reach: float,
        near_future: RelativeRates,
        slack: float,
    ) -> None:
        """Take the pairs.

        Args:
            near: the pairs.
            twists: of both bodies, in the frame of the corners.
            direction: unit, from the first body to the other, which all pairs are measured along.
            error: m, by which placed corners may be wrong.
            reach: as the attribute.
            near_future: how any point of the one accelerates relative to any of the other, and until when.
            slack: m/s, by which the velocities may be wrong.
        """
        self.reach, self.horizon = reach, near_future.horizon
        self._near, self._twists = near, twists
        self._error, self._slack = error, slack
        self._steady, self._varying = np.array(near_future.steady), near_future.varying
        every: NDArray[np.intp] = np.arange(len(near.radii))
        along = np.broadcast_to(np.array(direction), (len(every), 1, 3))
        self._shared = self._across(every, along)
        self._own = self._across(every[:0], np.empty((0, OWN_DIRECTIONS, 3)))
        self._known = np.empty(0, dtype=np.intp)  # the pairs that have directions of their own, in order of those

    def sleep(self, spare: float) -> float:
        """Return how long (s, <= horizon) every slab stays wider than `spare` m; errs low."""

        def lasts(gaps: Gaps) -> FloatArray:
            return roots(gaps.widths * (1.0 - RELATIVE_ROUNDING) - spare, gaps.closings, gaps.bends)

        return self._least(lasts, self.horizon) * (1.0 - RELATIVE_ROUNDING)

    def clearance(self, duration: float, displacement: float) -> float:
        """Return a lower bound (m) on the distance over the next `duration` s, -inf past the horizon.

        Args:
            duration: s.
            displacement: m, above how far the two bodies get relative to each other within it.
        """

        def left(gaps: Gaps) -> FloatArray:
            lost = np.maximum(0.0, gaps.closings * duration + 0.5 * gaps.bends * duration**2)
            return gaps.widths * (1.0 - RELATIVE_ROUNDING) - lost * (1.0 + RELATIVE_ROUNDING)

        return -inf if duration > self.horizon else self._least(left, self.reach - displacement)

    def _least(self, value: Callable[[Gaps], FloatArray], most: float) -> float:
        """Return the least over the pairs of the best that any of their directions gives, at most `most`.

        A direction gives the least of `value` over its corners. As long as the least of all stands with
        pairs that have no directions of their own yet, these get them.
        """
        best = value(self._shared).min(axis=2)[:, 0]
        if len(self._known):
            own = value(self._own).min(axis=2).max(axis=1)
            best[self._known] = np.maximum(best[self._known], own)
        while True:
            least = min(most, float(best[self._known].min(initial=inf)))
            lower = best < least
            lower[self._known] = False
            pairs = np.flatnonzero(lower)
            if not len(pairs):
                return min(most, float(best.min(initial=inf)))
            pairs = pairs[np.argsort(best[pairs], kind="stable")][: max(FIRST_PAIRS, len(self._known))]
            gaps = self._across(pairs, axes_between(self._near.one[pairs], self._near.other[pairs]))
            best[pairs] = np.maximum(best[pairs], value(gaps).min(axis=2).max(axis=1))
            self._own = Gaps(*map(np.concatenate, zip(self._own, gaps, strict=True)))
            self._known = np.concatenate((self._known, pairs))

    def _across(self, pairs: NDArray[np.intp], directions: FloatArray) -> Gaps:
        """Return the gaps of pairs (k,) along directions (k, d, 3) of each, errors and rounding radii off."""
        one, other = self._near.one[pairs], self._near.other[pairs]
        onto = np.swapaxes(directions, 1, 2)
        low, high = one @ onto, other @ onto  # (k, corner, d)
        approach, retreat = self._twists[0].at(one) @ onto, self._twists[1].at(other) @ onto
        taken = self._near.radii[pairs] + self._error
        gaps = high[:, None, :] - low[:, :, None] - taken[:, None, None, None]
        closings = approach[:, :, None] - retreat[:, None, :] + self._slack
        shape = (len(pairs), 9, directions.shape[1])
        bends = np.maximum(0.0, directions @ self._steady + self._varying.supports(directions))
        return Gaps(
            np.swapaxes(gaps.reshape(shape), 1, 2), np.swapaxes(closings.reshape(shape), 1, 2), bends[..., None]
        )


def axes_between(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return unit directions (k, OWN_DIRECTIONS, 3) from one triangle towards the other, zero where there is none.

    The separating axes of two triangles (k, 3, 3): their normals and the cross products of their edges; and for their
    corners the way between the nearest points.
    """
    sides, others = sides_of(one), sides_of(other)
    normals = np.stack((crossed(sides[:, 0], sides[:, 1]), crossed(others[:, 0], others[:, 1])), axis=1)
    crosses = crossed(sides[:, :, None], others[:, None, :]).reshape(-1, 9, 3)
    across = _between_nearest_points(one, other, sides, others)
    found = np.concatenate((normals, crosses, across[:, None]), axis=1)
    found = units(found)
    middle = other.mean(axis=1) - one.mean(axis=1)
    towards: FloatArray = found * np.where(np.einsum("kdc,kc->kd", found, middle) < 0.0, -1.0, 1.0)[:, :, None]
    return towards


def units(vectors: FloatArray) -> FloatArray:
    """Return vectors (..., 3) at length 1; zero where they point nowhere."""
    lengths = np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))
    scaled: FloatArray = np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > SHORTEST)
    return scaled


def _between_nearest_points(one: FloatArray, other: FloatArray, sides: FloatArray, others: FloatArray) -> FloatArray:
    """Return the way (k, 3) between the nearest points of the triangles' edges."""
    ways = ways_between(one[:, :, None], sides[:, :, None], other[:, None, :], others[:, None, :])
    ways = ways.reshape(-1, 9, 3)
    shortest: FloatArray = ways[np.arange(len(ways)), (ways**2).sum(-1).argmin(axis=1)]
    return shortest


def roots(left: FloatArray, closings: FloatArray, bends: FloatArray) -> FloatArray:
    """Return when left = closing s + bend s^2 / 2, s; 0 where nothing is left, inf where never."""
    spread = np.sqrt(closings**2 + 2.0 * bends * np.maximum(left, 0.0))
    closing = closings > 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        opening = np.where(bends > 0.0, (spread - closings) / bends, inf)
    roots = np.where(closing, 2.0 * left / np.where(closing, closings + spread, 1.0), opening)
    positive: FloatArray = np.where(left > 0.0, roots, 0.0)
    return positive
