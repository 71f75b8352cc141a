"""Rotations and rigid transforms."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from .arrays import FloatArray
from .vector import Vector, add, dot, subtract

Rows = tuple[Vector, Vector, Vector]

IDENTITY: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def turn(axis: Vector, angle: float) -> Rows:
    """Return the rows of the rotation by `angle` (rad, right-handed) about the unit vector `axis` (Rodrigues)."""
    x, y, z = axis
    s, c = sin(angle), cos(angle)
    k = 2.0 * sin(0.5 * angle) ** 2  # 1 - cos(angle), without cancellation
    return (
        (c + k * x * x, k * x * y - s * z, k * x * z + s * y),
        (k * y * x + s * z, c + k * y * y, k * y * z - s * x),
        (k * z * x - s * y, k * z * y + s * x, c + k * z * z),
    )


def apply(rows: Rows, q: Vector) -> Vector:
    """Return the vector q turned by the rotation with these rows."""
    return (dot(rows[0], q), dot(rows[1], q), dot(rows[2], q))


def multiplied(one: Rows, other: Rows) -> Rows:
    """Return the rotation by `other` and then by `one`."""
    (a, b, c), (d, e, f), (g, h, i) = other
    x, y, z = ((p * a + q * d + r * g, p * b + q * e + r * h, p * c + q * f + r * i) for p, q, r in one)
    return (x, y, z)


def transform(rows: Rows, translation: Vector) -> FloatArray:
    """Return the 4x4 matrix that turns by `rows` and then translates (m)."""
    a, b, c = rows
    x, y, z = translation
    return np.array(((*a, x), (*b, y), (*c, z), (0.0, 0.0, 0.0, 1.0)))


def turned_about(direction: Vector, point: Vector, angle: float, advance: Vector) -> FloatArray:
    """Return the 4x4 rotation by `angle` about the axis through `point`, then a translation by `advance`."""
    rows = turn(direction, angle)
    return transform(rows, add(subtract(point, apply(rows, point)), advance))


def rotation_of_quaternion(w: float, x: float, y: float, z: float) -> FloatArray:
    """Return the 3x3 rotation of a quaternion of any non-zero length."""
    n = 2.0 / (w * w + x * x + y * y + z * z)
    return np.array(
        (
            (1.0 - n * (y * y + z * z), n * (x * y - z * w), n * (x * z + y * w)),
            (n * (x * y + z * w), 1.0 - n * (x * x + z * z), n * (y * z - x * w)),
            (n * (x * z - y * w), n * (y * z + x * w), 1.0 - n * (x * x + y * y)),
        )
    )


def crossed(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a x b of vectors (..., 3); several times faster than numpy's own on few of them."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx), axis=-1)


def chord(angle: float, radius: float) -> float:
    """Return how far (m) a point at `radius` from the axis is displaced at most by turning up to `angle` >= 0 rad."""
    return 2.0 * radius * sin(0.5 * angle) if angle < pi else 2.0 * radius


def turned(pose: FloatArray, q: Vector) -> Vector:
    """Return the vector q turned by a 4x4 pose's rotation."""
    a, b, c, _ = pose.tolist()
    x, y, z = q
    return (
        a[0] * x + a[1] * y + a[2] * z,
        b[0] * x + b[1] * y + b[2] * z,
        c[0] * x + c[1] * y + c[2] * z,
    )


def mapped(pose: FloatArray, q: Vector) -> Vector:
    """Return the point q mapped by a 4x4 pose."""
    return add(turned(pose, q), translation_of(pose))


def translation_of(pose: FloatArray) -> Vector:
    """Return the translation of a 4x4 pose."""
    x, y, z = pose[:3, 3].tolist()
    return (x, y, z)
