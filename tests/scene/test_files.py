"""Files that a scene names: trajectories through the scene's eyes, and where files may lie."""

from __future__ import annotations

import hashlib
import math
import os
from pathlib import Path

import numpy as np
import pytest
from scene_files import HEAD, MOTION, TETRAHEDRON, fault, load, motion, warnings

from closecall.formats.scene.reader import read_scene
from closecall.formats.scene.trajectory_files.trajectories import LARGEST_TRAJECTORY
from closecall.scheduler.motions import Keyframes, Looped, Translation

CSV = "t,x,y,z,yaw,pitch,roll\n10,1,2,3,90,0,0\n10.5,0,0,0,0,0,0\n11,1,1,1,0,0,0\n"
TUM = "# t x y z qx qy qz qw\n10 1 2 3 0 0 0 1\n11 0 0 0 0 0 0.6 0.8\n"


def file_motion(options: str) -> str:
    return f"{MOTION}{{type: file, {options}}}"


def keys(folder: Path, options: str) -> Keyframes:
    found = motion(folder, f"{{type: file, {options}}}")
    assert isinstance(found, Keyframes)
    return found


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "path.csv").write_text(CSV)
    (tmp_path / "path.tum").write_text(TUM)
    return tmp_path


def test_a_csv_file_is_in_the_scenes_units_from_its_first_time(folder: Path) -> None:
    found = keys(folder, "file: path.csv, layout: csv")
    assert found.times.tolist() == [0.0, 0.5, 1.0]
    assert found.translations.tolist() == [[0.001, 0.002, 0.003], [0, 0, 0], [0.001, 0.001, 0.001]]
    np.testing.assert_allclose(found.quaternions[0], [math.sqrt(0.5), 0, 0, math.sqrt(0.5)], atol=1e-15)
    assert (found.translation, found.step_rotation) == (Translation.LINEAR, False)


def test_a_csv_file_may_have_units_of_its_own(folder: Path) -> None:
    assert keys(folder, "file: path.csv, layout: csv, units: cm").translations[0].tolist() == [0.01, 0.02, 0.03]


def test_angles_of_a_csv_file_are_in_the_scenes_unit(folder: Path) -> None:
    text = file_motion("file: path.csv, layout: csv").replace("angle: deg", "angle: rad")
    (found,) = [body.motion for body in load(folder, text).scene.bodies]
    assert isinstance(found, Keyframes)
    np.testing.assert_allclose(found.quaternions[0], [math.cos(45), 0, 0, math.sin(45)], atol=1e-15)


def test_a_tum_file_is_in_metres_whatever_the_scenes_unit(folder: Path) -> None:
    found = keys(folder, "file: path.tum, layout: tum")
    assert found.translations[0].tolist() == [1, 2, 3]
    np.testing.assert_allclose(found.quaternions[1], [0.8, 0, 0, 0.6], atol=1e-16)


def test_time_origin_zero_keeps_the_files_own_times_and_t0_adds_to_them(folder: Path) -> None:
    options = "file: path.csv, layout: csv, before: hold, after: hold"
    assert keys(folder, f"{options}, time_origin: zero").times.tolist() == [10.0, 10.5, 11.0]
    assert keys(folder, f"{options}, time_origin: first, t0: 2").times.tolist() == [2.0, 2.5, 3.0]
    assert keys(folder, f"{options}, time_origin: zero, t0: -10").times.tolist() == [0.0, 0.5, 1.0]


def test_a_file_may_be_repeated_and_interpolated_otherwise(folder: Path) -> None:
    options = "file: path.csv, layout: csv, before: loop, after: loop, t0: 5"
    found = motion(folder, f"{{type: file, {options}, interpolation: {{translation: cubic, rotation: step}}}}")
    assert isinstance(found, Looped)
    assert (found.before, found.after) == (True, True)
    assert (found.keys.translation, found.keys.step_rotation) == (Translation.CUBIC, True)
    assert found.keys.key_velocities is None


def test_trajectory_files_are_kept_with_their_hash_by_the_body_that_moves_so(folder: Path) -> None:
    (file,) = load(folder, file_motion("file: path.csv, layout: csv")).trajectory_files
    assert (file.name, file.path) == ("a", (folder / "path.csv").resolve())
    assert file.sha256 == hashlib.sha256(CSV.encode()).hexdigest()


@pytest.mark.parametrize(
    ("options", "begin", "phrase"),
    [
        ("file: none.csv, layout: csv", "6:32: bodies.a.motion.file: ", "none.csv: the file cannot be read: No such"),
        ("file: ., layout: csv", "6:32: bodies.a.motion.file: ", ".: expected a file"),
        ("file: pipe, layout: csv", "6:32: bodies.a.motion.file: ", "pipe: expected a file"),
        (
            "file: big.csv, layout: csv",
            "6:32: bodies.a.motion.file: ",
            f"big.csv: the file has {LARGEST_TRAJECTORY + 1} bytes, expected up to {LARGEST_TRAJECTORY}",
        ),
        ("file: empty.csv, layout: csv", "6:32: bodies.a.motion.file: ", "empty.csv: the file is empty"),
        ("file: ../path.csv, layout: csv", "6:32: bodies.a.motion.file: ", "lies outside the scene's folder"),
        ("file: /etc/passwd, layout: csv", "6:32: bodies.a.motion.file: ", "/etc/passwd is absolute"),
        ("file: 'http://a.b/c.csv', layout: csv", "6:32: bodies.a.motion.file: ", "is a URL"),
        (
            "file: bad.csv, layout: csv",
            "6:32: bodies.a.motion.file: ",
            "bad.csv:3: expected a number in 'x', got 'abc'",
        ),
        (
            "file: path.csv, layout: csv, max_gap: 0.25",
            "6:32: bodies.a.motion.file: ",
            "path.csv:3: lines 2 and 3 are 0.5 s apart, expected at most 0.25 s (max_gap) (and 1 more)",
        ),
        ("file: path.csv, layout: tum", "6:32: bodies.a.motion.file: ", "path.csv:1: expected 8 columns"),
        (
            "file: path.tum, layout: tum, units: m",
            "6:62: bodies.a.motion.units: ",
            "the tum layout is in m, leave the key out",
        ),
        (
            "file: path.csv, layout: csv, time_origin: zero",
            "6:32: bodies.a.motion.file: ",
            "path.csv:2: expected the first pose at 0 s or before, or say before: hold or loop, got 10 s",
        ),
        (
            "file: path.csv, layout: csv, t0: -0.5",
            "6:32: bodies.a.motion.file: ",
            "path.csv:4: expected the last pose at 1 s or after, or say after: hold or loop, got 0.5 s",
        ),
        (
            "file: one.csv, layout: csv, after: loop",
            "6:61: bodies.a.motion.after: ",
            "one pose cannot be repeated, expected two or more, or hold",
        ),
    ],
)
def test_a_file_that_cannot_be_followed_is_told_where_the_scene_names_it(
    folder: Path, options: str, begin: str, phrase: str
) -> None:
    (folder / "bad.csv").write_text("t,x,y,z\n0,0,0,0\n1,abc,0,0\n")
    (folder / "one.csv").write_text("t,x,y,z\n0,0,0,0\n")
    (folder / "empty.csv").touch()
    os.mkfifo(folder / "pipe")
    with (folder / "big.csv").open("wb") as file:
        file.truncate(LARGEST_TRAJECTORY + 1)
    line = fault(folder, file_motion(options))
    assert line.startswith(begin)
    assert phrase in line


def test_a_doubtful_trajectory_is_warned_of_where_the_scene_names_it(folder: Path) -> None:
    rows = "0,0,0,0,0,0,0,a\n0.5,0,0,0,160,0,0,b\n1,0,0,0,180,0,0,c\n"
    (folder / "turn.csv").write_text(f"t,x,y,z,yaw,pitch,roll,note\n{rows}")
    left_out, wide = warnings(folder, file_motion("file: turn.csv, layout: csv"))
    assert left_out == "6:32: bodies.a.motion.file: turn.csv: has columns that are left out: 'note'"
    assert wide.startswith("6:32: bodies.a.motion.file: turn.csv: lines 2 and 3 are 160.0 degrees apart: ")


@pytest.mark.parametrize("kind", ["trajectory", "mesh"])
def test_files_may_lie_in_a_folder_that_the_caller_names(folder: Path, kind: str) -> None:
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "m.obj").write_text(TETRAHEDRON)
    (elsewhere / "path.csv").write_text(CSV)
    inside = folder / "inside"
    inside.mkdir()
    texts = {
        "trajectory": file_motion("file: ../elsewhere/path.csv, layout: csv"),
        "mesh": f"{HEAD}meshes: {{m: {{file: {elsewhere}/m.obj, units: m}}}}\nbodies: {{}}",
    }
    assert "name its root" in fault(inside, texts[kind])
    assert read_scene(inside / "scene.yaml", [elsewhere])


def test_a_link_that_leaves_the_folder_is_refused(folder: Path) -> None:
    inside = folder / "inside"
    inside.mkdir()
    (inside / "link.csv").symlink_to(folder / "path.csv")
    assert "lies outside the scene's folder" in fault(inside, file_motion("file: link.csv, layout: csv"))
    (inside / "round.csv").symlink_to(inside / "round.csv")
    assert "round.csv" in fault(inside, file_motion("file: round.csv, layout: csv"))
