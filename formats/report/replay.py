"""The bodies of a log and how they move, as its topics for viewers have them, thinned to a budget."""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.CubePrimitive_pb2 import CubePrimitive
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive

from ...scheduler.geometry.arrays import FloatArray
from .models import Models

# Poses kept in all while a log is read, and in the page.
_MOST_KEPT = 800_000
_MOST_DRAWN = 160_000

# Lines between witnesses in the page.
_MOST_LINES = 50_000

# Of the run: where poses are farther apart, the log has no ticks.
_LONGEST_GAP = 0.25

_WORLD = "world"

# s, x, y, z, and the quaternion x, y, z, w.
POSE_NUMBERS = 8

# Of a box of a crowd: x, y, z, the quaternion x, y, z, w; the three sizes.
BOX_NUMBERS = 10


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a body, in its frame: a model, or "box" or "sphere" of size 1; pose as x, y, z, qx, qy, qz, qw."""

    model: int | str
    pose: tuple[float, ...]
    size: tuple[float, float, float]


@dataclass(slots=True)
class Drawn:
    """A body as it is drawn.

    Attributes:
        framed: whether it moves, by poses of its own.
        parts: in its frame, or in the world's.
        there: s, from when to when it exists, in turn.
    """

    framed: bool
    parts: list[Part]
    there: list[float] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Replay:
    """The bodies over time.

    Attributes:
        bodies: by name.
        models: the surfaces that they share.
        poses: by name, (n, 8) rows of s, x, y, z, qx, qy, qz, qw.
        boxes: by time, s, the bodies that are too many to have poses, (n, 10): x, y, z, qx, qy, qz, qw, three sizes.
        moves: whether the log tells how the bodies move; if not, they are where they start.
        lines: (n, 8) s, place of the pair in the page (-1: not there), two witness points, m.
    """

    bodies: dict[str, Drawn]
    models: Models
    poses: dict[str, FloatArray]
    boxes: list[tuple[float, FloatArray]]
    lines: FloatArray
    moves: bool


class ReplayBuilder:
    """Takes the messages for viewers in; memory does not grow with the log.

    Args:
        pairs: the places of the pairs in the page, by name.
        end: s, of the run.
    """

    def __init__(self, pairs: Mapping[str, int], end: float) -> None:
        self._pairs = pairs
        self._end = end
        self._models = Models()
        self._bodies: dict[str, Drawn] = {}
        self._poses: dict[str, array[float]] = {}
        self._last: dict[str, tuple[float, ...]] = {}
        self._boxes = _Thinning(_MOST_DRAWN)
        self._lines = _Thinning(_MOST_LINES)
        self._ticks = 0
        self._stride = 1
        self._kept = 0

    def add(self, topic: str, message: Any, time: float) -> None:
        """Take in one message of a time, s."""
        match topic, message:
            case "/scene/meshes", SceneUpdate():
                self._add_bodies(message, time)
            case "/scene/boxes", SceneUpdate():
                boxes = [_box(cube) for entity in message.entities for cube in entity.cubes]
                self._boxes.add(time, np.array(boxes, dtype=np.float64).reshape(-1, BOX_NUMBERS))
            case "/viz/clearance", SceneUpdate():
                lines = [self._line(entity, time) for entity in message.entities if entity.lines]
                self._lines.add(time, np.array(lines, dtype=np.float64).reshape(-1, POSE_NUMBERS))
            case "/tf", FrameTransforms():
                self._add_poses(message, time)
            case _:
                pass

    def finish(self) -> Replay | None:
        """Return what was taken in, None where no body is drawn."""
        if not self._bodies and not self._boxes.kept:
            return None
        for body in self._bodies.values():
            if len(body.there) % 2:
                body.there.append(self._end)
        while self._kept > _MOST_DRAWN:
            self._halve()
        poses = {name: self._track(name) for name in self._poses}
        moves = len(self._boxes.kept) > 1 or not poses or _are_ticks(max(poses.values(), key=len)[:, 0])
        if not moves:
            poses = {name: rows[:1] for name, rows in poses.items()}
        lines = [rows for _, rows in self._lines.kept]
        drawn = np.concatenate(lines) if lines else np.zeros((0, POSE_NUMBERS))
        return Replay(self._bodies, self._models, poses, self._boxes.kept, drawn, moves)

    def _add_bodies(self, update: SceneUpdate, time: float) -> None:
        """Take in the bodies that exist from now on; those that are not among them have vanished."""
        for entity in update.entities:
            body = self._bodies.get(entity.id)
            if body is None:
                body = self._bodies[entity.id] = Drawn(entity.frame_id != _WORLD, self._parts(entity))
            if len(body.there) % 2 == 0:
                body.there.append(time)
        present = {entity.id for entity in update.entities}
        for name, body in self._bodies.items():
            if name not in present and len(body.there) % 2:
                body.there.append(time)

    def _parts(self, entity: SceneEntity) -> list[Part]:
        parts = [Part(self._models.add(mesh), _placed(mesh.pose), (1.0, 1.0, 1.0)) for mesh in entity.triangles]
        parts += [Part("sphere", _placed(ball.pose), _size(ball)) for ball in entity.spheres]
        return parts + [Part("box", _placed(cube.pose), _size(cube)) for cube in entity.cubes]

    def _add_poses(self, message: FrameTransforms, time: float) -> None:
        kept = self._ticks % self._stride == 0
        self._ticks += 1
        for told in message.transforms:
            place, turn = told.translation, told.rotation
            pose = (time, place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w)
            self._last[told.child_frame_id] = pose
            if kept:
                self._poses.setdefault(told.child_frame_id, array("d")).extend(pose)
                self._kept += 1
        if self._kept > _MOST_KEPT:
            self._halve()

    def _halve(self) -> None:
        """Leave every other pose of each body."""
        self._stride *= 2
        self._kept = 0
        for name, poses in self._poses.items():
            rows = np.frombuffer(poses, dtype=np.float64).reshape(-1, POSE_NUMBERS)[::2]
            self._poses[name] = array("d", rows.tobytes())
            self._kept += len(rows)

    def _track(self, name: str) -> FloatArray:
        """Return a body's poses by time, up to its last."""
        rows = np.frombuffer(self._poses[name], dtype=np.float64).reshape(-1, POSE_NUMBERS)
        rows = np.concatenate((rows, [self._last[name]]))
        _, first = np.unique(rows[:, 0], return_index=True)
        track: FloatArray = rows[first]
        return track

    def _line(self, entity: SceneEntity, time: float) -> tuple[float, ...]:
        a, b = entity.lines[0].points[:2]
        return time, float(self._pairs.get(entity.id, -1)), a.x, a.y, a.z, b.x, b.y, b.z


class _Thinning:
    """Rows by time; of more than a budget every other time is left, again and again."""

    def __init__(self, most: int) -> None:
        self.kept: list[tuple[float, FloatArray]] = []
        self._most = most
        self._ticks = 0
        self._stride = 1
        self._rows = 0

    def add(self, time: float, rows: FloatArray) -> None:
        """Take in the rows of a time, s."""
        if self._ticks % self._stride == 0:
            self.kept.append((time, rows))
            self._rows += len(rows)
        self._ticks += 1
        while self._rows > self._most and len(self.kept) > 1:
            self.kept = self.kept[::2]
            self._rows = sum(len(rows) for _, rows in self.kept)
            self._stride *= 2


def _are_ticks(times: FloatArray) -> bool:
    """Tell whether poses of these times (n,) s are of ticks, not just of contacts."""
    return bool(len(times) > 2 and np.diff(times).max() < _LONGEST_GAP * (times[-1] - times[0]))


def _placed(pose: Pose) -> tuple[float, ...]:
    place, turn = pose.position, pose.orientation
    return place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w


def _size(part: SpherePrimitive | CubePrimitive) -> tuple[float, float, float]:
    return part.size.x, part.size.y, part.size.z


def _box(cube: CubePrimitive) -> tuple[float, ...]:
    return *_placed(cube.pose), *_size(cube)
