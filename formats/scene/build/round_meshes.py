"""The meshes of cylinders, cones and ellipsoids: polyhedra around them that hold the whole of the true shape.

Each is one fixed polyhedron around the unit shape, scaled along its axes: that keeps what is inside inside and what
touches touching, so a needle is held as surely as a ball.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import cos, pi, ulp

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ....scheduler.geometry.round_solid import RoundSolid
from ....scheduler.model.scene import Mesh
from .primitive_meshes import frozen_mesh

_FACETS = 64
"""Around a cylinder or a cone: 0.12% of the radius stands out at their edges, 50 facets would be over 0.2%."""

_HALVINGS = 3
"""Of an icosahedron's edges, to 1280 triangles: 0.46% of the largest half axis stands out, 1.8% with one less."""

_ROUNDING = 32 * ulp(1.0)
"""Of the unit shape: how much farther out its vertices go, since rounding moves each by 4 ulp at most."""

# Corners of an icosahedron about the origin and its triangles, outward by the right hand.
_GOLDEN = (1 + 5**0.5) / 2
_ICOSAHEDRON = (
    (-1, _GOLDEN, 0), (1, _GOLDEN, 0), (-1, -_GOLDEN, 0), (1, -_GOLDEN, 0),
    (0, -1, _GOLDEN), (0, 1, _GOLDEN), (0, -1, -_GOLDEN), (0, 1, -_GOLDEN),
    (_GOLDEN, 0, -1), (_GOLDEN, 0, 1), (-_GOLDEN, 0, -1), (-_GOLDEN, 0, 1),
)  # fmt: skip
_ICOSAHEDRON_TRIANGLES = (
    (0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11),
    (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
    (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9),
    (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1),
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class RoundMesh:
    """A convex polyhedron in place of a round shape.

    Attributes:
        mesh: solid; it holds every point of the true shape, in floating point too.
        chord_error: m, no point of the mesh is farther than this from the true shape; an upper bound, at most 0.2% of
            the radius of a cylinder or a cone and 0.5% of an ellipsoid's largest half axis.
        solid: the true shape.
    """

    mesh: Mesh
    chord_error: float
    solid: RoundSolid


@lru_cache(maxsize=1024)
def cylinder_mesh(radius: float, length: float) -> RoundMesh:
    """Return the solid cylinder of `radius` and full `length` (m), along z about the origin: 256 triangles.

    Facets touch it at +-x and +-y, where its bounds are its own.
    """
    ring, excess = _ring()
    below, above = (np.column_stack((ring * radius, np.full(_FACETS, z))) for z in (-length / 2, length / 2))
    centres = np.array(((0.0, 0.0, -length / 2), (0.0, 0.0, length / 2)))
    here, there = _sides()
    triangles = np.concatenate((
        np.column_stack((here, there, there + _FACETS)),
        np.column_stack((here, there + _FACETS, here + _FACETS)),
        np.column_stack((there, here, np.full(_FACETS, 2 * _FACETS))),
        np.column_stack((here + _FACETS, there + _FACETS, np.full(_FACETS, 2 * _FACETS + 1))),
    ))  # fmt: skip
    name = f"cylinder of radius {radius:g} m, length {length:g} m"
    mesh = frozen_mesh(name, np.vstack((below, above, centres)), triangles, solid=True)
    return RoundMesh(mesh, radius * excess, RoundSolid((radius, radius), length / 2))


@lru_cache(maxsize=1024)
def cone_mesh(radius: float, length: float) -> RoundMesh:
    """Return the solid cone of `length` (m) along z about the origin: 128 triangles.

    Its base has `radius` (m) and lies at z = -length/2, its apex at z = +length/2.
    """
    ring, excess = _ring()
    base = np.column_stack((ring * radius, np.full(_FACETS, -length / 2)))
    ends = np.array(((0.0, 0.0, -length / 2), (0.0, 0.0, length / 2)))
    here, there = _sides()
    triangles = np.concatenate((
        np.column_stack((there, here, np.full(_FACETS, _FACETS))),
        np.column_stack((here, there, np.full(_FACETS, _FACETS + 1))),
    ))  # fmt: skip
    name = f"cone of radius {radius:g} m, length {length:g} m"
    mesh = frozen_mesh(name, np.vstack((base, ends)), triangles, solid=True)
    return RoundMesh(mesh, radius * excess, RoundSolid((radius, 0.0), length / 2))


@lru_cache(maxsize=1024)
def ellipsoid_mesh(a: float, b: float, c: float) -> RoundMesh:
    """Return the solid ellipsoid with half axes a, b, c (m) along x, y, z about the origin: 1280 triangles.

    Its vertices lie on the ellipsoid with half axes (1 + e) a, (1 + e) b, (1 + e) c. A vertex v is no farther from the
    true one than from its point v / (1 + e), hence no farther than e times the largest half axis; and there is a
    vertex at the end of each axis, just so far from it.
    """
    vertices, triangles, excess = _unit_ball()
    name = f"ellipsoid of half axes {a:g} x {b:g} x {c:g} m"
    mesh = frozen_mesh(name, vertices * (a, b, c), triangles, solid=True)
    return RoundMesh(mesh, max(a, b, c) * excess, RoundSolid(axes=(a, b, c)))


@lru_cache(maxsize=1)
def _ring() -> tuple[FloatArray, float]:
    """Return the (n, 2) corners of a regular polygon around the unit circle, and how far outside they are at most."""
    reach = (1 + _ROUNDING) / cos(pi / _FACETS)
    angles = (np.arange(_FACETS) + 0.5) * (2 * pi / _FACETS)
    return reach * np.column_stack((np.cos(angles), np.sin(angles))), reach - 1 + _ROUNDING


def _sides() -> tuple[IntArray, IntArray]:
    """Return the indices of a ring's corners, and of their neighbours counterclockwise about z."""
    here: IntArray = np.arange(_FACETS)
    return here, (here + 1) % _FACETS


@lru_cache(maxsize=1)
def _unit_ball() -> tuple[FloatArray, IntArray, float]:
    """Return vertices (n, 3) and triangles around the unit ball, and how far outside the vertices are at most.

    Halving the edges of an icosahedron gives one whose vertices are on the sphere; all of them move outward until the
    nearest face touches it.
    """
    vertices: FloatArray = np.array(_ICOSAHEDRON) / np.linalg.norm(_ICOSAHEDRON[0])
    triangles: IntArray = np.array(_ICOSAHEDRON_TRIANGLES)
    for _ in range(_HALVINGS):
        vertices, triangles = _halved(vertices, triangles)
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    depths = np.einsum("ij,ij->i", normals, corners[:, 0]) / np.linalg.norm(normals, axis=1)
    reach = (1 + _ROUNDING) / float(depths.min())
    return vertices * reach, triangles, reach - 1 + _ROUNDING


def _halved(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """Return each triangle of a unit sphere as four, the middles of their edges on the sphere."""
    edges = np.sort(np.stack((triangles, np.roll(triangles, -1, axis=1)), axis=2), axis=2)
    pairs, inverse = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    middles = vertices[pairs].sum(axis=1)
    middles /= np.linalg.norm(middles, axis=1)[:, None]
    a, b, c = triangles.T
    ab, bc, ca = len(vertices) + inverse.reshape(-1, 3).T
    quarters = np.stack((a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca), axis=1)
    return np.vstack((vertices, middles)), quarters.reshape(-1, 3)
