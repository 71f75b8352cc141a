"""Mesh files read from scratch, and what holds of a triangle set: its parts, whether it is closed."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from .mesh_formats import READERS
from .rigid import FloatArray

STL_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_triangles(path: Path) -> FloatArray:
    """Return the file's triangles (n, 3, 3) in the file's own units and axes."""
    if path.suffix.lower() == ".obj":
        return read_obj(path)
    if path.suffix.lower() == ".stl":
        return read_stl(path)
    if path.suffix.lower() in READERS:
        return READERS[path.suffix.lower()](path.read_bytes())
    raise NotImplementedError(f"the oracle does not read {path.suffix} files")


def read_obj(path: Path) -> FloatArray:
    """Return the triangles of an OBJ file; polygons become fans."""
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            raw = [int(word.split("/")[0]) for word in words[1:]]
            corners = [index - 1 if index > 0 else len(vertices) + index for index in raw]
            triangles += [(corners[0], one, two) for one, two in pairwise(corners[1:])]
    return np.array(vertices)[np.array(triangles)]


def read_stl(path: Path) -> FloatArray:
    """Return the triangles of a binary STL file, or of an ASCII one."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + count * STL_RECORD.itemsize:
        return np.frombuffer(data, STL_RECORD, count, 84)["corners"].astype(np.float64)
    rows = [line.split()[1:] for line in data.decode("ascii").splitlines() if line.strip().startswith("vertex")]
    return np.array(rows, dtype=np.float64).reshape(-1, 3, 3)


@dataclass(frozen=True, slots=True, eq=False)
class Topology:
    """What holds of a triangle set once equal corners are merged.

    Attributes:
        parts: (k,) for each connected part the index of one of its triangles.
        closed: whether every edge belongs to exactly two triangles.
    """

    parts: NDArray[np.int64]
    closed: bool


def topology(triangles: FloatArray) -> Topology:
    """Merge exactly equal corners of (n, 3, 3) triangles and find parts and closedness."""
    _, flat = np.unique(triangles.reshape(-1, 3) + 0.0, axis=0, return_inverse=True)
    corners = flat.reshape(-1, 3)
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    size = int(corners.max()) + 1
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(size, size))
    _, labels = connected_components(graph, directed=False)
    _, parts = np.unique(labels[corners[:, 0]], return_index=True)
    _, counts = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    return Topology(parts, bool((counts == 2).all()))
