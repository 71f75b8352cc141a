"""The rotations of a trajectory file: columns to unit quaternions, and what is doubtful in them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ..limits import ROTATION_ROUNDING, ROTATION_TOLERANCE
from ..quantities.poses import nearest_rotations, quaternion_of, rotation_fault, stretch_of_length
from ..quantities.turns import turn_warnings, written_turns
from ..text.errors import counted, quoted
from .table import Faults


class Rotations(NamedTuple):
    """The rotations of n poses.

    Attributes:
        quaternions: (n, 4) w x y z of length 1, each in the sign that the file has.
        angles: (n, 3) rad, roll, pitch and yaw; None where those are not in the file.
        stretch: how far the worst one stretches, less 1.
        loose: what is off with how many; empty where nothing is that is to be told.
    """

    quaternions: FloatArray
    angles: FloatArray | None = None
    stretch: float = 0.0
    loose: str = ""


def read_rotations(columns: FloatArray, lines: IntArray, radians_per_unit: float, faults: Faults) -> Rotations:
    """Return the rotations of a file, faults recorded.

    Args:
        columns: (n, k): of quaternions w x y z, of roll, pitch and yaw, of matrices by rows, or none.
        lines: (n,) where each is.
        radians_per_unit: rad, the unit of roll, pitch and yaw.
        faults: takes those that are no rotations.
    """
    match columns.shape[1]:
        case 0:
            return Rotations(np.tile((1.0, 0.0, 0.0, 0.0), (len(lines), 1)))
        case 3:
            angles = columns * radians_per_unit
            quaternions = _of_fixed_axes(angles)
            return Rotations(quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True), angles)
        case 9:
            return _of_matrices(columns.reshape(-1, 3, 3), lines, faults)
        case _:
            return _of_quaternions(columns, lines, faults)


def turns_told(quaternions: FloatArray, angles: FloatArray | None, lines: IntArray) -> tuple[str, ...]:
    """Return the warnings where slerp's way between two poses may not be the one that was meant."""
    written = None if angles is None else written_turns(angles, quaternions)
    found = turn_warnings(quaternions, written, lambda i: f"lines {lines[i]} and {lines[i + 1]}", "pose")
    return tuple(text for _, text in found)


def _of_quaternions(columns: FloatArray, lines: IntArray, faults: Faults) -> Rotations:
    lengths: FloatArray = np.linalg.norm(columns, axis=1)
    off: FloatArray = np.abs(lengths - 1.0)
    for i in np.flatnonzero(off > ROTATION_TOLERANCE).tolist():
        faults.add(int(lines[i]), f"expected a unit quaternion, got one of length {quoted(float(lengths[i]))}")
    quaternions = columns / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    loose = _told(off, lines, "quaternion", "quaternions", "whose length is off 1")
    return Rotations(quaternions, None, max(map(stretch_of_length, lengths.tolist()), default=0.0), loose)


def _of_matrices(matrices: FloatArray, lines: IntArray, faults: Faults) -> Rotations:
    """Return the rotations nearest to (n, 3, 3) matrices."""
    nearest, off = nearest_rotations(matrices)
    for line, rotation, stretch in zip(lines.tolist(), nearest, off.tolist(), strict=True):
        problem = rotation_fault(rotation, stretch)
        if problem:
            faults.add(line, problem)
    quaternions = np.array([quaternion_of(rotation) for rotation in nearest])
    loose = _told(off, lines, "matrix", "matrices", "off a rotation")
    return Rotations(quaternions, None, float(off.max(initial=0.0)), loose)


def _told(off: FloatArray, lines: IntArray, thing: str, things: str, what: str) -> str:
    """Return what is off with how many of a file's rotations, by up to how much and in which line."""
    count = int(np.count_nonzero(off > ROTATION_ROUNDING))
    if not count:
        return ""
    worst = int(np.argmax(off))
    return f"has {counted(count, thing, things)} {what}, by up to {off[worst]:.2g} in line {lines[worst]}"


def _of_fixed_axes(angles: FloatArray) -> FloatArray:
    """Return the quaternions (n, 4) of Rz(yaw) Ry(pitch) Rx(roll) from roll, pitch, yaw (n, 3) in rad."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles / 2.0).T, np.sin(angles / 2.0).T
    return np.column_stack(
        (
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        )
    )
