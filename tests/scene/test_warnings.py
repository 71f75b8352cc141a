"""What a scene is warned of: sizes and places that look like a mistake, and half turns."""

from __future__ import annotations

from pathlib import Path

import pytest
from scene_files import HEAD, MOTION, TETRAHEDRON, load, warnings

from closecall.cli.application.scenes import counted_pairs
from closecall.formats.scene.reader import read_scene


def two(first: str, second: str) -> str:
    return f"{HEAD}bodies:\n  one: {{shapes: [{first}]}}\n  other: {{shapes: [{second}]}}\n"


def beside(folder: Path, size: float, *others: str, units: str = "m", scale: str = "1") -> list[str]:
    """Return the warnings of a scene with a mesh file of this size, from 0 to it along x, y and z, and other shapes."""
    (folder / "m.obj").write_text(TETRAHEDRON.replace("1", str(size), 3))
    meshes = f"meshes: {{part: {{file: m.obj, units: {units}}}}}\n"
    bodies = "".join(f"  b{i}: {{shapes: [{shape}]}}\n" for i, shape in enumerate(others))
    mesh = f"{{mesh: part, scale: {scale}}}"
    return warnings(
        folder, f"{HEAD}{meshes}bodies:\n  one: {{shapes: [{mesh}]}}\n  two: {{shapes: [{mesh}]}}\n{bodies}"
    )


def test_a_mesh_file_in_the_wrong_unit_is_warned_of(tmp_path: Path) -> None:
    around = ("{sphere: 150}", "{box: [100, 20, 20]}", "{box: [900, 20, 20]}")
    assert beside(tmp_path, 300, *around, units="mm") == []
    assert beside(tmp_path, 300, *around, units="m", scale="0.001") == []
    assert beside(tmp_path, 300, *around, units="m") == [
        "4:37: meshes.part.units: the mesh is 300 m in size, 1000 times larger than what else there is "
        "(the median is 0.3 m): is a unit wrong, mm for m?"
    ]
    assert beside(tmp_path, 0.3, *around, units="mm") == [
        "4:37: meshes.part.units: the mesh is 0.0003 m in size, 1000 times smaller than what else there is "
        "(the median is 0.3 m): is a unit wrong, mm for m?"
    ]


def test_a_mesh_file_is_warned_of_beyond_500_times_the_median_of_all_else(tmp_path: Path) -> None:
    for size in (0.2, 100, 50_000):
        assert beside(tmp_path, size, "{sphere: 50}", units="mm") == []
        assert beside(tmp_path, size, "{sphere: 5}", "{sphere: 50}", "{sphere: 500}", units="mm") == []
        assert beside(tmp_path, size, "{sphere: 5}", "{sphere: 500}", units="mm") == []
    for size in (0.199, 50_001):
        assert len(beside(tmp_path, size, "{sphere: 50}", units="mm")) == 1
        assert len(beside(tmp_path, size, "{sphere: 5}", "{sphere: 50}", "{sphere: 500}", units="mm")) == 1
        assert len(beside(tmp_path, size, "{sphere: 5}", "{sphere: 500}", units="mm")) == 1


def test_a_file_alone_has_nothing_to_be_compared_with(tmp_path: Path) -> None:
    assert beside(tmp_path, 300) == []


def test_a_screw_beside_a_bench_is_not_warned_of(tmp_path: Path) -> None:
    assert warnings(tmp_path, two("{box: [6000, 900, 800]}", "{capsule: {radius: 3, length: 4}}")) == []
    assert warnings(tmp_path, two("{ellipsoid: [1e9, 1e9, 1e9]}", "{box: [1, 1, 1]}")) == []
    assert beside(tmp_path, 10, "{box: [6000, 900, 800]}", "{box: [300, 80, 80]}", "{sphere: 25}", units="mm") == []


def test_every_mesh_in_the_wrong_unit_makes_the_one_that_is_right_stand_out(tmp_path: Path) -> None:
    for i, size in enumerate((100, 200, 300, 0.05)):
        (tmp_path / f"{i}.obj").write_text(TETRAHEDRON.replace("1", str(size), 3))
    meshes = ", ".join(f"link{i}: {{file: {i}.obj, units: m}}" for i in range(4))
    bodies = ", ".join(f"b{i}: {{shapes: [{{mesh: link{i}}}]}}" for i in range(4))
    (line,) = warnings(tmp_path, f"{HEAD}meshes: {{{meshes}}}\nbodies: {{{bodies}}}\n")
    assert ": meshes.link3.units: the mesh is 0.05 m in size, 4000 times smaller than" in line


def test_a_mesh_without_any_size_is_not_measured_against_others(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n")
    meshes = f"{HEAD}meshes: {{m: {{file: m.obj, units: mm}}}}\n"
    told = warnings(tmp_path, meshes + two("{sphere: 150}", "{mesh: m}")[len(HEAD) :])
    assert [line.split(": ")[1] for line in told] == ["meshes.m.file"] * 2


FAR = "rounding may show, move the origin"


@pytest.mark.parametrize(
    ("body", "distance"),
    [
        ("pose: {xyz: [2.1e6, 0, 0]}, shapes: [{sphere: 1}]", "2.1e+03"),
        ("shapes: [{sphere: 1, pose: {xyz: [0, 2.1e6, 0]}}]", "2.1e+03"),
        ("shapes: [{sphere: 1}], motion: {type: constant, velocity: [-3e6, 0, 0]}", "3e+03"),
        ("shapes: [{sphere: 1}, {sphere: 5}], pose: {xyz: [-2.1e6, 0, 0]}", "2.1e+03"),
    ],
)
def test_a_body_a_million_times_farther_away_than_it_is_large_is_warned_of(
    tmp_path: Path, body: str, distance: str
) -> None:
    (line,) = warnings(tmp_path, f"{HEAD}bodies:\n  a: {{{body}}}\n")
    assert line.startswith("5:")
    assert f": bodies.a.shapes: lies {distance} m from the origin, " in line
    assert line.endswith(f" times its smallest shape: {FAR}")
    assert warnings(tmp_path, f"{HEAD}bodies:\n  a: {{{body.replace('e6', 'e5')}}}\n") == []


def test_a_mesh_whose_own_coordinates_are_far_away_is_warned_of(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text(
        "v 4e6 0 0\nv 4000001 0 0\nv 4e6 1 0\nv 4e6 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    )
    text = f"{HEAD}meshes: {{m: {{file: m.obj, units: m}}}}\nbodies: {{a: {{shapes: [{{mesh: m}}]}}}}"
    (line,) = warnings(tmp_path, text)
    assert line == f"5:22: bodies.a.shapes: lies 4e+06 m from the origin, 4e+06 times its smallest shape: {FAR}"


def test_a_motion_whose_terms_are_far_larger_than_its_way_is_warned_of(tmp_path: Path) -> None:
    head = HEAD.replace("start: 0, end: 1}", "start: 1.7e9, end: 1700000001}\nsettings: {contact_tolerance: 1e-4}")
    cancels = "{type: polynomial, coefficients: [[-1.7e12, 0, 0], [1000, 0, 0]]}"
    (line,) = warnings(tmp_path, f"{head}bodies: {{a: {{motion: {cancels}, shapes: [{{sphere: 500}}]}}}}")
    assert line.startswith("5:22: bodies.a.motion: the motion's terms add up to ")
    assert line.endswith(" times the body's smallest shape: rounding may show, let times and t0 be nearer to 0")
    near = "{type: ballistic, acceleration: [0, 0, -9810], t0: 1.7e9}"
    assert warnings(tmp_path, f"{head}bodies: {{a: {{motion: {near}, shapes: [{{sphere: 500}}]}}}}") == []


def test_of_many_bodies_far_away_the_worst_is_told(tmp_path: Path) -> None:
    bodies = "".join(f"  b{i}: {{pose: {{xyz: [{i}e8, 0, 0]}}, shapes: [{{sphere: 1}}]}}\n" for i in range(5))
    (line,) = warnings(tmp_path, f"{HEAD}bodies:\n{bodies}")
    assert line.startswith("9:")
    assert line.endswith(f"{FAR} (and 3 more bodies)")


def test_a_frame_without_shapes_may_lie_anywhere(tmp_path: Path) -> None:
    frame = "a: {pose: {xyz: [1e15, 0, 0]}}"
    assert warnings(tmp_path, f"{HEAD}bodies: {{{frame}, b: {{shapes: [{{sphere: 1}}]}}}}") == []


def test_a_body_in_a_parent_far_away_is_as_far(tmp_path: Path) -> None:
    child = "b: {parent: a, shapes: [{sphere: 1}]}"
    (line,) = warnings(tmp_path, f"{HEAD}bodies: {{a: {{pose: {{xyz: [3e6, 0, 0]}}}}, {child}}}")
    assert "bodies.b.shapes: lies 3e+03 m" in line


def keyframes(keys: str, options: str = "") -> str:
    return f"{MOTION}{{type: keyframes, {options}keys: [{keys}]}}\n"


def test_keys_far_apart_are_warned_of_where_slerp_may_mislead(tmp_path: Path) -> None:
    keys = "{t: 0}, {t: 0.3, rpy: [0, 0, 149]}, {t: 0.6, rpy: [0, 0, 301]}, {t: 1, rpy: [0, 0, 121]}"
    first, second = warnings(tmp_path, keyframes(keys))
    assert first == (
        "6:74: bodies.a.motion.keys[2]: keys 1 and 2 are 152.0 degrees apart: "
        "the shorter way is taken, is a key missing?"
    )
    assert second == (
        "6:102: bodies.a.motion.keys[3]: keys 2 and 3 are 180.0 degrees apart: "
        "which way round is ambiguous, add a key between"
    )
    assert warnings(tmp_path, keyframes(keys, "interpolation: {rotation: step}, ")) == []


def test_warnings_come_in_the_order_of_the_file(tmp_path: Path) -> None:
    (tmp_path / "open.obj").write_text("v 0 0 0\nv 300 0 0\nv 0 300 0\nf 1 2 3\n")
    text = (
        f"{HEAD}bodies:\n  a: {{motion: {{type: keyframes, keys: [{{t: 0}}, {{t: 1, rpy: [0, 0, 160]}}]}}}}\n"
        "  b: {pose: {xyz: [1e6, 0, 0]}, shapes: [{sphere: 0.1}]}\n  c: {shapes: [{mesh: m}]}\n"
        "meshes: {m: {file: open.obj, units: mm}}\n"
    )
    assert [line.split(": ")[1] for line in warnings(tmp_path, text)] == [
        "bodies.a.motion.keys[1]",
        "bodies.b.shapes",
        "meshes.m.file",
        "meshes.m.units",
    ]


def test_a_faultless_scene_of_everyday_sizes_is_not_warned_of(tmp_path: Path) -> None:
    lengths = (12, 80, 400, 2500, 6000)
    parts = "".join(f"  p{i}: {{shapes: [{{box: [{s}, {s}, {s}]}}]}}\n" for i, s in enumerate(lengths))
    assert load(tmp_path, f"{HEAD}bodies:\n{parts}").warnings == ()


def test_a_log_names_the_scene_file_alone_however_its_path_was_typed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "scene.yaml").write_text(f"{HEAD}bodies:\n  one: {{shapes: [{{sphere: 1}}]}}\n")
    monkeypatch.chdir(tmp_path)
    typed = (Path("folder/scene.yaml"), Path("folder/../folder/scene.yaml"), tmp_path / "folder" / "scene.yaml")
    loaded = [counted_pairs(read_scene(path), strict=False)[0] for path in typed]
    assert len({scene.warnings for scene in loaded}) == 3
    (told,) = {scene.warnings_by_name for scene in loaded}
    assert [line.split(":")[0] for line in told] == ["scene.yaml"] * len(told) != []
