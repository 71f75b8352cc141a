"""Bounds on polynomial curves over short intervals: the hull of the Bernstein control points holds the curve."""

from __future__ import annotations

from functools import cache
from math import ceil, comb, frexp, ldexp, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import FloatArray
from ..geometry.vector import Vector
from .acceleration_set import AccelerationSet, ball, between

#: An interval is cut into half as many cells to as many, each with its own control points.
CELLS = 16
#: The last cell is cut short to a multiple of this part of it: at most 1% beyond the interval's end.
PARTS = 16
EPSILON = float(np.finfo(float).eps)


class Arc(NamedTuple):
    """The curve sum coefficients[k] s^k over s >= 0.

    Attributes:
        coefficients: (degree + 1, 3).
        sizes: (degree + 1,), at least the norm of every term that went into each coefficient: rounding scales with it.
        unit: cells are this long or a power of two times it, so that the bounds never decrease with the duration.
    """

    coefficients: FloatArray
    sizes: FloatArray
    unit: float = 1.0

    def away_from(self, place: FloatArray, size: float) -> Arc:
        """Return the curve less a place, (3,), whose terms add up to `size`."""
        coefficients, sizes = self.coefficients.copy(), self.sizes.copy()
        coefficients[0] -= place
        sizes[0] += size
        return Arc(coefficients, sizes, self.unit)

    def from_start(self) -> Arc:
        """Return the curve less its start."""
        coefficients, sizes = self.coefficients.copy(), self.sizes.copy()
        coefficients[0] = sizes[0] = 0.0
        return Arc(coefficients, sizes, self.unit)

    def derivative(self) -> Arc:
        """Return the curve's derivative."""
        if len(self.sizes) == 1:
            return Arc(0.0 * self.coefficients, 0.0 * self.sizes, self.unit)
        orders = _orders(len(self.sizes))[1:]
        return Arc(orders[:, None] * self.coefficients[1:], orders * self.sizes[1:], self.unit)

    def shifted(self, start: float) -> Arc:
        """Return the curve with s counted from `start`."""
        count = len(self.sizes)
        powers = np.zeros(count + 1)
        powers[:count] = start ** _orders(count)
        matrix = _binomials(count) * powers[_orders_apart(count)]
        return Arc(matrix @ self.coefficients, np.abs(matrix) @ self.sizes, self.unit)

    def supremum(self, duration: float) -> float:
        """Return an upper bound on the norm over 0 <= s <= duration, non-decreasing in the duration."""
        points, _, _, rounding = self._control_points(duration)
        return sqrt(np.einsum("pd,pd->p", points, points).max()) + rounding

    def spread(self, duration: float) -> tuple[Vector, AccelerationSet]:
        """Return the middle of the values over 0 <= s <= duration, and where they lie about it.

        On a straight segment for degree 1, in a box around the control points for more.
        """
        count = len(self.sizes)
        if count <= 2:
            (x, y, z), (u, v, w) = self.coefficients[0].tolist(), (duration * self.coefficients[-1]).tolist()
            steady, varying = between((x, y, z), (x + u, y + v, z + w) if count == 2 else (x, y, z))
            rounding = 4.0 * EPSILON * float(self.sizes @ duration ** _orders(count))
            return steady, varying.plus(ball(rounding))
        points, _, _, rounding = self._control_points(duration)
        low, high = points.min(axis=0), points.max(axis=0)
        x, y, z = (0.5 * (low + high)).tolist()
        u, v, w = (0.5 * (high - low)).tolist()
        return (x, y, z), AccelerationSet(rounding, (), ((u, 0.0, 0.0), (0.0, v, 0.0), (0.0, 0.0, w)))

    def integral(self, duration: float) -> float:
        """Return an upper bound on the integral of the norm over [0, duration], non-decreasing in the duration.

        The norm is below the same blend of the control points' norms, whose mean its integral is.
        """
        points, length, part, rounding = self._control_points(duration)
        norms, count = np.linalg.norm(points, axis=1), len(self.sizes)
        total = float(norms.sum()) - (1.0 - part) * float(norms[-count:].sum())
        return total / count * length + duration * rounding

    def _control_points(self, duration: float) -> tuple[FloatArray, float, float, float]:
        """Return the control points, cell by cell, and what the cells are.

        Cells of equal length from the start, the last cut short. Their length is unit / CELLS times the power of two
        that makes CELLS of them reach the end. A longer duration adds cells, lengthens the last, or joins them in
        pairs: the new hulls hold the old.

        Returns:
            The points, (cells * (degree + 1), 3); the length of a cell; the part of it that the last one has; and what
            floating point may take off a control point, every entry of the matrices being at most 1.
        """
        count = len(self.sizes)
        fraction, exponent = frexp(duration / self.unit)
        if fraction == 0.5:
            fraction, exponent = 1.0, exponent - 1
        whole = ldexp(self.unit, exponent) if fraction > 0.0 else 0.0
        ticks = max(1, ceil(fraction * CELLS * PARTS))
        cells = -(-ticks // PARTS)
        powers = whole ** _orders(count)
        points = cell_matrix(count)[: cells * count] @ (self.coefficients * powers[:, None])
        part = ticks - PARTS * (cells - 1)
        if part < PARTS:
            points[-count:] = _cuts(count)[part] @ points[-count:]
        reached = _powers_of_ticks(count)[ticks] @ (self.sizes * powers)
        rounding = 4.0 * (count + 1.0) * EPSILON * float(reached)
        return points, whole / CELLS, part / PARTS, rounding


@cache
def cell_matrix(count: int) -> FloatArray:
    """Return (CELLS * count, count): from `count` coefficients over [0, 1] to the control points of each cell.

    A control point of s^k is the mean of all products of k of the arguments (i times the cell's end, otherwise its
    start), hence between 0 and 1.
    """
    degree = count - 1
    matrix = np.empty((CELLS, count, count))
    for cell in range(CELLS):
        for i in range(count):
            for k in range(count):
                ways = (comb(i, m) * comb(degree - i, k - m) * (cell + 1) ** m * cell ** (k - m) for m in range(k + 1))
                matrix[cell, i, k] = sum(ways) / (comb(degree, k) * CELLS**k)
    return matrix.reshape(CELLS * count, count)


@cache
def _cuts(count: int) -> FloatArray:
    """Return (PARTS + 1, count, count): from a cell's control points to those of its first k / PARTS (de Casteljau)."""
    parts = np.arange(PARTS + 1.0)[:, None, None] / PARTS
    orders = np.arange(count)
    fewer = np.maximum(orders[:, None] - orders[None, :], 0)
    return np.asarray(_binomials(count).T * parts**orders * (1.0 - parts) ** fewer)


@cache
def _powers_of_ticks(count: int) -> FloatArray:
    """Return (CELLS * PARTS + 1, count): the powers of k / (CELLS * PARTS)."""
    return np.asarray((np.arange(CELLS * PARTS + 1.0) / (CELLS * PARTS))[:, None] ** np.arange(count))


@cache
def _orders(count: int) -> FloatArray:
    """Return 0, 1, ... count - 1."""
    return np.arange(float(count))


@cache
def _binomials(count: int) -> FloatArray:
    """Return (count, count): comb(k, j) in row j and column k."""
    return np.array([[float(comb(k, j)) for k in range(count)] for j in range(count)])


@cache
def _orders_apart(count: int) -> NDArray[np.int64]:
    """Return (count, count): k - j in row j and column k, `count` where it is negative."""
    apart = np.arange(count)[None, :] - np.arange(count)[:, None]
    return np.where(apart < 0, count, apart)
