"""Motions as written to the scheduler's motions: SI units, unit axes, keys in order."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from ...scheduler.motions import Ballistic, Constant, Fixed, Harmonic, Keyframes, Motion, Screw, Swing
from ...scheduler.scene import FloatArray
from .document import Findings
from .errors import Where, quoted
from .grammar import (
    BallisticMotion,
    ConstantMotion,
    HarmonicMotion,
    Key,
    KeyframesMotion,
    MotionChoice,
    ScrewMotion,
    SwingMotion,
    TimeRange,
)
from .limits import AMBIGUOUS_TURN, WIDE_TURN
from .poses import placement, unit_vector
from .units import Scale


def motion(part: MotionChoice | None, where: Where, time: TimeRange, scale: Scale, findings: Findings) -> Motion:
    """Return the motion in SI; faults are recorded, and a motion with one may come back as Fixed.

    Args:
        part: as the grammar read it; None is a body without motion.
        where: its place in the scene.
        time: what keyframes must cover, s.
        scale: the file's units.
        findings: takes the faults.
    """
    match part:
        case ConstantMotion():
            return Constant(scale.lengths(part.velocity), scale.angles(part.angular_velocity))
        case BallisticMotion():
            return Ballistic(
                scale.lengths(part.velocity),
                scale.lengths(part.acceleration),
                scale.angles(part.angular_velocity),
            )
        case ScrewMotion():
            axis = unit_vector(part.axis, (*where, "axis"), findings)
            return Screw(axis, scale.lengths(part.point), scale.angle(part.rate), scale.length(part.pitch))
        case HarmonicMotion():
            direction = unit_vector(part.direction, (*where, "direction"), findings)
            return Harmonic(direction, scale.length(part.amplitude), part.period, scale.angle(part.phase))
        case SwingMotion():
            axis = unit_vector(part.axis, (*where, "axis"), findings)
            point, amplitude = scale.lengths(part.point), scale.angle(part.amplitude)
            return Swing(axis, point, amplitude, part.period, scale.angle(part.phase))
        case KeyframesMotion():
            return _keyframes(part, where, time, scale, findings)
        case None:
            return Fixed()


def _keyframes(part: KeyframesMotion, where: Where, time: TimeRange, scale: Scale, findings: Findings) -> Motion:
    keys = (*where, "keys")
    faults_before = len(findings.faults)
    _check_order(part.keys, keys, findings)
    if len(findings.faults) == faults_before:
        _check_cover(part.keys, keys, time, findings)
    placements = [placement(key, (*keys, i), scale, findings) for i, key in enumerate(part.keys)]
    if len(findings.faults) > faults_before:
        return Fixed()
    quaternions = np.array([place.quaternion for place in placements])
    step_rotation = part.interpolation.rotation == "step"
    if not step_rotation:
        _warn_of_wide_turns(quaternions, keys, findings)
    return Keyframes(
        times=_read_only(np.array([key.t for key in part.keys])),
        translations=_read_only(np.array([place.translation for place in placements])),
        quaternions=_read_only(quaternions),
        step_translation=part.interpolation.translation == "step",
        step_rotation=step_rotation,
    )


def _check_order(keys: tuple[Key, ...], where: Where, findings: Findings) -> None:
    for i, (before, after) in enumerate(pairwise(keys), start=1):
        if after.t == before.t:
            findings.fault((*where, i, "t"), f"two keys at {quoted(after.t)} s, expected one pose at a time")
        elif after.t < before.t:
            problem = f"expected a time after the key before it ({quoted(before.t)} s), got {quoted(after.t)} s"
            findings.fault((*where, i, "t"), problem)


def _check_cover(keys: tuple[Key, ...], where: Where, time: TimeRange, findings: Findings) -> None:
    first, last = keys[0].t, keys[-1].t
    if first > time.start:
        problem = f"expected the first key at the time range's start ({quoted(time.start)} s) or before"
        findings.fault((*where, 0, "t"), f"{problem}, got {quoted(first)} s")
    if last < time.end:
        problem = f"expected the last key at the time range's end ({quoted(time.end)} s) or after"
        findings.fault((*where, len(keys) - 1, "t"), f"{problem}, got {quoted(last)} s")


def _warn_of_wide_turns(quaternions: FloatArray, where: Where, findings: Findings) -> None:
    """Warn where slerp's way between two keys may not be the one that was meant."""
    one, other = quaternions[:-1], quaternions[1:]
    near, far = np.linalg.norm(other - one, axis=1), np.linalg.norm(other + one, axis=1)
    angles = 4.0 * np.arctan2(np.minimum(near, far), np.maximum(near, far))
    for i in np.flatnonzero(angles > math.radians(WIDE_TURN)):
        between = f"keys {i} and {i + 1} are {math.degrees(angles[i]):.1f} degrees apart"
        if angles[i] > math.pi - AMBIGUOUS_TURN:
            findings.warn((*where, int(i) + 1), f"{between}: which way round is ambiguous, add a key between")
        else:
            findings.warn((*where, int(i) + 1), f"{between}: the shorter way is taken, is a key missing?")


def _read_only(array: FloatArray) -> FloatArray:
    array.flags.writeable = False
    return array
