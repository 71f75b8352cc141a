"""Lines through points, and where they meet a closed skin: how often it winds around a point, how far a line goes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .rotation import FloatArray

#: By this share of the coordinates places on a line may be wrong.
ROUNDING = 256.0 * 2.0**-52
#: Cells of the grid that a triangle lies in, on the average, at most.
MOST_CELLS = 8
#: Directions of the lines, each both ways.
DIRECTIONS = 13
#: In search of the outside: bends of a path, and points from which it goes on after each, at most.
BENDS = 12
FRONTIER = 256


class Met(NamedTuple):
    """What the lines through points (k, 3) meet.

    Attributes:
        winding: (k,) how often the skin winds around each; nan where an edge is too near to the line to tell.
        ahead, behind: (k,) m, how far the line is free from the point on, along the direction and against it; inf
            where it meets nothing. Errs low.
    """

    winding: FloatArray
    ahead: FloatArray
    behind: FloatArray


class Lines:
    """The triangles of a skin, to be met by lines along one direction."""

    def __init__(self, corners: FloatArray, axes: FloatArray) -> None:
        """Take the corners (m, 3, 3) m, and two axes and the direction as rows (3, 3) of a rotation."""
        self._axes = axes
        self.direction = axes[2]
        self._corners = corners @ axes.T
        self._slack = ROUNDING * float(np.abs(corners).max())
        a, b, c = (self._corners[:, k] for k in range(3))
        self._facing = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
        flat = self._corners[:, :, :2]
        low, high = flat.min(axis=1) - 2.0 * self._slack, flat.max(axis=1) + 2.0 * self._slack
        self._origin = low.min(axis=0)
        side = np.maximum(high.max(axis=0) - self._origin, 2.0**-1000)
        cells = max(1, int(np.sqrt(len(corners))))
        while True:
            self._cells, self._scale = cells, cells / side
            first, last = self._cell(low), self._cell(high)
            counts = np.prod(last - first + 1, axis=1)
            if cells == 1 or counts.sum() <= MOST_CELLS * len(corners) + 1000:
                break
            cells //= 2
        owners = np.repeat(np.arange(len(corners)), counts)
        rank = np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)
        width = (last - first + 1)[owners, 0]
        column, row = first[owners, 0] + rank % width, first[owners, 1] + rank // width
        places = column * cells + row
        order = np.argsort(places, kind="stable")
        self._members = owners[order]
        self._starts = np.searchsorted(places[order], np.arange(cells * cells + 1))

    def _cell(self, points: FloatArray) -> NDArray[np.int64]:
        """Return the cells (k, 2) of places (k, 2) across the direction."""
        cells: NDArray[np.int64] = np.clip((points - self._origin) * self._scale, 0, self._cells - 1).astype(np.int64)
        return cells

    def meet(self, points: FloatArray) -> Met:
        """Return what the lines through points (k, 3) m meet."""
        placed = points @ self._axes.T
        cells = self._cell(placed[:, :2])
        place = cells[:, 0] * self._cells + cells[:, 1]
        counts = self._starts[place + 1] - self._starts[place]
        of = np.repeat(np.arange(len(points)), counts)
        rank = np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts)
        triangles = self._members[self._starts[place[of]] + rank]
        corners, here = self._corners[triangles], placed[of]
        slack = self._slack + ROUNDING * np.abs(placed).max(initial=0.0)
        flat = corners[:, :, :2] - here[:, None, :2]
        ends = np.roll(flat, -1, axis=1)
        sides = flat[:, :, 0] * ends[:, :, 1] - flat[:, :, 1] * ends[:, :, 0]
        doubt = slack * (np.abs(flat).sum(axis=2) + np.abs(ends).sum(axis=2)) + slack**2
        facing = self._facing[triangles]
        turn = np.where(facing < 0.0, -1.0, 1.0)
        near = (sides * turn[:, None] >= -doubt).all(axis=1)
        sure = (sides * turn[:, None] > doubt).all(axis=1)
        of, corners, here, sides = of[near], corners[near], here[near], sides[near]
        sure, turn = sure[near], turn[near]
        total = sides.sum(axis=1)
        with np.errstate(all="ignore"):
            shares = np.roll(sides, -1, axis=1) / total[:, None]
            height = (shares * corners[:, :, 2]).sum(axis=1) - here[:, 2]
            error = slack + np.abs(doubt[near].sum(axis=1) / total) * np.ptp(corners[:, :, 2], axis=1)
        low, high = corners[:, :, 2].min(axis=1) - here[:, 2] - slack, corners[:, :, 2].max(axis=1) - here[:, 2] + slack
        sure &= np.isfinite(height) & (np.abs(height) > error)
        low, high = np.where(sure, height - error, low), np.where(sure, height + error, high)
        winding = np.zeros(len(points))
        np.add.at(winding, of[sure & (height > 0.0)], turn[sure & (height > 0.0)])
        winding[of[~sure & (high > 0.0)]] = np.nan
        ahead, behind = np.full(len(points), np.inf), np.full(len(points), np.inf)
        np.minimum.at(ahead, of[high > 0.0], np.maximum(low[high > 0.0], 0.0))
        np.minimum.at(behind, of[low < 0.0], np.maximum(-high[low < 0.0], 0.0))
        return Met(winding, ahead, behind)


class Surroundings:
    """What lies around points beside a skin, as lines along many directions tell."""

    def __init__(self, corners: FloatArray) -> None:
        """Take the skin's corners (m, 3, 3) m, normals outwards."""
        self._origin = corners[0, 0]  # of all that is looked at: how far away a mesh is does not count
        self._corners = corners - self._origin
        self._lines: list[Lines] = []

    def _along(self, direction: int) -> Lines:
        while len(self._lines) <= direction:
            self._lines.append(Lines(self._corners, _axes(len(self._lines))))
        return self._lines[direction]

    def windings(self, points: FloatArray) -> FloatArray:
        """Return (k,) how often the skin winds around points (k, 3) m; nan where none of the lines can tell."""
        placed, found = points - self._origin, np.full(len(points), np.nan)
        for direction in range(DIRECTIONS):
            left = np.flatnonzero(np.isnan(found))
            if not len(left):
                break
            found[left] = self._along(direction).meet(placed[left]).winding
        return found

    def open(self, points: FloatArray) -> NDArray[np.bool_]:
        """Tell from which points (k, 3) m a path is found that leads away and never meets the skin."""
        free = np.zeros(len(points), dtype=bool)
        frontier, origins = points - self._origin, np.arange(len(points))
        for _ in range(BENDS):
            steps, lengths, starts = [], [], []
            for direction in range(DIRECTIONS):
                lines = self._along(direction)
                met = lines.meet(frontier)
                free[origins[np.isinf(met.ahead) | np.isinf(met.behind)]] = True
                left = ~free[origins]
                frontier, origins = frontier[left], origins[left]
                for way, length in ((1.0, met.ahead[left]), (-1.0, met.behind[left])):
                    steps.append(frontier + way * 0.5 * length[:, None] * lines.direction)
                    lengths.append(length)
                    starts.append(origins)
            step, length, start = np.concatenate(steps), np.concatenate(lengths), np.concatenate(starts)
            going = np.flatnonzero(~free[start] & (length > 0.0))
            going = going[_farthest(length[going], start[going], max(1, FRONTIER // max(1, int((~free).sum()))))]
            frontier, origins = step[going], start[going]
        return free


def _farthest(lengths: FloatArray, origins: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    """Return those of each origin that have the greatest lengths, `most` of each."""
    order = np.lexsort((-lengths, origins))
    sorted_origins = origins[order]
    rank = np.arange(len(order)) - np.searchsorted(sorted_origins, sorted_origins)
    return order[rank < most]


def _axes(number: int) -> FloatArray:
    """Return a rotation (3, 3) whose last row points along the so manieth direction, none along a coordinate axis."""
    golden = np.pi * (3.0 - np.sqrt(5.0))
    height = 1.0 - (number + 0.37) / DIRECTIONS
    around = golden * number + 0.271
    z = np.array([np.sqrt(1.0 - height**2) * np.cos(around), np.sqrt(1.0 - height**2) * np.sin(around), height])
    x = np.cross(z, [0.37, -0.59, 0.72])
    x /= np.linalg.norm(x)
    axes: FloatArray = np.stack((x, np.cross(z, x), z))
    return axes
