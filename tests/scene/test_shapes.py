"""Each shape of a scene becomes the scheduler's, and what is no shape is refused at its place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mesh_files import ascii_ply
from scene_files import HEAD, TETRAHEDRON, body, fault, faults, load, warnings

SHAPES = f"{HEAD}bodies:\n  a:\n    shapes: "
MESH = f"{HEAD}meshes: {{m: {{file: m.obj, units: m}}}}\nbodies:\n  a:\n    shapes: "


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "m.obj").write_text(TETRAHEDRON)
    return tmp_path


def test_shapes_become_cores_and_radii_in_metres(tmp_path: Path) -> None:
    shapes = (
        "shapes: [{box: [200, 400, 600], pose: {xyz: [0, 0, 7]}}, {sphere: 50}, {capsule: {radius: 5, length: 600}}]"
    )
    box, sphere, capsule = body(tmp_path, shapes).shapes
    assert box.mesh.vertices.max(axis=0).tolist() == pytest.approx([0.1, 0.2, 0.3])
    assert (len(box.mesh.triangles), box.mesh.solid, box.radius) == (12, True, 0.0)
    assert box.pose[:3, 3].tolist() == [0, 0, 0.007]
    assert (sphere.mesh.triangles.tolist(), sphere.radius, sphere.mesh.solid) == ([[0, 0, 0]], 0.05, False)
    assert (capsule.mesh.triangles.tolist(), capsule.radius) == ([[0, 1, 1]], 0.005)
    assert capsule.mesh.vertices.tolist() == [[0, 0, -0.3], [0, 0, 0.3]]
    assert [shape.chord_error for shape in (box, sphere, capsule)] == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("shape", "half_lengths"),
    [
        ("cylinder: {radius: 50, length: 200}", (0.05, 0.05, 0.1)),
        ("cone: {radius: 50, length: 200}", (0.05, 0.05, 0.1)),
        ("ellipsoid: [100, 20, 30]", (0.1, 0.02, 0.03)),
    ],
)
def test_round_shapes_become_solids_around_them_with_their_chord_error(
    tmp_path: Path, shape: str, half_lengths: tuple[float, float, float]
) -> None:
    (found,) = body(tmp_path, f"shapes: [{{{shape}, pose: {{xyz: [0, 0, 1000]}}}}]").shapes
    assert found.mesh.solid
    assert found.radius == 0.0
    assert 0.0 < found.chord_error < 0.005 * max(half_lengths)
    reach = np.abs(found.mesh.vertices).max(axis=0)
    assert (reach >= half_lengths).all()
    assert (reach <= np.array(half_lengths) + found.chord_error).all()
    assert found.pose[:3, 3].tolist() == [0, 0, 1]


def test_a_cone_stands_on_its_base(tmp_path: Path) -> None:
    (cone,) = body(tmp_path, "shapes: [{cone: {radius: 50, length: 200}}]").shapes
    widths = {z: np.hypot(*cone.mesh.vertices[cone.mesh.vertices[:, 2] == z, :2].T).max() for z in (-0.1, 0.1)}
    assert widths[-0.1] >= 0.05
    assert widths[0.1] == 0.0


def test_a_body_has_the_largest_chord_error_of_its_shapes(tmp_path: Path) -> None:
    shapes = "shapes: [{sphere: 1}, {cylinder: {radius: 50, length: 2}}, {cylinder: {radius: 5, length: 2}}]"
    found = body(tmp_path, shapes)
    assert found.chord_error == max(shape.chord_error for shape in found.shapes) == found.shapes[1].chord_error


@pytest.mark.parametrize(
    ("scale", "factors"),
    [("", (1, 1, 1)), (", scale: 2.5", (2.5, 2.5, 2.5)), (", scale: [1, 2, 3]", (1, 2, 3)), (", scale: 1", (1, 1, 1))],
)
def test_a_mesh_is_scaled_along_its_own_axes(folder: Path, scale: str, factors: tuple[float, float, float]) -> None:
    (shape,) = load(folder, f"{MESH}[{{mesh: m{scale}, pose: {{rpy: [0, 0, 90]}}}}]").scene.bodies[0].shapes
    assert shape.mesh.vertices.max(axis=0).tolist() == list(factors)
    assert shape.mesh.solid


def test_equal_scales_share_a_mesh_and_unequal_ones_do_not(folder: Path) -> None:
    text = f"{MESH}[{{mesh: m, scale: 2}}, {{mesh: m, scale: [2, 2, 2]}}, {{mesh: m}}, {{mesh: m, scale: 3}}]"
    one, same, own, other = (shape.mesh for shape in load(folder, text).scene.bodies[0].shapes)
    assert one is same
    assert len({id(mesh) for mesh in (one, own, other)}) == 3


def test_a_mesh_with_y_up_is_turned_and_its_units_are_its_own(folder: Path) -> None:
    text = f"{HEAD}meshes: {{m: {{file: m.obj, units: cm, up: y}}}}\nbodies: {{a: {{shapes: [{{mesh: m}}]}}}}"
    (shape,) = load(folder, text).scene.bodies[0].shapes
    assert shape.mesh.vertices.min(axis=0).tolist() == pytest.approx([0, -0.01, 0])
    assert shape.mesh.vertices.max(axis=0).tolist() == pytest.approx([0.01, 0, 0.01])


@pytest.mark.parametrize(
    ("shape", "begin", "phrase"),
    [
        (
            "{sphre: 1}",
            "6:15: bodies.a.shapes[0]: ",
            "unknown shape 'sphre' (did you mean 'sphere'?), expected mesh, box, sphere, capsule, cylinder, cone or",
        ),
        ("{cilinder: 1}", "6:15: bodies.a.shapes[0]: ", "unknown shape 'cilinder' (did you mean 'cylinder'?)"),
        ("{elipsoid: 1}", "6:15: bodies.a.shapes[0]: ", "unknown shape 'elipsoid' (did you mean 'ellipsoid'?)"),
        ("{cylinder: 1}", "6:25: bodies.a.shapes[0].cylinder: ", "expected a mapping, got 1"),
        ("{cylinder: {radius: 1}}", "6:15: bodies.a.shapes[0].cylinder: ", "missing key 'length'"),
        ("{cone: {}}", "6:15: bodies.a.shapes[0].cone: ", "missing key 'radius'"),
        (
            "{cone: {radius: 1, length: 1, height: 2}}",
            "6:44: bodies.a.shapes[0].cone: ",
            "unknown key 'height', expected radius or length",
        ),
        (
            "{cylinder: {radius: 0, length: 1}}",
            "6:34: bodies.a.shapes[0].cylinder.radius: ",
            "expected a number greater than 0, got 0",
        ),
        (
            "{cone: {radius: 1, length: -1}}",
            "6:41: bodies.a.shapes[0].cone.length: ",
            "expected a number greater than 0, got -1",
        ),
        ("{ellipsoid: 1}", "6:26: bodies.a.shapes[0].ellipsoid: ", "expected a list, got 1"),
        ("{ellipsoid: [1, 2]}", "6:26: bodies.a.shapes[0].ellipsoid: ", "expected 3 numbers, got 2"),
        ("{ellipsoid: [1, 2, 0]}", "6:33: bodies.a.shapes[0].ellipsoid[2]: ", "greater than 0, got 0"),
        ("{ellipsoid: [1, 2, big]}", "6:33: bodies.a.shapes[0].ellipsoid[2]: ", "expected a number, got 'big'"),
        ("{cone: {radius: 1, length: 1}, sphere: 1}", "6:14: bodies.a.shapes[0]: ", "got sphere and cone"),
        ("{sphere: 1, scale: 2}", "6:26: bodies.a.shapes[0]: ", "unknown key 'scale', expected pose or sphere"),
    ],
)
def test_what_is_no_shape_is_refused_at_its_place(tmp_path: Path, shape: str, begin: str, phrase: str) -> None:
    told = faults(tmp_path, f"{SHAPES}[{shape}]")
    assert told[0].startswith(begin)
    assert phrase in told[0]


@pytest.mark.parametrize(
    ("shape", "begin", "phrase"),
    [
        ("scale: 0", "7:31: bodies.a.shapes[0].scale: ", "expected a number greater than 0, got 0"),
        ("scale: -1", "7:31: bodies.a.shapes[0].scale: ", "expected a number greater than 0, got -1"),
        ("scale: [1, 2]", "7:31: bodies.a.shapes[0].scale: ", "expected 3 numbers, got 2"),
        ("scale: [1, 2, -3]", "7:38: bodies.a.shapes[0].scale[2]: ", "expected a number greater than 0, got -3"),
        ("scale: large", "7:31: bodies.a.shapes[0].scale: ", "expected a number or a list of 3, got 'large'"),
        ("scale: {x: 1}", "7:31: bodies.a.shapes[0].scale: ", "expected a number or a list of 3, got a mapping"),
        ("scale: 1e-16", "7:31: bodies.a.shapes[0].scale: ", "at least 1e-15, got 1e-16"),
        ("scales: 1", "7:24: bodies.a.shapes[0]: ", "unknown key 'scales' (did you mean 'scale'?)"),
    ],
)
def test_what_is_no_scale_is_refused_at_its_place(folder: Path, shape: str, begin: str, phrase: str) -> None:
    line = fault(folder, f"{MESH}[{{mesh: m, {shape}}}]")
    assert line.startswith(begin)
    assert phrase in line


def test_an_unknown_mesh_is_told_with_the_nearest_name(folder: Path) -> None:
    text = f"{HEAD}meshes: {{crank: {{file: m.obj, units: m}}}}\nbodies: {{a: {{shapes: [{{mesh: krank}}]}}}}"
    line = fault(folder, text)
    assert line == (
        "5:30: bodies.a.shapes[0].mesh: unknown mesh 'krank' (did you mean 'crank'?), expected a name from meshes"
    )


def meshes(file: str, units: str = "mm") -> str:
    return f"{HEAD}meshes: {{m: {{file: {file}, units: {units}}}}}\nbodies: {{}}"


@pytest.mark.parametrize(
    ("file", "phrase"),
    [
        ("none.stl", "none.stl: the file cannot be read: No such file"),
        ("m.step", "m.step: .step is not supported by this version, expected .3mf, .glb, .obj, .off, .ply or .stl"),
        ("m", "m: a file without suffix is not supported by this version"),
        ("folder.obj", "folder.obj: expected a file"),
        ("empty.obj", "empty.obj: "),
        ("points.obj", "points.obj: "),
        ("bad.obj", "bad.obj:2: expected a finite coordinate"),
        ("index.obj", "index.obj:2: "),
        ("short.ply", "short.ply"),
        ("half.stl", "half.stl"),
        ("/m.obj", "/m.obj is absolute"),
        ("'C:\\m.obj'", "absolute"),
        ("../m.obj", "lies outside the scene's folder"),
        ("'https://example.org/m.obj'", "is a URL"),
        ('"a\\0b.obj"', "a\\x00b.obj is no path"),
    ],
)
def test_a_mesh_file_that_is_none_is_told_where_it_is_named(folder: Path, file: str, phrase: str) -> None:
    (folder / "folder.obj").mkdir()
    (folder / "empty.obj").touch()
    (folder / "points.obj").write_text("v 0 0 0\nv 1 0 0\n")
    (folder / "bad.obj").write_text("v 0 0 0\nv 0 nan 0\n")
    (folder / "index.obj").write_text("v 0 0 0\nf 1 2 3\n")
    (folder / "short.ply").write_bytes(ascii_ply(face_count=2))
    (folder / "half.stl").write_bytes(b"\0" * 80 + b"\x02\0\0\0" + b"\0" * 50)
    line = fault(folder, meshes(file))
    assert line.startswith("4:20: meshes.m.file: ")
    assert phrase in line


def test_a_doubtful_mesh_is_warned_of_where_it_is_named(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n")
    is_open, flat = warnings(tmp_path, meshes("m.obj"))
    assert is_open.startswith("4:20: meshes.m.file: m.obj is open: treated as a surface")
    assert flat == "4:20: meshes.m.file: m.obj has 1 zero-area triangle"
