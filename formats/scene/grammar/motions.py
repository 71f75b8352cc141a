"""Motions as they are written: each a mapping whose `type` names its law, in the frame world_from_parent * pose."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from .base import ORIGIN, LengthUnit, Margin, Number, Part, Size, Vector
from .poses import Pose


class MotionPart(Part):
    """A motion in the frame world_from_parent * pose."""

    t0: Number = Field(
        default=0.0,
        description="Seconds: the motion's own time is the scene's less this; its t = 0 is at scene time t0.",
    )


class ConstantMotion(MotionPart):
    """translate(velocity t) * rotate(angular_velocity t), both along the axes of the rest frame, which do not turn."""

    type: Literal["constant"] = Field(description="The law of the motion.")
    velocity: Vector = Field(
        default=ORIGIN,
        description="Length unit per second, along the axes of the rest frame (the body's pose in its parent), "
        "which do not turn with the body.",
    )
    angular_velocity: Vector = Field(default=ORIGIN, description="Rotation vector, angle unit per second.")


class BallisticMotion(MotionPart):
    """translate(velocity t + acceleration t^2 / 2) * rotate(angular_velocity t), all along the rest frame's axes."""

    type: Literal["ballistic"] = Field(description="The law of the motion.")
    velocity: Vector = Field(
        default=ORIGIN,
        description="At t = 0, length unit per second, along the axes of the rest frame (the body's pose in its "
        "parent), which do not turn with the body.",
    )
    acceleration: Vector = Field(default=ORIGIN, description="Length unit per second squared.")
    angular_velocity: Vector = Field(default=ORIGIN, description="Rotation vector, angle unit per second.")


class ScrewMotion(MotionPart):
    """A turn about an axis that advances along it."""

    type: Literal["screw"] = Field(description="The law of the motion.")
    axis: Vector = Field(description="Direction of the axis, of any length but 0.")
    point: Vector = Field(default=ORIGIN, description="On the axis, in the file's length unit.")
    rate: Number = Field(description="Right-handed, angle unit per second.")
    pitch: Number = Field(default=0.0, description="Advance along +axis per turn of positive rate, length unit.")


class OrbitMotion(MotionPart):
    """The body's origin on a circle about the rest origin."""

    type: Literal["orbit"] = Field(description="The law of the motion.")
    axis: Vector = Field(description="Direction of the circle's axis, of any length but 0.")
    start: Vector = Field(description="Direction from the centre to the place of angle 0, perpendicular to the axis.")
    radius: Size = Field(description="Of the circle, in the file's length unit.")
    rate: Number = Field(description="Right-handed, angle unit per second.")
    phase: Number = Field(default=0.0, description="The angle at t = 0, in the file's angle unit.")
    facing: bool = Field(default=False, description="Whether the body also turns about its origin, by the same angle.")


class HarmonicMotion(MotionPart):
    """translate(direction * amplitude * sin(2 pi t / period + phase))."""

    type: Literal["harmonic"] = Field(description="The law of the motion.")
    direction: Vector = Field(description="Direction of the motion, of any length but 0.")
    amplitude: Number = Field(description="In the file's length unit.")
    period: Size = Field(description="Seconds.")
    phase: Number = Field(default=0.0, description="In the file's angle unit.")


class SwingMotion(MotionPart):
    """A turn about an axis by amplitude * sin(2 pi t / period + phase)."""

    type: Literal["swing"] = Field(description="The law of the motion.")
    axis: Vector = Field(description="Direction of the axis, of any length but 0.")
    point: Vector = Field(default=ORIGIN, description="On the axis, in the file's length unit.")
    amplitude: Number = Field(description="In the file's angle unit.")
    period: Size = Field(description="Seconds.")
    phase: Number = Field(default=0.0, description="In the file's angle unit.")


class PolynomialMotion(MotionPart):
    """translate(sum of coefficients[k] t^k) * rotate(angular_velocity t)."""

    type: Literal["polynomial"] = Field(description="The law of the motion.")
    coefficients: tuple[Vector, ...] = Field(
        min_length=1, max_length=21, description="Of t^0, t^1, ...: length unit per second to the k."
    )
    angular_velocity: Vector = Field(default=ORIGIN, description="Rotation vector, angle unit per second.")


class ProfileMotion(MotionPart):
    """A slide or a turn by a trapezoid of speed, at rest before and after."""

    type: Literal["profile"] = Field(description="The law of the motion.")
    kind: Literal["slide", "turn"] = Field(description="Along the axis, or about it.")
    axis: Vector = Field(description="Direction of the axis, of any length but 0.")
    point: Vector = Field(default=ORIGIN, description="On the axis of a turn, in the file's length unit.")
    begin: Number = Field(alias="from", description="Where it rests until t = 0: length unit, or angle unit of a turn.")
    end: Number = Field(alias="to", description="Where it rests in the end, in the same unit.")
    max_velocity: Size = Field(description="In that unit per second.")
    max_acceleration: Size = Field(description="In that unit per second squared; the same for braking.")


class Key(Pose):
    """A pose at a time."""

    t: Number = Field(description="Seconds of the motion's own time, increasing from key to key.")
    name: str | None = Field(default=None, description="Quoted when something happens beside this key. Default: none.")
    velocity: Vector | None = Field(
        default=None,
        description="For cubic translation, length unit per second, along the axes in which xyz is given (the rest "
        "frame's, which do not turn with the body): at every key, or at none. Default: Catmull-Rom.",
    )


class Interpolation(Part):
    """What happens between two keys."""

    translation: Literal["linear", "cubic", "step"] = Field(
        default="linear",
        description="Cubic: Hermite with the keys' velocities, without them those of Catmull and Rom.",
    )
    rotation: Literal["slerp", "step"] = Field(
        default="slerp",
        description="Slerp: the shorter way round, also where angles are written over 180 degrees apart.",
    )


Outside = Literal["error", "hold", "loop"]


class PathMotion(MotionPart):
    """Poses at given times, and what happens between and outside of them."""

    interpolation: Interpolation = Field(
        default=Interpolation(), description="Between the poses. Default: linear and slerp."
    )
    before: Outside = Field(default="error", description="Before the first pose: refused, at rest, or repeated.")
    after: Outside = Field(default="error", description="After the last pose: refused, at rest, or repeated.")


class KeyframesMotion(PathMotion):
    """Poses at given times, written here."""

    type: Literal["keyframes"] = Field(description="The law of the motion.")
    keys: tuple[Key, ...] = Field(min_length=1, description="They cover the time range, or before and after are said.")


class FileMotion(PathMotion):
    """Poses at given times, from a file. The path interpolated between them is certified.

    Lines of text in UTF-8; what follows a # is a remark. Poses map the body's coordinates into those of its rest frame.
    Axes stay as the file has them: those of KITTI's cameras are x right, y down, z forward.
    """

    type: Literal["file"] = Field(description="The law of the motion.")
    file: str = Field(min_length=1, description="Relative to the scene file.")
    layout: Literal["tum", "euroc", "kitti", "csv"] = Field(
        description="tum: lines of t x y z qx qy qz qw, in s and m. euroc: lines of t,x,y,z,qw,qx,qy,qz, in whole "
        "ns and m; further columns are left out. kitti: 12 numbers a line, a 3x4 matrix by rows, in m; it has no "
        "times, see times and period. csv: a header names t, x, y, z, and qw, qx, qy, qz or roll, pitch, yaw (turns "
        "about the fixed axes x, then y, then z, in this file's angle unit), in any order; without either the body "
        "does not turn."
    )
    times: str | None = Field(
        default=None,
        min_length=1,
        description="Of kitti: a file with the time of each pose, one in s a line. Default: none.",
    )
    period: Size | None = Field(
        default=None,
        description="Of kitti, instead of times: seconds from pose to pose, the first at 0. Default: none.",
    )
    units: LengthUnit | None = Field(default=None, description="Of the lengths in a csv file. Default: this file's.")
    time_origin: Literal["first", "zero"] = Field(
        default="first", description="Whether t = 0 is the first pose's time, or the file's own 0."
    )
    duplicates: Literal["error", "first", "last"] = Field(
        default="error",
        description="Of successive poses at one time: refused, or the first or the last of them taken, with a warning.",
    )
    max_gap: Size | None = Field(
        default=None, description="Seconds: longer gaps between two poses are refused. Default: any gap."
    )


class LimitsMotion(MotionPart):
    """A path that is unknown but for its limits, from the rest pose, where it stands until t = 0."""

    type: Literal["limits"] = Field(description="The law of the motion.")
    velocity: Vector = Field(default=ORIGIN, description="At t = 0, length unit per second; its size alone counts.")
    max_speed: Size | None = Field(
        default=None,
        description="Of the frame's origin, length unit per second. Default: unlimited, if the next is not.",
    )
    max_acceleration: Margin | None = Field(
        default=None,
        description="Of the frame's origin, length unit per second squared. Default: none.",
    )
    max_angular_speed: Margin | None = Field(
        default=None, description="Angle unit per second, for the record: any attitude is allowed for. Default: none."
    )


MOTIONS = (
    *("constant", "ballistic", "screw", "orbit", "harmonic", "swing"),
    *("polynomial", "profile", "keyframes", "file", "limits"),
)


def _motion_tag(value: Any) -> str | None:
    tag = value.get("type") if isinstance(value, dict) else None
    return tag if isinstance(tag, str) and tag in MOTIONS else None


MotionChoice = Annotated[
    Annotated[ConstantMotion, Tag("constant")]
    | Annotated[BallisticMotion, Tag("ballistic")]
    | Annotated[ScrewMotion, Tag("screw")]
    | Annotated[OrbitMotion, Tag("orbit")]
    | Annotated[HarmonicMotion, Tag("harmonic")]
    | Annotated[SwingMotion, Tag("swing")]
    | Annotated[PolynomialMotion, Tag("polynomial")]
    | Annotated[ProfileMotion, Tag("profile")]
    | Annotated[KeyframesMotion, Tag("keyframes")]
    | Annotated[FileMotion, Tag("file")]
    | Annotated[LimitsMotion, Tag("limits")],
    Discriminator(_motion_tag),
]
