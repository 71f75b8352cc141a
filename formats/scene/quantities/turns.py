"""Turns from one pose to the next: the way that slerp takes, and the way that the angles as written would mean."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ....scheduler.geometry.arrays import FloatArray
from ..grammar.poses import Pose
from ..limits import AMBIGUOUS_TURN, PARALLEL_AXES, WIDE_TURN
from .poses import Quaternion, Vector, successive_turns, turn_about, turn_about_fixed_axes
from .units import Scale

_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_ALL_THE_WAY = "constant, screw, swing and profile (kind: turn) turn all the way"


class Spelling(NamedTuple):
    """A rotation as its angles are written, whole turns too.

    Attributes:
        axis: unit; None where roll, pitch and yaw turn about more than one.
        angle: rad about the axis.
        fixed: rad, roll, pitch and yaw; None where they are not what is written.
        lift: the quaternion that follows the angles from no turn on: its sign changes with a whole turn.
    """

    axis: Vector | None
    angle: float
    fixed: Vector | None
    lift: Quaternion


def spelling_of(pose: Pose, scale: Scale) -> Spelling | None:
    """Return how a pose's rotation is written; None for a quaternion or a matrix, which say no way to get there."""
    if pose.quat_wxyz or pose.quat_xyzw or pose.matrix:
        return None
    if pose.rpy is not None:
        fixed = scale.angles(pose.rpy)
        turned = [place for place, angle in enumerate(fixed) if angle != 0.0]
        place = turned[0] if turned else 0
        axis = _AXES[place] if len(turned) < 2 else None
        return Spelling(axis, fixed[place], fixed, turn_about_fixed_axes(*(scale.turn(a, 2) for a in pose.rpy)))
    if pose.axis_angle is not None:
        x, y, z = pose.axis_angle.axis
        length = math.hypot(x, y, z)
        axis = (x / length, y / length, z / length)
        lift = turn_about(axis, scale.turn(pose.axis_angle.angle, 2))
        return Spelling(axis, scale.angle(pose.axis_angle.angle), None, lift)
    return Spelling(_AXES[0], 0.0, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))


def written_turn(one: Spelling | None, other: Spelling | None) -> float:
    """Return the angle (rad) from one rotation to another as they are written, 0 where that says no way."""
    if one is None or other is None:
        return 0.0
    if one.axis is not None and other.axis is not None:
        if one.angle == 0.0 or other.angle == 0.0:
            return abs(other.angle - one.angle)
        along = sum(a * b for a, b in zip(one.axis, other.axis, strict=True))
        if abs(along) > 1.0 - PARALLEL_AXES:
            return abs(other.angle - math.copysign(one.angle, along * one.angle))
    turn = 2.0 * math.acos(max(-1.0, min(1.0, sum(a * b for a, b in zip(one.lift, other.lift, strict=True)))))
    if one.fixed is None or other.fixed is None:
        return turn
    return max(turn, *(abs(b - a) for a, b in zip(one.fixed, other.fixed, strict=True)))


def written_turns(angles: FloatArray, lifts: FloatArray) -> FloatArray:
    """Return the same (n - 1,) for successive roll, pitch, yaw (n, 3) in rad, with their quaternions (n, 4)."""
    along = np.clip(np.sum(lifts[1:] * lifts[:-1], axis=1), -1.0, 1.0)
    turns: FloatArray = np.maximum(2.0 * np.arccos(along), np.abs(np.diff(angles, axis=0)).max(axis=1))
    return turns


def turn_warnings(
    quaternions: FloatArray, written: FloatArray | None, between: Callable[[int], str], thing: str
) -> list[tuple[int, str]]:
    """Return what may mislead in slerp's way from one pose to the next: of each kind the first place, and a warning.

    Args:
        quaternions: (n, 4), unit.
        written: (n - 1,) rad, the turns as they are written; None where the spelling says no way.
        between: tells of which two poses the one at an index and the next are.
        thing: what a pose is called.
    """
    angles = successive_turns(quaternions)
    meant = np.zeros_like(angles) if written is None else written
    longer = meant > math.pi + AMBIGUOUS_TURN
    ambiguous = (angles > math.pi - AMBIGUOUS_TURN) & ~longer
    wide = (angles > math.radians(WIDE_TURN)) & ~ambiguous & ~longer
    warnings = []
    for found, remark in (
        (longer, f"write angles up to 180 degrees apart if that is meant, else {_ALL_THE_WAY}"),
        (ambiguous, f"which way round is ambiguous, add a {thing} between"),
        (wide, f"the shorter way is taken, is a {thing} missing?"),
    ):
        places = np.flatnonzero(found)
        if len(places):
            first = int(places[0])
            others = f" (and {len(places) - 1} more such)" if len(places) > 1 else ""
            text = f"{between(first)} are {math.degrees(angles[first]):.1f} degrees apart{others}"
            if found is longer:
                text = f"{between(first)} are written {math.degrees(meant[first]):.1f} degrees apart{others}, "
                text += f"slerp turns {math.degrees(angles[first]):.1f} degrees, the shorter way"
            warnings.append((first, f"{text}: {remark}"))
    return warnings
