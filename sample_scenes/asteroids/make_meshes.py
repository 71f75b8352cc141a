"""Write big.stl, middle.stl and small.stl: three bumpy, closed rocks, about 60, 40 and 25 m in radius.

Run it from anywhere: python make_meshes.py
"""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]

STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def icosahedron() -> Mesh:
    """Return corners (12, 3) on the unit sphere and triangles (20, 3), outward."""
    golden = 0.5 * (1.0 + 5.0**0.5)
    flat = [(s, t * golden) for s in (-1.0, 1.0) for t in (-1.0, 1.0)]
    corners = np.array([np.roll((0.0, a, b), shift) for shift in range(3) for a, b in flat])
    near = np.linalg.norm(corners[:, None] - corners, axis=2) < 2.1
    np.fill_diagonal(near, False)
    found = [corner for corner in combinations(range(12), 3) if all(near[a, b] for a, b in combinations(corner, 2))]
    outward = [(a, b, c) if np.linalg.det(corners[[a, b, c]]) > 0 else (a, c, b) for a, b, c in found]
    return corners / np.linalg.norm(corners[0]), np.array(outward)


def divided(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> Mesh:
    """Cut every triangle in four at the middles of its edges, pushed out onto the unit sphere."""
    points, middles = list(vertices), {}

    def middle(a: int, b: int) -> int:
        edge = (min(a, b), max(a, b))
        if edge not in middles:
            middles[edge] = len(points)
            between = points[a] + points[b]
            points.append(between / np.linalg.norm(between))
        return middles[edge]

    smaller: list[tuple[int, int, int]] = []
    for a, b, c in triangles.tolist():
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        smaller += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return np.array(points), np.array(smaller)


def rock(radius: float, axes: tuple[float, float, float], waves: float) -> Mesh:
    """Return a rock, m: a ball stretched along its axes, with bumps and hollows of up to a fifth of its radius.

    Args:
        radius: mean, m.
        axes: stretch along x, y, z.
        waves: picks the pattern of the bumps.
    """
    directions, triangles = divided(*divided(*icosahedron()))
    x, y, z = directions.T
    bumps = np.sin(3.0 * x + waves) * np.cos(4.0 * y - 2.0 * waves) + 0.5 * np.sin(7.0 * z + 5.0 * x * y + 3.0 * waves)
    height = radius * (1.0 + 0.13 * bumps)
    return height[:, None] * directions * axes, triangles


def write_stl(path: Path, vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> None:
    """Write a binary STL, coordinates to 1/1024 m, which its 32-bit floats hold exactly."""
    corners = (np.round(vertices * 1024.0) / 1024.0)[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    rows = np.zeros(len(triangles), STL_TRIANGLE)
    rows["corners"] = corners
    rows["normal"] = np.round(normals / np.linalg.norm(normals, axis=1)[:, None] * 1024.0) / 1024.0
    path.write_bytes(b"closecall sample asteroid".ljust(80) + len(rows).to_bytes(4, "little") + rows.tobytes())


if __name__ == "__main__":
    folder = Path(__file__).parent
    write_stl(folder / "big.stl", *rock(60.0, (1.25, 1.0, 0.85), 0.4))
    write_stl(folder / "middle.stl", *rock(40.0, (1.0, 1.3, 0.9), 1.7))
    write_stl(folder / "small.stl", *rock(25.0, (0.9, 1.0, 1.2), 2.9))
