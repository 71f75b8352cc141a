"""Files of the layouts euroc and kitti arrive as the poses that they hold, and poses at one time as the scene says."""

from __future__ import annotations

import json
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from places import SHARED
from scene_files import MOTION, fault, faults, load, motion, warnings
from scipy.spatial.transform import Rotation

from closecall.formats.scene.trajectory_files.kitti import Clock, read_stamps
from closecall.formats.scene.trajectory_files.trajectories import (
    Duplicates,
    Trajectory,
    TrajectoryError,
    read_trajectory,
)
from closecall.scheduler.motions import Keyframes
from oracle.draw_motions import random_motion
from oracle.paths import path_of
from oracle.poses import units_of
from oracle.scenes import begun

needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="shared data not there")

KEYS = ("duplicates", "times", "period")

HEADER = (
    "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
    "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1]\n"
)
ROWS = "1403636580838555648,1,2,3,0.8,0,0,0.6,7,8,9\n1403636580843555328,4,5,6,0.6,0,-0.8,0,7,8,9\n"
SWAPPED = HEADER.replace("q_RS_w", "q_RS_z").replace("q_RS_z [], v", "q_RS_w [], v")
XYZW = "# timestamp, p_x, p_y, p_z, q_x, q_y, q_z, q_w\n"
MATRICES = "1 0 0 1 0 1 0 2 0 0 1 3\n0 -1 0 4 1 0 0 5 0 0 1 6\n0 0 1 7 0 1 0 8 -1 0 0 9\n"


def euroc(text: str, duplicates: Duplicates = "error") -> Trajectory:
    return read_trajectory(text.encode(), "euroc", duplicates=duplicates)


def kitti(text: str, clock: Clock = Decimal("0.1")) -> Trajectory:
    return read_trajectory(text.encode(), "kitti", clock=clock)


def refusal(text: str, layout: str, clock: Clock | None = None) -> tuple[int | None, str]:
    with pytest.raises(TrajectoryError) as caught:
        read_trajectory(text.encode(), layout, clock=clock)
    assert caught.value.message.isprintable()
    return caught.value.line, caught.value.message


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        (HEADER + ROWS, [2, 3]),
        (HEADER.replace("timestamp", "timestamp [ns]").replace(", ", ",") + ROWS, [2, 3]),
        (HEADER.removeprefix("#") + ROWS, [2, 3]),
        (HEADER.replace("RS_R", "WB_W") + "# a remark, of two parts\n\n" + ROWS.replace(",", " , "), [4, 5]),
        ("\ufeff" + (HEADER + ROWS).replace("\n", "\r\n"), [2, 3]),
        (ROWS, [1, 2]),
        (ROWS.replace(",7,8,9", ""), [1, 2]),
        (ROWS.replace(",7,8,9", ",nan,,x"), [1, 2]),
        (ROWS.replace("1403636580838555648", "+1.403636580838555648e+18"), [1, 2]),
        (ROWS.replace("1403636580838555648", "1403636580838555648.0"), [1, 2]),
    ],
)
def test_a_euroc_file_is_read_in_seconds_and_with_the_quaternions_scalar_first(text: str, lines: list[int]) -> None:
    found = euroc(text)
    assert found.exact_times == (Decimal("1403636580.838555648"), Decimal("1403636580.843555328"))
    assert found.times.tolist() == [1403636580.838555648, 1403636580.843555328]
    assert found.in_scene_time("first", 0.0).times.tolist() == [0.0, 0.00499968]
    assert found.translations.tolist() == [[1, 2, 3], [4, 5, 6]]
    np.testing.assert_allclose(found.quaternions, [[0.8, 0, 0, 0.6], [0.6, 0, -0.8, 0]], rtol=0, atol=2e-16)
    assert found.lines.tolist() == lines
    assert found.warnings == ()


def test_nanoseconds_are_told_apart_that_floats_of_unix_seconds_are_not() -> None:
    rng = np.random.default_rng(3)
    first = 1_700_000_000_123_456_789
    stamps = first + np.cumsum(rng.integers(300, 2_000_000, 3000))
    text = "".join(f"{stamp},0,0,0,1,0,0,0\n" for stamp in stamps.tolist())
    expected = [float(Fraction(int(stamp) - int(stamps[0]), 10**9)) for stamp in stamps]
    assert euroc(text).in_scene_time("first", 0.0).times.tolist() == expected


@pytest.mark.parametrize(
    ("text", "line", "phrase"),
    [
        ("", None, "no poses"),
        (HEADER, None, "no poses"),
        ("1,0,0,0\n", 1, "(timestamp p_x p_y p_z q_w q_x q_y q_z) or more, separated by commas, got 4"),
        ("1 0 0 0 1 0 0 0\n", 1, "separated by commas, got 1"),
        (ROWS + "1403636580848555008,1,2,3,1,0,0\n", 3, "expected 11 columns as in line 1, got 7"),
        ("1,0,0,0,1,0,0,0\n2,0,0,0,1,0,0,0,\n", 2, "expected 8 columns as in line 1, got 9"),
        (ROWS.replace("0838555648,", "0.838555648,"), 1, "expected whole nanoseconds in timestamp, got '140363658"),
        (ROWS.replace("1403636580838555648", "1.40363658e9x"), 1, "expected whole nanoseconds"),
        (ROWS.replace("1403636580838555648", ""), 1, "expected whole nanoseconds in timestamp, got nothing"),
        (ROWS.replace("1403636580838555648", "1_000"), 1, "expected whole nanoseconds"),
        (ROWS.replace("1403636580838555648", "9" * 30), 1, "expected times up to 1e+15 s, got '99999"),
        (ROWS.replace("1403636580838555648", "9" * 101), 1, "expected a time of up to 100 characters, got 101"),
        (ROWS.replace("1403636580838555648", "1e99"), 1, "expected times up to 1e+15 s"),
        (ROWS + ROWS, 3, "expected a time after that of line 2"),
        (ROWS.replace("0843555328", "0838555648"), 2, "lines 1 and 2 are both at 1403636580.8385556 s"),
        (ROWS.replace(",0.8,0,0,0.6", ",0.8,0,0,0.7"), 1, "expected a unit quaternion"),
        (ROWS.replace(",5,", ",nan,"), 2, "expected a finite number in p_y, got 'nan'"),
        (SWAPPED + ROWS, 1, "names 'q_RS_z' in column 5, where euroc has q_w"),
        (XYZW + ROWS, 1, "names 'q_x' in column 5"),
        (HEADER.replace("x [m]", "x [mm]", 1) + ROWS, 1, "says that 'p_RS_R_x' is in 'mm', where euroc has m"),
        (HEADER.replace("timestamp", "timestamp [s]") + ROWS, 1, "'timestamp' is in 's', where euroc has ns"),
        (ROWS + HEADER.removeprefix("#"), 3, "expected whole nanoseconds in timestamp, got 'timestamp'"),
    ],
)  # fmt: skip
def test_bad_euroc_files_are_refused_at_their_line(text: str, line: int | None, phrase: str) -> None:
    where, message = refusal(text, "euroc")
    assert phrase in message
    assert where == line


@pytest.mark.parametrize(
    "text", [MATRICES, MATRICES.replace(" ", "\t "), "# poses\n\n" + MATRICES.replace("1 3\n", "1 3 # x\n")]
)
def test_a_kitti_file_is_read_matrix_by_matrix(text: str) -> None:
    found = kitti(text)
    assert found.translations.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    half = np.sqrt(0.5)
    np.testing.assert_allclose(found.quaternions, [[1, 0, 0, 0], [half, 0, 0, half], [half, 0, half, 0]], atol=1e-15)
    assert found.times.tolist() == [0.0, 0.1, 0.2]
    assert found.warnings == ()


def test_random_matrices_come_back_as_the_rotations_they_were() -> None:
    turns, places = Rotation.random(500, rng=np.random.default_rng(4)), np.random.default_rng(5).normal(size=(500, 3))
    matrices = np.concatenate([turns.as_matrix(), places[:, :, None]], axis=2).reshape(500, 12)
    found = kitti("\n".join(" ".join(map(repr, row)) for row in matrices.tolist()))
    assert found.translations.tolist() == places.tolist()
    got = Rotation.from_quat(found.quaternions, scalar_first=True).as_matrix()
    np.testing.assert_allclose(got, turns.as_matrix(), rtol=0, atol=2e-15)


@pytest.mark.parametrize(("decimals", "told"), [(7, False), (6, False), (4, True), (2, None)])
def test_matrices_of_few_decimals_are_taken_warned_of_or_refused(
    tmp_path: Path, decimals: int, told: bool | None
) -> None:
    turns = Rotation.from_rotvec(np.linspace(0.1, 1.0, 9)[:, None] * (0.3, -0.5, 0.7)).as_matrix()
    rows = [" ".join(f"{value:.{decimals}f}" for value in np.column_stack((turn, (1, 2, 3))).ravel()) for turn in turns]
    (tmp_path / "00.txt").write_text("\n".join(rows) + "\n")
    text = f"{MOTION}{{type: file, file: 00.txt, layout: kitti, period: 0.2}}\n    shapes: [{{sphere: 1000}}]\n"
    if told is None:
        assert "expected a rotation, got a matrix that scales or shears" in fault(tmp_path, text)
        return
    loaded = load(tmp_path, text)
    found = loaded.scene.bodies[0].motion
    assert isinstance(found, Keyframes)
    got = Rotation.from_quat(found.quaternions, scalar_first=True).as_matrix()
    np.testing.assert_allclose(got, turns, rtol=0, atol=2 * 10.0**-decimals)
    assert [("matrices" in line and line.count("00.txt") == 1) for line in loaded.warnings] == [True] * told


def test_a_period_is_multiplied_as_the_decimal_that_it_is() -> None:
    found = kitti("1 0 0 1 0 1 0 2 0 0 1 3\n" * 1000, Decimal("0.1"))
    assert found.times.tolist() == [float(Fraction(number, 10)) for number in range(1000)]


def test_times_of_a_kitti_file_come_from_another_file() -> None:
    stamps = read_stamps(b"# times\n0.000000e+00\n\n1.037359e-01\n  2.074998e-01\n")
    assert kitti(MATRICES, stamps).times.tolist() == [0.0, 0.1037359, 0.2074998]
    assert stamps.lines.tolist() == [2, 4, 5]


@pytest.mark.parametrize(
    ("text", "times", "line", "phrase"),
    [
        ("", "0\n", None, "the file has 0 poses, the file of times has 1 time"),
        (MATRICES, "0\n1\n", None, "the file has 3 poses, the file of times has 2 times, expected as many"),
        (MATRICES, "0\n1\n2\n3\n", None, "the file has 3 poses, the file of times has 4 times"),
        (MATRICES.replace(" 6\n", "\n"), "0\n1\n2\n", 2, "expected 12 columns, a 3x4 matrix by rows, got 11"),
        ("7 " + MATRICES, "0\n1\n2\n", 1, "got 13"),
        (MATRICES.replace(" 5 ", " five "), "0\n1\n2\n", 2, "expected a number in column 8, got 'five'"),
        (
            MATRICES.replace("-1 0 4", "-1.1 0 4"),
            "0\n1\n2\n",
            2,
            "expected a rotation, got a matrix that scales or shears",
        ),
        (MATRICES.replace("0 0 1 7", "0 0 -1 7"), "0\n1\n2\n", 3, "expected a rotation, got a matrix that mirrors"),
        (MATRICES.replace(" ", ","), "0\n1\n2\n", 1, "expected 12 columns, a 3x4 matrix by rows, got 1"),
    ],
)
def test_bad_kitti_files_are_refused_at_their_line(text: str, times: str, line: int | None, phrase: str) -> None:
    where, message = refusal(text, "kitti", read_stamps(times.encode()))
    assert phrase in message
    assert where == line


def kitti_scene(folder: Path, times: str, options: str = "") -> str:
    (folder / "00.txt").write_text(MATRICES)
    (folder / "times.txt").write_text(times)
    return f"{{type: file, file: 00.txt, layout: kitti, times: times.txt{options}, after: hold}}"


@pytest.mark.parametrize(
    ("times", "line", "phrase"),
    [
        ("0\n\n0.2\n0.1\n", ":4", "expected a time after that of line 3 (0.2 s), got 0.1 s"),
        ("# t\n0\n0.2\n0.2\n", ":4", "lines 3 and 4 are both at 0.2 s, expected one pose at a time"),
        ("0\n0.2 x\n0.3\n", ":2", "expected 1 time a line, got 2"),
        ("0\ntwo\n0.3\n", ":2", "expected a number in time, got 'two'"),
        ("0\n0.2\n0.9\n", ":3", "lines 2 and 3 are 0.7 s apart, expected at most 0.5 s (max_gap)"),
    ],
)
def test_faults_of_times_are_told_in_the_file_of_times(tmp_path: Path, times: str, line: str, phrase: str) -> None:
    told = fault(tmp_path, MOTION + kitti_scene(tmp_path, times, ", max_gap: 0.5"))
    assert told.startswith(f"6:62: bodies.a.motion.times: times.txt{line}: {phrase}")


@pytest.mark.parametrize(
    ("keys", "place", "phrase"),
    [
        ("layout: kitti, times: times.txt, period: 0.1", "period", "expected times or period, not both"),
        ("layout: csv, period: 1", "period", "the csv layout has times of its own, leave the key out"),
        ("layout: euroc, times: times.txt", "times", "the euroc layout has times of its own, leave the key out"),
        ("layout: tum, units: mm", "units", "the tum layout is in m, leave the key out"),
        ("layout: euroc, units: m", "units", "the euroc layout is in m, leave the key out"),
        ("layout: kitti, period: 1, units: mm", "units", "the kitti layout is in m, leave the key out"),
    ],
)
def test_keys_that_a_layout_has_no_use_for_are_refused(tmp_path: Path, keys: str, place: str, phrase: str) -> None:
    kitti_scene(tmp_path, "0\n1\n2\n")
    told = [line.partition(": ")[2] for line in faults(tmp_path, f"{MOTION}{{type: file, file: 00.txt, {keys}}}")]
    assert f"bodies.a.motion.{place}: {phrase}" in told


def test_a_scene_moves_by_a_kitti_file_in_metres_and_keeps_both_files(tmp_path: Path) -> None:
    text = kitti_scene(tmp_path, "5\n5.25\n6\n", ", t0: 0.5, before: hold")
    loaded = load(tmp_path, MOTION + text)
    found = loaded.scene.bodies[0].motion
    assert isinstance(found, Keyframes)
    assert found.times.tolist() == [0.5, 0.75, 1.5]
    assert found.translations.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert [(file.name, file.path.name) for file in loaded.trajectory_files] == [
        ("a/times", "times.txt"),
        ("a", "00.txt"),
    ]


def test_a_scene_moves_by_a_euroc_file_in_metres_from_its_first_time(tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text(HEADER + ROWS.replace("80843555328", "82838555648"))
    found = motion(tmp_path, "{type: file, file: data.csv, layout: euroc}")
    assert isinstance(found, Keyframes)
    assert found.times.tolist() == [0.0, 2.0]
    assert found.translations.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_times_of_two_clocks_are_brought_together_without_a_loss(tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text(ROWS)
    text = (
        "{type: file, file: data.csv, layout: euroc, time_origin: zero, t0: -1403636580.5, before: hold, after: hold}"
    )
    found = motion(tmp_path, text)
    assert isinstance(found, Keyframes)
    assert found.times.tolist() == [0.338555648, 0.343555328]
    assert found.times[0] != 1403636580.838555648 - 1403636580.5


TWICE = (
    "0 1 0 0 0 0 0 1\n0.50 2 0 0 0 0 0 1\n0.5 2 0.3 0.4 0 0 0 1\n5e-1 2 0 0 0 0 0.6 0.8\n"
    "1 3 0 0 0 0 0 1\n1 3 0 0 0 0 0 1\n"
)


@pytest.mark.parametrize(
    ("duplicates", "lines", "first"),
    [("first", [1, 2, 5], 3), ("last", [1, 4, 6], 2)],
)
def test_of_poses_at_one_time_the_first_or_the_last_is_taken(
    duplicates: Literal["first", "last"], lines: list[int], first: int
) -> None:
    found = read_trajectory(TWICE.encode(), "tum", duplicates=duplicates)
    assert found.times.tolist() == [0.0, 0.5, 1.0]
    assert found.lines.tolist() == lines
    assert found.exact_times == (Decimal(0), Decimal("0.5"), Decimal(1))
    assert found.quaternions[1, 3] == (0.0 if duplicates == "first" else 0.6)
    (told,) = found.warnings
    assert told == (
        f"has 3 poses at the time of another, first in line {first}: the {duplicates} of each is taken, "
        "they differ by up to 0.5 m and 73.7 degrees"
    )
    assert not found.times.flags.writeable
    with pytest.raises(TrajectoryError, match="or duplicates: first or last"):
        read_trajectory(TWICE.encode(), "tum")


@pytest.mark.parametrize("duplicates", ["first", "last"])
def test_times_that_go_back_are_refused_whatever_is_done_with_equal_ones(duplicates: Literal["first", "last"]) -> None:
    text = "".join(f"{time} 0 0 0 0 0 0 1\n" for time in (0, 1, 2, 2, 1))
    with pytest.raises(TrajectoryError, match="expected a time after that of line") as caught:
        read_trajectory(text.encode(), "tum", duplicates=duplicates)
    assert caught.value.line == 5
    assert read_trajectory(b"0 0 0 0 0 0 0 1\n" * 3, "tum", duplicates=duplicates).times.tolist() == [0.0]


def test_the_difference_of_poses_at_one_time_is_told_in_the_files_unit(tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_text("t,x,y,z\n0,0,0,0\n0,3,0,4\n1,0,0,0\n")
    (told,) = warnings(tmp_path, MOTION + "{type: file, file: path.csv, layout: csv, units: in, duplicates: last}")
    assert told.endswith("path.csv: has 1 pose at the time of another, first in line 2: the last of each is taken, "
                         "they differ by up to 5 in and 0 degrees")  # fmt: skip


def test_random_files_move_a_body_as_the_oracle_reads_them(tmp_path: Path) -> None:
    drawn: set[tuple[str, ...]] = set()
    for seed in range(120):
        folder = tmp_path / str(seed)
        folder.mkdir()
        draw = begun(seed, folder)
        spec = random_motion(draw, "file")
        drawn |= {(spec["layout"], key, str(spec[key]) * (key == "duplicates")) for key in KEYS if key in spec}
        scene = {
            "closecall": 1,
            "units": {"length": draw.length, "angle": draw.angle},
            "time": {"start": draw.start, "end": draw.end},
            "bodies": {"a": {"motion": spec}},
        }
        found = load(folder, json.dumps(scene), "scene.json").scene.bodies[0].motion
        truth = path_of(spec, units_of(scene), folder)
        times = np.linspace(draw.start, draw.end, 41)
        np.testing.assert_allclose([found.pose(time) for time in times], truth.at(times), rtol=0, atol=1e-9)
    layouts = ("tum", "euroc", "kitti", "csv")
    assert drawn >= {(layout, "duplicates", which) for layout in layouts for which in ("first", "last", "error")}
    assert drawn >= {("kitti", "times", ""), ("kitti", "period", "")}


@needs_shared
@pytest.mark.parametrize("duplicates", ["first", "last"])
def test_a_trajectory_from_the_field_with_equal_stamps_is_read(duplicates: Literal["first", "last"]) -> None:
    path = SHARED / "traj" / "V102.txt"
    rows = np.loadtxt(path)
    times = rows[:, 0]
    later, earlier = np.append(True, np.diff(times) > 0), np.append(np.diff(times) > 0, True)
    expected = rows[later if duplicates == "first" else earlier]
    found = read_trajectory(path.read_bytes(), "tum", duplicates=duplicates)
    assert found.times.tolist() == expected[:, 0].tolist()
    assert found.translations.tolist() == expected[:, 1:4].tolist()
