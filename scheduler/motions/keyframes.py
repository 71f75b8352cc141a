"""Keyframed motion: linear or stepped translation, slerped or stepped rotation."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from math import inf, nextafter

import numpy as np

from ..rotation import FloatArray, chord, rotation_of_quaternion, turn
from ..vector import ZERO, Vector, norm, scale
from .base import Axis, Rates, Reach


@dataclass(frozen=True, slots=True, eq=False)
class Keyframes:
    """Poses at strictly increasing times, interpolated between; held before the first key and after the last.

    Attributes:
        times: (n,) s, n >= 1.
        translations: (n, 3) m.
        quaternions: (n, 4) unit, w x y z; of either sign, since slerp takes the shortest path.
        step_translation: hold the key's translation until the next key, instead of the straight line.
        step_rotation: hold the key's rotation, instead of slerp (without fallback to lerp).
    """

    times: FloatArray
    translations: FloatArray
    quaternions: FloatArray
    step_translation: bool
    step_rotation: bool
    _knots: tuple[float, ...] = field(init=False, repr=False)
    _stops: tuple[float, ...] = field(init=False, repr=False)
    _velocities: FloatArray = field(init=False, repr=False)  # (n, 3) m/s from each key to the next, the last 0
    _spin_axes: FloatArray = field(init=False, repr=False)  # (n, 3) unit, in the rest frame
    _spin_rates: FloatArray = field(init=False, repr=False)  # (n,) rad/s
    _rotations: FloatArray = field(init=False, repr=False)  # (n, 3, 3)
    _speeds: tuple[float, ...] = field(init=False, repr=False)  # m/s from each key to the next, the last 0
    _travelled: RunningSum = field(init=False, repr=False)  # m along the path up to each key, jumps left out
    _turned: RunningSum = field(init=False, repr=False)  # rad up to each key, jumps left out

    def __post_init__(self) -> None:
        """Derive what the bounds look up: rates, and path and angle travelled up to each key."""
        durations = np.diff(self.times)
        moves = np.diff(self.translations, axis=0)
        axes, angles = _turns_between(self.quaternions)
        jumps = np.zeros(len(durations), dtype=bool)
        if self.step_translation:
            jumps |= np.any(moves != 0.0, axis=1)
            moves = np.zeros_like(moves)
        if self.step_rotation:
            jumps |= angles > 0.0
            angles = np.zeros_like(angles)
        lengths = np.linalg.norm(moves, axis=1)
        derived = {
            "_knots": tuple(map(float, self.times)),
            "_stops": tuple(stop for t in self.times[1:][jumps] for stop in (nextafter(float(t), -inf), float(t))),
            "_velocities": np.vstack((moves / durations[:, None], np.zeros(3))),
            "_spin_axes": np.vstack((axes, (1.0, 0.0, 0.0))),
            "_spin_rates": np.append(angles / durations, 0.0),
            "_rotations": np.array([rotation_of_quaternion(*map(float, q)) for q in self.quaternions]),
            "_speeds": (*(lengths / durations).tolist(), 0.0),
            "_travelled": RunningSum(lengths),
            "_turned": RunningSum(angles),
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    @property
    def axis(self) -> Axis | None:
        """None: the axis changes from segment to segment."""
        return None

    def pose(self, t: float) -> FloatArray:
        """Return rest_from_moved, 4x4; at a stepped key the pose after the step."""
        key, since = self._segment(t)
        pose = np.eye(4)
        rotation = self._rotations[key]
        if self._spin_rates[key] > 0.0:
            x, y, z = map(float, self._spin_axes[key])
            rotation = np.array(turn((x, y, z), float(self._spin_rates[key]) * since)) @ rotation
        pose[:3, :3] = rotation
        pose[:3, 3] = self.translations[key] + self._velocities[key] * since
        return pose

    def displacement(self, t: float, duration: float, reach: Reach) -> float:
        """Path and angle travelled bound it: row 'any rotation of bounded rate', about the point, plus the path."""
        path, angle = self._progress(t, duration)
        return path + chord(angle, reach.radius)

    def path_length(self, t: float, duration: float, reach: Reach) -> float:
        """Return the path of the origin plus the arc about it."""
        path, angle = self._progress(t, duration)
        return path + angle * reach.radius

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return the velocities of the segment that starts at or holds t."""
        if t < self._knots[0]:
            return ZERO, ZERO
        key, _ = self._segment(t)
        x, y, z = map(float, self._velocities[key])
        u, v, w = map(float, self._spin_axes[key])
        return (x, y, z), scale(float(self._spin_rates[key]), (u, v, w))

    def rates(self, t: float, duration: float) -> Rates:
        """Row 'slerp segment': both rates are constant from key to key."""
        velocity, spin = self.velocities(t)
        return Rates(norm(velocity), 0.0, norm(spin), 0.0)

    def knot_after(self, t: float) -> float:
        """Return the next key's time (inf: none)."""
        return _first_after(self._knots, t)

    def stop_after(self, t: float) -> float:
        """Return the next jump, or the last float before it (inf: none)."""
        return _first_after(self._stops, t)

    def extent(self, latest: float) -> float:
        """Return the farthest key's distance, three times: a key, and the way from it to the next."""
        return 3.0 * float(np.max(np.linalg.norm(self.translations, axis=1)))

    def rounding_scale(self, latest: float, radius: float) -> float:
        """The translation's terms and half a turn at `radius`: times are exact, so are seconds since a key."""
        return self.extent(latest) + 5.0 * radius

    def _segment(self, t: float) -> tuple[int, float]:
        """Return the key at or before t and the seconds since it, clamped to the keys' range."""
        key = max(0, bisect_right(self._knots, t) - 1)
        return key, max(0.0, t - self._knots[key])

    def _progress(self, t: float, duration: float) -> tuple[float, float]:
        """Return path (m) and angle (rad) travelled over [t, t + duration], up to the float after its end."""
        first, since_first = self._segment(t)
        last, since_last = self._segment(nextafter(t + duration, inf))
        path = self._travelled.between(first, last)
        path += self._speeds[last] * since_last - self._speeds[first] * since_first
        angle = self._turned.between(first, last)
        angle += float(self._spin_rates[last]) * since_last - float(self._spin_rates[first]) * since_first
        return max(0.0, path), max(0.0, angle)


class RunningSum:
    """Sums of the first n of some lengths, kept in two floats each, so that differences of far sums stay exact."""

    __slots__ = ("_high", "_low")

    def __init__(self, lengths: FloatArray) -> None:
        """Add up `lengths`, (n,)."""
        self._high, self._low = [0.0], [0.0]
        for length in lengths.tolist():
            high = self._high[-1] + length
            rest = high - self._high[-1]
            self._high.append(high)
            self._low.append(self._low[-1] + ((self._high[-2] - (high - rest)) + (length - rest)))

    def between(self, first: int, last: int) -> float:
        """Return the sum of lengths[first:last]."""
        return (self._high[last] - self._high[first]) + (self._low[last] - self._low[first])


def _turns_between(quaternions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the axes (n-1, 3), in the rest frame, and angles (n-1,) in [0, pi] of the shortest turns key to key."""
    first, last = quaternions[:-1], quaternions[1:].copy()
    last[np.sum(first * last, axis=1) < 0.0] *= -1.0
    angles = 4.0 * np.arctan2(np.linalg.norm(last - first, axis=1), np.linalg.norm(last + first, axis=1))
    # the vector part of last * conjugate(first), whose length is sin(angle / 2)
    axes = first[:, :1] * last[:, 1:] - last[:, :1] * first[:, 1:] + np.cross(first[:, 1:], last[:, 1:])
    lengths = np.linalg.norm(axes, axis=1)
    still = lengths == 0.0
    axes[still], lengths[still], angles[still] = (1.0, 0.0, 0.0), 1.0, 0.0
    return axes / lengths[:, None], angles


def _first_after(times: tuple[float, ...], t: float) -> float:
    """Return the first of the sorted times > t, inf if there is none."""
    place = bisect_right(times, t)
    return times[place] if place < len(times) else inf
