"""How long triangles that overlap go on overlapping: the counterpart of the slabs between triangles.

Two convex sets share a point if their Minkowski difference P, the hull of all v = p - q over their corners, holds 0.
Suppose each v moves by some d, and -d lies in P. Interpolate d over P: the map x -> -d(x) takes P into itself. By
Brouwer it has a fixed point x = -d(x). So x + d(x) = 0 lies in the moved hull, and the sets still share a point. Planes
bound P, and how fast each corner nears a plane is known. So sliding along a face costs nothing until its border.

Triangles that merely touch, or touch up to rounding, are given a thickness: P is thickened along the direction in which
it is shallowest, and a little all around. So a point that slides along the border of two triangles has a place in both.
"""

from __future__ import annotations

from math import inf

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.rounding import RELATIVE_ROUNDING
from ..geometry.segments import sides_of
from ..geometry.transform import crossed
from ..kinematics.chain import Twist
from ..kinematics.relative_motion import RelativeRates
from ..narrow.slivers import EPSILON
from ..narrow.triangle_pairs import NearTriangles
from .triangle_slabs import SHORTEST, roots, units

#: Planes through computed corners may miss P by this many eps times its size and how flat its triangles are.
PLANE_ERROR = 16.0 * EPSILON

#: Triangles flatter than this are not thickened all around: their corners would stick out far.
MOST_FLAT = 8.0
#: Offsets of planes err by no more than this many eps times the corners' coordinates.
OVERLAP_ROUNDING = 16.0 * EPSILON


class TriangleOverlap:
    """Pairs of triangles of two touching bodies at one time.

    Attributes:
        depth: m, how far any point may get relative to any other with some two triangles still meeting; 0 if unknown.
    """

    def __init__(
        self, near: NearTriangles, twists: tuple[Twist, Twist], error: float, near_future: RelativeRates, slack: float
    ) -> None:
        """Take the pairs.

        Args:
            near: the pairs.
            twists: of both bodies, in the frame of the corners.
            error: m, by which placed corners may be wrong; what is this near counts as touching.
            near_future: how any point of the one accelerates relative to any of the other, and until when.
            slack: m/s, by which the velocities may be wrong.
        """
        near = _meeting(near, near.radii + 2.0 * error)
        directions = _directions(near)
        onto = np.swapaxes(directions, 1, 2)
        one, other = near.one @ onto, near.other @ onto  # (k, corner, d)
        offsets = one.max(axis=1) - other.min(axis=1)
        pointless = ~directions.any(axis=2)
        shallowest = np.where(pointless, inf, offsets).argmin(axis=1)
        normals = directions[np.arange(len(directions)), shallowest][:, None]
        thickness = (near.radii + 2.0 * error)[:, None] * np.abs((directions * normals).sum(axis=2))
        rounding = OVERLAP_ROUNDING * (np.abs(near.one).max(axis=(1, 2)) + np.abs(near.other).max(axis=(1, 2)))
        size, flatness = _shape(near)
        missed = PLANE_ERROR * size * flatness
        wider = np.where(flatness <= MOST_FLAT, 2.0 * (error + rounding + missed), 0.0) - missed
        aslant = np.linalg.norm(crossed(directions, normals), axis=2)
        left = offsets + thickness + wider[:, None] * aslant - error - rounding[:, None]
        closing = (-(twists[0].at(near.one) @ onto)).max(axis=1) + (twists[1].at(near.other) @ onto).max(axis=1) + slack
        bends = np.maximum(0.0, near_future.varying.supports(directions) - directions @ np.array(near_future.steady))
        self._lasting = np.where(pointless, inf, roots(left, closing, bends)).min(axis=1)
        self._horizon = near_future.horizon
        self.depth = float(np.where(pointless, inf, left).min(axis=1).max(initial=0.0))

    def sleep(self) -> float:
        """Return how long (s) some two triangles certainly go on meeting, to within 100 times the error; errs low."""
        lasting = min(self._horizon, float(self._lasting.max(initial=0.0)))
        return lasting * (1.0 - RELATIVE_ROUNDING)


def proper(near: NearTriangles) -> NearTriangles:
    """Return the pairs of which one at least is no point or segment: P has an inside then, or is flat."""
    return near.only(np.maximum(_heights(near.one)[0], _heights(near.other)[0]) > 0.0)


def _meeting(near: NearTriangles, thickness: FloatArray) -> NearTriangles:
    """Leave out pairs (k,) that the plane of either triangle parts by more than `thickness` (k,) m."""
    sides = [sides_of(near.one), sides_of(near.other)]
    normals = np.stack([units(crossed(side[:, 0], side[:, 1])) for side in sides], axis=2)  # (k, 3, 2)
    one, other = near.one @ normals, near.other @ normals
    apart = np.maximum(other.min(axis=1) - one.max(axis=1), one.min(axis=1) - other.max(axis=1)).max(axis=1)
    return near.only(apart <= thickness)


def _directions(near: NearTriangles) -> FloatArray:
    """Return unit directions (k, 46, 3), those of all planes that bound P or P thickened; zero where there is none.

    The normals of both triangles, the cross products of their edges, and those of edges and normals, which also cut off
    where two planes meet at a sharp edge; each to both sides.
    """
    sides = np.concatenate([sides_of(near.one), sides_of(near.other)], axis=1)
    normals = _across(sides[:, [0, 3]], sides[:, [1, 4]])
    crosses = _across(sides[:, :3, None], sides[:, None, 3:]).reshape(-1, 9, 3)
    borders = _across(sides[:, :, None], normals[:, None]).reshape(-1, 12, 3)
    found = np.concatenate((normals, crosses, borders), axis=1)
    return np.concatenate((found, -found), axis=1)


def _across(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return unit vectors (..., 3) across both, zero where they are parallel.

    A cross product of nearly parallel vectors may lean along them by rounding: that is taken off again.
    """
    ways = units(crossed(one, other))
    for along in (units(one), units(other)):
        ways = units(ways - (ways * along).sum(axis=-1, keepdims=True) * along)
    return ways


def _heights(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the least heights and the longest sides (k,) m of triangles (k, 3, 3)."""
    sides = sides_of(corners)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    doubled = np.linalg.norm(crossed(sides[:, 0], sides[:, 1]), axis=1)
    return np.divide(doubled, longest, out=np.zeros_like(longest), where=longest > SHORTEST), longest


def _shape(near: NearTriangles) -> tuple[FloatArray, FloatArray]:
    """Return the size (k,) m of P, and how many times longer than high the flatter of its triangles is."""
    (height, longest), (other_height, other_longest) = _heights(near.one), _heights(near.other)
    ratios = [
        np.divide(side, h, out=np.ones_like(h), where=h > 0.0)
        for h, side in ((height, longest), (other_height, other_longest))
    ]
    return longest + other_longest, np.maximum(*ratios)
