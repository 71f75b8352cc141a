"""Mesh files as bytes, written by hand: PLY, OFF, GLB and 3MF, right unless a test makes them wrong."""

from __future__ import annotations

import io
import json
import struct
import zipfile
from collections.abc import Sequence
from typing import Any

import numpy as np

CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
"""Of a square."""

TRIANGLE_AND_SQUARE = ((0, 1, 2), (0, 1, 2, 3))
PLY_LETTERS = {"uchar": "B", "char": "b", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}


def ascii_ply(
    faces: str = "3 0 1 2\n",
    face_count: int = 1,
    vertices: str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n",
    face_properties: str = "property list uchar int vertex_indices\n",
    before_faces: str = "",
    vertex_count: int = 4,
) -> bytes:
    return (
        f"ply\nformat ascii 1.0\ncomment by hand\nelement vertex {vertex_count}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"{before_faces}element face {face_count}\n{face_properties}end_header\n{vertices}{faces}"
    ).encode()


def binary_ply(
    faces: Sequence[Sequence[int]] = ((0, 1, 2),),
    order: str = "<",
    count_type: str = "uchar",
    vertex_count: int = 4,
    face_count: int | None = None,
    colour: bool = False,
    vertices: Sequence[Sequence[float]] = CORNERS,
) -> bytes:
    """Return a file whose vertices are `z double, nx float, x float, y int`, in that order."""
    header = (
        f"ply\nformat binary_{'little' if order == '<' else 'big'}_endian 1.0\nelement vertex {vertex_count}\n"
        "property double z\nproperty float nx\nproperty float x\nproperty int y\n"
        f"element face {len(faces) if face_count is None else face_count}\n"
        f"property list {count_type} int vertex_index\n{'property uchar red' if colour else 'comment'}\nend_header\n"
    )
    body = b"".join(struct.pack(order + "dffi", z, 9.0, x, int(y)) for x, y, z in vertices)
    for face in faces:
        body += struct.pack(f"{order}{PLY_LETTERS[count_type]}{len(face)}i", len(face), *face)
        body += b"\xff" * colour
    return header.encode() + body


def off(faces: str = "3 0 1 2\n4 0 1 2 3\n", head: str = "OFF\n4 2 0\n", vertices: str = "") -> bytes:
    return (head + (vertices or "0 0 0\n1 0 0\n1 1 0\n0 1 0\n") + faces).encode()


def glb_bytes(document: dict[str, Any], binary: bytes = b"") -> bytes:
    """Return a GLB file of this JSON and this binary chunk."""
    text = json.dumps(document).encode()
    chunks = [(b"JSON", text + b" " * (-len(text) % 4))]
    if binary:
        chunks.append((b"BIN\0", binary + b"\0" * (-len(binary) % 4)))
    body = b"".join(struct.pack("<I4s", len(data), kind) + data for kind, data in chunks)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


POINTS = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (5, 5, 5), (6, 5, 5), (5, 6, 5), (6, 6, 5))


def glb_parts(
    indices: Sequence[int] = (0, 1, 2), mode: int = 4, points: Sequence[Sequence[float]] = POINTS
) -> tuple[dict[str, Any], bytes]:
    """Return the JSON and the binary chunk of a file with one node, one mesh and one primitive."""
    positions = np.array(points, dtype="<f4").tobytes()
    corners = np.array(indices, dtype="<u2").tobytes()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": mode}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(points)},
            {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": len(indices)},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(positions)},
            {"buffer": 0, "byteOffset": len(positions), "byteLength": len(corners)},
        ],
        "buffers": [{"byteLength": len(positions) + len(corners)}],
    }
    return document, positions + corners


CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
MODEL_RELATION = (
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="r" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/3D/3dmodel.model"/></Relationships>'
)
TRIANGLE_MESH = (
    '<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/></vertices>'
    '<triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh>'
)
OBJECT = f'<object id="1" type="model">{TRIANGLE_MESH}</object>'
ITEM = '<item objectid="1"/>'


def model_xml(
    resources: str = OBJECT, build: str = ITEM, attributes: str = 'unit="millimeter"', prolog: str = ""
) -> str:
    return (
        f'<?xml version="1.0"?>\n{prolog}<model {attributes} xmlns="{CORE}" xmlns:p="{PRODUCTION}" '
        f'xmlns:x="urn:other">\n'
        f"<resources>{resources}</resources>\n<build>{build}</build></model>"
    )


def package(model: str | None = None, parts: dict[str, str] | None = None, method: int = zipfile.ZIP_DEFLATED) -> bytes:
    """Return a 3MF file of this model part, and of others by their names, which may replace any."""
    held = {"[Content_Types].xml": "<Types/>", "_rels/.rels": MODEL_RELATION, "3D/3dmodel.model": model or model_xml()}
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        for name, text in (held | (parts or {})).items():
            archive.writestr(zipfile.ZipInfo(name), text, compress_type=method)
    return file.getvalue()
