"""The bodies as scene entities: drawn once for the whole run, and in red for as long as they are in contact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.timestamp_pb2 import Timestamp

from ....scheduler.scene import Body, FloatArray
from .colours import FIXED, MOVING, RED, RGB, colour
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

    Attributes:
        boxed: how many bodies are drawn as boxes, for want of triangles.
    """

    def __init__(
        self, bodies: Sequence[Body], moving: Sequence[bool], poses: FloatArray, drawings: Drawings, triangles: int
    ) -> None:
        """Take the bodies and which of them ever move.

        Args:
            bodies: in document order.
            moving: of each body, whether it ever moves.
            poses: (n, 4, 4) world_from_body, used for bodies that do not move.
            drawings: of the same bodies.
            triangles: how many may be drawn in all; first come, first served.
        """
        self._bodies = bodies
        self._moving = moving
        self._poses = poses
        self._drawings = drawings
        self._exact = _affordable(drawings.triangles, triangles)
        self.boxed = sum(1 for body, exact in zip(bodies, self._exact, strict=True) if body.shapes and not exact)

    def all(self, stamp: Timestamp) -> bytes:
        """Return a SceneUpdate with every body that has a shape."""
        seen = dict.fromkeys(self._moving, 0)
        entities = []
        for index, (body, moves) in enumerate(zip(self._bodies, self._moving, strict=True)):
            if not body.shapes:
                continue
            palette = MOVING if moves else FIXED
            rgb = palette[seen[moves] % len(palette)]
            seen[moves] += 1
            entities.append(self._entity(index, stamp, self._drawn(index, rgb)))
        return b"".join(embedded(SceneUpdate.ENTITIES_FIELD_NUMBER, entity) for entity in entities)

    def in_red(self, index: int, stamp: Timestamp, world_from_body: FloatArray) -> bytes:
        """Return the entity that covers a body in red, given its pose (4x4) now.

        Its origin lies over the body's, so that a viewer that looks from above paints it after the body.
        """
        low, high = self._drawings.outlines[index].min(axis=0), self._drawings.outlines[index].max(axis=0)
        size = float(np.linalg.norm(high - low))
        placement, red = self._placement(index), colour(RED, _OPACITY_IN_RED)
        if self._drawings.triangles[index] > _MOST_IN_RED:
            return self._entity(index, stamp, self._drawings.box(index, placement, red, _SKIN * size))
        origin = 0.5 * (low + high) + _RAISED * size * world_from_body[2, :3]  # that row is the world's z axis
        skin = self._drawings.triangulated(index, placement, red, origin, _SKIN * size)
        return self._entity(index, stamp, skin)

    def roof(self, index: int, world_from_body: FloatArray) -> float:
        """Return the height (m, z in the world) of a body's highest point, given its pose (4x4) now; errs low."""
        heights = self._drawings.outlines[index] @ world_from_body[2, :3]
        return float(heights.max() + world_from_body[2, 3])

    def _drawn(self, index: int, rgb: RGB) -> bytes:
        placement, paint = self._placement(index), colour(rgb, _OPACITY)
        if not self._exact[index]:
            return self._drawings.box(index, placement, paint)
        if self._moving[index] or self._drawings.triangles[index] == 0:
            return self._drawings.exact(index, placement, paint)
        # What stands still is painted from its foot, before what moves in it and on it.
        foot = self._drawings.outlines[index][np.argmin(self._drawings.outlines[index] @ placement[2, :3])]
        return self._drawings.triangulated(index, placement, paint, foot)

    def _placement(self, index: int) -> FloatArray:
        """Return the pose (4x4) of a body in its entity's frame."""
        return _IDENTITY if self._moving[index] else self._poses[index]

    def _entity(self, index: int, stamp: Timestamp, primitives: bytes) -> bytes:
        name = self._bodies[index].name
        frame = name if self._moving[index] else WORLD
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
