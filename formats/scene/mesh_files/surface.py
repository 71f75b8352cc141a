"""A triangle surface as a mesh file gives it, and what can be said of its shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ....scheduler.geometry.unique_points import distinct_points
from ..limits import COARSE_GRID


class MeshError(Exception):
    """A mesh file that cannot be used: what is wrong, and in which of its lines if it has lines."""

    def __init__(self, message: str, line: int | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.line = line


@dataclass(frozen=True, slots=True)
class MeasuredWarning:
    """What is doubtful in a mesh file, with a length.

    Attributes:
        text: with `{length}` where the length belongs.
        length: in the file's unit.
    """

    text: str
    length: float


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """What a mesh file holds.

    Attributes:
        vertices: (n, 3) finite, in the file's unit and axes.
        triangles: (m, 3) indices of vertices, in the file's order, m >= 1.
        warnings: what was doubtful in the file.
        measured: what was doubtful by how much.
        unit: the unit of length that the file itself states, m, cm, mm, in, ft or micron; None if it states none.
    """

    vertices: FloatArray
    triangles: IntArray
    warnings: tuple[str, ...]
    unit: str | None = None
    measured: tuple[MeasuredWarning, ...] = ()


def float32_grid(coordinates: FloatArray) -> float:
    """Return how far apart neighbouring 32-bit floats are at the largest of finite coordinates that are such."""
    return float(np.spacing(np.float32(np.abs(coordinates).max())))


def grid_warnings(vertices: FloatArray, grid: float) -> tuple[MeasuredWarning, ...]:
    """Return the warning of a surface (n, 3) whose corners stand on a grid that is coarse for its size, if it is."""
    size = float(np.ptp(vertices, axis=0).max())
    if not size or grid <= COARSE_GRID * size:
        return ()
    text = "lies so far from its own origin that its 32-bit floats put its corners on a grid of {length}"
    return (MeasuredWarning(f"{text}: move its origin into it, or write it with more digits", grid),)


@dataclass(frozen=True, slots=True)
class Topology:
    """How the triangles of a surface join at their vertices.

    Attributes:
        loose_edges: edges that do not join exactly two triangles.
        twisted_edges: directed edges that two or more triangles share: neighbours turned against each other.
        flat_triangles: triangles without area.
        solid: whether every edge joins two triangles.
    """

    loose_edges: int
    twisted_edges: int
    flat_triangles: int
    solid: bool


def welded(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """Return the same surface with exactly equal vertices made one (0.0 and -0.0 are equal), the others in order."""
    firsts, places = distinct_points(vertices)
    if len(firsts) == len(vertices):
        return vertices, triangles
    return vertices[firsts], places[triangles]


def topology(vertices: FloatArray, triangles: IntArray) -> Topology:
    """Return how the triangles join. Those with two equal corners have no say in it.

    Args:
        vertices: (n, 3), no two of them equal.
        triangles: (m, 3) indices of vertices.
    """
    a, b, c = triangles.T
    whole = triangles[(a != b) & (b != c) & (c != a)]
    begins, ends = whole.reshape(-1), np.roll(whole, -1, axis=1).reshape(-1)
    count = len(vertices)
    _, uses = np.unique(np.minimum(begins, ends) * count + np.maximum(begins, ends), return_counts=True)
    _, directed_uses = np.unique(begins * count + ends, return_counts=True)
    loose = int(np.count_nonzero(uses != 2))
    return Topology(
        loose_edges=loose,
        twisted_edges=int(np.count_nonzero(directed_uses > 1)),
        flat_triangles=_count_flat(vertices, triangles),
        solid=loose == 0 and len(whole) > 0,
    )


def _count_flat(vertices: FloatArray, triangles: IntArray) -> int:
    corners = vertices[triangles]
    with np.errstate(all="ignore"):  # coordinates whose products overflow are refused where the mesh is used
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return int(np.count_nonzero(~normals.any(axis=1)))


def used_only(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """Return the surface without vertices that no triangle uses, which would widen the bounds on its motion."""
    used = np.zeros(len(vertices), dtype=bool)
    used[triangles] = True
    if used.all():
        return vertices, triangles
    return vertices[used], (np.cumsum(used) - 1)[triangles]
