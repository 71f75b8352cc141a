"""The directional bound: every two triangles within reach stay on their sides of a slab between them.

Triangles are convex, so where a direction n parts two of them by a gap, they stay apart until their corners have
closed it along n; motion across n costs nothing. Each pair of triangles within reach gets directions of its own, all
others are too far away for the plain displacement bound. Sources: Zhang, Redon, Lee, Kim, "CATCH" (2007); Tang, Kim,
Manocha, "C2A" (2009).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from .bounds import RELATIVE_ROUNDING
from .chain import Twist
from .nearby import NearTriangles
from .rotation import FloatArray
from .segments import ways_between

#: Vectors shorter than this (m, m^2) point nowhere. Longer ones that are noise do no harm: each gap is measured anew.
SHORTEST = 1e-150


@dataclass(frozen=True, slots=True, eq=False)
class Slabs:
    """Gaps between all triangles of two bodies that are within reach of each other, at one time.

    Attributes:
        reach: m, whatever is not in a slab is at least this far apart.
        gaps: (k, d, 9) m, for each of k triangle pairs along each of d directions, from each corner of the one to each
            of the other; errors and rounding radii are off.
        closings: (k, d, 9) m/s, how fast each of these gaps closes then.
        acceleration: m/s^2, above that of any point of the one relative to any of the other, until the horizon.
        horizon: s after that time.
    """

    reach: float
    gaps: FloatArray
    closings: FloatArray
    acceleration: float
    horizon: float

    def sleep(self, spare: float) -> float:
        """Return how long (s, <= horizon) every slab stays wider than `spare` m; errs low."""
        if not len(self.gaps):
            return self.horizon
        left = self.gaps * (1.0 - RELATIVE_ROUNDING) - spare
        roots = _roots(left, self.closings, self.acceleration)
        longest = roots.min(axis=2).max(axis=1).min()
        return min(self.horizon, float(longest) * (1.0 - RELATIVE_ROUNDING))

    def clearance(self, duration: float, displacement: float) -> float:
        """Return a lower bound (m) on the distance over the next `duration` s, -inf past the horizon.

        Args:
            duration: s.
            displacement: m, above how far the two bodies get relative to each other within it.
        """
        if duration > self.horizon:
            return -inf
        beyond = self.reach - displacement
        if not len(self.gaps):
            return beyond
        lost = np.maximum(0.0, self.closings * duration + 0.5 * self.acceleration * duration**2)
        left = self.gaps * (1.0 - RELATIVE_ROUNDING) - lost * (1.0 + RELATIVE_ROUNDING)
        return min(beyond, float(left.min(axis=2).max(axis=1).min()))


def slabs(
    near: NearTriangles,
    twists: tuple[Twist, Twist],
    error: float,
    reach: float,
    acceleration: float,
    horizon: float,
    slack: float,
) -> Slabs:
    """Return the slabs between pairs of triangles.

    Args:
        near: the pairs.
        twists: of both bodies, in the frame of the corners.
        error: m, by which placed corners may be wrong.
        reach: m, below the distance of whatever is not among the pairs.
        acceleration, horizon: as in Slabs.
        slack: m/s, by which the velocities may be wrong.
    """
    one, other, radii = near
    directions = _directions(one, other)
    low = np.einsum("kdc,kvc->kdv", directions, one)
    high = np.einsum("kdc,kvc->kdv", directions, other)
    gaps = high[:, :, None, :] - low[:, :, :, None] - (radii[:, None, None, None] + error)
    approach = np.einsum("kdc,kvc->kdv", directions, twists[0].at(one))
    retreat = np.einsum("kdc,kvc->kdv", directions, twists[1].at(other))
    closings = approach[:, :, :, None] - retreat[:, :, None, :] + slack
    shape = (*gaps.shape[:2], 9)
    return Slabs(reach, gaps.reshape(shape), closings.reshape(shape), acceleration, horizon)


def _directions(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return unit directions (k, d, 3) from each triangle of `one` towards its partner; zero where there is none.

    The separating axes of two triangles: their normals and the cross products of their edges; and for their corners
    the ways from corner to corner.
    """
    sides, others = np.roll(one, -1, axis=1) - one, np.roll(other, -1, axis=1) - other
    normals = np.stack((np.cross(sides[:, 0], sides[:, 1]), np.cross(others[:, 0], others[:, 1])), axis=1)
    crosses = np.cross(sides[:, :, None], others[:, None, :]).reshape(-1, 9, 3)
    across = _between_nearest_points(one, other, sides, others)
    found = np.concatenate((normals, crosses, across[:, None]), axis=1)
    lengths = np.linalg.norm(found, axis=2)
    known = (lengths > SHORTEST)[:, :, None]
    found = np.divide(found, lengths[:, :, None], out=np.zeros_like(found), where=known)
    middle = other.mean(axis=1) - one.mean(axis=1)
    towards: FloatArray = found * np.where(np.einsum("kdc,kc->kd", found, middle) < 0.0, -1.0, 1.0)[:, :, None]
    return towards


def _between_nearest_points(one: FloatArray, other: FloatArray, sides: FloatArray, others: FloatArray) -> FloatArray:
    """Return the way (k, 3) between the nearest points of the triangles' edges."""
    ways, _ = ways_between(one[:, :, None], sides[:, :, None], other[:, None, :], others[:, None, :])
    ways = ways.reshape(-1, 9, 3)
    shortest: FloatArray = ways[np.arange(len(ways)), (ways**2).sum(-1).argmin(axis=1)]
    return shortest


def _roots(left: FloatArray, closings: FloatArray, acceleration: float) -> FloatArray:
    """Return when left = closing s + acceleration s^2 / 2, s; 0 where nothing is left, inf where never."""
    if acceleration == 0.0:
        with np.errstate(divide="ignore"):
            roots = np.where(closings > 0.0, left / np.where(closings > 0.0, closings, 1.0), inf)
    else:
        spread = np.sqrt(closings**2 + 2.0 * acceleration * np.maximum(left, 0.0))
        closing = closings > 0.0
        roots = np.where(
            closing, 2.0 * left / np.where(closing, closings + spread, 1.0), (spread - closings) / acceleration
        )
    positive: FloatArray = np.where(left > 0.0, roots, 0.0)
    return positive
