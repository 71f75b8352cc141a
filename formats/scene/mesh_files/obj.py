"""Wavefront OBJ: the vertices and faces of a file, all of them.

trimesh 5.2 reads OBJ for display and was not faithful here: `f 1 2\\` with its `3` on the next line loses the
face, index 0 becomes vertex 1, negative indices count from the end of the file instead of the face's line, faces of
two corners vanish, `f 1 2 3 # note` fails, and negative_indices.obj of its own test models does not load. Nor does
it know the line of a fault.
"""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Iterator

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ..text.errors import quoted
from .polygons import first_stray, polygon_surface
from .surface import MeshError, Surface

_UNSEEN = {b"l": "lines", b"p": "points", b"curv": "curves", b"curv2": "curves", b"surf": "surfaces"}
"""Elements that are not faces. They are left out with a warning."""


def read_obj(data: bytes) -> Surface:
    """Return the surface of an OBJ file; polygons are cut into triangles.

    Raises:
        MeshError: a coordinate or index cannot be read or is out of range, or there are no faces.
    """
    plain = _read_plain(data)
    if plain is not None:
        return plain
    faces = _Faces()
    for line, words in _statements(data):
        keyword = words[0].lower()
        if keyword == b"v":
            faces.add_vertex(words[1:], line)
        elif keyword in (b"f", b"fo"):
            faces.add_face(words[1:], line)
        elif keyword in _UNSEEN:
            faces.unseen.add(_UNSEEN[keyword])
        elif keyword == b"call":
            raise MeshError("'call' is not supported by this version, put the geometry in one file", line)
    return faces.surface()


_PASSED_OVER = (b"v ", b"f ", b"#", b"vn ", b"vt ", b"vp ", b"g", b"o", b"s ", b"usemtl", b"mtllib")
"""What the lines of a plain file begin with. All but the first two matter not to the shape."""


_AFTER_SLASH = re.compile(rb"/[0-9/]*")
"""What follows the index of a corner's vertex."""


def _read_plain(data: bytes) -> Surface | None:
    """Return the surface of a plain file without a fault, many times faster; None of any other file.

    Every line begins with its keyword and ends its statement, all vertices have as many numbers, and faces count them
    from 1.
    """
    lines = data.splitlines()
    if b"\\" in data or any(line and not line.startswith(_PASSED_OVER) for line in lines):
        return None
    vertices = [line[2:] for line in lines if line.startswith(b"v ")]
    faces = [line[2:] for line in lines if line.startswith(b"f ")]
    widths = {len(line.split()) for line in vertices}
    if not faces or len(widths) != 1 or (width := widths.pop()) < 3:
        return None
    numbers, indices = b" ".join(vertices), _AFTER_SLASH.sub(b"", b" ".join(faces))
    if b"_" in numbers or indices.translate(None, b"0123456789 "):
        return None
    try:
        points: FloatArray = np.array([*map(float, numbers.split())]).reshape(-1, width)[:, :3]
    except ValueError:
        return None
    corners: IntArray = np.fromstring(indices, dtype=np.int64, sep=" ") - 1
    sizes = np.fromiter((len(line.split()) for line in faces), dtype=np.int64, count=len(faces))
    if sizes.sum() != len(corners) or sizes.min() < 3 or corners.min() < 0 or corners.max() >= len(points):
        return None
    if not np.isfinite(points).all():
        return None
    face_lines = [number for number, line in enumerate(lines, start=1) if line.startswith(b"f ")]
    return polygon_surface(points, corners, sizes, (), face_lines)


def _statements(data: bytes) -> Iterator[tuple[int, list[bytes]]]:
    """Yield the words of each statement with its first line; a backslash at a line's end continues it."""
    held: list[bytes] = []
    begin = 0
    for line, text in enumerate(data.splitlines(), start=1):
        if b"#" in text:
            text = text[: text.index(b"#")]
        begin = begin if held else line
        if text.endswith(b"\\"):
            held += text[:-1].split()
            continue
        words = held + text.split() if held else text.split()
        held = []
        if words:
            yield begin, words
    if held:
        yield begin, held


class _Faces:
    """The geometry read so far."""

    def __init__(self) -> None:
        self.unseen: set[str] = set()
        self._coordinates = array("d")
        self._corners = array("q")
        self._sizes = array("q")
        self._lines = array("q")

    def add_vertex(self, words: list[bytes], line: int) -> None:
        """Take `v x y z`; what follows (a weight or a colour) has no say in the shape."""
        if len(words) < 3:
            raise MeshError(f"expected the three coordinates of a vertex, got {len(words)}", line)
        for word in words[:3]:
            self._coordinates.append(coordinate(word, line))

    def add_face(self, words: list[bytes], line: int) -> None:
        """Take `f` with corners `v`, `v/vt`, `v//vn` or `v/vt/vn`; a negative v counts back from here."""
        if len(words) < 3:
            raise MeshError(f"expected a face with at least 3 corners, got {len(words)}", line)
        count = len(self._coordinates) // 3
        for word in words:
            index = vertex_index(word.partition(b"/")[0], line)
            if index == 0 or index < -count:
                raise MeshError(f"the face refers to vertex {index}, expected 1 to {count} or -{count} to -1", line)
            self._corners.append(index - 1 if index > 0 else count + index)
        self._sizes.append(len(words))
        self._lines.append(line)

    def surface(self) -> Surface:
        """Return the whole, once every line is read."""
        if not self._sizes:
            raise MeshError("the file has no faces, expected at least one triangle")
        vertices: FloatArray = np.array(self._coordinates, dtype=np.float64).reshape(-1, 3)
        corners: IntArray = np.array(self._corners, dtype=np.int64)
        sizes: IntArray = np.array(self._sizes, dtype=np.int64)
        self._refuse_forward(corners, sizes, len(vertices))
        warnings = [f"holds {' and '.join(sorted(self.unseen))}, which are left out"] if self.unseen else []
        return polygon_surface(vertices, corners, sizes, warnings, self._lines)

    def _refuse_forward(self, corners: IntArray, sizes: IntArray, count: int) -> None:
        """Refuse a face that refers to a vertex the whole file does not have."""
        stray = first_stray(corners, sizes, count)
        if stray is not None:
            face, corner = stray
            raise MeshError(f"the face refers to vertex {corner + 1}, the file has {count}", self._lines[face])


def coordinate(word: bytes, line: int) -> float:
    """Return the finite number spelt by `word`.

    Raises:
        MeshError: it is none.
    """
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or b"_" in word:
        raise MeshError(f"expected a finite coordinate, got {quoted(word.decode(errors='replace'))}", line)
    return value


def vertex_index(word: bytes, line: int) -> int:
    """Return the integer spelt by `word`, within 64 bits.

    Raises:
        MeshError: it is none.
    """
    try:
        value = int(word)
    except ValueError:
        value = 2**63
    if abs(value) >= 2**63 or b"_" in word:
        raise MeshError(f"expected the index of a vertex, got {quoted(word.decode(errors='replace'))}", line)
    return value
