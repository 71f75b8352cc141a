"""Poses as they are written: a translation and at most one way to write a rotation."""

from __future__ import annotations

from itertools import combinations

from pydantic import ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from .base import Number, Part, Quaternion, Vector


class AxisAngle(Part):
    """A turn about an axis."""

    axis: Vector = Field(description="Direction of the axis, of any length but 0.")
    angle: Number = Field(description="Right-handed angle about the axis, in the file's angle unit.")


ROTATIONS = ("quat_wxyz", "quat_xyzw", "rpy", "axis_angle", "matrix")
_NEVER_TOGETHER = (*combinations(ROTATIONS, 2), ("xyz", "matrix"))


class Pose(Part):
    """Where a frame lies in its parent: child coordinates become the parent's."""

    model_config = ConfigDict(
        json_schema_extra={"not": {"anyOf": [{"required": list(keys)} for keys in _NEVER_TOGETHER]}}
    )
    xyz: Vector | None = Field(default=None, description="Translation, in the file's length unit. Default: none.")
    quat_wxyz: Quaternion | None = Field(
        default=None, description="Unit quaternion to 0.001, scalar first. Default: no turn."
    )
    quat_xyzw: Quaternion | None = Field(
        default=None, description="Unit quaternion to 0.001, scalar last. Default: no turn."
    )
    rpy: Vector | None = Field(
        default=None,
        description="Turns about the fixed axes x, then y, then z, in the file's angle unit. Default: no turn.",
    )
    axis_angle: AxisAngle | None = Field(
        default=None, description="An axis, and the angle of the turn about it. Default: no turn."
    )
    matrix: tuple[Quaternion, Quaternion, Quaternion, Quaternion] | None = Field(
        default=None,
        description="4x4, row-major, parent from child: a rotation to 0.001, translation in the file's length unit. "
        "Alone. Default: none.",
    )

    @model_validator(mode="after")
    def _one_rotation(self) -> Pose:
        given = [name for name in ROTATIONS if getattr(self, name) is not None]
        if len(given) > 1:
            text = f"expected at most one of {', '.join(ROTATIONS)}, got {' and '.join(given)}"
            raise PydanticCustomError("pose", "{text}", {"text": text})
        if self.matrix is not None and self.xyz is not None:
            text = "expected matrix alone, got xyz too (the translation is the matrix's last column)"
            raise PydanticCustomError("pose", "{text}", {"text": text})
        return self


REST = Pose()
