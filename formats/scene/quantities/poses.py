"""Poses as written to poses as used: a translation in m and a unit quaternion, however they were spelt."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ....scheduler.geometry.arrays import FloatArray
from ....scheduler.geometry.transform import rotation_of_quaternion
from ..grammar.poses import Pose
from ..limits import LAST_ROW_TOLERANCE, ROTATION_ROUNDING, ROTATION_TOLERANCE, SHORTEST_DIRECTION
from ..text.document import Findings
from ..text.errors import Where, quoted
from .arrays import read_only
from .units import Scale

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

UNTURNED: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Placement:
    """A rigid placement: translation in m, then a unit quaternion w x y z."""

    translation: Vector
    quaternion: Quaternion

    def matrix(self) -> FloatArray:
        """Return the 4x4 parent_from_child, read-only."""
        pose = np.eye(4)
        pose[:3, :3] = rotation_of_quaternion(*self.quaternion)
        pose[:3, 3] = self.translation
        return read_only(pose)


def placement(pose: Pose, where: Where, scale: Scale, findings: Findings) -> Placement:
    """Return the pose in SI; a fault found on the way is recorded, and stands in as no rotation.

    Args:
        pose: as the grammar read it.
        where: its place in the scene.
        scale: the file's units.
        findings: takes the faults.
    """
    if pose.matrix is not None:
        translation = scale.lengths(row[3] for row in pose.matrix[:3])
        return Placement(translation, _from_matrix(np.array(pose.matrix), (*where, "matrix"), findings))
    translation = (0.0, 0.0, 0.0) if pose.xyz is None else scale.lengths(pose.xyz)
    return Placement(translation, _quaternion(pose, where, scale, findings))


def unit_vector(vector: Vector, where: Where, findings: Findings) -> Vector:
    """Return `vector` over its length; one too short to have a direction is recorded as a fault, and x stands in."""
    length = math.hypot(*vector)
    if length < SHORTEST_DIRECTION:
        got = f"a vector of length {quoted(length)}, too short for its digits: multiply it by 1e300"
        findings.fault(where, f"expected a direction, got {got if length else 'the zero vector'}")
        return (1.0, 0.0, 0.0)
    x, y, z = (component / length for component in vector)
    return x, y, z


def _quaternion(pose: Pose, where: Where, scale: Scale, findings: Findings) -> Quaternion:
    if pose.quat_wxyz is not None:
        return _normalised(pose.quat_wxyz, (*where, "quat_wxyz"), findings)
    if pose.quat_xyzw is not None:
        x, y, z, w = pose.quat_xyzw
        return _normalised((w, x, y, z), (*where, "quat_xyzw"), findings)
    if pose.rpy is not None:
        return turn_about_fixed_axes(*map(scale.turn, pose.rpy))
    if pose.axis_angle is not None:
        axis = unit_vector(pose.axis_angle.axis, (*where, "axis_angle", "axis"), findings)
        return turn_about(axis, scale.turn(pose.axis_angle.angle))
    return UNTURNED


def _normalised(quaternion: Quaternion, where: Where, findings: Findings) -> Quaternion:
    length = math.hypot(*quaternion)
    off = abs(length - 1.0)
    if off > ROTATION_TOLERANCE:
        findings.fault(where, f"expected a unit quaternion, got one of length {quoted(length)}")
        return UNTURNED
    if off > ROTATION_ROUNDING:
        findings.loose(where, stretch_of_length(length), f"the quaternion's length is off 1 by {off:.2g}")
    w, x, y, z = (component / length for component in quaternion)
    return w, x, y, z


def turn_about(axis: Vector, angle: float) -> Quaternion:
    """Return the turn by `angle` (rad) about a unit axis."""
    x, y, z = (component * math.sin(angle / 2) for component in axis)
    return math.cos(angle / 2), x, y, z


def turn_about_fixed_axes(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return Rz(yaw) Ry(pitch) Rx(roll), angles in rad."""
    about_x = turn_about((1.0, 0.0, 0.0), roll)
    about_y = turn_about((0.0, 1.0, 0.0), pitch)
    about_z = turn_about((0.0, 0.0, 1.0), yaw)
    w, x, y, z = _product(about_z, _product(about_y, about_x))
    length = math.hypot(w, x, y, z)
    return w / length, x / length, y / length, z / length


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation b followed by a."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


def stretch_of_length(length: float) -> float:
    """Return how far a quaternion of this length stretches, less 1: read as it is, it does so by the square."""
    return abs(length - 1.0) * (length + 1.0)


def nearest_rotations(matrices: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the orthogonal matrices (n, 3, 3) nearest to (n, 3, 3), and how far (n,) these stretch, less 1.

    The nearest matrix moves a point by as much, times its distance from the origin, at most. It mirrors where they do.
    """
    left, stretches, right = np.linalg.svd(matrices)
    off: FloatArray = np.abs(stretches - 1.0).max(axis=-1)
    return left @ right, off


def rotation_fault(nearest: FloatArray, off: float) -> str:
    """Return what keeps a matrix from being a rotation, nothing if it is one within ROTATION_TOLERANCE.

    Args:
        nearest, off: as `nearest_rotations` returns them for the matrix.
    """
    if off > ROTATION_TOLERANCE:
        return f"expected a rotation, got a matrix that scales or shears by {off:.2g}"
    if np.linalg.det(nearest) < 0.0:
        return "expected a rotation, got a matrix that mirrors"
    return ""


def _from_matrix(matrix: FloatArray, where: Where, findings: Findings) -> Quaternion:
    """Return the rotation nearest to a 4x4 matrix, a rigid transform within ROTATION_TOLERANCE."""
    if np.abs(matrix[3] - (0.0, 0.0, 0.0, 1.0)).max() > LAST_ROW_TOLERANCE:
        findings.fault(where, "expected the last row 0, 0, 0, 1 (matrices are row-major)")
        return UNTURNED
    (nearest,), (off,) = nearest_rotations(matrix[None, :3, :3])
    problem = rotation_fault(nearest, off)
    if problem:
        findings.fault(where, problem)
        return UNTURNED
    if off > ROTATION_ROUNDING:
        findings.loose(where, float(off), f"the matrix is off a rotation by {off:.2g}")
    return quaternion_of(nearest)


def quaternion_of(rotation: FloatArray) -> Quaternion:
    """Return the quaternion of a 3x3 rotation, from the largest of its four components (Shepperd, 1978)."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation.tolist()
    rows = (
        (1.0 + xx + yy + zz, zy - yz, xz - zx, yx - xy),
        (zy - yz, 1.0 + xx - yy - zz, xy + yx, xz + zx),
        (xz - zx, xy + yx, 1.0 - xx + yy - zz, yz + zy),
        (yx - xy, xz + zx, yz + zy, 1.0 - xx - yy + zz),
    )
    row = max(range(4), key=lambda i: rows[i][i])
    w, x, y, z = rows[row]
    length = math.hypot(w, x, y, z)
    return w / length, x / length, y / length, z / length


def turns_between(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the angles (n,) in rad, 0 to pi, from n unit quaternions (n, 4) to as many others."""
    near, far = np.linalg.norm(other - one, axis=1), np.linalg.norm(other + one, axis=1)
    angles: FloatArray = 4.0 * np.arctan2(np.minimum(near, far), np.maximum(near, far))
    return angles


def successive_turns(quaternions: FloatArray) -> FloatArray:
    """Return the angles (n - 1,) in rad, 0 to pi, from each of n unit quaternions (n, 4) to the next."""
    return turns_between(quaternions[:-1], quaternions[1:])
