"""The bodies as scene entities: drawn while they exist, or as a crowd of boxes, and in red while in contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from google.protobuf.timestamp_pb2 import Timestamp
from numpy.typing import NDArray

from ....scheduler.geometry.arrays import FloatArray
from ....scheduler.model.scene import Body, Scene
from ....scheduler.snapshots.schedule import changes_of_existence
from .colours import FIXED, MOVING, RED, RGB, colour
from .drawings import Drawings
from .instances import Crowd
from .markers import line
from .transforms import WORLD
from .wire import Pieces, rounded, scene_update

# Bodies let the markers on them and in them show.
_OPACITY = 0.65
_OPACITY_IN_RED = 0.6

# Triangles. A colliding body with more is marked by its box: it is drawn anew in every snapshot.
_MOST_IN_RED = 5_000

# Of the body's own diagonal: how far its red skin stands off it, so that neither shows through the other, and how far
# the skin's origin lies over the body's.
_SKIN = 0.004
_RAISED = 0.05

# To multiples of this what is up for a body is rounded: while it turns by less, its skin is the same. So many are kept.
_UP_STEP = 0.25
_MOST_SKINS = 64

# How far the origins of what stands still lie below the scene, in its sizes; and how much a foot's height counts.
_BELOW = 4.0
_STEEPNESS = 20.0

# A body that measures less than this share of the scene has a dot of so many pixels at its place, which is seen from
# anywhere.
_SMALL = 0.008
_DOT_PIXELS = 8.0

_IDENTITY: FloatArray = np.eye(4)


@dataclass(frozen=True, slots=True)
class Look:
    """How bodies are shown.

    Attributes:
        framed: of each body, whether it moves and has a frame of its own.
        triangles: how many may be drawn in all; first come, first served.
        size: m, the diagonal of all that the bodies reach.
        top: m, the highest that they reach.
    """

    framed: Sequence[bool]
    triangles: int
    size: float
    top: float


class BodyEntities:
    """One entity a body, named as the body: in the body's own frame if it moves, else in the world's.

    What moves and has no frame of its own is a crowd: boxes in the world, all one entity.

    Attributes:
        boxed: how many bodies are drawn as boxes, for want of triangles.
        crowd: the bodies without an entity of their own; None if there are none.
    """

    def __init__(self, scene: Scene, moving: Sequence[bool], poses: FloatArray, drawings: Drawings, look: Look) -> None:
        """Take the bodies and which of them ever move.

        Args:
            scene: whose bodies.
            moving: of each body, whether it ever moves.
            poses: (n, 4, 4) world_from_body at the start, which bodies that do not move keep.
            drawings: of the same bodies.
            look: how they are shown.
        """
        bodies, framed = scene.bodies, look.framed
        self._bodies = bodies
        self._framed = framed
        self._look = look
        self._poses = poses
        self._drawings = drawings
        self._colours = _colours(bodies, moving)
        crowded = [bool(body.shapes) and moving[k] and not framed[k] for k, body in enumerate(bodies)]
        self._single = [index for index, body in enumerate(bodies) if body.shapes and not crowded[index]]
        times = _times_drawn(scene)
        counts = [0 if crowded[k] else count * times[k] for k, count in enumerate(drawings.triangles)]
        self._exact = _affordable(counts, look.triangles)
        self.boxed = sum(1 for index in self._single if not self._exact[index])
        members = [index for index, apart in enumerate(crowded) if apart]
        colours = [self._colours[index] for index in members]
        self._skins: dict[int, tuple[bytes, bytes]] = {}  # those made last, each with what it depends on
        self.crowd = Crowd(members, drawings.outlines, colours, _OPACITY, poses) if members else None

    def all(self, stamp: Timestamp, there: NDArray[np.bool_]) -> bytes:
        """Return a SceneUpdate with the bodies that exist (n,), have a shape and are not of the crowd."""
        shown = [index for index in self._single if there[index]]
        return scene_update(stamp, [self._head(k, stamp) + self._drawn(k) + self._dot(k) for k in shown])

    def in_red(self, index: int, stamp: Timestamp, world_from_body: FloatArray) -> Pieces:
        """Return the entity that covers a body in red, given its pose (4x4) now; the large piece often is the same one.

        Its origin lies over the body's, so that a viewer that looks from above paints it after the body.
        """
        placement = self._placement(index, world_from_body)
        up = rounded(world_from_body[2, :3], _UP_STEP)  # that row is the world's z axis
        look = placement.tobytes() + up.tobytes()
        if index not in self._skins or self._skins[index][0] != look:
            self._skins.pop(index, None)
            if len(self._skins) == _MOST_SKINS:
                del self._skins[next(iter(self._skins))]
            self._skins[index] = look, self._skin(index, placement, up)
        return self._head(index, stamp), self._skins[index][1]

    def roof(self, index: int, world_from_body: FloatArray) -> float:
        """Return the height (m, z in the world) of a body's highest point, given its pose (4x4) now; errs low."""
        heights = self._drawings.outlines[index] @ world_from_body[2, :3]
        return float(heights.max() + world_from_body[2, 3])

    def front(self, index: int, world_from_body: FloatArray, point: FloatArray, direction: FloatArray) -> float:
        """Return how far (m) a body reaches beyond a point (3,) of the world in a unit direction; errs low."""
        local = world_from_body[:3, :3].T @ direction
        reached = self._drawings.outlines[index] @ local
        return float(reached.max() + (world_from_body[:3, 3] - point) @ direction)

    def peak(self, index: int, world_from_body: FloatArray) -> FloatArray:
        """Return the point (3,) m of the world over a body's middle, as high as its highest, at a pose (4x4)."""
        placed = self._drawings.outlines[index] @ world_from_body[:3, :3].T + world_from_body[:3, 3]
        peak: FloatArray = 0.5 * (placed.min(axis=0) + placed.max(axis=0))
        peak[2] = placed[:, 2].max()
        return peak

    def size(self, index: int) -> float:
        """Return the diagonal (m) of a body's bounds in its own frame."""
        return float(np.linalg.norm(np.ptp(self._drawings.outlines[index], axis=0)))

    def is_small(self, index: int) -> bool:
        """Tell whether a body is hardly seen in a picture of the whole scene."""
        return self.size(index) < _SMALL * self._look.size

    def rgb(self, index: int) -> RGB:
        """Return the colour of a body."""
        return self._colours[index]

    def _dot(self, index: int) -> bytes:
        """Return what makes a small body noticed."""
        if not self.is_small(index):
            return b""
        marks = SceneEntity()
        outline, place = self._drawings.outlines[index], self._placement(index, self._poses[index])
        (lx, ly, lz), (hx, hy, hz) = ((place @ (*end, 1.0))[:3].tolist() for end in (outline.min(0), outline.max(0)))
        marks.lines.append(line((lx, ly, lz), (hx, hy, hz), self._colours[index], _DOT_PIXELS))
        data: bytes = marks.SerializeToString()
        return data

    def _drawn(self, index: int) -> bytes:
        placement, paint = self._placement(index, self._poses[index]), colour(self._colours[index], _OPACITY)
        if not self._exact[index]:
            return self._drawings.box(index, placement, paint)
        if self._framed[index] or self._drawings.triangles[index] == 0:
            return self._drawings.exact(index, placement, paint)
        return self._drawings.triangulated(index, placement, paint, self._depth(index))

    def _skin(self, index: int, placement: FloatArray, up: FloatArray) -> bytes:
        """Return what covers a body placed (4x4) in its entity's frame, where `up` (3,) points up in its own."""
        low, high = self._drawings.outlines[index].min(axis=0), self._drawings.outlines[index].max(axis=0)
        size, red = self.size(index), colour(RED, _OPACITY_IN_RED)
        if self._drawings.triangles[index] > _MOST_IN_RED:
            return self._drawings.box(index, placement, red, _SKIN * size)
        origin = 0.5 * (low + high) + _RAISED * size * up
        return self._drawings.triangulated(index, placement, red, origin, _SKIN * size)

    def _depth(self, index: int) -> FloatArray:
        """Return the origin (3,) m, in its own frame, of what stands still: so far below that it is painted first.

        That is before all that moves; and what has its foot lower comes before what stands on it.
        """
        outline, pose = self._drawings.outlines[index], self._poses[index]
        placed = outline @ pose[:3, :3].T + pose[:3, 3]
        origin = 0.5 * (placed.min(axis=0) + placed.max(axis=0))
        origin[2] = self._look.top - _BELOW * self._look.size - _STEEPNESS * (self._look.top - placed[:, 2].min())
        depth: FloatArray = (origin - pose[:3, 3]) @ pose[:3, :3]
        return depth

    def _placement(self, index: int, world_from_body: FloatArray) -> FloatArray:
        """Return the pose (4x4) of a body in its entity's frame, given that in the world."""
        return _IDENTITY if self._framed[index] else world_from_body

    def _head(self, index: int, stamp: Timestamp) -> bytes:
        """Return a body's entity but for its primitives."""
        name = self._bodies[index].name
        frame = name if self._framed[index] else WORLD
        head: bytes = SceneEntity(timestamp=stamp, frame_id=frame, id=name, frame_locked=True).SerializeToString()
        return head


def _times_drawn(scene: Scene) -> list[int]:
    """Return how often each body is drawn: at the start and whenever any appears or vanishes, while it exists."""
    times = np.array([scene.start, *changes_of_existence(scene)])
    from_, to = np.array([body.exists for body in scene.bodies]).reshape(-1, 2).T
    drawn: list[int] = (np.searchsorted(times, to) - np.searchsorted(times, from_)).tolist()
    return drawn


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
