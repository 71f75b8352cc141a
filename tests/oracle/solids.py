"""Closed non-convex triangle meshes for random scenes, and the files that they are written to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .mesh_formats import WRITERS
from .meshes import STL_RECORD
from .rigid import FloatArray

GOLDEN = (1.0 + 5.0**0.5) / 2.0

CELLS = {
    "L": ((0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)),
    "U": ((0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1, 0)),
    "corner": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (2, 0, 0)),
    "ring": ((0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1, 0), (0, 2, 0), (1, 2, 0), (2, 2, 0)),
    "hook": ((0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (2, 2, 0), (1, 2, 0), (2, 2, 1)),
}


def random_solid(rng: np.random.Generator) -> FloatArray:
    """Return triangles (n, 3, 3) of a closed solid, outward, within about 1 of its origin."""
    kind = rng.choice(["star", "star", "torus", "cells", "cells"])
    if kind == "star":
        return star(rng)
    if kind == "torus":
        return torus(rng)
    return cells(CELLS[str(rng.choice(sorted(CELLS)))], rng.uniform(0.3, 0.6, 3))


def star(rng: np.random.Generator) -> FloatArray:
    """Return a bumpy star-shaped solid of 80 triangles, radii 0.45 to 1."""
    base = icosahedron()
    middles = 0.5 * (base + np.roll(base, -1, axis=1))
    a, b, c = (base[:, k] for k in range(3))
    ab, bc, ca = (middles[:, k] for k in range(3))
    parts = ([a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca])
    triangles = np.concatenate([np.stack(part, axis=1) for part in parts])
    points, index = np.unique(np.round(triangles.reshape(-1, 3), 9), axis=0, return_inverse=True)
    radii = rng.uniform(0.45, 1.0, len(points)) / np.linalg.norm(points, axis=1)
    return (points * radii[:, None])[index.reshape(-1, 3)]


def icosahedron() -> FloatArray:
    """Return the 20 outward triangles (20, 3, 3) of an icosahedron."""
    corners = np.array(
        [roll(point) for roll in cyclic() for point in [(0.0, s, t * GOLDEN) for s in (1, -1) for t in (1, -1)]]
    )
    near = np.linalg.norm(corners[:, None] - corners, axis=2) < 2.1
    triples = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    triangles = corners[np.array(triples)]
    inward = np.linalg.det(triangles) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles


def cyclic() -> list:
    """Return the three cyclic shifts of a point's coordinates."""
    return [lambda p: p, lambda p: (p[1], p[2], p[0]), lambda p: (p[2], p[0], p[1])]


def torus(rng: np.random.Generator) -> FloatArray:
    """Return a bumpy torus of 7 to 12 by 5 to 8 quads."""
    return ring(rng, int(rng.integers(7, 13)), int(rng.integers(5, 9)))


def ring(rng: np.random.Generator, around: int, across: int) -> FloatArray:
    """Return a bumpy torus of `around` by `across` quads."""
    u = 2.0 * np.pi * np.arange(around)[:, None] / around
    v = 2.0 * np.pi * np.arange(across)[None, :] / across
    tube = rng.uniform(0.15, 0.3) * rng.uniform(0.8, 1.2, (around, across))
    reach = 0.7 + tube * np.cos(v)
    grid = np.stack([reach * np.cos(u), reach * np.sin(u), tube * np.sin(v)], axis=2)
    right = np.roll(grid, -1, axis=0)
    corners = [grid, right, np.roll(right, -1, axis=1), np.roll(grid, -1, axis=1)]
    return quads(*(corner.reshape(-1, 3) for corner in corners))


def quads(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Return two triangles for each quad a, b, c, d, each (n, 3)."""
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def cells(filled: tuple[tuple[int, int, int], ...], sides: FloatArray) -> FloatArray:
    """Return the surface of unit cells put together, stretched by `sides` (3,) and centred."""
    found: list[NDArray[np.float64]] = []
    for cell in filled:
        for axis in range(3):
            for side in (0, 1):
                step = np.zeros(3, dtype=int)
                step[axis] = 2 * side - 1
                if tuple(np.array(cell) + step) not in filled:
                    found.append(np.array(cell) + face(axis, side))
    corners = np.array(found, dtype=np.float64)
    triangles = quads(*(corners[:, k] for k in range(4))) * sides
    return triangles - triangles.mean(axis=(0, 1))


def face(axis: int, side: int) -> FloatArray:
    """Return the four corners (4, 3) of one side of the unit cell, outward."""
    one, two = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
    corners = side * np.eye(3)[axis] + np.array([0 * one, one, one + two, two])
    return corners if side else corners[::-1]


def write_mesh(path: Path, triangles: FloatArray, seed: int, unit: str = "m") -> None:
    """Write triangles (n, 3, 3) in a unit as the suffix says; of OBJ with shared vertices, of STL binary (float32)."""
    if path.suffix in WRITERS:
        path.write_bytes(WRITERS[path.suffix](triangles, unit, seed))
        return
    if path.suffix == ".obj":
        points, index = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
        lines = [f"# closecall oracle, seed {seed}"]
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
        lines += [f"f {a} {b} {c}" for a, b, c in (index.reshape(-1, 3) + 1).tolist()]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return
    records = np.zeros(len(triangles), dtype=STL_RECORD)
    records["corners"] = triangles
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    records["normal"] = normals / np.linalg.norm(normals, axis=1)[:, None]
    header = f"closecall oracle, seed {seed}".encode().ljust(80) + len(triangles).to_bytes(4, "little")
    path.write_bytes(header + records.tobytes())
