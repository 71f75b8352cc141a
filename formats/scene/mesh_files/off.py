"""OFF: the polygons of a file. Vertices and faces stand on a line each; what follows them there is colours and such.

trimesh 5.2 loads files that are cut short, hold NaN or go on after their counts without a word, and 4OFF as OFF.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Iterator

import numpy as np

from ..text.errors import quoted
from .obj import coordinate, vertex_index
from .polygons import polygon_surface, refuse_unfit
from .surface import MeshError, Surface

_KEYWORD = re.compile(rb"(ST)?C?N?(4?n?)OFF[ \t]*(.*)", re.DOTALL)
"""Texture coordinates, colours, normals follow a vertex and matter not; 4 and n change what a vertex is."""


def read_off(data: bytes) -> Surface:
    """Return the surface of an OFF file in ASCII (also COFF, NOFF, STOFF); polygons are cut into triangles.

    Raises:
        MeshError: the file is cut short or malformed, its counts do not hold, a coordinate is not finite, an index is
            out of range, or there are no faces.
    """
    statements = _statements(data)
    vertex_count, face_count = _counts(statements, data.count(b"\n") + data.count(b"\r") + 1)
    if not face_count:
        raise MeshError("the file has no faces, expected at least one triangle")
    values, corners, sizes, lines = array("d"), array("q"), array("q"), array("q")
    for line, words in _taken(statements, vertex_count, "vertices"):
        if len(words) < 3:
            raise MeshError(f"expected the three coordinates of a vertex, got {len(words)}", line)
        values.extend([coordinate(word, line) for word in words[:3]])
    for line, words in _taken(statements, face_count, "faces"):
        size = vertex_index(words[0], line)
        if not 0 <= size < len(words):
            raise MeshError(f"expected {size} corners of a face, got {len(words) - 1}", line)
        corners.extend([vertex_index(word, line) for word in words[1 : size + 1]])
        sizes.append(size)
        lines.append(line)
    for line, _ in statements:
        raise MeshError("the counts at the file's head end before this line", line)
    vertices = np.array(values, dtype=np.float64).reshape(-1, 3)
    polygons = np.array(corners, dtype=np.int64), np.array(sizes, dtype=np.int64)
    refuse_unfit(*polygons, lines, len(vertices))
    return polygon_surface(vertices, *polygons, (), lines)


def _statements(data: bytes) -> Iterator[tuple[int, list[bytes]]]:
    """Yield the words of each line that has any, comments left out."""
    for line, text in enumerate(data.splitlines(), start=1):
        words = text.partition(b"#")[0].split()
        if words:
            yield line, words


def _counts(statements: Iterator[tuple[int, list[bytes]]], most: int) -> tuple[int, int]:
    """Return how many vertices and faces follow, at most as many as lines: `OFF`, then counts there or below it."""
    line, words = next(statements, (1, []))
    keyword = _KEYWORD.fullmatch(b" ".join(words))
    if keyword is None:
        raise MeshError(f"expected 'OFF', got {_shown(words)}", line)
    if keyword[2]:
        raise MeshError(f"vertices in other than 3 dimensions are not supported by this version: {_shown(words)}", line)
    words = keyword[3].split()
    if words[:1] == [b"BINARY"]:
        raise MeshError("binary OFF is not supported by this version, expected ASCII", line)
    if not words:
        line, words = next(statements, (line, []))
    if len(words) not in (2, 3):
        raise MeshError(f"expected the counts of vertices, faces and edges, got {_shown(words)}", line)
    vertices, faces = (vertex_index(word, line) for word in words[:2])
    if not (0 <= vertices <= most and 0 <= faces <= most):
        raise MeshError(f"the counts at the file's head, {_shown(words)}, do not fit its {most} lines", line)
    return vertices, faces


def _taken(statements: Iterator[tuple[int, list[bytes]]], count: int, what: str) -> Iterator[tuple[int, list[bytes]]]:
    """Yield the next `count` statements."""
    for row in range(count):
        statement = next(statements, None)
        if statement is None:
            raise MeshError(f"the file is cut short: its head says {count} {what}, it holds {row}")
        yield statement


def _shown(words: list[bytes]) -> str:
    return quoted(b" ".join(words).decode(errors="replace")) if words else "nothing"
