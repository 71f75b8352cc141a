"""Write forearm.obj, a tapered beam, and bracket.obj, a T-shaped stand with a foot.

Run it from anywhere: python make_meshes.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Mesh = tuple[NDArray[np.float64], list[tuple[int, int, int]]]

FOREARM = [(-40.0, 45.0), (0.0, 55.0), (60.0, 55.0), (340.0, 32.0), (400.0, 32.0)]
"""mm: places along the beam (z, from the elbow) and the corner radius of its eight-sided section there."""

HALF_BRACKET = [(70.0, 0.0), (70.0, 15.0), (18.0, 25.0), (18.0, 215.0), (55.0, 237.0), (55.0, 252.0)]
"""mm: the right half of the stand's outline, (x, z) from its foot to its top at 252."""

BRACKET_DEPTH = 60.0
"""mm, along y."""


def loft(rings: list[NDArray[np.float64]]) -> Mesh:
    """Join rings (n, 3), each anticlockwise seen from the next, into a closed surface with flat ends."""
    count = len(rings[0])
    ends = [rings[0].mean(axis=0), rings[-1].mean(axis=0)]
    triangles: list[tuple[int, int, int]] = []
    for ring in range(len(rings) - 1):
        for i in range(count):
            a, b = ring * count + i, ring * count + (i + 1) % count
            triangles += [(a, b, b + count), (a, b + count, a + count)]
    first, last, start = len(rings) * count, len(rings) * count + 1, (len(rings) - 1) * count
    for i in range(count):
        j = (i + 1) % count
        triangles += [(first, j, i), (last, start + i, start + j)]
    return np.vstack([*rings, *ends]), triangles


def forearm() -> Mesh:
    """Return the beam along +z, its flat sides towards x and y."""
    angles = np.pi * (2.0 * np.arange(8) + 1.0) / 8.0
    circle = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(8)])
    return loft([radius * circle + [0.0, 0.0, z] for z, radius in FOREARM])


def bracket() -> Mesh:
    """Return the stand: horizontal slices, each a rectangle, from the foot to the top."""
    square = np.array([(1.0, -0.5), (1.0, 0.5), (-1.0, 0.5), (-1.0, -0.5)])
    return loft([np.array([(x * sx, BRACKET_DEPTH * sy, z) for sx, sy in square.tolist()]) for x, z in HALF_BRACKET])


def write_obj(path: Path, mesh: Mesh) -> None:
    """Write an OBJ, coordinates to 1e-6 mm."""
    rows = [f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in mesh[0].tolist()]
    rows += [f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in mesh[1]]
    path.write_text("".join(rows).replace("-0.000000", "0.000000"), encoding="ascii", newline="\n")


if __name__ == "__main__":
    folder = Path(__file__).parent
    write_obj(folder / "forearm.obj", forearm())
    write_obj(folder / "bracket.obj", bracket())
