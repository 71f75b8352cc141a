"""The native scene file, version 1: one pydantic model a mapping, its numbers in the file's units."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from .base import LengthUnit, Margin, Number, Part, Share, Size
from .motions import MotionChoice
from .poses import REST, Pose
from .shapes import ShapePart


class Units(Part):
    """The units of every number in this file."""

    length: LengthUnit = Field(description="Unit of lengths; velocities are per second.")
    angle: Literal["deg", "rad"] = Field(description="Unit of angles; rates are per second.")


class TimeRange(Part):
    """The times that are checked."""

    start: Number = Field(description="Seconds.")
    end: Number = Field(description="Seconds, after start.")


def _tolerance_tag(value: Any) -> str:
    return "none" if value == "none" else "share"


DistanceTolerance = Annotated[
    Annotated[Share, Tag("share")] | Annotated[Literal["none"], Tag("none")], Discriminator(_tolerance_tag)
]


class SettingsPart(Part):
    """What a command-line option overrides."""

    time_resolution: Size | None = Field(
        default=None, description="Seconds: the least step of the main loop. Default: 0.001."
    )
    contact_tolerance: Size | None = Field(
        default=None,
        description="Seconds: the widest bracket of a contact's begin or end. "
        "Default: 0.000001, or 64 floats of time where those are more.",
    )
    margin: Margin | None = Field(
        default=None, description="A pair nearer than this is in breach, in the file's length unit. Default: 0."
    )
    distance_tolerance: DistanceTolerance | None = Field(
        default=None,
        description="How well each pair's least distance is certified, as a share of it (never better than 1e-6 m); "
        "none: as it comes. Default: 0.01.",
    )


class MeshReference(Part):
    """A mesh file."""

    file: str = Field(min_length=1, description="OBJ, STL, PLY, OFF, GLB or 3MF, relative to the scene file.")
    units: LengthUnit = Field(description="Unit of the coordinates in the mesh file.")
    up: Literal["z", "y"] = Field(default="z", description="The file's upward axis; y is turned to z.")


class BodyPart(Part):
    """A rigid body, or a mere frame: world_from_parent * pose * motion."""

    parent: str | None = Field(default=None, description="The body that carries this one. Default: the world.")
    pose: Pose = Field(default=REST, description="In the parent. Default: at its origin, not turned.")
    shapes: tuple[ShapePart, ...] = Field(default=(), description="Rigid together.")
    motion: MotionChoice | None = Field(default=None, description="How it moves from its pose. Default: fixed.")
    groups: tuple[str, ...] = Field(default=(), description="Names for pairs to refer to.")
    exists: tuple[Number, Number] | None = Field(
        default=None, description="Seconds, from and to: the body's shapes are there in between. Default: always."
    )


class PairPart(Part):
    """Pairs with one body on each side."""

    between: tuple[str, str] = Field(description="Each a body, a group, or a pattern with * ? [ ].")
    reason: str | None = Field(default=None, description="For the reader. Default: none.")


class MarginPart(PairPart):
    """A margin of its own for pairs with one body on each side; of several that fit, the last counts."""

    margin: Margin = Field(description="In the file's length unit.")


class PairsPart(Part):
    """Which pairs are checked, and how near they may come."""

    default: Literal["check", "ignore"] = Field(default="check", description="What is done with every other pair.")
    ignore: tuple[PairPart, ...] = Field(default=(), description="Not checked.")
    check: tuple[PairPart, ...] = Field(default=(), description="Checked though ignored.")
    margins: tuple[MarginPart, ...] = Field(default=(), description="Instead of the margin in settings.")


class SceneFile(Part):
    """A native closecall scene."""

    schema_address: str | None = Field(
        default=None, alias="$schema", description="For editors; not read. Default: none."
    )
    closecall: Literal[1] = Field(description="The version of the format.")
    units: Units = Field(description="Of this file.")
    time: TimeRange = Field(description="What is checked.")
    settings: SettingsPart = Field(
        default=SettingsPart(), description="Overridden by command-line options. Default: those of each key."
    )
    meshes: dict[str, MeshReference] = Field(default_factory=dict, description="Mesh files by name. Default: none.")
    bodies: dict[str, BodyPart] = Field(description="Bodies by name.")
    pairs: PairsPart = Field(default=PairsPart(), description="Which pairs are checked. Default: all.")
