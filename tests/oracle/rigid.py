"""4x4 rigid matrices from the scene file's ways to write them, vectorised over time where motion needs it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import polar
from scipy.spatial.transform import Rotation

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
RADIANS = {"rad": 1.0, "deg": np.pi / 180.0}


def numbers(value: ArrayLike) -> FloatArray:
    """Return floats; PyYAML leaves YAML 1.2's `1e-3` as text, which numpy still reads as a number."""
    return np.asarray(value, dtype=np.float64)


def unit(vector: ArrayLike) -> FloatArray:
    """Return a (3,) vector scaled to length 1."""
    v = numbers(vector)
    v = v / np.abs(v).max()  # squares of tiny components are 0
    return np.asarray(v / np.linalg.norm(v))


def rotations(axis: FloatArray, angles: FloatArray) -> FloatArray:
    """Return (n, 3, 3) rotations by `angles` (n,) rad about the unit vector `axis` (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine = np.sin(angles)[:, None, None]
    versine = 2.0 * np.sin(angles / 2.0)[:, None, None] ** 2
    return np.eye(3) + sine * cross + versine * (cross @ cross)


def rigid(rotation: FloatArray | None, translation: FloatArray) -> FloatArray:
    """Return (n, 4, 4) from translations (n, 3) m and rotations (n, 3, 3) or None for no rotation."""
    out = np.zeros((len(translation), 4, 4))
    out[:, :3, :3] = np.eye(3) if rotation is None else rotation
    out[:, :3, 3] = translation
    out[:, 3, 3] = 1.0
    return out


def inverse(matrices: FloatArray) -> FloatArray:
    """Return the inverses of rigid (..., 4, 4) matrices."""
    out = np.zeros_like(matrices)
    turned = np.swapaxes(matrices[..., :3, :3], -1, -2)
    out[..., :3, :3] = turned
    out[..., :3, 3] = -np.einsum("...ij,...j->...i", turned, matrices[..., :3, 3])
    out[..., 3, 3] = 1.0
    return out


def about_point(rotation: FloatArray, point: FloatArray) -> FloatArray:
    """Return (n, 4, 4): the rotations (n, 3, 3) about `point` (3,) m."""
    return rigid(rotation, point - rotation @ point)


def rotation_of(pose: Mapping[str, Any], radians: float) -> FloatArray:
    """Return the (3, 3) rotation that a pose or a key states; `radians` is the file's angle unit."""
    if "quat_wxyz" in pose:
        w, x, y, z = numbers(pose["quat_wxyz"])
        return Rotation.from_quat([x, y, z, w]).as_matrix()
    if "quat_xyzw" in pose:
        return Rotation.from_quat(numbers(pose["quat_xyzw"])).as_matrix()
    if "rpy" in pose:
        roll, pitch, yaw = numbers(pose["rpy"]) * radians
        x, y, z = np.eye(3)
        turns = (rotations(z, np.array([yaw])), rotations(y, np.array([pitch])), rotations(x, np.array([roll])))
        return (turns[0] @ turns[1] @ turns[2])[0]
    if "axis_angle" in pose:
        turn = pose["axis_angle"]
        return rotations(unit(turn["axis"]), np.array([float(turn["angle"]) * radians]))[0]
    return np.eye(3)


def pose_of(pose: Mapping[str, Any] | None, metres: float, radians: float) -> FloatArray:
    """Return the 4x4 matrix (m) of a pose in the file's units; an absent pose is the identity."""
    out = np.eye(4)
    if not pose:
        return out
    if "matrix" in pose:
        out = numbers(pose["matrix"]).copy()
        out[:3, :3] = polar(out[:3, :3])[0]  # the nearest rotation
        out[:3, 3] *= metres
        return out
    out[:3, :3] = rotation_of(pose, radians)
    out[:3, 3] = numbers(pose.get("xyz", (0.0, 0.0, 0.0))) * metres
    return out
