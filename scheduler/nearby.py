"""The triangles of two placed shapes that are near each other, found by their bounding balls and boxes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .rotation import FloatArray

#: More pairs of triangles than this are not looked at one by one: measuring anew is cheaper.
MOST_TRIANGLE_PAIRS = 2_000
#: The same for pairs of bounding boxes.
MOST_BOX_PAIRS = 400_000
#: Relative loss granted to the arithmetic of what is near.
ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Triangles:
    """A mesh's triangles in one frame, m: corners (m, 3, 3); balls around them, centres (m, 3) and radii (m,); boxes
    around them, low and high (m, 3).
    """

    corners: FloatArray
    centres: FloatArray
    radii: FloatArray
    low: FloatArray
    high: FloatArray

    @staticmethod
    def of(corners: FloatArray) -> Triangles:
        """Return the triangles with these corners."""
        centres = corners.mean(axis=1)
        radii = np.sqrt(((corners - centres[:, None]) ** 2).sum(axis=2).max(axis=1))
        return Triangles(corners, centres, radii, corners.min(axis=1), corners.max(axis=1))


class NearTriangles(NamedTuple):
    """Pairs of triangles of two bodies: corners (k, 3, 3) m of each, in the poses' frame centred on the first body.

    `radii` (k,) m are the sums of their rounding radii.
    """

    one: FloatArray
    other: FloatArray
    radii: FloatArray


NOTHING = NearTriangles(np.empty((0, 3, 3)), np.empty((0, 3, 3)), np.empty(0))


def near_pairs(
    one: Triangles, other: Triangles, pose_one: FloatArray, pose_other: FloatArray, reach: float
) -> tuple[FloatArray, FloatArray] | None:
    """Return the corners (k, 3, 3), (k, 3, 3) of the triangle pairs that may be within `reach`, in the poses' frame.

    Every pair that is left out is farther apart than `reach`. None where there are too many. Boxes stand along the axes
    of `one`'s frame: long triangles often run along an axis.

    Args:
        one, other: the triangles, each in its own frame.
        pose_one, pose_other: 4x4, common frame from own.
        reach: m, >= 0; what placing the corners may be wrong by is for the caller to add.
    """
    relative = pose_one[:3, :3].T @ pose_other[:3, :3]
    shift = pose_one[:3, :3].T @ (pose_other[:3, 3] - pose_one[:3, 3])
    there = other.centres @ relative.T + shift
    limit = reach * (1.0 + ROUNDING)
    balls = other.radii[:, None]
    theirs = _near_box(there - balls, there + balls, one.low, one.high, limit)
    placed = other.corners[theirs] @ relative.T + shift
    low, high = placed.min(axis=1), placed.max(axis=1)
    ours = _near_box(one.low, one.high, low, high, limit)
    kept = _near_box(low, high, one.low[ours], one.high[ours], limit)
    theirs, low, high = theirs[kept], low[kept], high[kept]
    if len(ours) * len(theirs) > MOST_BOX_PAIRS:
        return None
    i, j = _near_each_other(one.low[ours], one.high[ours], low, high, limit)
    if len(i) > MOST_TRIANGLE_PAIRS:
        return None
    mine = one.corners[ours[i]] @ pose_one[:3, :3].T + pose_one[:3, 3]
    yours = other.corners[theirs[j]] @ pose_other[:3, :3].T + pose_other[:3, 3]
    return mine, yours


def _near_box(low: FloatArray, high: FloatArray, lows: FloatArray, highs: FloatArray, reach: float) -> NDArray[np.intp]:
    """Return the indices of the boxes (n, 3) that come within `reach` of the box around the other boxes (m, 3)."""
    if not len(lows):
        return np.empty(0, dtype=np.intp)
    return np.flatnonzero(_within(low, high, lows.min(axis=0), highs.max(axis=0), reach))


def _near_each_other(
    low: FloatArray, high: FloatArray, lows: FloatArray, highs: FloatArray, reach: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the pairs of indices of the boxes (n, 3) and (m, 3) that come within `reach` of each other."""
    axis = int(np.argmax(np.ptp(low, axis=0))) if len(low) else 0
    after = lows[:, axis] <= high[:, axis, None] + reach
    before = highs[:, axis] >= low[:, axis, None] - reach
    i, j = np.nonzero(after & before)
    near = _within(low[i], high[i], lows[j], highs[j], reach)
    return i[near], j[near]


def _within(
    low: FloatArray, high: FloatArray, others_low: FloatArray, others_high: FloatArray, reach: float
) -> NDArray[np.bool_]:
    """Tell which boxes come within `reach` of each other, (..., 3) against (..., 3)."""
    apart = np.maximum(np.maximum(others_low - high, low - others_high), 0.0)
    near: NDArray[np.bool_] = np.einsum("...d,...d->...", apart, apart) <= reach**2
    return near
