"""What every mapping of the scene file shares: how numbers, sizes and directions are written."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from ..limits import LARGEST_NUMBER, SMALLEST_SIZE


def _without_sign_of_zero(value: float) -> float:
    return value + 0.0


Number = Annotated[float, Field(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER), AfterValidator(_without_sign_of_zero)]
Size = Annotated[float, Field(ge=SMALLEST_SIZE, le=LARGEST_NUMBER)]
Margin = Annotated[float, Field(ge=0.0, le=LARGEST_NUMBER), AfterValidator(_without_sign_of_zero)]
Share = Annotated[float, Field(ge=1e-6, lt=1.0)]
Vector = tuple[Number, Number, Number]
Quaternion = tuple[Number, Number, Number, Number]
LengthUnit = Literal["m", "cm", "mm", "in", "ft"]

ORIGIN: Vector = (0.0, 0.0, 0.0)


class Part(BaseModel):
    """A mapping of the scene file."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)
