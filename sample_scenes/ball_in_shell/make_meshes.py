"""Write solid.obj, a faceted ball drawn by its outer skin alone, and hollow.obj, the same with a cubic pocket inside.

Run it from anywhere: python make_meshes.py
"""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

OUTER_RADIUS = 120.0
"""mm: of the corners of the skin, a geodesic ball of 320 triangles."""

POCKET = 100.0
"""mm: the edge of the cubic pocket, centred; its corners are 86.6 mm from the centre, inside the skin."""

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]


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


def skin() -> Mesh:
    """Return the outer surface, mm."""
    vertices, triangles = divided(*divided(*icosahedron()))
    return OUTER_RADIUS * vertices, triangles


def pocket_wall() -> Mesh:
    """Return the pocket's surface, mm, its triangles facing into the pocket, away from the material."""
    corners = POCKET * np.array([[(i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2) - 0.5] for i in range(8)])
    outward = [(0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5), (0, 1, 5), (0, 5, 4)]
    outward += [(2, 6, 7), (2, 7, 3), (0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6)]
    return corners, np.array(outward)[:, ::-1]


def joined(one: Mesh, other: Mesh) -> Mesh:
    """Return two surfaces as one mesh."""
    return np.concatenate([one[0], other[0]]), np.concatenate([one[1], other[1] + len(one[0])])


def write_obj(path: Path, vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> None:
    """Write an OBJ, coordinates to 1e-6 mm."""
    rows = [f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in (vertices + 0.0).tolist()]
    rows += [f"f {a} {b} {c}\n" for a, b, c in (triangles + 1).tolist()]
    path.write_text("".join(rows).replace("-0.000000", "0.000000"), encoding="ascii", newline="\n")


if __name__ == "__main__":
    folder = Path(__file__).parent
    write_obj(folder / "solid.obj", *skin())
    write_obj(folder / "hollow.obj", *joined(skin(), pocket_wall()))
