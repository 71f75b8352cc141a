"""Where the attached layout looks from: all bodies in view, motion in its full width, as near as it may be."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import atan2, cos, degrees, radians, sin, tan

import numpy as np

from ....scheduler.geometry.arrays import FloatArray
from .view_extent import Reach

FIELD_OF_VIEW = 45.0  # degrees, upright
_ASPECT = 1.05  # width by height of the 3D panel, while the sidebar is open
_FILL = 0.92  # of the panel's half height and width

# Seen from a side and above; what is flat is seen more from above. Degrees from the z axis.
_SLANT, _SLANT_OF_FLAT, _FLATNESS = 62.0, 38.0, 0.2

# Degrees off the direction across which motion spreads most: what is square is not seen face on.
_OBLIQUE = 20.0

# As wide as long, nearly: such motion has no direction, and is seen along y.
_ROUND = 0.8


@dataclass(frozen=True, eq=False)
class Camera:
    """Where the camera looks at (m, world), from how far (m), and from where.

    Attributes:
        phi: degrees from the z axis.
        theta: degrees about the z axis; from 0 the camera looks along y, from 90 along x.
    """

    target: FloatArray
    distance: float
    phi: float
    theta: float

    @cached_property
    def _axes(self) -> FloatArray:
        return _axes(self.phi, self.theta)

    @cached_property
    def place(self) -> FloatArray:
        """Where the camera is, (3,) m in the world."""
        place: FloatArray = self.target - self.distance * self._axes[2]
        return place

    def picture(self, point: FloatArray) -> tuple[float, float]:
        """Return where a point (3,) m is seen: to the right and up, in halves of the picture's height."""
        across, upright, depth = (self._axes @ (point - self.place)).tolist()
        half = max(depth, 1e-9 * self.distance) * tan(radians(FIELD_OF_VIEW / 2.0))
        return across / half, upright / half


def camera(reach: Reach) -> Camera:
    """Return a camera that has all in view, as near as it may be."""
    x, y, z = (reach.high - reach.low).tolist()
    phi = _SLANT_OF_FLAT if z < _FLATNESS * max(x, y) else _SLANT
    theta = _bearing(reach)
    axes = _axes(phi, theta)
    across, upright, depth = np.ascontiguousarray((reach.points @ axes.T).T)
    target = axes @ (0.5 * (reach.low + reach.high))
    high, distance = _FILL * tan(radians(FIELD_OF_VIEW / 2.0)), reach.size
    for _ in range(8):  # the picture of the points comes nearer to the middle with each round
        depths = np.maximum(distance + depth - target[2], 1e-3 * reach.size)
        for axis, seen in enumerate((across, upright)):
            slopes = (seen - target[axis]) / depths
            target[axis] += 0.5 * distance * (slopes.min() + slopes.max())
        widths = np.maximum(np.abs(across - target[0]) / _ASPECT, np.abs(upright - target[1])) / high
        distance = max(float((widths - depth).max() + target[2]), 0.1 * reach.size)
    return Camera(target @ axes, distance, phi, theta)


def _bearing(reach: Reach) -> float:
    """Return theta from which motion is seen in its full width, from the side where it takes place."""
    if len(reach.moving) < 2:
        return _OBLIQUE
    flat = reach.moving[:, :2]
    spreads, directions = np.linalg.eigh(np.cov(flat, rowvar=False))
    if spreads[0] > _ROUND * spreads[1]:
        return _OBLIQUE
    x, y = directions[:, 0]  # across the widest spread
    aside = flat.mean(axis=0) - 0.5 * (reach.low + reach.high)[:2]
    towards = float(aside @ (x, y))
    if abs(towards) < 0.02 * reach.size:
        towards = -y  # no side is better: from the front
    side = 1.0 if towards >= 0.0 else -1.0
    return degrees(atan2(-side * x, -side * y)) + _OBLIQUE


def _axes(phi: float, theta: float) -> FloatArray:
    """Return unit vectors to the right, up and forward of a camera, in the world, as rows (3, 3)."""
    tilt, turn = radians(phi), radians(theta)
    right = np.array((cos(turn), -sin(turn), 0.0))
    forward = np.array((sin(tilt) * sin(turn), sin(tilt) * cos(turn), -cos(tilt)))
    return np.array((right, np.cross(right, forward), forward))
