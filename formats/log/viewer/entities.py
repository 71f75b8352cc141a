"""The bodies as scene entities: drawn once for the run, or as a crowd of boxes, and in red while in contact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.timestamp_pb2 import Timestamp

from ....scheduler.scene import Body, FloatArray
from .colours import FIXED, MOVING, RED, RGB, colour
from .crowd import Crowd
from .drawings import Drawings
from .transforms import WORLD
from .wire import embedded

# Bodies let the markers on them and in them show.
_OPACITY = 0.65
_OPACITY_IN_RED = 0.6

# Triangles. A colliding body with more is marked by its box: it is drawn anew in every snapshot.
_MOST_IN_RED = 5_000

# Of the body's own diagonal: how far its red skin stands off it, so that neither shows through the other, and how far
# the skin's origin lies over the body's.
_SKIN = 0.004
_RAISED = 0.05

_IDENTITY: FloatArray = np.eye(4)


class BodyEntities:
    """One entity a body, named as the body: in the body's own frame if it moves, else in the world's.

    What moves and has no frame of its own is a crowd: boxes in the world, all one entity.

    Attributes:
        boxed: how many bodies are drawn as boxes, for want of triangles.
        crowd: the bodies without an entity of their own; None if there are none.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        moving: Sequence[bool],
        framed: Sequence[bool],
        poses: FloatArray,
        drawings: Drawings,
        triangles: int,
    ) -> None:
        """Take the bodies and which of them ever move.

        Args:
            bodies: in document order.
            moving: of each body, whether it ever moves.
            framed: of each body, whether it moves and has a frame of its own.
            poses: (n, 4, 4) world_from_body at the start, which bodies that do not move keep.
            drawings: of the same bodies.
            triangles: how many may be drawn in all; first come, first served.
        """
        self._bodies = bodies
        self._framed = framed
        self._poses = poses
        self._drawings = drawings
        self._colours = _colours(bodies, moving)
        crowded = [bool(body.shapes) and moving[k] and not framed[k] for k, body in enumerate(bodies)]
        self._single = [index for index, body in enumerate(bodies) if body.shapes and not crowded[index]]
        counts = [0 if apart else count for count, apart in zip(drawings.triangles, crowded, strict=True)]
        self._exact = _affordable(counts, triangles)
        self.boxed = sum(1 for index in self._single if not self._exact[index])
        members = [index for index, apart in enumerate(crowded) if apart]
        colours = [self._colours[index] for index in members]
        self.crowd = Crowd(members, drawings.outlines, colours, _OPACITY, poses) if members else None

    def all(self, stamp: Timestamp) -> bytes:
        """Return a SceneUpdate with every body that has a shape and is not of the crowd."""
        entities = [self._entity(index, stamp, self._drawn(index)) for index in self._single]
        return b"".join(embedded(SceneUpdate.ENTITIES_FIELD_NUMBER, entity) for entity in entities)

    def in_red(self, index: int, stamp: Timestamp, world_from_body: FloatArray) -> bytes:
        """Return the entity that covers a body in red, given its pose (4x4) now.

        Its origin lies over the body's, so that a viewer that looks from above paints it after the body.
        """
        low, high = self._drawings.outlines[index].min(axis=0), self._drawings.outlines[index].max(axis=0)
        size = float(np.linalg.norm(high - low))
        placement, red = self._placement(index, world_from_body), colour(RED, _OPACITY_IN_RED)
        if self._drawings.triangles[index] > _MOST_IN_RED:
            return self._entity(index, stamp, self._drawings.box(index, placement, red, _SKIN * size))
        origin = 0.5 * (low + high) + _RAISED * size * world_from_body[2, :3]  # that row is the world's z axis
        skin = self._drawings.triangulated(index, placement, red, origin, _SKIN * size)
        return self._entity(index, stamp, skin)

    def roof(self, index: int, world_from_body: FloatArray) -> float:
        """Return the height (m, z in the world) of a body's highest point, given its pose (4x4) now; errs low."""
        heights = self._drawings.outlines[index] @ world_from_body[2, :3]
        return float(heights.max() + world_from_body[2, 3])

    def _drawn(self, index: int) -> bytes:
        placement, paint = self._placement(index, self._poses[index]), colour(self._colours[index], _OPACITY)
        if not self._exact[index]:
            return self._drawings.box(index, placement, paint)
        if self._framed[index] or self._drawings.triangles[index] == 0:
            return self._drawings.exact(index, placement, paint)
        # What stands still is painted from its foot, before what moves in it and on it.
        foot = self._drawings.outlines[index][np.argmin(self._drawings.outlines[index] @ placement[2, :3])]
        return self._drawings.triangulated(index, placement, paint, foot)

    def _placement(self, index: int, world_from_body: FloatArray) -> FloatArray:
        """Return the pose (4x4) of a body in its entity's frame, given that in the world."""
        return _IDENTITY if self._framed[index] else world_from_body

    def _entity(self, index: int, stamp: Timestamp, primitives: bytes) -> bytes:
        name = self._bodies[index].name
        frame = name if self._framed[index] else WORLD
        head: bytes = SceneEntity(timestamp=stamp, frame_id=frame, id=name, frame_locked=True).SerializeToString()
        return head + primitives


def _affordable(triangles: Sequence[int], most: int) -> list[bool]:
    """Tell of each body whether its triangles fit in what those before it leave of `most`."""
    left = most
    fits = []
    for count in triangles:
        fits.append(count <= left)
        left -= count if fits[-1] else 0
    return fits


def _colours(bodies: Sequence[Body], moving: Sequence[bool]) -> list[RGB]:
    """Return the colour of each body: in turn among those with shapes that move, and those that do not."""
    seen = dict.fromkeys((False, True), 0)
    colours = []
    for body, moves in zip(bodies, moving, strict=True):
        palette = MOVING if moves else FIXED
        colours.append(palette[seen[moves] % len(palette)])
        seen[moves] += 1 if body.shapes else 0
    return colours
