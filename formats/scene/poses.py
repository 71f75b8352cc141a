"""Poses as written to poses as used: a translation in m and a unit quaternion, however they were spelt."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...scheduler.rotation import rotation_of_quaternion
from ...scheduler.scene import FloatArray
from .arrays import read_only
from .document import Findings
from .errors import Where, quoted
from .grammar.poses import Pose
from .limits import MATRIX_TOLERANCE, QUATERNION_TOLERANCE, SHORTEST_DIRECTION
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
        return _from_fixed_axes(*map(scale.turn, pose.rpy))
    if pose.axis_angle is not None:
        axis = unit_vector(pose.axis_angle.axis, (*where, "axis_angle", "axis"), findings)
        return _about(axis, scale.turn(pose.axis_angle.angle))
    return UNTURNED


def _normalised(quaternion: Quaternion, where: Where, findings: Findings) -> Quaternion:
    length = math.hypot(*quaternion)
    if abs(length - 1.0) > QUATERNION_TOLERANCE:
        findings.fault(where, f"expected a unit quaternion, got one of length {quoted(length)}")
        return UNTURNED
    w, x, y, z = (component / length for component in quaternion)
    return w, x, y, z


def _about(axis: Vector, angle: float) -> Quaternion:
    """Return the turn by `angle` (rad) about a unit axis."""
    x, y, z = (component * math.sin(angle / 2) for component in axis)
    return math.cos(angle / 2), x, y, z


def _from_fixed_axes(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return Rz(yaw) Ry(pitch) Rx(roll), angles in rad."""
    about_x = _about((1.0, 0.0, 0.0), roll)
    about_y = _about((0.0, 1.0, 0.0), pitch)
    about_z = _about((0.0, 0.0, 1.0), yaw)
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


def _from_matrix(matrix: FloatArray, where: Where, findings: Findings) -> Quaternion:
    """Return the rotation nearest to a 4x4 matrix, a rigid transform within MATRIX_TOLERANCE."""
    fault = _matrix_fault(matrix)
    if fault:
        findings.fault(where, fault)
        return UNTURNED
    return nearest_rotation(matrix[:3, :3])


def nearest_rotation(matrix: FloatArray) -> Quaternion:
    """Return the quaternion of the rotation nearest to a 3x3 matrix that is nearly one."""
    left, _, right = np.linalg.svd(matrix)
    return _from_rotation(left @ right)


def _matrix_fault(matrix: FloatArray) -> str:
    if np.abs(matrix[3] - (0.0, 0.0, 0.0, 1.0)).max() > MATRIX_TOLERANCE:
        return "expected the last row 0, 0, 0, 1 (matrices are row-major)"
    return rotation_fault(matrix[:3, :3])


def rotation_fault(rotation: FloatArray) -> str:
    """Return what keeps a 3x3 matrix from being a rotation within MATRIX_TOLERANCE; nothing if it is one."""
    if np.abs(rotation.T @ rotation - np.eye(3)).max() > MATRIX_TOLERANCE:
        return "expected a rotation, got a matrix that scales or shears"
    if abs(np.linalg.det(rotation) - 1.0) > MATRIX_TOLERANCE:
        return "expected a rotation, got a matrix that mirrors"
    return ""


def _from_rotation(rotation: FloatArray) -> Quaternion:
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
