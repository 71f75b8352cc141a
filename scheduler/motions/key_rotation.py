"""The rotation of keyframes: the shortest turn from each key to the next at a constant rate, or steps."""

from __future__ import annotations

import numpy as np

from ..geometry.arrays import BoolArray, FloatArray
from ..geometry.transform import IDENTITY, Rows, multiplied, rotation_of_quaternion, turn
from ..geometry.vector import Vector, scale
from .key_interval import RunningSum, Span


class KeyRotation:
    """Slerp between keys (without fallback to lerp), or steps; at rest after the last key.

    Attributes:
        jumps: (keys - 1,) whether the next key is jumped to.
        fastest: rad/s, the greatest rate anywhere.
    """

    __slots__ = (
        "_axes",
        "_durations",
        "_quaternions",
        "_rates",
        "_recent",
        "_rotations",
        "_turned",
        "fastest",
        "jumps",
    )

    def __init__(self, quaternions: FloatArray, durations: FloatArray, steps: bool) -> None:
        """Take the keys' quaternions (keys, 4) w x y z, of either sign, and the seconds between them (keys - 1,)."""
        axes, angles = turns_between(quaternions[:-1], quaternions[1:])
        self.jumps: BoolArray = (angles > 0.0) if steps else np.zeros(len(angles), dtype=bool)
        if steps:
            angles = np.zeros_like(angles)
        self._quaternions = quaternions
        self._durations: list[float] = durations.tolist()
        self._axes: list[list[float]] = [*axes.tolist(), [1.0, 0.0, 0.0]]
        self._rates: list[float] = [*(angles / durations).tolist(), 0.0]
        self._rotations = np.array([rotation_of_quaternion(*map(float, q)) for q in quaternions])
        self._recent: tuple[int, Rows] = -1, IDENTITY  # the last key asked for, and the rotation there
        self._turned = RunningSum(angles)
        self.fastest = max(self._rates)

    @property
    def gap(self) -> float:
        """The angle (rad) between the orientation just before the last key and the first key's."""
        last = self._quaternions[-2:-1] if np.any(self.jumps[-1:]) else self._quaternions[-1:]
        return float(turns_between(last, self._quaternions[:1])[1][0])

    def rotation(self, key: int, since: float) -> Rows:
        """Return the rotation `since` s after a key."""
        if self._recent[0] != key:
            a, b, c = self._rotations[key].tolist()
            self._recent = key, (tuple(a), tuple(b), tuple(c))
        first = self._recent[1]
        if self._rates[key] == 0.0:
            return first
        x, y, z = self._axes[key]
        return multiplied(turn((x, y, z), self._rates[key] * since), first)

    def velocity(self, key: int) -> Vector:
        """Return the angular velocity (rad/s) from a key to the next."""
        x, y, z = self._axes[key]
        return scale(self._rates[key], (x, y, z))

    def angle(self, span: Span) -> float:
        """Return the angle (rad) turned over the span, jumps left out: row `slerp`."""
        first, since_first, last, since_last = span
        if first == last:
            return self._rates[first] * max(0.0, since_last - since_first)
        rest = self._rates[first] * max(0.0, self._durations[first] - since_first)
        return rest + self._turned.between(first + 1, last) + self._rates[last] * since_last


def turns_between(first: FloatArray, last: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the axes (n, 3), in the rest frame, and angles (n,) in [0, pi] of the shortest turns, (n, 4) each."""
    last = last.copy()
    last[np.sum(first * last, axis=1) < 0.0] *= -1.0
    angles = 4.0 * np.arctan2(np.linalg.norm(last - first, axis=1), np.linalg.norm(last + first, axis=1))
    # the vector part of last * conjugate(first), whose length is sin(angle / 2)
    axes = first[:, :1] * last[:, 1:] - last[:, :1] * first[:, 1:] + np.cross(first[:, 1:], last[:, 1:])
    lengths = np.linalg.norm(axes, axis=1)
    still = lengths == 0.0
    axes[still], lengths[still], angles[still] = (1.0, 0.0, 0.0), 1.0, 0.0
    return axes / lengths[:, None], angles
