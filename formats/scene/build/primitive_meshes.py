"""The meshes of boxes, spheres and capsules: a core of triangles, to be rounded by a radius. And meshes scaled."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ....scheduler.model.scene import Mesh
from ..quantities.arrays import read_only

# Corners as bits of their index: x = 1, y = 2, z = 4. Every face is two triangles, outward by the right hand.
_BOX_TRIANGLES = (
    (0, 4, 6), (0, 6, 2),
    (1, 3, 7), (1, 7, 5),
    (0, 1, 5), (0, 5, 4),
    (2, 6, 7), (2, 7, 3),
    (0, 2, 3), (0, 3, 1),
    (4, 5, 7), (4, 7, 6),
)  # fmt: skip


@lru_cache(maxsize=1024)
def box_mesh(x: float, y: float, z: float) -> Mesh:
    """Return the solid box with these full lengths (m) about the origin: 12 triangles, shared by equal boxes."""
    corners = [[(i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2) - 0.5] for i in range(8)]
    return frozen_mesh(f"box {x:g} x {y:g} x {z:g} m", np.array(corners) * (x, y, z), _BOX_TRIANGLES, solid=True)


@lru_cache(maxsize=1)
def point_mesh() -> Mesh:
    """Return the core of every sphere: the origin, as a triangle with three equal corners."""
    return frozen_mesh("point", np.zeros((1, 3)), ((0, 0, 0),), solid=False)


@lru_cache(maxsize=1024)
def segment_mesh(length: float) -> Mesh:
    """Return the core of a capsule: `length` m along z about the origin, a triangle with two equal corners."""
    ends = np.array(((0.0, 0.0, -length / 2), (0.0, 0.0, length / 2)))
    return frozen_mesh(f"segment {length:g} m", ends, ((0, 1, 1),), solid=False)


def scaled_mesh(mesh: Mesh, scale: tuple[float, float, float]) -> Mesh:
    """Return the mesh with its x, y, z times these positive factors, its triangles shared with it; itself at 1, 1, 1.

    Called anew it makes a new mesh: `MeshFolder.scaled` keeps one of each.
    """
    if scale == (1.0, 1.0, 1.0):
        return mesh
    return replace(mesh, vertices=read_only(mesh.vertices * scale))


def frozen_mesh(
    name: str, vertices: FloatArray, triangles: IntArray | tuple[tuple[int, int, int], ...], solid: bool
) -> Mesh:
    """Return a Mesh over read-only, contiguous copies: vertices (n, 3) float64 m, triangles (m, 3) int64."""
    points = np.array(vertices, dtype=np.float64, order="C")
    corners = np.array(triangles, dtype=np.int64, order="C")
    return Mesh(name, read_only(points), read_only(corners), solid)
