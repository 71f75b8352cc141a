"""How far a body extends: balls around it, and the points that span it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.vector import Vector
from .scene import Body, used_vertices


@dataclass(frozen=True, slots=True)
class Ball:
    """All points within `radius` (m) of `centre`."""

    centre: Vector
    radius: float


@dataclass(frozen=True, eq=False)
class Extent:
    """A body's points in its own frame: those that span it, each rounded by its radius, and a ball around all.

    Attributes:
        points: (n, 3) m.
        radii: (n,) m, each point stands for the ball of this radius about it.
    """

    points: FloatArray
    radii: FloatArray
    ball: Ball

    @cached_property
    def high(self) -> FloatArray:
        """The high corner (3,) m of the box around all, along the body's axes."""
        corner: FloatArray = (self.points + self.radii[:, None]).max(axis=0)
        return corner


def bounding_ball(points: FloatArray) -> Ball:
    """Return a ball about the middle of the points' bounding box, (n, 3) m."""
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    x, y, z = centre.tolist()
    return Ball((x, y, z), float(np.max(np.linalg.norm(points - centre, axis=1))))


def body_extents(bodies: Sequence[Body]) -> dict[int, Extent]:
    """Return the extents of the bodies that have shapes, by index; bodies of the same shapes share one."""
    made: dict[tuple[tuple[int, float, bytes], ...], Extent] = {}
    extents: dict[int, Extent] = {}
    for index, body in enumerate(bodies):
        if body.shapes:
            shapes = tuple((id(shape.mesh), shape.radius, shape.pose.tobytes()) for shape in body.shapes)
            if shapes not in made:
                made[shapes] = body_extent(body)
            extents[index] = made[shapes]
    return extents


def body_extent(body: Body) -> Extent:
    """Return the points that span a body (its cores' vertices, each rounded by its shape's radius) and a ball."""
    points, radii = [], []
    for shape in body.shapes:
        used = used_vertices(shape.mesh)
        points.append(used @ shape.pose[:3, :3].T + shape.pose[:3, 3])
        radii.append(np.full(len(used), shape.radius))
    spanning, rounding = np.vstack(points), np.concatenate(radii)
    centre = 0.5 * ((spanning - rounding[:, None]).min(axis=0) + (spanning + rounding[:, None]).max(axis=0))
    x, y, z = centre.tolist()
    radius = float(np.max(np.linalg.norm(spanning - centre, axis=1) + rounding))
    return Extent(spanning, rounding, Ball((x, y, z), radius))
