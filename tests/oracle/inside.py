"""Whether a part of one body lies inside a closed shape of another, by the winding number."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .bodies import Surface
from .rigid import FloatArray
from .triangles import cross, dot

BATCH_CELLS = 200_000
"""Points times triangles evaluated in one go."""


def winding(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Return (n,) winding numbers of the triangles (m, 3, 3) about points (n, 3): 1 inside a closed surface.

    The sum of the signed solid angles over 4 pi (Van Oosterom and Strackee, 1983).
    """
    step = max(1, BATCH_CELLS // len(triangles))
    parts = [solid_angles(points[i : i + step], triangles) for i in range(0, len(points), step)]
    return np.concatenate([np.zeros(0), *parts]) / (4.0 * np.pi)


def solid_angles(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Return (n,) sr: the signed solid angles of the triangles (m, 3, 3) summed, seen from points (n, 3)."""
    corners = [np.moveaxis(triangles[None, :, k] - points[:, None], 2, 0) for k in range(3)]
    a, b, c = corners
    la, lb, lc = (np.sqrt(dot(corner, corner)) for corner in corners)
    above = dot(a, cross(b, c))
    below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
    return (2.0 * np.arctan2(above, below)).sum(axis=1)


class Containment:
    """Tells at which poses a part of the `guest` lies inside a closed shape of the `host`.

    Exact where the surfaces are disjoint: then each connected part is wholly inside or wholly outside.
    """

    def __init__(self, guest: Surface, host: Surface) -> None:
        self.probes = guest.probes
        self.solids = host.solids
        self.boxes = [(solid.min(axis=(0, 1)), solid.max(axis=(0, 1))) for solid in host.solids]

    def any_inside(self, poses: FloatArray) -> NDArray[np.bool_]:
        """Return (n,) booleans at poses (n, 4, 4) of the guest in the frame of the host."""
        out = np.zeros(len(poses), dtype=bool)
        points = self.probes @ np.swapaxes(poses[:, :3, :3], 1, 2) + poses[:, None, :3, 3]
        for solid, (low, high) in zip(self.solids, self.boxes, strict=True):
            at, probe = np.nonzero(((points > low) & (points < high)).all(axis=2) & ~out[:, None])
            held = np.abs(winding(points[at, probe], solid)) > 0.5
            out[at[held]] = True
        return out
