"""PLY: the polygons of a file, ASCII or binary of either byte order.

trimesh 5.2 loads ASCII files that are cut short, hold NaN or refer to vertices they do not have, all without a word,
and did not load a binary file of triangles and quadrilaterals with a colour each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ..text.errors import quoted
from .ply_header import Element, read_header
from .ply_rows import AsciiRows, BinaryRows
from .polygons import polygon_surface, refuse_unfit
from .surface import MeshError, Surface, float32_grid, grid_warnings

_CORNERS = ("vertex_indices", "vertex_index")
_NONE = Element("", 0, ())


def read_ply(data: bytes) -> Surface:
    """Return the surface of a PLY file; polygons are cut into triangles.

    Raises:
        MeshError: the file is cut short or malformed, its counts do not hold, a coordinate is not finite, an index is
            out of range, or there are no faces.
    """
    header = read_header(data)
    elements = {element.name: element for element in header.elements}
    vertex, face = elements.get("vertex", _NONE), elements.get("face", _NONE)
    if elements.get("tristrips", _NONE).count:
        raise MeshError("strips of triangles ('tristrips') are not supported by this version, expected faces")
    if not face.count:
        raise MeshError("the file has no faces, expected at least one triangle")
    columns, column = _coordinate_columns(vertex), _corner_column(face)
    rows = BinaryRows(data, header) if header.order else AsciiRows(data, header)
    vertices: FloatArray = np.empty((0, 3))
    corners: IntArray = np.empty(0, dtype=np.int64)
    sizes = corners
    lines: Sequence[int] = ()
    for element in header.elements:
        if element is vertex:
            vertices = rows.vertices(element, columns)
        elif element is face:
            corners, sizes, lines = rows.polygons(element, column)
        else:
            rows.skip(element)
    rows.finish()
    refuse_unfit(corners, sizes, lines, len(vertices))
    warnings = ["holds edges, which are left out"] if elements.get("edge", _NONE).count else []
    surface = polygon_surface(vertices, corners, sizes, warnings, lines)
    singles = [axis for axis, column in enumerate(columns) if vertex.properties[column].code == "f"]
    if not header.order or not singles:
        return surface
    used = vertices[corners]
    return replace(surface, measured=surface.measured + grid_warnings(used, float32_grid(used[:, singles])))


def _coordinate_columns(vertex: Element) -> tuple[int, int, int]:
    """Return the places of x, y and z among the vertices' properties."""
    places = {part.name: place for place, part in enumerate(vertex.properties) if part.count_code is None}
    missing = [name for name in "xyz" if name not in places]
    if missing:
        raise MeshError(f"the header declares no vertices with a number {quoted(missing[0])}")
    return places["x"], places["y"], places["z"]


def _corner_column(face: Element) -> int:
    """Return the place of the corners among the faces' properties."""
    for place, part in enumerate(face.properties):
        if part.name in _CORNERS and part.is_list_of_integers:
            return place
    raise MeshError("the header declares no faces with a list of integers " + " or ".join(map(repr, _CORNERS)))
