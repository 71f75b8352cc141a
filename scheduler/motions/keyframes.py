"""Keyframed motion: linear, cubic or stepped translation, slerped or stepped rotation; held outside the keys."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from math import inf, nextafter

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.transform import chord, transform
from ..geometry.vector import ZERO, Vector, norm, unit
from .acceleration_set import STILL
from .key_interpolation import Translation, path_between
from .key_interval import Span, end_of
from .key_rotation import KeyRotation
from .key_translation import Path
from .motion import Axis, Interval, LeverArms, Rates


@dataclass(frozen=True, slots=True, eq=False)
class Keyframes:
    """Poses at strictly increasing times, interpolated between; held before the first key and after the last.

    Attributes:
        times: (n,) s, n >= 1.
        translations: (n, 3) m.
        quaternions: (n, 4) unit, w x y z; of either sign, since slerp takes the shortest path.
        translation: how the translation runs from key to key.
        step_rotation: hold the key's rotation, instead of slerp (without fallback to lerp).
        key_velocities: (n, 3) m/s of the origin at the keys, for a cubic translation; None: non-uniform Catmull-Rom.
    """

    times: FloatArray
    translations: FloatArray
    quaternions: FloatArray
    translation: Translation
    step_rotation: bool
    key_velocities: FloatArray | None = None
    path: Path = field(init=False, repr=False)
    turning: KeyRotation = field(init=False, repr=False)
    _knots: tuple[float, ...] = field(init=False, repr=False)
    _jumps: tuple[float, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Derive what the bounds look up."""
        path = path_between(self.times, self.translations, self.translation, self.key_velocities)
        turning = KeyRotation(self.quaternions, np.diff(self.times), self.step_rotation)
        derived = {
            "path": path,
            "turning": turning,
            "_knots": tuple(self.times.tolist()),
            "_jumps": tuple(self.times[1:][path.jumps | turning.jumps].tolist()),
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    @property
    def axis(self) -> Axis | None:
        """None: the axis changes from segment to segment."""
        return None

    def pose(self, t: float) -> FloatArray:
        """Return rest_from_moved, 4x4; at a stepped key the pose after the step."""
        key, since = self.segment(t)
        return transform(self.turning.rotation(key, since), self.path.position(key, since))

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Row `Keyframes`: control points, boxes around whole segments or the path gone; and row `slerp`."""
        span = self.span(t, end_of(t, duration))
        return self.path.displacement(span) + chord(self.turning.angle(span), reach.radius)

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """Return the path of the origin plus the arc about it."""
        span = self.span(t, end_of(t, duration))
        return self.path.length(span) + self.turning.angle(span) * reach.radius

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return the velocities of the segment that starts at or holds t."""
        if t < self._knots[0]:
            return ZERO, ZERO
        key, since = self.segment(t)
        return self.path.velocity(key, since), self.turning.velocity(key)

    def rates(self, t: float, duration: float) -> Rates:
        """Rows `Keyframes` and `slerp`, whose rate is constant."""
        if t < self._knots[0]:
            return Rates(0.0, STILL, 0.0, 0.0)
        key, since = self.segment(t)
        speed, steady, varying = self.path.rates(key, since, duration)
        turning = self.turning.velocity(key)
        return Rates(speed, varying, norm(turning), 0.0, steady, unit(turning))

    def knot_after(self, t: float) -> float:
        """Return the next key's time (inf: none)."""
        return first_after(self._knots, t)

    def jump_after(self, t: float) -> float:
        """Return the next time that the pose is not continuous at (inf: none)."""
        return first_after(self._jumps, t)

    def stop_after(self, t: float) -> float:
        """Return the next jump, or the last float before it (inf: none)."""
        return stop_before(self.jump_after(t), t)

    def extent(self, times: Interval) -> float:
        """Return the largest sum of the terms of any segment."""
        return self.path.extent

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """The translation's terms and half a turn at `radius`: times are exact, so are seconds since a key."""
        return 2.0 * self.extent(times) + 5.0 * radius

    def segment(self, t: float) -> tuple[int, float]:
        """Return the key at or before t and the seconds since it, clamped to the first key."""
        key = max(0, bisect_right(self._knots, t) - 1)
        return key, max(0.0, t - self._knots[key])

    def span(self, start: float, end: float) -> Span:
        """Return the stretch of the keys from `start` to `end`, s."""
        return Span(*self.segment(start), *self.segment(end))


def first_after(times: tuple[float, ...], t: float) -> float:
    """Return the first of the sorted times > t, inf if there is none."""
    place = bisect_right(times, t)
    return times[place] if place < len(times) else inf


def stop_before(jump: float, t: float) -> float:
    """Return the last float before a jump if it is later than t, else the jump."""
    before = nextafter(jump, -inf)
    return before if t < before and jump < inf else jump
