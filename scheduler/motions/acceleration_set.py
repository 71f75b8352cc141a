"""A set that an acceleration stays in, given by its support function: a zonoid and a ball."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.transform import crossed, turned
from ..geometry.vector import Vector, add, cross, dot, norm, scale, subtract

#: Axes that differ by no more than this (the sine) are one: rounding of poses turns them by as much.
PARALLEL_AXES = 1e-14


class AccelerationSet(NamedTuple):
    """The sum (Minkowski) of a ball, flat discs and segments, all about 0.

    Attributes:
        ball: radius.
        discs: the unit normal and the radius of each.
        lines: half of each segment.
    """

    ball: float = 0.0
    discs: tuple[tuple[Vector, float], ...] = ()
    lines: tuple[Vector, ...] = ()

    @property
    def norm_bound(self) -> float:
        """Above the norm of every vector in it."""
        return self.ball + sum(radius for _, radius in self.discs) + sum(map(norm, self.lines))

    def plus(self, other: AccelerationSet) -> AccelerationSet:
        """Return the sum of two."""
        return AccelerationSet(self.ball + other.ball, self.discs + other.discs, self.lines + other.lines)

    def turned(self, frame: FloatArray) -> AccelerationSet:
        """Return it in the frame that `frame` (4x4) maps to."""
        discs = tuple((turned(frame, normal), radius) for normal, radius in self.discs)
        return AccelerationSet(self.ball, discs, tuple(turned(frame, line) for line in self.lines))

    def swept_about(self, axis: Vector) -> AccelerationSet:
        """Return a set that holds this one however it is turned about the unit vector `axis`."""
        along = across = 0.0
        for normal, radius in self.discs:
            along += radius * norm(cross(normal, axis))
            across += radius
        for line in self.lines:
            along += abs(dot(line, axis))
            across += norm(subtract(line, scale(dot(line, axis), axis)))
        return AccelerationSet(self.ball, ((axis, across),), (scale(along, axis),))

    def support(self, direction: Vector) -> float:
        """Return the support function: the largest product of a vector in it with a unit vector."""
        most = self.ball
        for normal, radius in self.discs:
            most += radius * norm(cross(direction, normal))
        for line in self.lines:
            most += abs(dot(direction, line))
        return most

    def supports(self, directions: FloatArray) -> FloatArray:
        """Return the support function of many unit vectors (..., 3)."""
        farthest: FloatArray = np.full(directions.shape[:-1], self.ball)
        for normal, radius in self.discs:
            farthest += radius * np.linalg.norm(crossed(directions, np.array(normal)), axis=-1)
        for line in self.lines:
            farthest += np.abs(directions @ np.array(line))
        return farthest


STILL = AccelerationSet()


def ball(radius: float) -> AccelerationSet:
    """Return a ball."""
    return AccelerationSet(radius)


def disc(normal: Vector, radius: float) -> AccelerationSet:
    """Return a disc across the unit vector `normal`."""
    return AccelerationSet(0.0, ((normal, radius),))


def across(axis: Vector | None, radius: float) -> AccelerationSet:
    """Return the disc across an axis, the ball where there is none."""
    return ball(radius) if axis is None else disc(axis, radius)


def shared(one: Vector | None, other: Vector | None) -> Vector | None:
    """Return the axis that two unit vectors have in common, None where they are not parallel."""
    if one is None or other is None or norm(cross(one, other)) > PARALLEL_AXES:
        return None
    return one


def between(one: Vector, other: Vector) -> tuple[Vector, AccelerationSet]:
    """Return the middle of the segment between two vectors, and its spread."""
    return scale(0.5, add(one, other)), AccelerationSet(0.0, (), (scale(0.5, subtract(other, one)),))
