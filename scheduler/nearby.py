"""The triangles of two placed shapes that are near each other, found by their bounding balls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .rotation import FloatArray

#: More pairs of triangles than this are not looked at one by one: measuring anew is cheaper.
MOST_TRIANGLE_PAIRS = 2_000
#: The same for pairs of bounding balls.
MOST_BALL_PAIRS = 200_000


@dataclass(frozen=True, slots=True, eq=False)
class Triangles:
    """A mesh's triangles in one frame: corners (m, 3, 3) m, and balls around them, centres (m, 3) and radii (m,) m."""

    corners: FloatArray
    centres: FloatArray
    radii: FloatArray

    @staticmethod
    def of(corners: FloatArray) -> Triangles:
        """Return the triangles with these corners."""
        centres = corners.mean(axis=1)
        radii = np.sqrt(((corners - centres[:, None]) ** 2).sum(axis=2).max(axis=1))
        return Triangles(corners, centres, radii)


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

    Every pair that is left out is farther apart than `reach`. None where there are too many.

    Args:
        one, other: the triangles, each in its own frame.
        pose_one, pose_other: 4x4, common frame from own.
        reach: m, >= 0.
    """
    # In one's frame first: only the other's triangles near one's box are of interest, then the reverse.
    relative = pose_one[:3, :3].T @ pose_other[:3, :3]
    shift = pose_one[:3, :3].T @ (pose_other[:3, 3] - pose_one[:3, 3])
    there = other.centres @ relative.T + shift
    theirs = _near_box(there, other.radii, one.centres, one.radii, reach)
    if not len(theirs):
        return NOTHING.one, NOTHING.other
    there, reaches = there[theirs], other.radii[theirs]
    ours = _near_box(one.centres, one.radii, there, reaches, reach)
    if len(ours) * len(theirs) > MOST_BALL_PAIRS:
        return None
    apart = one.centres[ours][:, None] - there[None, :]
    limit = one.radii[ours][:, None] + reaches[None, :] + reach * (1.0 + 1e-9)
    i, j = np.nonzero((apart**2).sum(axis=2) <= limit**2)
    if len(i) > MOST_TRIANGLE_PAIRS:
        return None
    mine = one.corners[ours[i]] @ pose_one[:3, :3].T + pose_one[:3, 3]
    yours = other.corners[theirs[j]] @ pose_other[:3, :3].T + pose_other[:3, 3]
    return mine, yours


def _near_box(
    centres: FloatArray, radii: FloatArray, others: FloatArray, reaches: FloatArray, reach: float
) -> NDArray[np.intp]:
    """Return the indices of the balls that come within `reach` of the box around the other balls."""
    low = (others - reaches[:, None]).min(axis=0)
    high = (others + reaches[:, None]).max(axis=0)
    outside = np.maximum(np.maximum(low - centres, centres - high), 0.0)
    return np.flatnonzero((outside**2).sum(axis=1) <= (radii + reach * (1.0 + 1e-9)) ** 2)
