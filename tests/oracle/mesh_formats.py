"""OFF, PLY, GLB and 3MF files as the random scenes write them, and read from scratch: triangles (n, 3, 3) and bytes."""

from __future__ import annotations

import io
import json
import struct
import zipfile
from collections.abc import Callable
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np

from .rigid import FloatArray, IntArray

CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
UNITS = {"m": "meter", "cm": "centimeter", "mm": "millimeter", "in": "inch", "ft": "foot"}
"""How 3MF names the units of lengths."""

MODEL_TYPE = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
RELATIONS = (
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    f'<Relationship Id="r" Type="{MODEL_TYPE}" Target="/3D/3dmodel.model"/></Relationships>'
)
PLY_TYPES = {"double": "f8", "float": "f4", "uchar": "u1", "int": "i4"}


def shared(triangles: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the different corners (k, 3) of triangles, and which of them (n, 3) each triangle has."""
    points, index = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    return points, index.reshape(-1, 3)


def rows(values: FloatArray | IntArray, before: str = "") -> str:
    """Return a line for each row, its numbers with all digits."""
    return "".join(before + " ".join(map(repr, row)) + "\n" for row in values.tolist())


def off_bytes(triangles: FloatArray, _unit: str, _seed: int) -> bytes:
    points, index = shared(triangles)
    return f"OFF\n{len(points)} {len(index)} 0\n{rows(points)}{rows(index, '3 ')}".encode()


def off_triangles(data: bytes) -> FloatArray:
    lines = [line.split() for line in data.decode().splitlines() if line.strip() and not line.startswith("#")]
    corners, faces, _ = map(int, lines[1])
    points = np.array([row[:3] for row in lines[2 : 2 + corners]], dtype=np.float64)
    return fans(points, [[int(word) for word in row[1:]] for row in lines[2 + corners : 2 + corners + faces]])


def fans(points: FloatArray, faces: list[list[int]]) -> FloatArray:
    """Return polygons as triangles about their first corners."""
    return points[np.array([(face[0], one, two) for face in faces for one, two in pairwise(face[1:])])]


def ply_bytes(triangles: FloatArray, _unit: str, seed: int) -> bytes:
    """Return text, or numbers of either byte order, by the seed."""
    points, index = shared(triangles)
    kind = ("ascii", "binary_little_endian", "binary_big_endian")[seed % 3]
    head = (
        f"ply\nformat {kind} 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\n"
        f"property double z\nelement face {len(index)}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    if kind == "ascii":
        return head + (rows(points) + rows(index, "3 ")).encode()
    order = "<" if kind == "binary_little_endian" else ">"
    faces = np.zeros(len(index), dtype=[("count", "u1"), ("corners", order + "i4", 3)])
    faces["count"], faces["corners"] = 3, index
    return head + points.astype(order + "f8").tobytes() + faces.tobytes()


def ply_triangles(data: bytes) -> FloatArray:
    """Return the triangles of a file of vertices and triangles without anything else."""
    head, body = data.split(b"end_header\n", 1)
    words = [line.split() for line in head.decode().splitlines()]
    kind = next(row[1] for row in words if row[0] == "format")
    corners, faces = (int(row[2]) for row in words if row[0] == "element")
    if kind == "ascii":
        lines = body.decode().splitlines()
        points = np.array([row.split() for row in lines[:corners]], dtype=np.float64)
        return fans(points, [[int(word) for word in row.split()[1:]] for row in lines[corners:]])
    order = "<" if kind == "binary_little_endian" else ">"
    vertex = np.dtype([(row[2], order + PLY_TYPES[row[1]]) for row in words if row[0] == "property" and len(row) == 3])
    face = np.dtype([("count", "u1"), ("corners", order + "i4", 3)])
    table = np.frombuffer(body, vertex, corners)
    points = np.column_stack([table[name] for name in "xyz"]).astype(np.float64)
    return points[np.frombuffer(body, face, faces, corners * vertex.itemsize)["corners"]]


def glb_bytes(triangles: FloatArray, _unit: str, _seed: int) -> bytes:
    points, index = shared(triangles.astype(np.float32).astype(np.float64))
    places, corners = points.astype("<f4").tobytes(), index.astype("<u4").tobytes()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"}
            | {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()},
            {"bufferView": 1, "componentType": 5125, "count": index.size, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(places)},
            {"buffer": 0, "byteOffset": len(places), "byteLength": len(corners)},
        ],
        "buffers": [{"byteLength": len(places + corners)}],
    }
    text = json.dumps(document).encode()
    chunks = [(b"JSON", text + b" " * (-len(text) % 4)), (b"BIN\0", places + corners)]
    body = b"".join(struct.pack("<I4s", len(chunk), kind) + chunk for kind, chunk in chunks)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def glb_triangles(data: bytes) -> FloatArray:
    """Return the triangles of a file of one mesh whose node is not moved."""
    length = struct.unpack_from("<I", data, 12)[0]
    document, binary = json.loads(data[20 : 20 + length]), data[28 + length :]
    primitive = document["meshes"][0]["primitives"][0]

    def read(accessor: int, kind: str, width: int) -> np.ndarray:
        found = document["accessors"][accessor]
        begin = document["bufferViews"][found["bufferView"]]["byteOffset"]
        return np.frombuffer(binary, kind, found["count"] * width, begin)

    points = read(primitive["attributes"]["POSITION"], "<f4", 3).reshape(-1, 3).astype(np.float64)
    return points[read(primitive["indices"], "<u4", 1).reshape(-1, 3)]


def threemf_bytes(triangles: FloatArray, unit: str, _seed: int) -> bytes:
    points, index = shared(triangles)
    vertices = "".join('<vertex x="{!r}" y="{!r}" z="{!r}"/>'.format(*row) for row in points.tolist())
    faces = "".join('<triangle v1="{}" v2="{}" v3="{}"/>'.format(*row) for row in index.tolist())
    mesh = f"<mesh><vertices>{vertices}</vertices><triangles>{faces}</triangles></mesh>"
    model = (
        f'<model unit="{UNITS[unit]}" xmlns="{CORE[1:-1]}"><resources><object id="1">{mesh}</object></resources>'
        '<build><item objectid="1"/></build></model>'
    )
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as package:
        for name, text in (("_rels/.rels", RELATIONS), ("3D/3dmodel.model", model)):
            package.writestr(zipfile.ZipInfo(name), text)
    return out.getvalue()


def threemf_triangles(data: bytes) -> FloatArray:
    """Return the triangles of a package of one object that is built once, where it is."""
    with zipfile.ZipFile(io.BytesIO(data)) as package:
        mesh = ElementTree.fromstring(package.read("3D/3dmodel.model")).find(f".//{CORE}mesh")
    assert mesh is not None
    points = np.array([[float(one.attrib[axis]) for axis in "xyz"] for one in mesh.iter(f"{CORE}vertex")])
    return points[[[int(one.attrib[corner]) for corner in ("v1", "v2", "v3")] for one in mesh.iter(f"{CORE}triangle")]]


READERS: dict[str, Callable[[bytes], FloatArray]] = {
    ".3mf": threemf_triangles,
    ".glb": glb_triangles,
    ".off": off_triangles,
    ".ply": ply_triangles,
}

WRITERS: dict[str, Callable[[FloatArray, str, int], bytes]] = {
    ".3mf": threemf_bytes,
    ".glb": glb_bytes,
    ".off": off_bytes,
    ".ply": ply_bytes,
}
"""Of triangles (n, 3, 3) in a unit, and the seed that the file is of."""
