"""The surfaces of bodies: each kept once, and those that are too fine for a page drawn coarser."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive

from ...scheduler.geometry.arrays import FloatArray, IntArray

# Triangles in a page; of one model; and those that a model keeps at least.
_MOST_TRIANGLES = 150_000
_MOST_OF_ONE = 40_000
_FEWEST_OF_ONE = 200

# Cells across a model that points are merged in, from fine to coarse.
_CELLS = (256, 128, 64, 32, 16, 8)


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """Triangles (m, 3) over points (n, 3), m, in the frame of a part."""

    points: FloatArray
    triangles: IntArray


class Models:
    """Distinct surfaces.

    Attributes:
        coarser: how many models have fewer triangles than the log shows.
    """

    def __init__(self) -> None:
        self._models: list[Model] = []
        self._known: dict[bytes, int] = {}
        self.coarser = 0

    def add(self, mesh: TriangleListPrimitive) -> int:
        """Take a surface in; return its number."""
        key = TriangleListPrimitive(points=mesh.points, indices=mesh.indices).SerializeToString(deterministic=True)
        if key not in self._known:
            points = np.array([(point.x, point.y, point.z) for point in mesh.points], dtype=np.float64).reshape(-1, 3)
            corners = np.array(mesh.indices, dtype=np.int64) if mesh.indices else np.arange(len(points))
            triangles = corners[: len(corners) // 3 * 3].reshape(-1, 3)
            self._known[key] = len(self._models)
            self._models.append(Model(points, triangles[(triangles < len(points)).all(axis=1)]))
        return self._known[key]

    def drawn(self) -> list[Model]:
        """Return all models, with few enough triangles for a page."""
        total = sum(min(len(model.triangles), _MOST_OF_ONE) for model in self._models)
        share = min(1.0, _MOST_TRIANGLES / max(total, 1))
        models = []
        for model in self._models:
            most = max(_FEWEST_OF_ONE, ceil(share * min(len(model.triangles), _MOST_OF_ONE)))
            models.append(_coarser(model, most))
        self.coarser = sum(len(a.triangles) < len(b.triangles) for a, b in zip(models, self._models, strict=True))
        return models


def _coarser(model: Model, most: int) -> Model:
    """Return a model with at most so many triangles, or as few as merging its points in a coarse grid leaves."""
    coarse = model
    for cells in _CELLS:
        if len(coarse.triangles) <= most:
            break
        coarse = _merged(model, cells)
    return coarse


def _merged(model: Model, cells: int) -> Model:
    """Return a model whose points within a cell of a grid are their mean, without the triangles that vanish."""
    low = model.points.min(axis=0)
    cell = float(np.ptp(model.points, axis=0).max()) / cells or 1.0
    places = ((model.points - low) / cell).astype(np.int64)
    _, where, counts = np.unique(places, axis=0, return_inverse=True, return_counts=True)
    where = where.reshape(-1)
    points = np.column_stack([np.bincount(where, weights=column) for column in model.points.T]) / counts[:, None]
    triangles = where[model.triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    return Model(points, triangles[np.sort(first)])
