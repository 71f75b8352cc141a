"""Write pinion.obj and wheel.obj: involute gears of 20 and 30 teeth, module 4 mm, thinned for 0.12 mm of play a side.

Run it from anywhere: python make_meshes.py
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

MODULE = 4.0
"""mm: the pitch diameter is module times teeth, the centre distance 4 (20 + 30) / 2 = 100 mm."""

PRESSURE_ANGLE = np.radians(20.0)

FLANK_CLEARANCE = 0.12
"""mm, between facing flanks along the line of action, when the tooth stands in the middle of its gap."""

FLANK_POINTS = 8
"""Corners along each involute. Chords run inside the tooth, so that facets can only add clearance."""

ADDENDUM, DEDENDUM = 1.0, 1.25
"""In modules: how far teeth reach outside the pitch circle, and gaps inside."""


def tooth(teeth: int) -> NDArray[np.float64]:
    """Return the outline (n, 2) mm of one tooth about the +x axis, anticlockwise, from root to root."""
    pitch_radius = 0.5 * MODULE * teeth
    base, tip = pitch_radius * np.cos(PRESSURE_ANGLE), pitch_radius + ADDENDUM * MODULE
    # A turn by one angle shifts an involute along its normals by that angle times the base radius.
    thinned = 0.5 * FLANK_CLEARANCE / base
    half = 0.5 * np.pi / teeth + np.tan(PRESSURE_ANGLE) - PRESSURE_ANGLE - thinned
    roll = np.linspace(0.0, np.sqrt((tip / base) ** 2 - 1.0), FLANK_POINTS)
    radii = base * np.hypot(1.0, roll)
    angles = half - (roll - np.arctan(roll))
    root = pitch_radius - DEDENDUM * MODULE
    root_angle = half + 0.15 * (np.pi / teeth - half)
    radii, angles = np.append(root, radii), np.append(root_angle, angles)
    radii, angles = np.append(radii, radii[::-1]), np.append(-angles, angles[::-1])
    return np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])


def gear(teeth: int, bore: float, width: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return corners (n, 3) mm and triangles (m, 3), outward, of a gear about z with a bore of this radius, mm."""
    one = tooth(teeth)
    corner = np.array([bore, 0.0])
    turns = 2.0 * np.pi * np.arange(teeth) / teeth
    matrices = np.array([[np.cos(turns), -np.sin(turns)], [np.sin(turns), np.cos(turns)]]).transpose(2, 0, 1)
    flat = np.concatenate([np.vstack([corner, one]) @ matrix.T for matrix in matrices])
    count = len(one) + 1
    total = len(flat)
    triangles: list[tuple[int, int, int]] = []
    for start in range(0, total, count):
        hole, next_hole = start, (start + count) % total
        outline = [*range(start + 1, start + count), (start + count + 1) % total]
        cap = [(hole, a, b) for a, b in pairwise(outline)]
        cap.append((hole, outline[-1], next_hole))
        triangles += [(c + total, a + total, b + total) for c, a, b in cap]
        triangles += [(c, b, a) for c, a, b in cap]
        walls = [*pairwise(outline), (next_hole, hole)]
        triangles += [t for a, b in walls for t in ((a, b, b + total), (a, b + total, a + total))]
    low, high = (np.column_stack([flat, np.full(total, z)]) for z in (-0.5 * width, 0.5 * width))
    return np.concatenate([low, high]), np.array(triangles)


def write_obj(path: Path, vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> None:
    """Write an OBJ, coordinates to 1e-6 mm."""
    rows = [f"v {x:.6f} {y:.6f} {z:g}\n" for x, y, z in vertices.tolist()]
    rows += [f"f {a} {b} {c}\n" for a, b, c in (triangles + 1).tolist()]
    path.write_text("".join(rows), encoding="ascii", newline="\n")


if __name__ == "__main__":
    folder = Path(__file__).parent
    write_obj(folder / "pinion.obj", *gear(teeth=20, bore=12.0, width=12.0))
    write_obj(folder / "wheel.obj", *gear(teeth=30, bore=20.0, width=10.0))
