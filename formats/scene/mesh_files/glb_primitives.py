"""The triangles of glTF's meshes: from accessors over views over the file's bytes to vertices and corners."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ..text.errors import quoted
from .assembly import Budget
from .gltf import FAN, POINTS_AND_LINES, STRIP, Accessor, Document, Primitive, View
from .surface import MeshError, float32_grid

_FLOAT = 5126
_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", _FLOAT: "<f4"}
_WHOLE = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}
"""What a normalized integer is divided by."""

_INDEX_TYPES = frozenset((5121, 5123, 5125))
_WIDTHS = {"SCALAR": 1, "VEC3": 3}
_DRACO = "KHR_draco_mesh_compression"


class Primitives:
    """The meshes of one file."""

    def __init__(self, document: Document, binary: memoryview) -> None:
        """Take the document, and the binary chunk that its buffer is."""
        self.left_out: set[str] = set()
        self._document = document
        self._binary = binary
        self._budget = Budget()

    def of_mesh(self, index: int) -> Iterator[tuple[FloatArray, IntArray, float]]:
        """Yield the vertices (n, 3) and triangles (m, 3) of each of a mesh's primitives that has triangles.

        With them comes how far apart the floats are in which the file has the vertices; 0 for whole numbers.

        Raises:
            MeshError: one cannot be read, then the message names it; or all in all there are too many.
        """
        if index >= len(self._document.meshes):
            raise MeshError(f"a mesh {index} is referred to, the file has {len(self._document.meshes)}")
        for number, primitive in enumerate(self._document.meshes[index].primitives):
            self._budget.spend(0, 1)
            try:
                if primitive.mode in POINTS_AND_LINES:
                    self.left_out.add("points" if primitive.mode == 0 else "lines")
                else:
                    yield self._geometry(primitive)
            except MeshError as error:
                raise MeshError(f"meshes[{index}].primitives[{number}]: {error.message}") from error

    def _geometry(self, primitive: Primitive) -> tuple[FloatArray, IntArray, float]:
        if _DRACO in primitive.extensions:
            raise MeshError(f"the extension {_DRACO} is not supported by this version")
        if primitive.targets:
            raise MeshError("morph targets are not supported by this version")
        if "POSITION" not in primitive.attributes:
            raise MeshError("expected an attribute POSITION")
        positions = self._positions(primitive.attributes["POSITION"])
        corners = self._corners(primitive, len(positions))
        triangles = _triangles(corners, primitive.mode)
        used, renumbered = np.unique(triangles, return_inverse=True)
        accessor = self._document.accessors[primitive.attributes["POSITION"]]
        vertices = positions[used].astype(np.float64)
        if accessor.normalized and accessor.component_type in _WHOLE:
            vertices = np.maximum(vertices / _WHOLE[accessor.component_type], -1.0)
        if not np.isfinite(vertices).all():
            raise MeshError("a coordinate is not finite")
        grid = float32_grid(vertices) if len(vertices) and accessor.component_type == _FLOAT else 0.0
        return vertices, renumbered.reshape(-1, 3), grid

    def _positions(self, index: int) -> NDArray[Any]:
        """Return an accessor's (n, 3) values as they are stored, a view of the file's bytes."""
        accessor = self._accessor(index, "VEC3")
        if accessor.component_type == 5125:
            raise MeshError(f"accessors[{index}]: expected coordinates as float, short or byte")
        return self._values(accessor, index)

    def _corners(self, primitive: Primitive, count: int) -> IntArray:
        """Return the corners in the order that the mode speaks of, each below `count`."""
        each = 1 if primitive.mode in (STRIP, FAN) else 3
        if primitive.indices is None:
            self._budget.spend(count // each, 0)
            return np.arange(count)
        accessor = self._accessor(primitive.indices, "SCALAR")
        if accessor.component_type not in _INDEX_TYPES:
            raise MeshError(f"accessors[{primitive.indices}]: expected indices as unsigned integers")
        self._budget.spend(accessor.count // each, 0)
        corners: IntArray = self._values(accessor, primitive.indices).reshape(-1).astype(np.int64)
        if corners.max() >= count:
            raise MeshError(f"the index {corners.max()} is out of range, there are {count} vertices")
        return corners

    def _accessor(self, index: int, kind: str) -> Accessor:
        if index >= len(self._document.accessors):
            raise MeshError(f"an accessor {index} is referred to, the file has {len(self._document.accessors)}")
        accessor = self._document.accessors[index]
        if accessor.type != kind:
            raise MeshError(f"accessors[{index}]: expected the type {kind}")
        if not accessor.count:
            raise MeshError(f"accessors[{index}]: expected at least one value")
        if accessor.sparse is not None:
            raise MeshError(f"accessors[{index}]: sparse accessors are not supported by this version")
        return accessor

    def _values(self, accessor: Accessor, index: int) -> NDArray[Any]:
        """Return the accessor's (n, width) values, a view of the file's bytes."""
        view = self._view(accessor, index)
        layout = np.dtype(_TYPES[accessor.component_type])
        width = _WIDTHS[accessor.type]
        stride = view.byte_stride or layout.itemsize * width
        need = accessor.byte_offset + stride * (accessor.count - 1) + layout.itemsize * width
        begin = view.byte_offset + accessor.byte_offset
        if need > view.byte_length or view.byte_offset + view.byte_length > len(self._binary):
            raise MeshError(f"accessors[{index}]: the bytes of {accessor.count} values lie beyond those of the file")
        strides = (stride, layout.itemsize)
        return np.ndarray((accessor.count, width), layout, self._binary, begin, strides)

    def _view(self, accessor: Accessor, index: int) -> View:
        number = accessor.buffer_view
        if number is None or number >= len(self._document.buffer_views):
            raise MeshError(f"accessors[{index}]: expected a buffer view that the file has")
        view = self._document.buffer_views[number]
        if view.extensions:
            name = next(iter(view.extensions))
            raise MeshError(f"bufferViews[{number}]: the extension {quoted(name)} is not supported by this version")
        if view.buffer >= len(self._document.buffers):
            raise MeshError(f"bufferViews[{number}]: expected a buffer that the file has")
        if view.buffer != 0 or self._document.buffers[0].uri is not None:
            raise MeshError(f"bufferViews[{number}]: buffers outside the binary chunk are not supported")
        return view


def _triangles(corners: IntArray, mode: int) -> IntArray:
    """Return the (m, 3) triangles of a list, a strip or a fan of corners.

    Those of a strip or a fan with two equal corners join what lies apart and are no part of it: left out.
    """
    if mode not in (STRIP, FAN):
        if len(corners) % 3:
            raise MeshError(f"expected three corners for each triangle, got {len(corners)} in all")
        return corners.reshape(-1, 3)
    if len(corners) < 3:
        raise MeshError(f"expected at least three corners, got {len(corners)}")
    if mode == STRIP:
        triangles = np.column_stack((corners[:-2], corners[1:-1], corners[2:]))
        triangles[1::2] = triangles[1::2, ::-1]
    else:
        triangles = np.column_stack((np.full(len(corners) - 2, corners[0]), corners[1:-1], corners[2:]))
    a, b, c = triangles.T
    joined: IntArray = triangles[(a != b) & (b != c) & (c != a)]
    return joined
