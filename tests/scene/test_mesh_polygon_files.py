"""PLY and OFF: every polygon of a file arrives, in whatever dress, or the file is refused where it is wrong."""

from __future__ import annotations

import io
import re
import struct
from collections.abc import Callable
from typing import Any

import mesh_files
import numpy as np
import pytest
import trimesh
from mesh_files import CORNERS, TRIANGLE_AND_SQUARE, ascii_ply, binary_ply, off

from closecall.formats.scene.mesh_files.obj import read_obj
from closecall.formats.scene.mesh_files.off import read_off
from closecall.formats.scene.mesh_files.ply import read_ply
from closecall.formats.scene.mesh_files.surface import MeshError, Surface

HALVES = [[0, 1, 2], [0, 1, 2], [0, 2, 3]]
"""Triangles of TRIANGLE_AND_SQUARE."""

LISTS = "property list uchar int vertex_indices\n"
EDGE = "element edge 1\nproperty int vertex1\nproperty int vertex2\n"


def assert_holds(surface: Surface, triangles: list[list[int]]) -> None:
    assert surface.triangles.tolist() == triangles
    assert surface.vertices.tolist() == [list(map(float, corner)) for corner in CORNERS]
    assert surface.vertices.dtype == np.float64
    assert surface.unit is None


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("count_type", ["uchar", "char", "ushort", "int", "uint"])
@pytest.mark.parametrize("colour", [False, True])
def test_binary_ply_is_read_in_both_byte_orders_whatever_its_types_and_their_order(
    order: str, count_type: str, colour: bool
) -> None:
    mixed = binary_ply(TRIANGLE_AND_SQUARE, order, count_type, colour=colour)
    alike = binary_ply(((0, 1, 2), (0, 2, 3)), order, count_type, colour=colour)
    assert_holds(read_ply(mixed), HALVES)
    assert_holds(read_ply(alike), HALVES[1:])
    assert_holds(read_ply(alike + b"\0\n"), HALVES[1:])


@pytest.mark.parametrize("ending", [b"\n", b"\r\n", b"\r"])
def test_ply_is_read_with_the_line_ends_of_any_system(ending: bytes) -> None:
    assert_holds(read_ply(ascii_ply().replace(b"\n", ending)), HALVES[:1])
    head, mark, body = binary_ply(TRIANGLE_AND_SQUARE).partition(b"end_header\n")
    binary = (head + mark).replace(b"\n", ending) + body
    assert_holds(read_ply(binary), HALVES)


@pytest.mark.filterwarnings("error")
def test_a_signalling_nan_is_refused_without_a_word_from_numpy() -> None:
    data = binary_ply(vertices=((0, 0, 0), (123, 0, 0), (1, 1, 0), (0, 1, 0)))
    signalling = data.replace(struct.pack("<f", 123), b"\1\0\x80\x7f")
    with pytest.raises(MeshError, match="vertex 2 of 4 has a coordinate that is not finite"):
        read_ply(signalling)


@pytest.mark.parametrize(
    "data",
    [
        ascii_ply("3 0 1 2\n\n4 0 1 2 3\n\n", 2),
        ascii_ply(" 3\t0 1  2 \n4 0 1 2 3", 2),
        ascii_ply("3 0 1 2\n4 0 1 2 3\n", 2, face_properties="property list uint8 uint32 vertex_index\n"),
        ascii_ply(
            "7 3 0 1 2 2 .5 .5 1\n7 4 0 1 2 3 0 1\n",
            2,
            face_properties=f"property uchar red\n{LISTS}property list uchar float texcoord\nproperty uchar blue\n",
        ),
        ascii_ply("3 0 1 2\n4 0 1 2 3\n", 2, vertices="0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 9 9\n0\n")
        .replace(b"element face", b"element odd 2\nproperty list uchar int values\nelement face"),
        ascii_ply("3 0 1 2\n4 0 1 2 3\n1 2 3\n", 2)
        .replace(b"end_header", b"element camera 1\nproperty float a\nproperty float b\nproperty float c\nend_header"),
        ascii_ply("3 0 1 2\n4 0 1 2 3\n", 2).replace(b"format", b"comment \xff binary\nobj_info 1\nformat"),
    ],
)  # fmt: skip
def test_ascii_ply_is_read_whatever_else_it_holds(data: bytes) -> None:
    assert_holds(read_ply(data), HALVES)


def test_ply_faces_may_come_first_and_vertices_may_hold_lists() -> None:
    data = (
        b"ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 3\n"
        b"property double z\nproperty list uchar int near\nproperty int x\nproperty float y\nend_header\n"
        b"3 0 1 2\n5 0 1 2\n6 2 8 8 3 4\n7 1 9 5 6\n"
    )
    assert read_ply(data).vertices.tolist() == [[1, 2, 5], [3, 4, 6], [5, 6, 7]]
    head = data.partition(b"end_header\n")[0].replace(b"ascii", b"binary_big_endian") + b"end_header\n"
    body = bytes.fromhex("03 00000000 00000001 00000002")
    for z, near, x, y in ((5, 0, 1, 2), (6, 2, 3, 4), (7, 1, 5, 6)):
        body += np.array(z, ">f8").tobytes() + bytes((near,)) + bytes(4 * near)
        body += np.array(x, ">i4").tobytes() + np.array(y, ">f4").tobytes()
    assert read_ply(head + body).vertices.tolist() == [[1, 2, 5], [3, 4, 6], [5, 6, 7]]


def test_edges_beside_the_faces_of_ply_are_warned_of() -> None:
    data = ascii_ply("3 0 1 2\n0 1\n").replace(b"end_header", EDGE.encode() + b"end_header")
    assert read_ply(data).warnings == ("holds edges, which are left out",)


@pytest.mark.parametrize(
    ("data", "line", "phrase"),
    [
        (b"", 1, "expected 'ply'"),
        (b"solid", 1, "expected 'ply'"),
        (b"ply\nformat ascii 1.0\n", None, "header is cut short"),
        (ascii_ply().replace(b"format ascii 1.0\n", b""), None, "no 'format'"),
        (ascii_ply().replace(b"1.0", b"2.0"), 2, "version 1.0, got 'ascii 2.0'"),
        (ascii_ply().replace(b"ascii", b"text"), 2, "expected one of ascii, binary_little_endian"),
        (ascii_ply().replace(b"element vertex 4", b"element vertex -4"), 4, "name and count, got 'vertex -4'"),
        (ascii_ply().replace(b"element vertex 4", b"element vertex " + b"9" * 5000), 4, "name and count"),
        (ascii_ply().replace(b"float z", b"real z"), 7, "unknown type 'real'"),
        (ascii_ply().replace(b"float z", b"float y"), 7, "'y' is declared twice"),
        (ascii_ply().replace(b"float z", b"float w"), None, "no vertices with a number 'z'"),
        (ascii_ply().replace(b"uchar int", b"float int"), 9, "integer type for the count"),
        (ascii_ply().replace(b"uchar int", b"uchar float"), None, "no faces with a list of integers"),
        (ascii_ply().replace(b"list uchar int", b"int"), None, "no faces with a list of integers"),
        (ascii_ply().replace(b"element vertex 4\n", b""), 4, "an 'element' before"),
        (ascii_ply().replace(b"comment", b"remark"), 3, "got 'remark'"),
        (ascii_ply().replace(b"element face 1", b"element vertex 1"), 8, "'vertex' is declared twice"),
        (ascii_ply("", 0), None, "no faces"),
        (ascii_ply(face_properties=""), None, "rows of face without any property"),
        (ascii_ply(face_properties=LISTS + "element tristrips 1\n" + LISTS), None, "strips of triangles"),
        (ascii_ply("2 0 1\n"), 15, "at least 3 corners, face 1 of 1 has 2"),
        (ascii_ply("3 0 1 2\n0\n", 2), 16, "face 2 of 2 has 0"),
        (ascii_ply("3 0 1 4\n"), 15, "face 1 of 1 refers to vertex 4, expected 0 to 3"),
        (ascii_ply("3 0 1 -1\n"), 15, "refers to vertex -1"),
        (ascii_ply("3 0 1\n"), 15, "3 numbers do not make one face"),
        (ascii_ply("3 0 1 2 3\n"), 15, "5 numbers do not make one face"),
        (ascii_ply("-3 0 1 2\n"), 15, "do not make one face"),
        (ascii_ply("3 0 1 2.5\n"), 15, "index of a vertex, got '2.5'"),
        (ascii_ply("3 0 1 2\n", 2), None, "cut short: its header says 'element face 2', it holds 1"),
        (ascii_ply("3 0 1 2\n" * 2), 16, "the header's counts end before this line"),
        (ascii_ply(vertex_count=10**17), None, "its header says 'element vertex 1" + "0" * 17 + "', 5 lines follow"),
        (ascii_ply(vertex_count=3), 14, "3 numbers do not make one face"),
        (ascii_ply(vertices="0 0 0\n1 nan 0\n1 1 0\n0 1 0\n"), 12, "finite coordinate, got 'nan'"),
        (ascii_ply(vertices="0 0 0\n1 0\n1 1 0\n0 1 0\n"), 12, "2 numbers do not make one vertex"),
        (binary_ply()[:-1], None, "its header says 'element face 1', it holds 0"),
        (binary_ply(face_count=2), None, "cut short: its header says 'element face 2', it holds 1"),
        (binary_ply(face_count=10**17), None, "cut short"),
        (binary_ply(vertex_count=10**17), None, "000', at most 4 fit"),
        (binary_ply(((0, 1, 2), (0, 2, 3)), face_count=1), None, "13 bytes follow what the header's counts say"),
        (binary_ply(((0, 1, 2), (0, 1, 4))), None, "face 2 of 2 refers to vertex 4"),
        (binary_ply(((0, 1, -1),), ">"), None, "refers to vertex -1"),
        (binary_ply(((0, 1, 2), ())), None, "face 2 of 2 has 0"),
        (binary_ply(((),)), None, "face 1 of 1 has 0"),
        (binary_ply(count_type="char").replace(b"\3\0\0\0\0\1", b"\xff\0\0\0\0\1"), None, "list of -1 values"),
        (binary_ply(vertices=((0, 0, 0), (1, 0, 0), (np.nan, 0, 0), (0, 1, 0))), None, "vertex 3 of 4 .* not finite"),
        (binary_ply(vertices=((0, 0, 0), (1, 0, np.inf), (0, 0, 0), (0, 1, 0))), None, "vertex 2 of 4"),
        (binary_ply(vertices=(), vertex_count=0), None, "refers to vertex 0, the file has none"),
    ],
)  # fmt: skip
def test_bad_ply_is_refused(data: bytes, line: int | None, phrase: str) -> None:
    with pytest.raises(MeshError, match=phrase) as caught:
        read_ply(data)
    assert caught.value.line == line


@pytest.mark.parametrize(
    "data",
    [
        off(),
        off(head="OFF 4 2 0\n"),
        off(head="OFF4 2 0\n"),
        off(head="# by hand\n\nOFF # it is\n# counts\n4 2\n"),
        off(head="COFF\n4 2 0\n", vertices="0 0 0 255 0 0 9\n1 0 0 1 1 1 1\n1 1 0 0 0 0 0\n0 1 0 0 0 0 0\n"),
        off(head="STCNOFF\n4 2 0\n", vertices="0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n"),
        off("3 0 1 2 255 0 0\n4 0 1 2 3 0.5 0.5 0.5 1 # red\n"),
        off().replace(b"\n", b"\r\n"),
        off() + b"\n \n# the end",
    ],
)
def test_off_is_read_whatever_its_head_and_colours(data: bytes) -> None:
    assert_holds(read_off(data), HALVES)


@pytest.mark.parametrize(
    ("data", "line", "phrase"),
    [
        (b"", 1, "expected 'OFF', got nothing"),
        (b"4 2 0\n", 1, "expected 'OFF', got '4 2 0'"),
        (b"OFF", 1, "the counts of vertices, faces and edges, got nothing"),
        (b"OFF 4 2 0 1", 1, "the counts"),
        (b"OFF\n4 x 0", 2, "got 'x'"),
        (b"OFF BINARY\n4 2 0", 1, "binary OFF is not supported"),
        (off(head="4OFF\n4 2 0\n"), 1, "other than 3 dimensions"),
        (off(head="nOFF\n4 2 0\n"), 1, "other than 3 dimensions"),
        (off(head="OFF\n4 0 0\n"), None, "no faces"),
        (off(head="OFF\n-4 2 0\n"), 2, "do not fit its 9 lines"),
        (off(head="OFF\n4 999999999 0\n"), 2, "do not fit its 9 lines"),
        (off(head="OFF\n4 3 0\n"), None, "its head says 3 faces, it holds 2"),
        (off(head="OFF\n4 1 0\n"), 8, "end before this line"),
        (off(head="OFF\n3 2 0\n"), 8, "end before this line"),
        (off("3 0 1\n4 0 1 2 3\n"), 7, "expected 3 corners of a face, got 2"),
        (off("-3 0 1 2\n4 0 1 2 3\n"), 7, "expected -3 corners"),
        (off("3 0 1 2\n2 0 1\n"), 8, "at least 3 corners, face 2 of 2 has 2"),
        (off("3 0 1 2\n3 0 1 4\n"), 8, "face 2 of 2 refers to vertex 4, expected 0 to 3"),
        (off("3 0 1 2\n3 0 1 -1\n"), 8, "refers to vertex -1"),
        (off(vertices="0 0 0\n1 0\n1 1 0\n0 1 0\n"), 4, "three coordinates of a vertex, got 2"),
        (off(vertices="0 0 0\n1 0 inf\n1 1 0\n0 1 0\n"), 4, "finite coordinate, got 'inf'"),
    ],
)
def test_bad_off_is_refused(data: bytes, line: int | None, phrase: str) -> None:
    with pytest.raises(MeshError, match=phrase) as caught:
        read_off(data)
    assert caught.value.line == line


@pytest.mark.parametrize(
    ("read", "file_type", "options"),
    [
        (read_ply, "ply", {"encoding": "binary"}),
        (read_ply, "ply", {"encoding": "ascii", "vertex_normal": True}),
        (read_off, "off", {"digits": 17}),
    ],
)
def test_what_trimesh_writes_is_read_as_it_was(
    read: Callable[[bytes], Surface], file_type: str, options: dict[str, Any]
) -> None:
    ball: Any = trimesh.creation.icosphere(2, 3.7)
    ball.visual.face_colors = np.random.default_rng(1).integers(0, 255, (len(ball.faces), 4))
    written: Any = ball.export(file_type=file_type, **options)
    surface = read(written if isinstance(written, bytes) else written.encode())
    np.testing.assert_allclose(surface.vertices, ball.vertices, atol=1e-6 if file_type == "ply" else 1e-15)
    assert surface.triangles.tolist() == ball.faces.tolist()


def test_a_star_is_cut_ear_by_ear_unless_it_has_so_many_corners_that_it_would_not_end() -> None:
    for corners in (10, 4000):
        angles = np.arange(corners) * 2 * np.pi / corners
        radii = np.where(np.arange(corners) % 2, 0.2, 2.0)
        rows = "".join(f"{x} {y} 0\n" for x, y in zip(radii * np.cos(angles), radii * np.sin(angles), strict=True))
        face = " ".join(map(str, (corners, *range(corners)))) + "\n"
        for surface in (
            read_off(off(face, f"OFF\n{corners} 1 0\n", rows)),
            read_ply(ascii_ply(face, 1, rows, "property list int int vertex_index\n", vertex_count=corners)),
            read_obj(re.sub("^", "v ", rows.rstrip(), flags=re.M).encode() + f"\nf {face_from_one(corners)}".encode()),
        ):
            assert len(surface.triangles) == corners - 2
            told = [one.text.partition(",")[0] for one in surface.measured]
            assert told == ["holds 1 polygon that no triangles fit"] * (corners > 1000)


def face_from_one(corners: int) -> str:
    return " ".join(map(str, range(1, corners + 1)))


def test_the_helpers_write_what_the_standards_say() -> None:
    assert mesh_files.ascii_ply().startswith(b"ply\nformat ascii 1.0\n")
    assert trimesh.load_mesh(io.BytesIO(binary_ply()), "ply", process=False).faces.tolist() == [[0, 1, 2]]
