"""Thin triangles: by how much they may falsify a distance, and which are too thin for floating point."""

from __future__ import annotations

import numpy as np

from ..geometry.arrays import FloatArray, IntArray
from ..geometry.segments import sides_of
from ..model.scene import Mesh

EPSILON = float(np.finfo(float).eps)
#: A triangle whose height is below this share of its longest side is taken for that side: its normal is noise.
THINNEST = 1e-8
#: m^2. So is one whose doubled area is below this, whose face FCL would skip (`narrow_phase.SCALE`): that side is then
#: the whole of it to 4e-22 m.
SMALLEST = 1e-43
#: The rounding of a thin triangle's normal misplaces its face by less than this times eps * side^2 / height
#: (measured: at most 0.17 over 6,000 pairs, `python -m benchmarks.narrow_phase_error 6000`).
NORMAL_ERROR = 16.0


def without_slivers(mesh: Mesh) -> tuple[IntArray, float]:
    """Return the mesh's triangles (m, 3) with each sliver collapsed onto its longest side as (a, b, b).

    The second value is how far (m) the distance to the mesh may then err for the triangles' thinness: the height of
    the collapsed ones, the rounding of the others' normals.
    """
    triangles = mesh.triangles.copy()
    corners = mesh.vertices[triangles]
    sides = np.linalg.norm(sides_of(corners), axis=2)
    longest = sides.max(axis=1)
    heights = _heights(corners, longest)
    thin = (heights <= THINNEST * longest) | (heights * longest < SMALLEST)
    start = np.argmax(sides, axis=1)
    rows = np.arange(len(triangles))
    ends = triangles[rows, (start + 1) % 3]
    collapsed = np.stack((triangles[rows, start], ends, ends), axis=1)
    triangles[thin] = collapsed[thin]
    faces = ~thin
    normals = NORMAL_ERROR * EPSILON * longest[faces] ** 2 / heights[faces]
    return triangles, float(max(heights[thin].max(initial=0.0), normals.max(initial=0.0)))


def _heights(corners: FloatArray, longest: FloatArray) -> FloatArray:
    """Return each triangle's height (m) over its longest side; 0 for points and segments."""
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    heights: FloatArray = np.divide(areas, longest, out=np.zeros(len(areas)), where=longest > 0.0)
    return heights
