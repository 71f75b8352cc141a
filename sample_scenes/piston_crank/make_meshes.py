"""Write piston.obj, a piston with a shallow dish in its crown and the room for the rod cut out below.

Run it from anywhere: python make_meshes.py
"""

from __future__ import annotations

from math import cos, pi, sin
from pathlib import Path

PROFILE = [(30.0, 10.0), (30.0, -20.0), (42.9, -20.0), (42.9, 30.0), (38.0, 30.0), (36.0, 29.0)]
"""mm: the outline (radius, z) from the middle of the inner ceiling to the middle of the dish; the pin is at z = 0."""

CEILING, FLOOR = 10.0, 29.0
"""mm: z of the two middles."""

SIDES = 32


def lathe() -> tuple[list[tuple[float, float, float]], list[tuple[int, int, int]]]:
    """Turn the outline about z; the triangles face outward."""
    vertices = [
        (radius * cos(2.0 * pi * i / SIDES), radius * sin(2.0 * pi * i / SIDES), z)
        for radius, z in PROFILE
        for i in range(SIDES)
    ]
    vertices += [(0.0, 0.0, CEILING), (0.0, 0.0, FLOOR)]
    triangles: list[tuple[int, int, int]] = []
    for ring in range(len(PROFILE) - 1):
        for i in range(SIDES):
            a, b = ring * SIDES + i, ring * SIDES + (i + 1) % SIDES
            triangles += [(a, b, b + SIDES), (a, b + SIDES, a + SIDES)]
    last = (len(PROFILE) - 1) * SIDES
    for i in range(SIDES):
        j = (i + 1) % SIDES
        triangles += [(len(vertices) - 2, j, i), (len(vertices) - 1, last + i, last + j)]
    return vertices, triangles


if __name__ == "__main__":
    vertices, triangles = lathe()
    rows = [f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in vertices]
    rows += [f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in triangles]
    text = "".join(rows).replace("-0.000000", "0.000000")
    (Path(__file__).parent / "piston.obj").write_text(text, encoding="ascii", newline="\n")
