"""Closed meshes for the tests of what is inside: boxes put together, turned inside out, joined by tubes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from closecall.formats.scene.build.primitive_meshes import box_mesh
from closecall.scheduler.model.scene import Mesh
from closecall.scheduler.solids.containment import Interior
from closecall.scheduler.solids.enclosed_space import enclosed_by

Raw = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Vertices (n, 3) and triangles (m, 3)."""


def box(low: ArrayLike, high: ArrayLike, inwards: bool = False) -> Raw:
    """Return the box between two corners."""
    unit = box_mesh(1.0, 1.0, 1.0)
    corners = np.where(unit.vertices > 0.0, np.array(high, dtype=float), np.array(low, dtype=float))
    return corners, unit.triangles[:, ::-1] if inwards else unit.triangles


def cube(half: float, middle: ArrayLike = (0.0, 0.0, 0.0), inwards: bool = False) -> Raw:
    """Return the cube of this half edge about a point."""
    centre = np.array(middle, dtype=float)
    return box(centre - half, centre + half, inwards)


def together(*meshes: Raw) -> Raw:
    """Return the meshes as one."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    triangles = [mesh[1] + start for mesh, start in zip(meshes, starts, strict=False)]
    return np.vstack([vertices for vertices, _ in meshes]), np.vstack(triangles)


def turned(mesh: Raw, which: slice | NDArray[np.bool_] = slice(None)) -> Raw:
    """Return the mesh with some of its triangles turned over."""
    triangles = mesh[1].copy()
    triangles[which] = triangles[which][:, ::-1]
    return mesh[0], triangles


def moved(mesh: Raw, rotation: NDArray[np.float64], shift: ArrayLike) -> Raw:
    """Return the mesh turned and moved."""
    return mesh[0] @ rotation.T + np.array(shift), mesh[1]


def tube(*rings: NDArray[np.float64]) -> Raw:
    """Return the open tube through rings (k, 3) each."""
    count = len(rings[0])
    triangles = []
    for level in range(len(rings) - 1):
        for i in range(count):
            a, b = level * count + i, level * count + (i + 1) % count
            triangles += [(a, b, b + count), (a, b + count, a + count)]
    return np.vstack(rings), np.array(triangles)


def joined_boxes(shift: ArrayLike, inwards: bool) -> Raw:
    """Return the cube of half edge 1 and the same cube moved, joined by a tube over both into one consistent part.

    The tube bends as a handle does; with `inwards` it does not, so that it turns inside out on its way and the second
    cube is wound the other way.
    """
    away = np.array(shift, dtype=float)
    ring = np.array([(-0.2, -0.2, 0.0), (0.2, -0.2, 0.0), (0.2, 0.2, 0.0), (-0.2, 0.2, 0.0)])
    end, second = ring, turned((_holed()[0] + away, _holed()[1]))
    up = np.array([0.0, 0.0, 1.0])
    bend = [ring + up, ring + 4.0 * up]
    if not inwards:
        end, second = ring * (-1, 1, 1), turned(second)
        upright = np.column_stack((np.zeros(4), ring[:, 1], -ring[:, 0]))
        bend.append(upright + np.array([0.5 * away[0], 0.5 * away[1], 6.0]))
    vertices, triangles = together(_holed(), second, tube(*bend, end + away + 5.0 * up, end + away + up))
    points, of = np.unique(np.round(vertices, 9), axis=0, return_inverse=True)
    return points, of.reshape(-1)[triangles]


def _holed() -> Raw:
    """Return the cube of half edge 1 with a square hole in its upper face, 0.4 wide."""
    vertices, triangles = cube(1.0)
    lid = (vertices[triangles][:, :, 2] > 0.0).all(axis=1)
    around = np.array([(-1.0, -1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, 1.0), (-1.0, 1.0, 1.0)])
    return together((vertices, triangles[~lid]), tube(around, around * (0.2, 0.2, 1.0)))


def write_obj(path: Path, mesh: Raw) -> None:
    """Write an OBJ file."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh[0].tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (np.asarray(mesh[1]) + 1).tolist()]
    path.write_text("\n".join(lines) + "\n")


def walls_between(labels: NDArray[np.int64], rng: np.random.Generator, turned_share: float) -> Raw:
    """Return the unit squares between cells of different labels, normals to the lower, but for some turned over."""
    triangles = []
    for axis in range(3):
        along_axis = labels.transpose(np.roll((0, 1, 2), -axis))
        first, second = along_axis[:-1], along_axis[1:]
        for place in np.argwhere(first != second).tolist():
            corner = np.roll(np.array(place) + np.array([1.0, 0.0, 0.0]), axis)
            across, along = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
            square = [corner, corner + across, corner + across + along, corner + along]
            if (first[tuple(place)] < second[tuple(place)]) ^ (rng.random() < turned_share):
                square.reverse()
            triangles += [square[:3], [square[0], *square[2:]]]
    points, of = np.unique(np.array(triangles).reshape(-1, 3), axis=0, return_inverse=True)
    return points, of.reshape(-1, 3)


def inside(mesh: Raw, points: Sequence[Sequence[float]] | NDArray[np.floating]) -> list[bool]:
    """Tell which points are inside a mesh as closecall reads it."""
    vertices, triangles = mesh
    solids = enclosed_by(vertices, triangles).solids
    if not solids:
        return [False] * len(points)
    interior = Interior(Mesh("m", vertices, triangles, True, solids))
    return [interior.contains(np.array([point])) is not None for point in points]
