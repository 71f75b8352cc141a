"""How often a closed surface winds around points."""

from __future__ import annotations

import numpy as np

from ..geometry.arrays import FloatArray

#: Points times triangles that are looked at in one go.
BATCH = 1 << 19


def winding_numbers(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Return (k,) how often triangles wind around points: the sum of their solid angles over 4 pi.

    Args:
        points: (k, 3) m.
        corners: (m, 3, 3) m, the corners of each triangle.

    Source: van Oosterom and Strackee, "The solid angle of a plane triangle" (1983).
    """
    step = max(1, BATCH // len(corners))
    found = [_winding_numbers(points[begin : begin + step], corners) for begin in range(0, len(points), step)]
    return np.concatenate([np.zeros(0), *found])


def _winding_numbers(points: FloatArray, corners: FloatArray) -> FloatArray:
    a, b, c = (corners[None, :, corner] - points[:, None] for corner in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=2) for side in (a, b, c))
    volume = np.einsum("kij,kij->ki", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("kij,kij->ki", p, q) for p, q in ((a, b), (b, c), (c, a)))
    angles = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
    found: FloatArray = np.sum(angles, axis=1) / (4.0 * np.pi)
    return found
