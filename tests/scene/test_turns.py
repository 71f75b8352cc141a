"""Keys whose angles are written more than half a turn apart: slerp takes the shorter way, and a warning says so."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cli_process import closecall
from scene_files import HEAD, MOTION, load, motion, warnings
from scipy.spatial.transform import Rotation

ALL_THE_WAY = "constant, screw, swing and profile (kind: turn) turn all the way"
REMARK = f"write angles up to 180 degrees apart if that is meant, else {ALL_THE_WAY}"


def keyframes(*rotations: str, options: str = "") -> str:
    keys = ", ".join(f"{{t: {i / (len(rotations) - 1)}{r and ', '}{r}}}" for i, r in enumerate(rotations))
    return f"{MOTION}{{type: keyframes, {options}keys: [{keys}]}}\n"


def told(folder: Path, *rotations: str, options: str = "") -> list[str]:
    """Return the warnings of keys at equal steps, without their place."""
    lines = warnings(folder, keyframes(*rotations, options=options))
    assert all(": bodies.a.motion.keys[" in line for line in lines)
    return [line.split(": ", 2)[2] for line in lines]


def about_z(angle: float) -> str:
    return f"axis_angle: {{axis: [0, 0, 2], angle: {angle}}}"


@pytest.mark.parametrize(
    ("one", "other", "written", "shorter"),
    [
        ("rpy: [0, 0, -170]", "rpy: [0, 0, 170]", 340, 20),
        ("rpy: [0, 0, 10]", "rpy: [0, 0, 195]", 185, 175),
        ("rpy: [5, 0, -170]", "rpy: [5, 3, 170]", 340, 20.2),
        ("rpy: [0, 0, 0]", "rpy: [0, 0, 360]", 360, 0),
        ("rpy: [0, -720, 0]", "rpy: [0, 0, 0]", 720, 0),
        ("rpy: [190, 0, 0]", "", 190, 170),
        ("", about_z(270), 270, 90),
        (about_z(-170), about_z(170), 340, 20),
        (about_z(350), about_z(1090), 740, 20),
        (about_z(170), "axis_angle: {axis: [0, 0, -1], angle: 170}", 340, 20),
        (about_z(-170), "axis_angle: {axis: [0, 0, -1], angle: -170}", 340, 20),
        (about_z(-170), "axis_angle: {axis: [0, 1.0e-4, 1], angle: 170}", 340, 20),
        ("rpy: [0, 0, -170]", about_z(170), 340, 20),
        ("rpy: [0, 1, -170]", about_z(170), 340, 20),
    ],
)
def test_angles_written_more_than_half_a_turn_apart_are_told_in_both_readings(
    tmp_path: Path, one: str, other: str, written: float, shorter: float
) -> None:
    (line,) = told(tmp_path, one, other)
    begin, rest = line.split(" degrees apart, slerp turns ")
    turned, remark = rest.split(" degrees, the shorter way: ")
    assert float(begin.removeprefix("keys 0 and 1 are written ")) == pytest.approx(written, abs=0.06)
    assert float(turned) == pytest.approx(shorter, abs=0.06)
    assert remark == REMARK


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("rpy: [0, 0, -70]", "rpy: [0, 0, 70]"),
        ("rpy: [0, 0, 190]", "rpy: [0, 0, 170]"),
        ("rpy: [0, 0, 720]", "rpy: [0, 0, 800]"),
        (about_z(300), about_z(440)),
        (about_z(170), "axis_angle: {axis: [0, 0, -1], angle: -150}"),
        ("axis_angle: {axis: [1, 0, 0], angle: 100}", "axis_angle: {axis: [0, 1, 0], angle: 100}"),
        ("quat_wxyz: [0, 0, 0, 1]", "rpy: [0, 0, -170]"),
        ("rpy: [0, 0, 179]", "quat_xyzw: [0, 0, 1, 0]"),
    ],
)
def test_angles_up_to_half_a_turn_apart_and_quaternions_are_not(tmp_path: Path, one: str, other: str) -> None:
    assert told(tmp_path, one, other) == []


def test_a_half_turn_stays_ambiguous_and_steps_turn_nowhere(tmp_path: Path) -> None:
    (line,) = told(tmp_path, "rpy: [0, 0, -90]", "rpy: [0, 0, 90]")
    assert line == "keys 0 and 1 are 180.0 degrees apart: which way round is ambiguous, add a key between"
    steps = "interpolation: {rotation: step}, "
    assert told(tmp_path, "rpy: [0, 0, -170]", "rpy: [0, 0, 170]", options=steps) == []


def test_a_body_is_told_of_once_with_its_first_keys_and_a_count(tmp_path: Path) -> None:
    turns = [f"rpy: [0, 0, {angle}]" for angle in (0, 30, 300, 10, 350, 340)]
    (line,) = warnings(tmp_path, keyframes(*turns, options="before: loop, after: loop, "))
    begin = "bodies.a.motion.keys[2]: keys 1 and 2 are written 270.0 degrees apart (and 2 more such), slerp turns 90.0"
    assert line.split(": ", 1)[1].startswith(begin)


@pytest.mark.parametrize("units", ["deg", "rad"])
def test_both_units_of_angles_are_told_in_degrees(tmp_path: Path, units: str) -> None:
    most = 170.0 if units == "deg" else np.radians(170.0)
    text = keyframes(f"rpy: [0, 0, {-most}]", f"rpy: [0, 0, {most}]").replace("angle: deg", f"angle: {units}")
    (line,) = warnings(tmp_path, text)
    assert "written 340.0 degrees apart, slerp turns 20.0 degrees" in line


def test_what_is_told_is_what_slerp_does_and_what_the_angles_say(tmp_path: Path) -> None:
    """Followed in small steps, random roll, pitch and yaw end as slerp does, or on the other side of the sphere."""
    rng = np.random.default_rng(8)
    for _ in range(30):
        first, last = rng.uniform(-260.0, 260.0, (2, 3))
        lines = told(tmp_path, f"rpy: {first.tolist()}", f"rpy: {last.tolist()}")
        way = Rotation.from_euler("xyz", np.linspace(first, last, 400), degrees=True).as_quat()
        flips = np.sum(way[1:] * way[:-1], axis=1) < 0.0  # the sign that follows the way
        along = float(way[0] @ way[-1]) * (-1.0) ** int(flips.sum())
        far = along < 0.0 or np.abs(last - first).max() > 180.0
        assert any("are written" in line for line in lines) == far
        moving = motion(tmp_path, keyframes(f"rpy: {first.tolist()}", f"rpy: {last.tolist()}").removeprefix(MOTION))
        turned = Rotation.from_matrix(moving.pose(1.0)[:3, :3]) * Rotation.from_matrix(moving.pose(0.0)[:3, :3]).inv()
        if far:
            shorter = float(lines[0].split("slerp turns ")[1].split()[0])
            assert np.degrees(turned.magnitude()) == pytest.approx(shorter, abs=0.06)


CSV = "t,x,y,z,roll,pitch,yaw\n"


def test_angles_of_a_trajectory_file_are_told_of_by_line(tmp_path: Path) -> None:
    (tmp_path / "p.csv").write_text(CSV + "0,0,0,0,0,0,-170\n0.5,0,0,0,0,0,-100\n0.7,0,0,0,0,0,170\n1,0,0,0,0,0,-170\n")
    follow = "{type: file, file: p.csv, layout: csv%s}"
    (line,) = warnings(tmp_path, MOTION + follow % "")
    text = "lines 3 and 4 are written 270.0 degrees apart (and 1 more such), slerp turns 90.0 degrees, the shorter way"
    assert line == f"6:32: bodies.a.motion.file: p.csv: {text}: {REMARK}"
    assert warnings(tmp_path, MOTION + follow % ", interpolation: {rotation: step}") == []


def test_a_joint_that_is_meant_to_turn_all_the_way_is_refused_under_strict_and_named(tmp_path: Path) -> None:
    """A link that points to the left turns by 340 degrees past a post in front; slerp's 20 degrees miss it."""
    post = "post: {pose: {xyz: [700, 0, 0]}, shapes: [{sphere: 20}]}"
    link = "shapes: [{box: [800, 60, 60], pose: {xyz: [400, 0, 0]}}]"
    keys = "{type: keyframes, keys: [{t: 0, rpy: [0, 0, -170]}, {t: 1, rpy: [0, 0, 170]}]}"
    limits = "max_velocity: 680, max_acceleration: 2040"
    turn = f"{{type: profile, kind: turn, axis: [0, 0, 1], from: -170, to: 170, {limits}}}"

    def ended(moving: str, *options: str) -> tuple[int, str, str]:
        (tmp_path / "s.yaml").write_text(f"{HEAD}bodies:\n  link: {{{link}, motion: {moving}}}\n  {post}\n")
        done = closecall("run", "s.yaml", "-o", "s.mcap", "--log", "certificate", *options, cwd=tmp_path)
        return done.returncode, done.stdout, done.stderr

    code, out, err = ended(keys)
    assert (code, "clear" in out) == (0, True)
    assert "keys 0 and 1 are written 340.0 degrees apart, slerp turns 20.0 degrees, the shorter way" in err
    code, out, err = ended(keys, "--strict")
    assert (code, out) == (2, "")
    assert ALL_THE_WAY in err
    code, out, err = ended(turn, "--strict")
    assert (code, "contact" in out, err) == (0, True, "")


def test_whole_turns_of_a_scene_change_nothing_of_its_rotations(tmp_path: Path) -> None:
    plain, whole = (
        load(tmp_path, keyframes("rpy: [10, 20, 30]", f"rpy: [{10 + turns}, 20, 40]")).scene.bodies[0].motion.pose(1.0)
        for turns in (0, 360)
    )
    assert plain.tobytes() == whole.tobytes()
