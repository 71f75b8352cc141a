"""Which axis-aligned boxes overlap: a grid for each size of box, rebuilt when enough boxes have changed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import FloatArray, IntArray

#: Cells lie this many to either side of the origin; what lies beyond is in the outermost.
_FARTHEST_CELL = (1 << 19) - 1
_CELL_BITS = 20
#: A box that spans more columns of cells than this is held against all boxes of that size instead.
_MOST_COLUMNS = 256
#: The grids are built anew once the boxes that changed have been held one by one against this many others for each box.
_CHECKS_A_BOX = 30

Couples = tuple[IntArray, IntArray]


class _Layer(NamedTuple):
    """The boxes whose longest side is at most `cell` (m), and more than half of it: sorted by the cell of their middle.

    Attributes:
        keys: (n,) of the cells, rising.
        members: (n,) the boxes.
    """

    cell: float
    keys: IntArray
    members: IntArray


class BoxGrid:
    """Boxes by number, which come and are replaced.

    Attributes:
        low, high: (n, 3) m; of a box that has not come yet, nan.
    """

    def __init__(self, boxes: int) -> None:
        """Make room for so many boxes."""
        self.low = np.full((boxes, 3), np.nan)
        self.high = np.full((boxes, 3), np.nan)
        self._layers: list[_Layer] = []
        self._changed = np.zeros(boxes, dtype=bool)
        self._checks = 0

    def put(self, boxes: IntArray, low: FloatArray, high: FloatArray) -> None:
        """Place boxes, new ones or in place of the old."""
        self.low[boxes], self.high[boxes] = low, high
        self._changed[boxes] = True

    def meet(self, one: IntArray, other: IntArray) -> NDArray[np.bool_]:
        """Tell of pairs of boxes whether they have a point in common; those that have not come do not."""
        meet = np.ones(len(one), dtype=bool)
        for low, high in zip(self.low.T, self.high.T, strict=True):  # a column at a time, which is quicker
            meet &= (low[one] <= high[other]) & (low[other] <= high[one])
        return meet

    def meeting(self, boxes: IntArray) -> Couples:
        """Return all pairs of a box of `boxes`, each named once, and any other that it meets, each pair once."""
        changed = np.flatnonzero(self._changed)
        self._checks += len(boxes) * len(changed)
        if self._checks > _CHECKS_A_BOX * len(self.low):
            self._build()
            changed = changed[:0]
        found = [_every(boxes, changed), *(couples for layer in self._layers for couples in self._near(boxes, layer))]
        one, other = (np.concatenate(side) for side in zip(*found, strict=True))
        asked = np.zeros(len(self.low), dtype=bool)
        asked[boxes] = True
        once = np.where(asked[other], one < other, True)
        one, other = one[once], other[once]
        meeting = self.meet(one, other)
        return one[meeting], other[meeting]

    def _build(self) -> None:
        """Sort all boxes into the grids of their sizes."""
        present = np.flatnonzero(~np.isnan(self.low[:, 0]))
        sides = (self.high[present] - self.low[present]).max(axis=1)
        _, exponents = np.frexp(np.maximum(sides, np.finfo(float).tiny))
        self._layers = []
        for exponent in np.unique(exponents).tolist():
            members = present[exponents == exponent]
            cell = float(np.ldexp(1.0, exponent))
            cells = _cells(0.5 * (self.low[members] + self.high[members]), cell)
            keys = _keys(cells[:, 0], cells[:, 1], cells[:, 2])
            order = np.argsort(keys, kind="stable")
            self._layers.append(_Layer(cell, keys[order], members[order]))
        self._changed[:] = False
        self._checks = 0

    def _near(self, boxes: IntArray, layer: _Layer) -> Iterator[Couples]:
        """Yield pairs of boxes and unchanged ones of a layer, among which are all that meet."""
        # The middle of a box that meets another lies within half a cell of it.
        least = _cells(self.low[boxes] - 0.501 * layer.cell, layer.cell)
        most = _cells(self.high[boxes] + 0.501 * layer.cell, layer.cell)
        across = most[:, 1] - least[:, 1] + 1
        columns = (most[:, 0] - least[:, 0] + 1) * across
        wide = columns > _MOST_COLUMNS
        for box in boxes[wide].tolist():
            yield self._unchanged(_every(np.array([box]), layer.members[self._overlapping(box, layer.members)]))
        asked = np.flatnonzero(~wide)
        query, column = _expanded(asked, columns[asked])
        x = least[query, 0] + column // across[query]
        y = least[query, 1] + column % across[query]
        first = np.searchsorted(layer.keys, _keys(x, y, least[query, 2]), side="left")
        last = np.searchsorted(layer.keys, _keys(x, y, most[query, 2]), side="right")
        place, offset = _expanded(np.arange(len(query)), last - first)
        yield self._unchanged((boxes[query[place]], layer.members[first[place] + offset]))

    def _overlapping(self, box: int, members: IntArray) -> NDArray[np.bool_]:
        return self.meet(np.full(len(members), box), members)

    def _unchanged(self, couples: Couples) -> Couples:
        """Leave out those that the grids have in an old place."""
        one, other = couples
        kept = ~self._changed[other] & (one != other)
        return one[kept], other[kept]


def _every(one: IntArray, other: IntArray) -> Couples:
    """Return every pair of one of the first and one of the second that are not the same."""
    first, second = np.repeat(one, len(other)), np.tile(other, len(one))
    differ = first != second
    return first[differ], second[differ]


def _cells(points: FloatArray, cell: float) -> IntArray:
    """Return the cells (n, 3) that points (n, 3) m lie in, the outermost for those beyond."""
    numbers = np.clip(np.floor(points / cell), -_FARTHEST_CELL, _FARTHEST_CELL)
    return numbers.astype(np.int64)


def _keys(x: IntArray, y: IntArray, z: IntArray) -> IntArray:
    """Return one number a cell: cells of one x and y follow each other by z."""
    middle = _FARTHEST_CELL + 1
    keys: IntArray = ((x + middle) << (2 * _CELL_BITS)) | ((y + middle) << _CELL_BITS) | (z + middle)
    return keys


def _expanded(values: IntArray, counts: IntArray) -> tuple[IntArray, IntArray]:
    """Return each value as often as its count says, and 0, 1, 2 ... beside it."""
    repeated = np.repeat(values, counts)
    begins = np.cumsum(counts) - counts
    return repeated, np.arange(len(repeated)) - np.repeat(begins, counts)
