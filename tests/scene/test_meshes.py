"""Mesh files arrive whole, in metres and z up, or not at all."""

from __future__ import annotations

import hashlib
import os
import struct
from pathlib import Path

import numpy as np
import pytest
from places import SHARED

from closecall.formats.scene.build.meshes import LoadedMesh, MeshFolder
from closecall.formats.scene.build.primitive_meshes import box_mesh, point_mesh, segment_mesh
from closecall.formats.scene.grammar.scene import MeshReference
from closecall.formats.scene.mesh_files.obj import read_obj
from closecall.formats.scene.mesh_files.stl import read_stl
from closecall.formats.scene.mesh_files.surface import MeshError, topology, welded

needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="shared data not there")

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
TETRAHEDRON = TRIANGLE + "v 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


def obj_triangles(text: str) -> list[list[int]]:
    return read_obj(text.encode()).triangles.tolist()


def binary_stl(triangles: np.ndarray, count: int | None = None, header: bytes = b"") -> bytes:
    body = b"".join(struct.pack("<12fH", 0, 0, 1, *map(float, t.reshape(-1)), 0) for t in triangles)
    return header.ljust(80, b" ") + struct.pack("<I", len(triangles) if count is None else count) + body


def ascii_stl(
    vertices: str = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0", name: str = "x", end: str = "endsolid x"
) -> bytes:
    return f"solid {name}\nfacet normal 0 0 1\nouter loop\n{vertices}\nendloop\nendfacet\n{end}\n".encode()


def load(folder: Path, file: str, units: str = "m", up: str = "z", roots: tuple[Path, ...] = ()) -> LoadedMesh:
    reference = MeshReference.model_validate({"file": file, "units": units, "up": up})
    return MeshFolder(folder, roots).load("part", reference)


@pytest.mark.parametrize(
    ("text", "triangles"),
    [
        (TRIANGLE + "f 1 2 3\n", [[0, 1, 2]]),
        (TRIANGLE + "f 1/1 2/2/2 3//3\n", [[0, 1, 2]]),
        (TRIANGLE + "f 1// 2// 3//\n", [[0, 1, 2]]),
        (TRIANGLE + "f -3 -2 -1\nv 5 5 5\nv 6 5 5\nv 5 6 5\nf -3 -2 -1\n", [[0, 1, 2], [3, 4, 5]]),
        ("f 1 2 3\n" + TRIANGLE, [[0, 1, 2]]),
        (TRIANGLE + "f 1 2\\\n3\n", [[0, 1, 2]]),
        (TRIANGLE + "f 1 2 3 # one\n#f 3 2 1\n", [[0, 1, 2]]),
        (TRIANGLE.replace("\n", "\r\n") + "f 1 2 3\r\n", [[0, 1, 2]]),
        (TRIANGLE + "usemtl a\nf 1 2 3\ng b\nusemtl c\nf 3 2 1\nf 1 1 2", [[0, 1, 2], [2, 1, 0], [0, 0, 1]]),
        (SQUARE + "f 1 2 3 4\nf 1 2 3\n", [[0, 1, 2], [0, 2, 3], [0, 1, 2]]),
        ("v 0 0 0 1 0 0\nv 1 0 0 1\nv 0 1 0 nan nan nan\nfoo bar\nf 1 2 3\n", [[0, 1, 2]]),
        ("V 0 0 0\nv 1 0 0\nv 0 1 0\nF 1 2 3\n", [[0, 1, 2]]),
    ],
)
def test_every_face_of_an_obj_file_is_kept_in_order(text: str, triangles: list[list[int]]) -> None:
    assert obj_triangles(text) == triangles


def test_a_dart_is_cut_from_its_hollow_corner_so_that_nothing_is_added() -> None:
    surface = read_obj(b"v 0 2 0\nv -1 -1 0\nv 0 0 0\nv 1 -1 0\nf 2 3 4 1\nf 1 2 3 4\n")
    corners = surface.vertices[surface.triangles]
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert (doubled > 0).all()
    assert doubled.sum() / 2 == pytest.approx(2 * 2.0)
    assert surface.warnings == ()


def test_a_polygon_no_triangles_fit_is_covered_and_warned_of() -> None:
    star = [(np.cos(angle), np.sin(angle)) for angle in np.arange(5) * 4 * np.pi / 5]
    text = "".join(f"v {x} {y} 0\n" for x, y in star) + "f 1 2 3 4 5\n"
    surface = read_obj(text.encode())
    assert len(surface.triangles) == 3
    (told,) = surface.measured
    assert told.text.startswith("holds 1 polygon that no triangles fit, as where an outline crosses itself: ")
    assert told.text.endswith(" (the face in line 6, cut from its corner 1 of 5)")
    assert told.length == pytest.approx(np.cos(np.pi / 10))  # half of the way from tip to tip


@pytest.mark.parametrize(
    ("text", "line", "phrase"),
    [
        ("", None, "no faces"),
        (TRIANGLE, None, "no faces"),
        (TRIANGLE + "p 1 2 3\n", None, "no faces"),
        (TRIANGLE + "f 1 2\n", 4, "at least 3 corners, got 2"),
        (TRIANGLE + "f 0 1 2\n", 4, "vertex 0"),
        (TRIANGLE + "f 1 2 4\n", 4, "vertex 4, the file has 3"),
        (TRIANGLE + "\nf 1 2 3\nf 1 2 3 4\n", 6, "vertex 4"),
        (TRIANGLE + "f -4 2 3\n", 4, "vertex -4"),
        (TRIANGLE + "f 1 2 x\n", 4, "index of a vertex, got 'x'"),
        (TRIANGLE + "f 1 2 1.5\n", 4, "got '1.5'"),
        (TRIANGLE + "f 1 2 " + "9" * 5000 + "\n", 4, "index of a vertex"),
        (TRIANGLE + "f 1 2 99999999999999999999\n", 4, "index of a vertex"),
        ("v 0 0\n" + TRIANGLE + "f 1 2 3\n", 1, "three coordinates of a vertex, got 2"),
        ("v 0 nan 0\n" + TRIANGLE + "f 2 3 4\n", 1, "finite coordinate, got 'nan'"),
        ("v 0 1e999 0\n", 1, "finite coordinate"),
        ("v 0 1_0 0\n", 1, "finite coordinate"),
        (TRIANGLE + "call other.obj\nf 1 2 3\n", 4, "'call' is not supported"),
    ],
)
def test_bad_obj_is_refused_at_its_line(text: str, line: int | None, phrase: str) -> None:
    with pytest.raises(MeshError, match=phrase) as caught:
        read_obj(text.encode())
    assert caught.value.line == line


def test_lines_and_points_beside_faces_are_warned_of() -> None:
    assert read_obj((TRIANGLE + "l 1 2\np 1\nf 1 2 3\n").encode()).warnings == (
        "holds lines and points, which are left out",
    )


def test_ascii_and_binary_stl_give_the_same_triangles() -> None:
    corners = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], dtype=float)
    for data in (
        ascii_stl(),
        ascii_stl(name="vertex 9 9 endsolid"),
        binary_stl(corners),
        binary_stl(corners, header=b"solid x"),
    ):
        surface = read_stl(data)
        assert surface.vertices[surface.triangles].tolist() == corners.tolist()
        assert surface.vertices.dtype == np.float64
        assert surface.warnings == ()


def test_bytes_after_a_binary_stl_are_warned_of() -> None:
    corners = np.eye(3)[None]
    assert "has 7 bytes after the 1 triangle" in read_stl(binary_stl(corners) + b"trailer").warnings[0]


@pytest.mark.parametrize(
    ("data", "line", "phrase"),
    [
        (b"", None, "0 bytes"),
        (b"x" * 83, None, "83 bytes"),
        (binary_stl(np.zeros((0, 3, 3))), None, "0 triangles"),
        (
            binary_stl(np.zeros((0, 3, 3)), count=2**32 - 1),
            None,
            "cut short: its header says 4294967295 triangles",
        ),
        (binary_stl(np.zeros((2, 3, 3)))[:-1], None, "header says 2 triangles, it holds 1"),
        (binary_stl(np.zeros((1, 3, 3)), count=2, header=b"solid"), None, "cut short"),
        (binary_stl(np.array([np.eye(3), np.full((3, 3), np.nan)])), None, "triangle 2 of 2"),
        (binary_stl(np.array([np.full((3, 3), np.inf)])), None, "not finite"),
        (b"solid a\nendsolid a\n", None, "no facets"),
        (ascii_stl(end=""), 9, "cut short: expected 'facet' or 'endsolid'"),
        (ascii_stl()[:60], 5, "three coordinates of a vertex, got 1"),
        (ascii_stl("vertex 0 0 0\nvertex 1 0 0"), 6, "3 vertices, got 2"),
        (ascii_stl("vertex 0 0 0\n" * 4), 9, "3 vertices, got 4"),
        (ascii_stl("vertex 0 0 0\nvertex 0 NaN 0\nvertex 0 1 0"), 5, "finite coordinate, got 'NaN'"),
        (ascii_stl("vertex 0 0\n"), 4, "three coordinates"),
        (ascii_stl("vertex 0 0 0\nedge 1 2"), 5, "expected 'vertex' or 'endloop', got 'edge'"),
    ],
)
def test_bad_stl_is_refused(data: bytes, line: int | None, phrase: str) -> None:
    with pytest.raises(MeshError, match=phrase) as caught:
        read_stl(data)
    assert caught.value.line == line


def test_a_surface_is_solid_when_every_edge_joins_two_triangles_at_equal_vertices() -> None:
    closed = read_obj(TETRAHEDRON.encode())
    soup = closed.vertices[closed.triangles].reshape(-1, 3) * (1, 1, -1)  # holds 0.0 and -0.0
    soup[0, 2] = 0.0
    corners = np.arange(12).reshape(4, 3)
    assert topology(closed.vertices, closed.triangles).solid
    assert topology(*welded(soup, corners)).solid
    assert not topology(*welded(soup + np.eye(12, 3, dtype=float) * 1e-15, corners)).solid
    assert topology(*welded(soup, corners[:3])).loose_edges == 3


def test_equal_vertices_of_a_file_are_one(tmp_path: Path) -> None:
    """An STL file repeats every corner. The first of equals stays, and no triangle moves."""
    corners = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[-0.0, 0, 0], [0, 1, 0], [0, 0, 1]]], dtype=float)
    (tmp_path / "t.stl").write_bytes(binary_stl(corners))
    mesh = load(tmp_path, "t.stl").mesh
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_degenerate_triangles_have_no_say_in_closedness_and_are_counted() -> None:
    surface = read_obj((TETRAHEDRON + "f 1 1 2\nf 3 3 3\n").encode())
    found = topology(surface.vertices, surface.triangles)
    assert found.solid
    assert found.flat_triangles == 2
    assert not topology(np.zeros((1, 3)), np.array([[0, 0, 0]])).solid


def test_a_turned_face_is_seen() -> None:
    surface = read_obj(TETRAHEDRON.replace("f 1 3 2", "f 1 2 3").encode())
    found = topology(surface.vertices, surface.triangles)
    assert found.solid
    assert found.twisted_edges == 3


@pytest.mark.parametrize(("units", "metres"), [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254), ("ft", 0.3048)])
def test_coordinates_become_metres(tmp_path: Path, units: str, metres: float) -> None:
    (tmp_path / "t.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 0 5.1\nf 1 2 3\n")
    mesh = load(tmp_path, "t.obj", units).mesh
    np.testing.assert_allclose(mesh.vertices, [[0, 0, 0], [metres, 0, 0], [0, 0, 5.1 * metres]], rtol=3e-16)


def test_millimetres_are_the_nearest_floats_to_their_metres(tmp_path: Path) -> None:
    (tmp_path / "t.obj").write_text("v 35 70 1.5\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert load(tmp_path, "t.obj", "mm").mesh.vertices[0].tolist() == [0.035, 0.07, 0.0015]


def test_y_up_is_turned_so_that_y_becomes_z(tmp_path: Path) -> None:
    (tmp_path / "t.obj").write_text("v 1 2 3\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert load(tmp_path, "t.obj", up="y").mesh.vertices.tolist() == [[1, -3, 2], [1, 0, 0], [0, 0, 1]]


def test_a_mesh_is_read_only_contiguous_and_without_stray_vertices(tmp_path: Path) -> None:
    (tmp_path / "t.obj").write_text("v 1e9 0 0\n" + TRIANGLE + "f 2 3 4\n")
    for up in ("y", "z"):
        mesh = load(tmp_path, "t.obj", up=up).mesh
        assert mesh.vertices.shape == (3, 3)
        assert mesh.triangles.tolist() == [[0, 1, 2]]
        for array, kind in ((mesh.vertices, np.float64), (mesh.triangles, np.int64)):
            assert array.dtype == kind
            assert array.flags.c_contiguous
            assert not array.flags.writeable


def test_one_file_with_equal_units_and_axes_is_one_mesh(tmp_path: Path) -> None:
    (tmp_path / "t.obj").write_text(TETRAHEDRON)
    folder = MeshFolder(tmp_path, ())
    metre = folder.load("a", MeshReference(file="t.obj", units="m"))
    same = folder.load("b", MeshReference(file="./t.obj", units="m"))
    inch = folder.load("c", MeshReference(file="t.obj", units="in"))
    assert metre.mesh is same.mesh
    assert metre.mesh is not inch.mesh
    assert metre.sha256 == inch.sha256 == hashlib.sha256(TETRAHEDRON.encode()).hexdigest()
    assert metre.path == (tmp_path / "t.obj").resolve()
    assert metre.mesh.solid
    assert metre.warnings == ()


def test_doubtful_meshes_are_warned_of(tmp_path: Path) -> None:
    (tmp_path / "open.obj").write_text(TRIANGLE + "f 1 2 3\nf 1 1 1\n")
    (tmp_path / "mixed.obj").write_text(TETRAHEDRON.replace("f 1 3 2", "f 1 2 3"))
    opened, flat = load(tmp_path, "open.obj").warnings
    assert opened.startswith("open.obj is open: treated as a surface, containment inside it is not seen")
    assert flat == "open.obj has 1 zero-area triangle"
    assert "mixed.obj is of mixed orientation" in load(tmp_path, "mixed.obj").warnings[0]


@pytest.mark.parametrize(
    ("file", "phrase"),
    [
        ("none.obj", "none.obj: the file cannot be read: No such file"),
        ("sub", "sub: a file without suffix is not supported"),
        ("folder.obj", "folder.obj: expected a file"),
        (
            "t.step",
            "t.step: .step is not supported by this version, expected .3mf, .glb, .obj, .off, .ply or .stl",
        ),
        ("bad.obj", "bad.obj:1: expected a finite coordinate"),
        ("huge.obj", "huge.obj: expected coordinates up to 1e"),
        ("../out.obj", "lies outside the scene's folder"),
        ("sub/../../out.obj", "lies outside the scene's folder"),
        ("link.obj", "lies outside the scene's folder"),
        ("/etc/passwd.obj", "is absolute"),
        ("C:\\t.obj", "is absolute"),
        ("http://example.org/t.obj", "is a URL"),
        ("file:///t.obj", "is a URL"),
        ("a\0.obj", "is no path"),
        ("loop.obj", "loop.obj"),
        ("x" * 5000 + ".obj", "cannot be read"),
    ],
)
def test_files_that_may_not_or_cannot_be_read_are_refused(tmp_path: Path, file: str, phrase: str) -> None:
    scene = tmp_path / "scene"
    (scene / "sub").mkdir(parents=True)
    (scene / "folder.obj").mkdir()
    (tmp_path / "out.obj").write_text(TETRAHEDRON)
    os.symlink(tmp_path / "out.obj", scene / "link.obj")
    os.symlink("loop.obj", scene / "loop.obj")
    (scene / "t.step").write_text("step")
    (scene / "bad.obj").write_text("v nan 0 0\n")
    (scene / "huge.obj").write_text("v 1e200 0 0\nv 0 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(MeshError) as caught:
        load(scene, file)
    assert phrase in caught.value.message


def test_a_named_root_admits_files_inside_it_alone(tmp_path: Path) -> None:
    for name in ("scene", "parts", "other"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "t.obj").write_text(TETRAHEDRON)
    roots = (tmp_path / "parts",)
    assert load(tmp_path / "scene", "../parts/t.obj", roots=roots).mesh.solid
    assert load(tmp_path / "scene", str(tmp_path / "parts" / "t.obj"), roots=roots).mesh.solid
    assert load(tmp_path / "scene", "t.obj", roots=roots).mesh.solid
    with pytest.raises(MeshError, match="lies outside"):
        load(tmp_path / "scene", "../other/t.obj", roots=roots)


def test_primitives_are_triangle_cores() -> None:
    box = box_mesh(2.0, 4.0, 6.0)
    assert topology(box.vertices, box.triangles).solid
    assert topology(box.vertices, box.triangles).twisted_edges == 0
    assert box.vertices.max(axis=0).tolist() == [1, 2, 3]
    assert box.vertices.min(axis=0).tolist() == [-1, -2, -3]
    corners = box.vertices[box.triangles]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(48.0)
    assert box.solid
    assert (point_mesh().vertices.tolist(), point_mesh().triangles.tolist()) == ([[0, 0, 0]], [[0, 0, 0]])
    segment = segment_mesh(0.5)
    assert (segment.vertices.tolist(), segment.triangles.tolist()) == (
        [[0, 0, -0.25], [0, 0, 0.25]],
        [[0, 1, 1]],
    )
    assert not point_mesh().solid
    assert not segment.solid


@needs_shared
@pytest.mark.parametrize(
    ("file", "triangles", "solid"),
    [
        ("gears/gear.obj", 608, True),
        ("fcl/manyframes_a.obj", 3322, None),
        ("fcl/manyframes_b.obj", 3564, None),
        ("meshes/20mm-xyz-cube.stl", 260, None),
        ("meshes/busted.STL", 3878, None),
        ("meshes/joined_tetrahedra.obj", 8, False),
        ("meshes/nancolor.obj", 12, True),
        ("meshes/negative_indices.obj", 12, True),
        ("meshes/not_convex.obj", 96, False),
        ("meshes/plane.ply", 2, False),
        ("meshes/soup.stl", 100, False),
    ],
)
def test_meshes_from_the_field_are_read_whole(file: str, triangles: int, solid: bool | None) -> None:
    loaded = load(SHARED, file)
    assert len(loaded.mesh.triangles) == triangles
    if solid is not None:
        assert loaded.mesh.solid is solid
    assert loaded.mesh.solid != any("is open" in warning for warning in loaded.warnings)


@needs_shared
@pytest.mark.parametrize("file", ["empty.obj", "empty.stl", "notenoughindices.obj", "points_emptyface.ply"])
def test_meshes_from_the_field_without_a_surface_are_refused(file: str) -> None:
    with pytest.raises(MeshError, match=file):
        load(SHARED, f"meshes/{file}")
