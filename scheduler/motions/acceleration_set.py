"""Where a vector that varies may be about its middle: what bounds an acceleration direction by direction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.transform import crossed, turned
from ..geometry.vector import Vector, add, cross, dot, norm, scale, subtract

#: Axes that differ by no more than this (the sine) are one: rounding of poses turns them by as much.
PARALLEL = 1e-14


class Spread(NamedTuple):
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
    def size(self) -> float:
        """Above the norm of every vector in it."""
        return self.ball + sum(radius for _, radius in self.discs) + sum(map(norm, self.lines))

    def plus(self, other: Spread) -> Spread:
        """Return the sum of two."""
        return Spread(self.ball + other.ball, self.discs + other.discs, self.lines + other.lines)

    def turned(self, frame: FloatArray) -> Spread:
        """Return it in the frame that `frame` (4x4) maps to."""
        discs = tuple((turned(frame, normal), radius) for normal, radius in self.discs)
        return Spread(self.ball, discs, tuple(turned(frame, line) for line in self.lines))

    def turning(self, axis: Vector) -> Spread:
        """Return what holds it however it is turned about the unit vector `axis`."""
        along = across = 0.0
        for normal, radius in self.discs:
            along += radius * norm(cross(normal, axis))
            across += radius
        for line in self.lines:
            along += abs(dot(line, axis))
            across += norm(subtract(line, scale(dot(line, axis), axis)))
        return Spread(self.ball, ((axis, across),), (scale(along, axis),))

    def reach(self, direction: Vector) -> float:
        """Return the farthest that it reaches along a unit vector."""
        reach = self.ball
        for normal, radius in self.discs:
            reach += radius * norm(cross(direction, normal))
        for line in self.lines:
            reach += abs(dot(direction, line))
        return reach

    def along(self, directions: FloatArray) -> FloatArray:
        """Return the same along many (..., 3)."""
        farthest: FloatArray = np.full(directions.shape[:-1], self.ball)
        for normal, radius in self.discs:
            farthest += radius * np.linalg.norm(crossed(directions, np.array(normal)), axis=-1)
        for line in self.lines:
            farthest += np.abs(directions @ np.array(line))
        return farthest


STILL = Spread()


def ball(radius: float) -> Spread:
    """Return a ball."""
    return Spread(radius)


def disc(normal: Vector, radius: float) -> Spread:
    """Return a disc across the unit vector `normal`."""
    return Spread(0.0, ((normal, radius),))


def across(axis: Vector | None, radius: float) -> Spread:
    """Return the disc across an axis, the ball where there is none."""
    return ball(radius) if axis is None else disc(axis, radius)


def shared(one: Vector | None, other: Vector | None) -> Vector | None:
    """Return the axis that two unit vectors have in common, None where they are not parallel."""
    if one is None or other is None or norm(cross(one, other)) > PARALLEL:
        return None
    return one


def between(one: Vector, other: Vector) -> tuple[Vector, Spread]:
    """Return the middle of the segment between two vectors, and its spread."""
    return scale(0.5, add(one, other)), Spread(0.0, (), (scale(0.5, subtract(other, one)),))
