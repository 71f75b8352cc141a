"""Shapes as they are written: each a mapping with one key that names its kind, and a pose."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from .base import Part, Size
from .poses import REST, Pose


class ShapeBase(Part):
    """A shape in its own frame."""

    pose: Pose = Field(default=REST, description="Of the shape's frame, in the body. Default: the body's own.")


class Box(ShapeBase):
    """A box about the origin of its pose."""

    box: tuple[Size, Size, Size] = Field(description="Full lengths along x, y, z, in the file's length unit.")


class Sphere(ShapeBase):
    """A sphere about the origin of its pose."""

    sphere: Size = Field(description="Radius, in the file's length unit.")


class CapsuleSize(Part):
    """All points within a radius of a segment."""

    radius: Size = Field(description="In the file's length unit.")
    length: Size = Field(description="Of the segment, without the round ends, in the file's length unit.")


class Capsule(ShapeBase):
    """A capsule about the origin of its pose, along z."""

    capsule: CapsuleSize = Field(description="Radius and length.")


class RoundSize(Part):
    """The size of a cylinder or a cone."""

    radius: Size = Field(description="Of the cylinder, or of the cone's base, in the file's length unit.")
    length: Size = Field(description="Along z, in the file's length unit.")


class Cylinder(ShapeBase):
    """A cylinder about the origin of its pose, along z."""

    cylinder: RoundSize = Field(description="Radius and length.")


class Cone(ShapeBase):
    """A cone along z: its base at -length/2, its apex at +length/2."""

    cone: RoundSize = Field(description="Radius of the base, and length.")


class Ellipsoid(ShapeBase):
    """An ellipsoid about the origin of its pose."""

    ellipsoid: tuple[Size, Size, Size] = Field(description="Half axes along x, y, z, in the file's length unit.")


def _scale_tag(value: Any) -> str:
    return "each" if isinstance(value, tuple | list) else "all"


Scale = Annotated[
    Annotated[Size, Tag("all")] | Annotated[tuple[Size, Size, Size], Tag("each")],
    Discriminator(_scale_tag),
]


class MeshShape(ShapeBase):
    """A mesh from `meshes`."""

    mesh: str = Field(description="A name from meshes.")
    scale: Scale = Field(default=1.0, description="Factor of the mesh's size, or one each along its x, y, z.")


SHAPES = ("mesh", "box", "sphere", "capsule", "cylinder", "cone", "ellipsoid")


def _shape_tag(value: Any) -> str | None:
    kinds = [kind for kind in SHAPES if kind in value] if isinstance(value, dict) else []
    return kinds[0] if len(kinds) == 1 else None


ShapePart = Annotated[
    Annotated[MeshShape, Tag("mesh")]
    | Annotated[Box, Tag("box")]
    | Annotated[Sphere, Tag("sphere")]
    | Annotated[Capsule, Tag("capsule")]
    | Annotated[Cylinder, Tag("cylinder")]
    | Annotated[Cone, Tag("cone")]
    | Annotated[Ellipsoid, Tag("ellipsoid")],
    Discriminator(_shape_tag),
]
