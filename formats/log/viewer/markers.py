"""What /viz/clearance and /viz/contacts show of one instant: full snapshots, for a viewer restores the last alone."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import dist

from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneEntityDeletion_pb2 import SceneEntityDeletion
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp

from ....scheduler.events import Nearness, Point
from .colours import RED, RGB, YELLOW, ClearanceScale, colour
from .transforms import WORLD
from .wire import embedded

_LINE_PIXELS = 4.0
_STALK_PIXELS = 1.0
_TEXT_PIXELS = 15.0


@dataclass(frozen=True, slots=True)
class MarkerSizes:
    """How markers fit a scene of `size` (m, the diagonal of all that the bodies reach)."""

    size: float

    @property
    def farthest(self) -> float:
        """m: pairs further apart get no line."""
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
    def apart(self) -> float:
        """m: figures nearer to each other would cover each other, from where the layout looks."""
        return 0.08 * self.size

    @property
    def scale(self) -> ClearanceScale:
        """Red up to 0.1 % of the scene, green from 10 % on."""
        return ClearanceScale(1e-3 * self.size, 0.1 * self.size)


def clearances(near: Iterable[tuple[str, Nearness]], sizes: MarkerSizes, stamp: Timestamp) -> bytes:
    """Return a SceneUpdate with a line between each pair's witness points and a figure over its middle.

    Where figures would cover each other, that of the nearest pair is told alone.

    Args:
        near: pairs by name, nearest first.
        sizes: of the scene.
        stamp: of the instant.
    """
    told: list[Point] = []
    entities = []
    for pair, nearness in near:
        (ax, ay, az), (bx, by, bz) = nearness.witness_a, nearness.witness_b
        middle = (0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * (az + bz))
        rgb = sizes.scale.rgb(nearness.distance)
        entity = SceneEntity(timestamp=stamp, frame_id=WORLD, id=pair, frame_locked=True)
        entity.lines.append(_line(nearness.witness_a, nearness.witness_b, rgb, _LINE_PIXELS))
        if all(dist(middle, other) > sizes.apart for other in told):
            told.append(middle)
            _call_out(entity, middle, sizes.stalk, figure(nearness.distance), rgb)
        entities.append(entity.SerializeToString())
    return update(stamp, entities)


def contact(pair: str, point: Point, roof: float, sizes: MarkerSizes, stamp: Timestamp) -> bytes:
    """Return the SceneEntity that marks where a pair touches, told over the bodies' `roof` (m, z) if it is not far."""
    diameter = Vector3(x=sizes.contact, y=sizes.contact, z=sizes.contact)
    ball = SpherePrimitive(pose=_at(point), size=diameter, color=colour(YELLOW))
    entity = SceneEntity(timestamp=stamp, frame_id=WORLD, id=pair, frame_locked=True, spheres=[ball])
    height = min(max(0.0, roof - point[2]) + sizes.stalk, 8.0 * sizes.stalk)
    _call_out(entity, point, height, "contact", RED)
    data: bytes = entity.SerializeToString()
    return data


def update(stamp: Timestamp, entities: Iterable[bytes]) -> bytes:
    """Return a SceneUpdate that deletes all that its topic showed, and shows these entities."""
    everything = SceneEntityDeletion(timestamp=stamp, type=SceneEntityDeletion.ALL)
    cleared: bytes = SceneUpdate(deletions=[everything]).SerializeToString()
    return cleared + b"".join(embedded(SceneUpdate.ENTITIES_FIELD_NUMBER, entity) for entity in entities)


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


def _call_out(entity: SceneEntity, point: Point, height: float, text: str, rgb: RGB) -> None:
    """Add a text over a point, on a stalk of some height (m): at the point it would hide what it speaks of."""
    x, y, z = point
    top = (x, y, z + height)
    entity.lines.append(_line(point, top, rgb, _STALK_PIXELS))
    entity.texts.add(
        pose=_at(top), billboard=True, font_size=_TEXT_PIXELS, scale_invariant=True, color=colour(rgb), text=text
    )


def _line(start: Point, end: Point, rgb: RGB, pixels: float) -> LinePrimitive:
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
