"""Meshes that a file places by transforms, some of them many times, put together as one surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from .surface import MeshError, Surface, grid_warnings

MOST_TRIANGLES = 20_000_000
"""Of one file, all placements counted: 1.4 GB here and some 10 GB in FCL. A small file can ask for any number."""

MOST_PLACEMENTS = 100_000
"""Of meshes and groups of meshes in one file, some seconds' work. Groups within groups can ask for any number."""


class Budget:
    """How many triangles and placements one file has asked for so far."""

    def __init__(self) -> None:
        self._triangles = 0
        self._placements = 0

    def spend(self, triangles: int, placements: int) -> None:
        """Add to both.

        Raises:
            MeshError: that is more than one file may have.
        """
        self._triangles += triangles
        self._placements += placements
        if self._triangles > MOST_TRIANGLES:
            raise MeshError(f"the file places {self._triangles} triangles, expected {MOST_TRIANGLES} at most")
        if self._placements > MOST_PLACEMENTS:
            raise MeshError(f"the file places {self._placements} meshes, expected {MOST_PLACEMENTS} at most")


class Assembly:
    """The triangles placed so far. Whoever places them keeps the budget."""

    def __init__(self) -> None:
        self._grid = 0.0
        self._vertices: list[FloatArray] = []
        self._triangles: list[IntArray] = []
        self._vertex_count = 0

    def place(self, vertices: FloatArray, triangles: IntArray, transform: FloatArray, grid: float = 0.0) -> None:
        """Add a mesh, turned inside out again if the transform mirrors it.

        Args:
            vertices: (n, 3).
            triangles: (m, 3) indices of these vertices.
            transform: (4, 4) affine, of column vectors.
            grid: how far apart the floats are in which the file has the vertices; 0 for decimals.

        Raises:
            MeshError: a coordinate is not finite.
        """
        placed = transformed(vertices, transform)
        if not np.isfinite(placed).all():
            raise MeshError("a coordinate is not finite")
        with np.errstate(all="ignore"):
            mirrored = np.linalg.det(transform[:3, :3]) < 0
        with np.errstate(all="ignore"):
            self._grid = max(self._grid, grid * float(np.linalg.norm(transform[:3, :3], axis=0).max()))
        self._vertices.append(placed)
        self._triangles.append((triangles[:, ::-1] if mirrored else triangles) + self._vertex_count)
        self._vertex_count += len(vertices)

    def surface(self, warnings: Sequence[str], unit: str | None = None) -> Surface:
        """Return the whole.

        Raises:
            MeshError: there are no triangles.
        """
        if not any(map(len, self._triangles)):
            raise MeshError("the file places no triangles, expected at least one")
        vertices, triangles = np.concatenate(self._vertices), np.concatenate(self._triangles)
        return Surface(vertices, triangles, tuple(warnings), unit, grid_warnings(vertices, self._grid))


def transformed(points: FloatArray, transform: FloatArray) -> FloatArray:
    """Return (n, 3) points under an affine (4, 4) transform of column vectors.

    Equal points stay equal, which a matrix product does not promise and closedness hangs on.
    """
    x, y, z = points.T
    with np.errstate(all="ignore"):
        return np.column_stack([row[0] * x + row[1] * y + row[2] * z + row[3] for row in transform[:3]])
