"""The grammar of a native scene, version 1: one pydantic model a mapping, its numbers in the file's units."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from .limits import LARGEST_NUMBER, SMALLEST_NUMBER, SMALLEST_SIZE


def _without_residue(value: float) -> float:
    return value if abs(value) >= SMALLEST_NUMBER else 0.0


Number = Annotated[float, Field(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER), AfterValidator(_without_residue)]
Size = Annotated[float, Field(ge=SMALLEST_SIZE, le=LARGEST_NUMBER)]
Vector = tuple[Number, Number, Number]
Quaternion = tuple[Number, Number, Number, Number]
LengthUnit = Literal["m", "cm", "mm", "in", "ft"]

ORIGIN: Vector = (0.0, 0.0, 0.0)


class Part(BaseModel):
    """A mapping of the scene file.

    Attributes:
        later_keys: keys of the format that this version does not read yet.
        later_values: the same for values, by key.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)
    later_keys: ClassVar[frozenset[str]] = frozenset()
    later_values: ClassVar[dict[str, frozenset[str]]] = {}


class Units(Part):
    """The units of every number in this file."""

    length: LengthUnit = Field(description="Unit of lengths; velocities are per second.")
    angle: Literal["deg", "rad"] = Field(description="Unit of angles; rates are per second.")


class TimeRange(Part):
    """The times that are checked."""

    start: Number = Field(description="Seconds.")
    end: Number = Field(description="Seconds, after start.")


class SettingsPart(Part):
    """What a command-line option overrides."""

    later_keys = frozenset({"margin"})
    time_resolution: Size | None = Field(default=None, description="Seconds: the least step of the main loop.")
    contact_tolerance: Size | None = Field(
        default=None, description="Seconds: the widest bracket of a contact's begin or end."
    )


class MeshReference(Part):
    """A mesh file."""

    file: str = Field(min_length=1, description="OBJ or STL, relative to the scene file.")
    units: LengthUnit = Field(description="Unit of the coordinates in the mesh file.")
    up: Literal["z", "y"] = Field(default="z", description="The file's upward axis; y is turned to z.")


class AxisAngle(Part):
    """A turn about an axis."""

    axis: Vector = Field(description="Direction of the axis, of any length but 0.")
    angle: Number = Field(description="Right-handed angle about the axis, in the file's angle unit.")


class Pose(Part):
    """Where a frame lies in its parent: child coordinates become the parent's."""

    xyz: Vector | None = Field(default=None, description="Translation, in the file's length unit.")
    quat_wxyz: Quaternion | None = Field(default=None, description="Unit quaternion, scalar first.")
    quat_xyzw: Quaternion | None = Field(default=None, description="Unit quaternion, scalar last.")
    rpy: Vector | None = Field(
        default=None, description="Turns about the fixed axes x, then y, then z, in the file's angle unit."
    )
    axis_angle: AxisAngle | None = Field(default=None, description="A turn about an axis.")
    matrix: tuple[Quaternion, Quaternion, Quaternion, Quaternion] | None = Field(
        default=None,
        description="4x4, row-major, parent from child; translation in the file's length unit. Alone.",
    )

    @model_validator(mode="after")
    def _one_rotation(self) -> Pose:
        names = ("quat_wxyz", "quat_xyzw", "rpy", "axis_angle", "matrix")
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) > 1:
            text = f"expected at most one of {', '.join(names)}, got {' and '.join(given)}"
            raise PydanticCustomError("pose", "{text}", {"text": text})
        if self.matrix is not None and self.xyz is not None:
            text = "expected matrix alone, got xyz too (the translation is the matrix's last column)"
            raise PydanticCustomError("pose", "{text}", {"text": text})
        return self


REST = Pose()


class Box(Part):
    """A box about the origin of its pose."""

    box: tuple[Size, Size, Size] = Field(description="Full lengths along x, y, z, in the file's length unit.")
    pose: Pose = Field(default=REST, description="In the body.")


class Sphere(Part):
    """A sphere about the origin of its pose."""

    sphere: Size = Field(description="Radius, in the file's length unit.")
    pose: Pose = Field(default=REST, description="In the body.")


class CapsuleSize(Part):
    """All points within a radius of a segment."""

    radius: Size = Field(description="In the file's length unit.")
    length: Size = Field(description="Of the segment, without the round ends, in the file's length unit.")


class Capsule(Part):
    """A capsule about the origin of its pose, along z."""

    capsule: CapsuleSize = Field(description="Radius and length.")
    pose: Pose = Field(default=REST, description="In the body.")


class MeshShape(Part):
    """A mesh from `meshes`."""

    later_keys = frozenset({"scale"})
    mesh: str = Field(description="A name from meshes.")
    pose: Pose = Field(default=REST, description="In the body.")


SHAPES = ("mesh", "box", "sphere", "capsule")
LATER_SHAPES = frozenset({"cylinder", "cone", "ellipsoid"})


def _shape_tag(value: Any) -> str | None:
    kinds = [kind for kind in SHAPES if kind in value] if isinstance(value, dict) else []
    return kinds[0] if len(kinds) == 1 else None


ShapePart = Annotated[
    Annotated[MeshShape, Tag("mesh")]
    | Annotated[Box, Tag("box")]
    | Annotated[Sphere, Tag("sphere")]
    | Annotated[Capsule, Tag("capsule")],
    Discriminator(_shape_tag),
]


class MotionPart(Part):
    """A motion in the frame world_from_parent * pose."""

    later_keys = frozenset({"t0"})


class ConstantMotion(MotionPart):
    """translate(velocity t) * rotate(angular_velocity t)."""

    type: Literal["constant"]
    velocity: Vector = Field(default=ORIGIN, description="Length unit per second.")
    angular_velocity: Vector = Field(default=ORIGIN, description="Rotation vector, angle unit per second.")


class BallisticMotion(MotionPart):
    """translate(velocity t + acceleration t^2 / 2) * rotate(angular_velocity t)."""

    type: Literal["ballistic"]
    velocity: Vector = Field(default=ORIGIN, description="At t = 0, length unit per second.")
    acceleration: Vector = Field(default=ORIGIN, description="Length unit per second squared.")
    angular_velocity: Vector = Field(default=ORIGIN, description="Rotation vector, angle unit per second.")


class ScrewMotion(MotionPart):
    """A turn about an axis that advances along it."""

    type: Literal["screw"]
    axis: Vector = Field(description="Direction of the axis, of any length but 0.")
    point: Vector = Field(default=ORIGIN, description="On the axis, in the file's length unit.")
    rate: Number = Field(description="Right-handed, angle unit per second.")
    pitch: Number = Field(default=0.0, description="Advance along +axis per turn of positive rate, length unit.")


class HarmonicMotion(MotionPart):
    """translate(direction * amplitude * sin(2 pi t / period + phase))."""

    type: Literal["harmonic"]
    direction: Vector = Field(description="Of any length but 0.")
    amplitude: Number = Field(description="In the file's length unit.")
    period: Size = Field(description="Seconds.")
    phase: Number = Field(default=0.0, description="In the file's angle unit.")


class SwingMotion(MotionPart):
    """A turn about an axis by amplitude * sin(2 pi t / period + phase)."""

    type: Literal["swing"]
    axis: Vector = Field(description="Direction of the axis, of any length but 0.")
    point: Vector = Field(default=ORIGIN, description="On the axis, in the file's length unit.")
    amplitude: Number = Field(description="In the file's angle unit.")
    period: Size = Field(description="Seconds.")
    phase: Number = Field(default=0.0, description="In the file's angle unit.")


class Key(Pose):
    """A pose at a time."""

    later_keys = frozenset({"name", "velocity"})
    t: Number = Field(description="Seconds, increasing from key to key.")


class Interpolation(Part):
    """What happens between two keys."""

    later_values: ClassVar[dict[str, frozenset[str]]] = {"translation": frozenset({"cubic"})}
    translation: Literal["linear", "step"] = Field(default="linear", description="Of the translation.")
    rotation: Literal["slerp", "step"] = Field(default="slerp", description="Of the rotation: the shorter way round.")


class KeyframesMotion(MotionPart):
    """Poses at given times."""

    later_keys = frozenset({"t0", "before", "after"})
    type: Literal["keyframes"]
    keys: tuple[Key, ...] = Field(min_length=1, description="They cover the time range.")
    interpolation: Interpolation = Field(default=Interpolation(), description="Default: linear and slerp.")


MOTIONS = ("constant", "ballistic", "screw", "harmonic", "swing", "keyframes")
LATER_MOTIONS = frozenset({"orbit", "polynomial", "profile", "file", "limits"})


def _motion_tag(value: Any) -> str | None:
    tag = value.get("type") if isinstance(value, dict) else None
    return tag if isinstance(tag, str) and tag in MOTIONS else None


MotionChoice = Annotated[
    Annotated[ConstantMotion, Tag("constant")]
    | Annotated[BallisticMotion, Tag("ballistic")]
    | Annotated[ScrewMotion, Tag("screw")]
    | Annotated[HarmonicMotion, Tag("harmonic")]
    | Annotated[SwingMotion, Tag("swing")]
    | Annotated[KeyframesMotion, Tag("keyframes")],
    Discriminator(_motion_tag),
]


class BodyPart(Part):
    """A rigid body, or a mere frame: world_from_parent * pose * motion."""

    later_keys = frozenset({"exists"})
    parent: str | None = Field(default=None, description="The body that carries this one; default: the world.")
    pose: Pose = Field(default=REST, description="In the parent.")
    shapes: tuple[ShapePart, ...] = Field(default=(), description="Rigid together.")
    motion: MotionChoice | None = Field(default=None, description="Default: fixed.")
    groups: tuple[str, ...] = Field(default=(), description="Names for pairs to refer to.")


class PairPart(Part):
    """Pairs with one body on each side."""

    between: tuple[str, str] = Field(description="Each a body, a group, or a pattern with * ? [ ].")
    reason: str | None = Field(default=None, description="For the reader.")


class PairsPart(Part):
    """Which pairs are checked; default all."""

    later_keys = frozenset({"default", "margins"})
    ignore: tuple[PairPart, ...] = Field(default=(), description="Not checked.")
    check: tuple[PairPart, ...] = Field(default=(), description="Checked though ignored.")


class SceneFile(Part):
    """A native closecall scene."""

    closecall: Literal[1] = Field(description="The version of the format.")
    units: Units = Field(description="Of this file.")
    time: TimeRange = Field(description="What is checked.")
    settings: SettingsPart = Field(default=SettingsPart(), description="Overridden by command-line options.")
    meshes: dict[str, MeshReference] = Field(default_factory=dict, description="Mesh files by name.")
    bodies: dict[str, BodyPart] = Field(description="Bodies by name.")
    pairs: PairsPart = Field(default=PairsPart(), description="Default: every pair is checked.")
