"""STL, binary and ASCII. Files cut short or lying, which trimesh 5.2 loads without a word, are refused first."""

from __future__ import annotations

import io

import numpy as np

from ....scheduler.geometry.arrays import FloatArray
from ..text.errors import counted, printable, quoted
from .obj import coordinate
from .surface import MeshError, Surface, float32_grid, grid_warnings

_HEADER_BYTES = 84
_TRIANGLE_BYTES = 50


def read_stl(data: bytes) -> Surface:
    """Return the surface of an STL file: three vertices of its own for each triangle.

    Raises:
        MeshError: the file is cut short or malformed, a coordinate is not finite, or there are no triangles.
    """
    ascii_text = _is_ascii(data)
    corners, warnings = _read_ascii(data) if ascii_text else _read_binary(data)
    triangles = np.arange(len(corners)).reshape(-1, 3)
    measured = () if ascii_text else grid_warnings(corners, float32_grid(corners))
    return Surface(corners, triangles, warnings, measured=measured)


def _is_ascii(data: bytes) -> bool:
    """Tell ASCII from binary, whose header may begin with `solid` too but whose count (if < 2^24) has a NUL."""
    return data.lstrip()[:5].lower() == b"solid" and b"\0" not in data[:_HEADER_BYTES]


def _read_binary(data: bytes) -> tuple[FloatArray, tuple[str, ...]]:
    if len(data) < _HEADER_BYTES:
        raise MeshError(f"the file has {len(data)} bytes, expected an STL header of {_HEADER_BYTES}")
    count = int.from_bytes(data[80:_HEADER_BYTES], "little")
    end = _HEADER_BYTES + count * _TRIANGLE_BYTES
    if len(data) < end:
        whole = (len(data) - _HEADER_BYTES) // _TRIANGLE_BYTES
        raise MeshError(f"the file is cut short: its header says {counted(count, 'triangle')}, it holds {whole}")
    if count == 0:
        raise MeshError("the header says 0 triangles, expected at least one")
    corners = _loaded_by_trimesh(data[:end])
    if len(corners) != 3 * count:
        raise MeshError(f"expected {count} triangles, got {len(corners) // 3}")
    bad = np.flatnonzero(~np.isfinite(corners).all(axis=1))
    if len(bad):
        raise MeshError(f"triangle {bad[0] // 3 + 1} of {count} has a coordinate that is not finite")
    trailing = len(data) - end
    warning = f"has {counted(trailing, 'byte')} after the {counted(count, 'triangle')} of its header, left out"
    return corners, (warning,) if trailing else ()


def _loaded_by_trimesh(data: bytes) -> FloatArray:
    """Return the (3 m, 3) corners of a binary STL file whose length has been checked."""
    import trimesh  # late: it takes 0.3 s, and most scenes of primitives need none of it

    try:
        with np.errstate(all="ignore"):
            mesh = trimesh.load_mesh(io.BytesIO(data), file_type="stl", process=False)
        corners: FloatArray = np.asarray(mesh.vertices, dtype=np.float64)[np.asarray(mesh.faces)].reshape(-1, 3)
    except Exception as error:  # whatever the library meets, the scene has a fault at this file
        raise MeshError(f"the file cannot be read as STL: {printable(str(error))}") from error
    return corners


_STEPS = {
    ("", b"solid"): "solid",
    ("solid", b"facet"): "facet",
    ("solid", b"endsolid"): "",
    ("facet", b"outer"): "loop",
    ("loop", b"vertex"): "loop",
    ("loop", b"endloop"): "end of loop",
    ("end of loop", b"endfacet"): "solid",
}
"""What each keyword of ASCII STL leads to, by what it stands in."""


def _read_ascii(data: bytes) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the (3 m, 3) corners; the statements are followed one by one, so nothing is lost unnoticed."""
    coordinates: list[float] = []
    state, corners, line = "", 0, 0
    for line, text in enumerate(data.splitlines(), start=1):
        words = text.split()
        if not words:
            continue
        keyword = words[0].lower()
        following = _STEPS.get((state, keyword))
        if following is None:
            raise MeshError(f"expected {_expected(state)}, got {_shown(words[0])}", line)
        if keyword == b"vertex":
            if len(words) != 4:
                raise MeshError(f"expected the three coordinates of a vertex, got {len(words) - 1}", line)
            coordinates += [coordinate(word, line) for word in words[1:]]
            corners += 1
        elif keyword == b"endloop" and corners != 3:
            raise MeshError(f"expected a facet with 3 vertices, got {corners}", line)
        elif keyword == b"endfacet":
            corners = 0
        state = following
    if state:
        raise MeshError(f"the file is cut short: expected {_expected(state)}", line)
    if not coordinates:
        raise MeshError("the file has no facets, expected at least one triangle")
    return np.array(coordinates, dtype=np.float64).reshape(-1, 3), ()


def _expected(state: str) -> str:
    return " or ".join(repr(keyword.decode()) for from_state, keyword in _STEPS if from_state == state)


def _shown(word: bytes) -> str:
    return quoted(word.decode(errors="replace"))
