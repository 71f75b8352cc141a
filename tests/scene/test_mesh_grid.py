"""A mesh whose 32-bit floats are coarse where it lies is warned of, with the grid of its corners."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from mesh_files import glb_bytes
from scene_files import HEAD, TETRAHEDRON, warnings

CORNERS = np.array([[0, 0, 0], [100, 0, 0], [0, 100, 0], [0, 0, 100]], dtype=float)
FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
COARSE = "lies so far from its own origin that its 32-bit floats put its corners on a grid of {}: "


def far_away(distance: float) -> np.ndarray:
    return CORNERS + np.array([distance, 0, 0])


def stl(points: np.ndarray) -> bytes:
    body = b"".join(struct.pack("<12fH", 0, 0, 1, *points[list(face)].reshape(-1), 0) for face in FACES)
    return bytes(80) + struct.pack("<I", len(FACES)) + body


def ply(points: np.ndarray, kind: str = "float", letter: str = "<f4") -> bytes:
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty {kind} x\nproperty {kind} y\n"
    header += f"property {kind} z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
    return header.encode() + points.astype(letter).tobytes() + b"".join(struct.pack("<B3i", 3, *face) for face in FACES)


def glb(points: np.ndarray) -> bytes:
    """Return a GLB file whose node scales by 2."""
    binary = (points / 2).astype("<f4").tobytes() + np.array(FACES, "<u2").tobytes()
    places = {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}
    corners = {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "accessors": [places, corners],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0, "scale": [2, 2, 2]}],
        "scenes": [{"nodes": [0]}],
    }
    return glb_bytes(document, binary)


def told(folder: Path, suffix: str, data: bytes, units: str = "mm", scene_unit: str = "mm") -> list[str]:
    (folder / f"m.{suffix}").write_bytes(data)
    head = HEAD.replace("length: mm", f"length: {scene_unit}")
    text = f"{head}meshes: {{m: {{file: m.{suffix}, units: {units}}}}}\nbodies: {{a: {{shapes: [{{mesh: m}}]}}}}"
    return [line.partition(f"m.{suffix} ")[2] for line in warnings(folder, text) if "32-bit" in line]


@pytest.mark.parametrize(("suffix", "write"), [("stl", stl), ("ply", ply), ("glb", glb)])
def test_a_part_at_a_hundred_metres_tells_its_grid(tmp_path: Path, suffix: str, write) -> None:
    far = write(far_away(1e5))
    grid = float(np.nextafter(np.float32(1.001e5), np.float32(np.inf)) - np.float32(1.001e5))
    assert f"{grid:.3g}" == "0.00781"
    for units, scene_unit, length in (("mm", "mm", "0.00781 mm"), ("mm", "m", "7.81e-06 m"), ("in", "mm", "0.198 mm")):
        (line,) = told(tmp_path, suffix, far, units, scene_unit)
        assert line == COARSE.format(length) + "move its origin into it, or write it with more digits"


@pytest.mark.parametrize(("suffix", "write"), [("stl", stl), ("ply", ply), ("glb", glb)])
@pytest.mark.parametrize("place", [0.0, 1000.0])
def test_a_part_within_ten_of_its_sizes_is_not_warned_of(tmp_path: Path, suffix: str, write, place: float) -> None:
    assert told(tmp_path, suffix, write(far_away(place))) == []


def test_what_is_written_in_decimals_or_doubles_has_no_such_grid(tmp_path: Path) -> None:
    far = TETRAHEDRON.replace("v 0", "v 100000").replace("v 1", "v 100001", 1)
    assert told(tmp_path, "obj", far.encode()) == []
    assert told(tmp_path, "ply", ply(far_away(1e5), "double", "<f8")) == []
