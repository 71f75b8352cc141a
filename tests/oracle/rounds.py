"""Cylinders, cones and ellipsoids as what they are: their support functions, and coarse meshes inside them.

The mesh only finds where to look; distances are then taken from the support function (see gjk).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .rigid import FloatArray, numbers
from .solids import icosahedron, quads

FACETS = 20
"""Around the mesh inside a cylinder or a cone."""

HALVINGS = 2
"""Of the edges of the icosahedron inside an ellipsoid."""

KINDS = ("cylinder", "cone", "ellipsoid")


@dataclass(frozen=True, eq=False)
class Round:
    """A convex round shape in a body.

    Attributes:
        kind: of KINDS; a cone's base lies at -length/2 along z, its apex at +length/2.
        sizes: (3,) m: half axes along x, y, z; of a cylinder or a cone: radius, radius, half length.
        pose: (4, 4), body from shape.
    """

    kind: str
    sizes: FloatArray
    pose: FloatArray

    def support(self, directions: FloatArray) -> FloatArray:
        """Return (n, 3) m: the point of the shape farthest along each direction (n, 3), in the body's frame."""
        turned = directions @ self.pose[:3, :3]
        x, _, z = self.sizes
        if self.kind == "ellipsoid":
            stretched = turned * self.sizes
            local = self.sizes * stretched / np.maximum(np.linalg.norm(stretched, axis=1), 1e-300)[:, None]
        else:
            across = np.hypot(turned[:, 0], turned[:, 1])
            rim = turned[:, :2] * np.divide(x, across, out=np.zeros_like(across), where=across > 0.0)[:, None]
            up = turned[:, 2] >= 0.0
            if self.kind == "cone":
                up = 2.0 * z * turned[:, 2] > x * across
                rim = np.where(up[:, None], 0.0, rim)
            local = np.column_stack([rim, np.where(up, z, -z)])
        return local @ self.pose[:3, :3].T + self.pose[:3, 3]

    @cached_property
    def mesh(self) -> FloatArray:
        """(n, 3, 3) m: triangles of a closed mesh inside the shape, corners on its surface, in the body's frame."""
        return unit_mesh(self.kind) * self.sizes @ self.pose[:3, :3].T + self.pose[:3, 3]

    @cached_property
    def slack(self) -> float:
        """The largest distance (m) of a point of the shape from the mesh inside, with a little to spare."""
        if self.kind != "ellipsoid":
            return 1.001 * float(self.sizes[0]) * (1.0 - np.cos(np.pi / FACETS))
        triangles = unit_mesh(self.kind)
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        depths = np.einsum("nk,nk->n", normals, triangles[:, 0]) / np.linalg.norm(normals, axis=1)
        return 1.001 * float(self.sizes.max()) * (1.0 - float(depths.min()))

    @cached_property
    def reach(self) -> float:
        """The radius (m) of a ball about the shape's own origin that holds it."""
        return float(self.sizes.max() if self.kind == "ellipsoid" else np.hypot(self.sizes[0], self.sizes[2]))

    @property
    def chord_limit(self) -> float:
        """The most (m) that the tool's polyhedron may stand out: 0.2% of the radius, 0.5% of the largest half axis."""
        return float(0.005 * self.sizes.max() if self.kind == "ellipsoid" else 0.002 * self.sizes[0])


def round_of(shape: Mapping[str, Any], metres: float, pose: FloatArray) -> Round | None:
    """Return the round shape that a scene's shape is, None if it is none."""
    if "ellipsoid" in shape:
        return Round("ellipsoid", numbers(shape["ellipsoid"]) * metres, pose)
    for kind in ("cylinder", "cone"):
        if kind in shape:
            radius, length = float(shape[kind]["radius"]) * metres, float(shape[kind]["length"]) * metres
            return Round(kind, np.array([radius, radius, 0.5 * length]), pose)
    return None


def unit_mesh(kind: str) -> FloatArray:
    """Return (n, 3, 3): an outward mesh inside the unit shape (radius 1, half length 1)."""
    if kind == "ellipsoid":
        triangles = icosahedron()
        triangles /= np.linalg.norm(triangles, axis=2, keepdims=True)
        for _ in range(HALVINGS):
            triangles = halved_edges(triangles)
        return triangles
    angles = 2.0 * np.pi * np.arange(FACETS + 1) / FACETS
    angles[-1] = 0.0
    ring = np.column_stack([np.cos(angles), np.sin(angles), np.full(FACETS + 1, -1.0)])
    here, there = ring[:-1], ring[1:]
    up = np.array([0.0, 0.0, 2.0])
    foot, top = np.broadcast_to(-0.5 * up, here.shape), np.broadcast_to(0.5 * up, here.shape)
    base = np.stack([there, here, foot], axis=1)
    if kind == "cone":
        return np.concatenate([base, np.stack([here, there, top], axis=1)])
    lid = np.stack([here + up, there + up, top], axis=1)
    return np.concatenate([base, lid, quads(here, there, there + up, here + up)])


def halved_edges(triangles: FloatArray) -> FloatArray:
    """Return each triangle of the unit sphere as four, with the middles of its edges on the sphere."""
    a, b, c = (triangles[:, k] for k in range(3))
    ab, bc, ca = (one + other for one, other in ((a, b), (b, c), (c, a)))
    ab, bc, ca = (middle / np.linalg.norm(middle, axis=1, keepdims=True) for middle in (ab, bc, ca))
    parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return np.concatenate([np.stack(part, axis=1) for part in parts])
