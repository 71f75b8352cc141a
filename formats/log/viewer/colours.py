"""Colours, as sRGB shares of 1: muted for bodies, so that clearances and contacts stand out, on dark and light."""

from __future__ import annotations

from dataclasses import dataclass
from math import log10

from foxglove_schemas_protobuf.Color_pb2 import Color

RGB = tuple[float, float, float]

MOVING: tuple[RGB, ...] = (
    (0.40, 0.58, 0.78),
    (0.82, 0.72, 0.50),
    (0.64, 0.54, 0.76),
    (0.42, 0.68, 0.70),
    (0.76, 0.58, 0.62),
    (0.55, 0.62, 0.45),
)
FIXED: tuple[RGB, ...] = ((0.60, 0.62, 0.65), (0.70, 0.69, 0.66), (0.52, 0.55, 0.60))

RED: RGB = (0.90, 0.22, 0.20)
AMBER: RGB = (0.96, 0.70, 0.20)
YELLOW: RGB = (1.00, 0.95, 0.20)
WHITE: RGB = (1.0, 1.0, 1.0)
GREEN: RGB = (0.36, 0.78, 0.42)


def colour(rgb: RGB, opacity: float = 1.0) -> Color:
    """Return the colour as a message."""
    red, green, blue = rgb
    return Color(r=red, g=green, b=blue, a=opacity)


@dataclass(frozen=True, slots=True)
class ClearanceScale:
    """Colours for distances, by their logarithm: red up to `near`, amber half-way, green from `far` (m) on."""

    near: float
    far: float

    def rgb(self, distance: float) -> RGB:
        """Return the colour of a distance >= 0, m."""
        if distance <= self.near:
            return RED
        share = min(1.0, log10(distance / self.near) / log10(self.far / self.near))
        return mixed(RED, AMBER, 2.0 * share) if share < 0.5 else mixed(AMBER, GREEN, 2.0 * share - 1.0)


def mixed(one: RGB, other: RGB, share: float) -> RGB:
    """Return a colour on the way from one to another, which a share of 1 reaches."""
    red, green, blue = (a + share * (b - a) for a, b in zip(one, other, strict=True))
    return (red, green, blue)
