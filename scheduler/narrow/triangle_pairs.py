"""Pairs of triangles of two shapes that are near each other, found by a two-level tree of boxes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import FloatArray

#: More pairs of triangles than this are not looked at one by one: measuring anew is cheaper.
MOST_TRIANGLE_PAIRS = 2_000
#: The same for pairs of bounding boxes.
MOST_BOX_PAIRS = 30_000
#: More pairs of boxes than this are not compared each with each, but first by boxes around `GROUP` of them.
MOST_COMPARED = 20_000
#: More pairs of boxes than this are never looked at.
MOST_BOXES_COMPARED = 2_000_000
#: So many neighbouring triangles share a box.
GROUP = 8
#: Relative loss granted to the arithmetic of what is near.
REACH_ROUNDING = 1e-9

Rows = tuple[NDArray[np.intp], NDArray[np.intp]]


@dataclass(frozen=True, slots=True, eq=False)
class Triangles:
    """A mesh's triangles in one frame, m, neighbours next to each other.

    Attributes:
        order: (m,), each one's index in the mesh.
        corners: (m, 3, 3).
        boxes: (2, m, 3), the low and the high corner around each.
        low, high: (groups, 3), around every `GROUP` of them in turn.
    """

    order: NDArray[np.intp]
    corners: FloatArray
    boxes: FloatArray
    low: FloatArray
    high: FloatArray

    @staticmethod
    def of(corners: FloatArray) -> Triangles:
        """Return the triangles with these corners."""
        order = _neighbours_together(corners.mean(axis=1))
        ordered = corners[order]
        starts = np.arange(0, len(ordered), GROUP)
        boxes = np.stack((ordered.min(axis=1), ordered.max(axis=1)))
        low, high = np.minimum.reduceat(boxes[0], starts), np.maximum.reduceat(boxes[1], starts)
        return Triangles(order, ordered, boxes, low, high)

    def halves(self) -> tuple[Triangles, Triangles]:
        """Return the first half of the groups, and the others; there must be two."""
        group = len(self.low) // 2
        row = group * GROUP
        first = self.order[:row], self.corners[:row], self.boxes[:, :row], self.low[:group], self.high[:group]
        second = self.order[row:], self.corners[row:], self.boxes[:, row:], self.low[group:], self.high[group:]
        return Triangles(*first), Triangles(*second)

    def members(self, groups: NDArray[np.intp]) -> NDArray[np.intp]:
        """Return the rows (k, GROUP) of groups (k,); the last group's are filled up with its last."""
        rows: NDArray[np.intp] = np.minimum(groups[:, None] * GROUP + np.arange(GROUP), len(self.corners) - 1)
        return rows


class NearTriangles(NamedTuple):
    """Pairs of triangles of two bodies: corners (k, 3, 3) m of each, in the poses' frame centred on the first body.

    `radii` (k,) m are the sums of their rounding radii.
    """

    one: FloatArray
    other: FloatArray
    radii: FloatArray

    def only(self, kept: NDArray[np.bool_]) -> NearTriangles:
        """Return those that are kept (k,)."""
        return NearTriangles(self.one[kept], self.other[kept], self.radii[kept])


NOTHING = NearTriangles(np.empty((0, 3, 3)), np.empty((0, 3, 3)), np.empty(0))


def near_pairs(
    one: Triangles, other: Triangles, pose_one: FloatArray, pose_other: FloatArray, reach: float, some: bool = False
) -> tuple[FloatArray, FloatArray] | None:
    """Return the corners (k, 3, 3), (k, 3, 3) of the triangle pairs that may be within `reach`, in the poses' frame.

    Every pair that is left out is farther apart than `reach`. None where there are too many.

    Args:
        one, other: the triangles, each in its own frame.
        pose_one, pose_other: 4x4, common frame from own.
        reach: m, >= 0; what placing the corners may be wrong by is for the caller to add.
        some: whether some of them will do where there are too many; those from all over the bodies are taken.
    """
    rows = near_rows(one, other, pose_one, pose_other, reach, some)
    return None if rows is None else placed_rows(one, other, pose_one, pose_other, rows)


def placed_rows(
    one: Triangles, other: Triangles, pose_one: FloatArray, pose_other: FloatArray, rows: Rows
) -> tuple[FloatArray, FloatArray]:
    """Return the corners (k, 3, 3), (k, 3, 3) of pairs of triangles, in the poses' frame."""
    found = one.corners[rows[0]] @ pose_one[:3, :3].T + pose_one[:3, 3]
    return found, other.corners[rows[1]] @ pose_other[:3, :3].T + pose_other[:3, 3]


def near_rows(
    one: Triangles, other: Triangles, pose_one: FloatArray, pose_other: FloatArray, reach: float, some: bool = False
) -> Rows | None:
    """Return the rows (k,), (k,) of the pairs that `near_pairs` returns.

    Boxes stand along the axes of `one`'s frame: long triangles often run along an axis.
    """
    relative = pose_one[:3, :3].T @ pose_other[:3, :3]
    shift = pose_one[:3, :3].T @ (pose_other[:3, 3] - pose_one[:3, 3])
    limit = reach * (1.0 + REACH_ROUNDING)
    centres = 0.5 * (other.low + other.high) @ relative.T + shift
    halves = 0.5 * (other.high - other.low) @ np.abs(relative).T
    groups = _groups_near(one.low, one.high, centres - halves, centres + halves, limit)
    taken = None if groups is None else _taken(len(groups[0]), MOST_BOX_PAIRS // GROUP**2, some)
    if groups is None or taken is None:
        return None
    i, j = groups[0][taken], groups[1][taken]
    placed, place = np.unique(j, return_inverse=True)
    moved = other.corners[other.members(placed)] @ relative.T + shift  # (groups, GROUP, corner, 3)
    low, high = moved.min(axis=2), moved.max(axis=2)  # (groups, GROUP, 3)
    ours, theirs = one.members(i), other.members(j)
    mine = one.boxes[:, ours]
    ends_low, ends_high = low.min(axis=1)[place], high.max(axis=1)[place]
    first = _within(mine[0], mine[1], ends_low[:, None], ends_high[:, None], limit)
    second = _within(low[place], high[place], one.low[i][:, None], one.high[i][:, None], limit)
    first &= _first_of_each(i, len(one.corners))
    second &= _first_of_each(j, len(other.corners))
    k, m, n = np.nonzero(first[:, :, None] & second[:, None])
    near = _within(mine[0][k, m], mine[1][k, m], low[place[k], n], high[place[k], n], limit)
    rows = np.flatnonzero(near)
    taken = _taken(len(rows), MOST_TRIANGLE_PAIRS, some)
    if taken is None:
        return None
    rows = rows[taken]
    return ours[k[rows], m[rows]], theirs[k[rows], n[rows]]


def _taken(count: int, most: int, some: bool) -> NDArray[np.intp] | None:
    """Return which of so many are taken: all, or of too many, `most` from all over if `some` will do, else None."""
    if count <= most:
        return np.arange(count)
    return np.linspace(0, count - 1, most).astype(np.intp) if some else None


def _neighbours_together(centres: FloatArray) -> NDArray[np.intp]:
    """Return an order of points (m, 3) in which every `GROUP` in turn lie near each other: halves of halves.

    Stretches of one length are sorted and halved together.
    """
    columns = np.ascontiguousarray(centres.T)
    order = np.arange(len(centres))
    stretches = {len(order): [np.zeros(1, dtype=np.intp)]}  # by length, where they begin
    while stretches:
        halves: dict[int, list[NDArray[np.intp]]] = {}
        for length, begins in stretches.items():
            if length <= GROUP:
                continue
            begin = np.concatenate(begins)
            members = begin[:, None] + np.arange(length)
            rows = order[members]
            placed = columns[:, rows]
            along = placed[np.argmax(_spans(placed), axis=0), np.arange(len(begin))]
            order[members] = np.take_along_axis(rows, np.argsort(along, axis=1, kind="stable"), axis=1)
            half = -(-length // (2 * GROUP)) * GROUP
            halves.setdefault(half, []).append(begin)
            halves.setdefault(length - half, []).append(begin + half)
        stretches = halves
    return order


def _spans(placed: FloatArray) -> FloatArray:
    """Return how far (3, k) the members (3, k, n) of each stretch lie apart along each axis."""
    if placed.shape[1] > placed.shape[2]:  # numpy is slow along short rows
        placed, axis = np.ascontiguousarray(placed.transpose(0, 2, 1)), 1
    else:
        axis = 2
    spans: FloatArray = placed.max(axis=axis) - placed.min(axis=axis)
    return spans


def _first_of_each(groups: NDArray[np.intp], count: int) -> NDArray[np.bool_]:
    """Tell (k, GROUP) which members of groups (k,) are there, of so many triangles, and not just fill the last up."""
    there: NDArray[np.bool_] = groups[:, None] * GROUP + np.arange(GROUP) < count
    return there


def _groups_near(low: FloatArray, high: FloatArray, lows: FloatArray, highs: FloatArray, reach: float) -> Rows | None:
    """Return the pairs of indices of the boxes (n, 3) and (m, 3) that come within `reach`, None where far too many."""
    theirs = _near_box(lows, highs, low, high, reach)
    ours = _near_box(low, high, lows[theirs], highs[theirs], reach)
    boxes = low[ours], high[ours], lows[theirs], highs[theirs]
    if len(ours) * len(theirs) <= MOST_COMPARED:
        i, j = _near_each_other(*boxes, reach)
        return ours[i], theirs[j]
    starts, their_starts = np.arange(0, len(ours), GROUP), np.arange(0, len(theirs), GROUP)
    wider = _groups_near(
        np.minimum.reduceat(boxes[0], starts),
        np.maximum.reduceat(boxes[1], starts),
        np.minimum.reduceat(boxes[2], their_starts),
        np.maximum.reduceat(boxes[3], their_starts),
        reach,
    )
    if wider is None or len(wider[0]) * GROUP**2 > MOST_BOXES_COMPARED:
        return None
    within = np.arange(GROUP)
    i = (wider[0][:, None, None] * GROUP + within[:, None]).repeat(GROUP, axis=2).reshape(-1)
    j = (wider[1][:, None, None] * GROUP + within).repeat(GROUP, axis=1).reshape(-1)
    there = (i < len(ours)) & (j < len(theirs))
    i, j = ours[i[there]], theirs[j[there]]
    near = _within(low[i], high[i], lows[j], highs[j], reach)
    return i[near], j[near]


def _near_box(low: FloatArray, high: FloatArray, lows: FloatArray, highs: FloatArray, reach: float) -> NDArray[np.intp]:
    """Return the indices of the boxes (n, 3) that come within `reach` of the box around the other boxes (m, 3)."""
    if not len(lows):
        return np.empty(0, dtype=np.intp)
    return np.flatnonzero(_within(low, high, lows.min(axis=0), highs.max(axis=0), reach))


def _near_each_other(low: FloatArray, high: FloatArray, lows: FloatArray, highs: FloatArray, reach: float) -> Rows:
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
    """Return which boxes come within `reach` of each other, (..., 3) against (..., 3)."""
    apart = np.maximum(np.maximum(others_low - high, low - others_high), 0.0)
    near: NDArray[np.bool_] = np.einsum("...d,...d->...", apart, apart) <= reach**2
    return near
