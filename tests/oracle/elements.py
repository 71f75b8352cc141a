"""Round shapes against triangles and each other, measured by their support functions."""

from __future__ import annotations

import numpy as np

from . import gjk
from .bodies import Surface
from .rigid import FloatArray, IntArray

BATCH = 20_000
"""Pairs of elements measured in one go."""


class ElementPairs:
    """Two bodies as elements: element k is triangle k, element n + k is round shape k of n triangles."""

    def __init__(self, a: Surface, b: Surface) -> None:
        self.a, self.b = a, b

    def lower(self, best: FloatArray, poses: FloatArray, at: IntArray, i: IntArray, j: IntArray) -> None:
        """Lower `best` (n,) m at poses (n, 4, 4) of b in a by the elements of triangles i of a and j of b.

        Args:
            at: (k,) indices of poses, one for each pair of triangles.
        """
        asked = np.column_stack([at, elements(self.a, i), elements(self.b, j)])
        asked = np.unique(asked, axis=0) if len(asked) else asked
        kinds = np.column_stack([
            np.maximum(asked[:, 1] - len(self.a.triangles), -1),
            np.maximum(asked[:, 2] - len(self.b.triangles), -1),
        ])  # fmt: skip
        for kind in np.unique(kinds, axis=0):
            rows = asked[(kinds == kind).all(axis=1)]
            for first in range(0, len(rows), BATCH):
                part = rows[first : first + BATCH]
                np.minimum.at(best, part[:, 0], self._distances(poses[part[:, 0]], part[:, 1], part[:, 2]))

    def lower_by_rounds(self, best: FloatArray, poses: FloatArray) -> None:
        """Lower `best` (n,) m at poses (n, 4, 4) by each round shape of a with each of b."""
        for i, one in enumerate(self.a.rounds):
            for j, other in enumerate(self.b.rounds):
                centres = poses[:, :3, :3] @ other.pose[:3, 3] + poses[:, :3, 3]
                gaps = np.linalg.norm(centres - one.pose[:3, 3], axis=1) - one.reach - other.reach
                at = np.flatnonzero((gaps < best) & (best > 0.0))
                chosen = [np.full(len(at), len(own.triangles) + k) for own, k in ((self.a, i), (self.b, j))]
                if len(at):
                    best[at] = np.minimum(best[at], self._distances(poses[at], *chosen))

    def _distances(self, poses: FloatArray, i: IntArray, j: IntArray) -> FloatArray:
        """Return (n,) m: signed distances of elements i of a and j of b, each all of one kind, at poses (n, 4, 4)."""
        centre_a, radius_a, support_a = element_set(self.a, i)
        centre_b, radius_b, support_b = element_set(self.b, j)
        turns, places = poses[:, :3, :3], poses[:, :3, 3]

        def placed(directions: FloatArray, rows: IntArray) -> FloatArray:
            local = np.einsum("nyx,ny->nx", turns[rows], directions)
            return np.einsum("nxy,ny->nx", turns[rows], support_b(local, rows)) + places[rows]

        start = centre_a - (np.einsum("nxy,ny->nx", turns, centre_b) + places)
        return gjk.distances(support_a, placed, len(i), start) - radius_a - radius_b


def elements(surface: Surface, triangles: IntArray) -> IntArray:
    """Return which element each triangle stands for."""
    owner = surface.round_of[triangles]
    return np.where(owner < 0, triangles, len(surface.triangles) + owner)


def element_set(surface: Surface, chosen: IntArray) -> tuple[FloatArray, FloatArray, gjk.Support]:
    """Return a point (n, 3) m of each element, rounding radii (n,) m, and the support function of the elements."""
    whole = int(chosen[0]) - len(surface.triangles)
    if whole >= 0:
        shape = surface.rounds[whole]
        centres = np.broadcast_to(shape.pose[:3, 3], (len(chosen), 3))
        return centres, np.zeros(len(chosen)), lambda directions, _: shape.support(directions)
    corners = surface.triangles[chosen]

    def support(directions: FloatArray, rows: IntArray) -> FloatArray:
        heights = np.einsum("nkx,nx->nk", corners[rows], directions)
        return corners[rows, heights.argmax(axis=1)]

    return corners[:, 0], surface.radii[chosen], support
