"""What /viz/clearance and /viz/contacts show of one instant: full snapshots, for a viewer restores the last alone."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp

from ....scheduler.geometry.arrays import FloatArray
from ....scheduler.model.events import Nearness, Point
from .camera import Camera
from .colours import RGB, WHITE, YELLOW, ClearanceScale, colour, mixed
from .transforms import WORLD
from .wire import scene_update

_LINE_PIXELS = 4.0
_STALK_PIXELS = 1.0
_TEXT_PIXELS = 15.0

# Halves of the picture's height, in a window of 1000 pixels: how wide and high a letter is.
_LETTER_WIDTH = 0.032
_LETTER_HEIGHT = 0.07


@dataclass(frozen=True, slots=True)
class MarkerSizes:
    """How markers fit a scene of `size` (m, the diagonal of all that the bodies reach)."""

    size: float

    @property
    def farthest(self) -> float:
        """m: pairs further apart get no line, but for the nearest of all."""
        return 0.1 * self.size

    @property
    def contact(self) -> float:
        """m: the diameter of a contact's marker."""
        return 0.012 * self.size

    @property
    def stalk(self) -> float:
        """m: how high figures stand over what they speak of."""
        return 0.04 * self.size

    @property
    def farthest_front(self) -> float:
        """m: figures come no farther towards the eye than this, out of the bodies that they would be hidden in."""
        return 0.12 * self.size

    @property
    def scale(self) -> ClearanceScale:
        """Red up to 0.1 % of the scene, green from 10 % on."""
        return ClearanceScale(1e-3 * self.size, 0.1 * self.size)


class CallOuts:
    """The texts in one picture, from where the layout looks: none covers another."""

    def __init__(self, view: Camera) -> None:
        """Start with none."""
        self._view = view
        self._told: list[tuple[float, float, float]] = []

    def room(self, point: FloatArray, text: str) -> bool:
        """Tell whether a text at a point (3,) m would be seen whole, and keep the room for it if so."""
        x, y = self._view.picture(point)
        half = 0.5 * _LETTER_WIDTH * (len(text) + 1)
        for x_told, y_told, half_told in self._told:
            if abs(x - x_told) < half + half_told and abs(y - y_told) < _LETTER_HEIGHT:
                return False
        self._told.append((x, y, half))
        return True


def clearances(
    near: Iterable[tuple[str, Nearness]],
    front: Callable[[Nearness, FloatArray], FloatArray],
    sizes: MarkerSizes,
    told: CallOuts,
    stamp: Timestamp,
) -> bytes:
    """Return a SceneUpdate with a line between each pair's witness points and, where there is room, a figure over it.

    Args:
        near: pairs by name, nearest first, whose figure has precedence.
        front: how far (3,) m from a point towards the eye the pair's bodies would hide a text there.
        sizes: of the scene.
        told: the texts that are there already.
        stamp: of the instant.
    """
    entities = []
    stalk = np.array((0.0, 0.0, sizes.stalk))
    for pair, nearness in near:
        rgb = sizes.scale.rgb(nearness.distance)
        entity = SceneEntity(timestamp=stamp, frame_id=WORLD, id=pair, frame_locked=True)
        entity.lines.append(line(nearness.witness_a, nearness.witness_b, rgb, _LINE_PIXELS))
        middle = 0.5 * (np.array(nearness.witness_a) + np.array(nearness.witness_b))
        text = figure(nearness.distance)
        if told.room(middle + stalk, text):
            _call_out(entity, middle, middle + front(nearness, middle) + stalk, text, rgb)
        entities.append(entity.SerializeToString())
    return scene_update(stamp, entities)


def contact(
    pair: str, word: str, rgb: RGB, point: Point, roof: float, sizes: MarkerSizes, told: CallOuts, stamp: Timestamp
) -> bytes:
    """Return the SceneEntity that marks where a pair touches, told over the bodies' `roof` (m, z) if it is not far.

    `word` says what it is, in its colour.
    """
    diameter = Vector3(x=sizes.contact, y=sizes.contact, z=sizes.contact)
    ball = SpherePrimitive(pose=_at(point), size=diameter, color=colour(YELLOW))
    entity = SceneEntity(timestamp=stamp, frame_id=WORLD, id=pair, frame_locked=True, spheres=[ball])
    height = min(max(0.0, roof - point[2]) + sizes.stalk, 8.0 * sizes.stalk)
    foot = np.array(point)
    top = foot + np.array((0.0, 0.0, height))
    if told.room(top, word):
        _call_out(entity, foot, top, word, rgb)
    data: bytes = entity.SerializeToString()
    return data


def names(tags: Iterable[tuple[str, FloatArray, RGB]], sizes: MarkerSizes, told: CallOuts, stamp: Timestamp) -> bytes:
    """Return a SceneUpdate with the names of bodies where there is room: each with the point under it, and colour."""
    entities = []
    for name, point, rgb in tags:
        top = point + np.array((0.0, 0.0, 0.5 * sizes.stalk))
        if told.room(top, name):
            entity = SceneEntity(timestamp=stamp, frame_id=WORLD, id=name, frame_locked=True)
            _text(entity, top, name, mixed(rgb, WHITE, 0.5))
            entities.append(entity.SerializeToString())
    return scene_update(stamp, entities)


def figure(distance: float) -> str:
    """Return a distance >= 0 (m) to three digits in the unit that fits it."""
    for unit, metres, below in (("µm", 1e-6, 1e-4), ("mm", 1e-3, 0.1), ("m", 1.0, 1e3)):
        if distance < below:
            return f"{_three_digits(distance / metres)} {unit}"
    return f"{_three_digits(distance / 1e3)} km"


def _three_digits(value: float) -> str:
    """Return a number >= 0 with three digits, but whole from 100 on and to 0.001 at the least."""
    decimals = next((3 - k for k, least in enumerate((0.9995, 9.995, 99.95)) if value < least), 0)
    return f"{value:.{decimals}f}"


def _call_out(entity: SceneEntity, foot: FloatArray, top: FloatArray, text: str, rgb: RGB) -> None:
    """Add a text at the top of a stalk: at the foot it would hide what it speaks of."""
    (fx, fy, fz), (x, y, z) = foot.tolist(), top.tolist()
    entity.lines.append(line((fx, fy, fz), (x, y, z), rgb, _STALK_PIXELS))
    _text(entity, top, text, rgb)


def _text(entity: SceneEntity, place: FloatArray, text: str, rgb: RGB) -> None:
    """Add a text that is as large from anywhere."""
    x, y, z = place.tolist()
    entity.texts.add(
        pose=_at((x, y, z)), billboard=True, font_size=_TEXT_PIXELS, scale_invariant=True, color=colour(rgb), text=text
    )


def line(start: Point, end: Point, rgb: RGB, pixels: float) -> LinePrimitive:
    """Return a line that is so many pixels wide from anywhere."""
    return LinePrimitive(
        type=LinePrimitive.LINE_STRIP,
        pose=_at((0.0, 0.0, 0.0)),
        thickness=pixels,
        scale_invariant=True,
        points=[Point3(x=x, y=y, z=z) for x, y, z in (start, end)],
        color=colour(rgb),
    )


def _at(point: Point) -> Pose:
    x, y, z = point
    return Pose(position=Vector3(x=x, y=y, z=z), orientation=Quaternion(w=1.0))
