"""Trajectory files arrive as the poses they hold, at the times they say, or are refused at the line that is wrong."""

from __future__ import annotations

import math
import random
from decimal import Decimal
from fractions import Fraction
from itertools import permutations

import numpy as np
import pytest
from guarded import time_limited
from places import SHARED
from scipy.spatial.transform import Rotation

from closecall.formats.scene.trajectory_files import trajectories
from closecall.formats.scene.trajectory_files.trajectories import (
    Trajectory,
    TrajectoryError,
    read_trajectory,
)

needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="shared data not there")

TUM = "# timestamp tx ty tz qx qy qz qw\n0.5 1 2 3 0 0 0 1\n\n1.5 4 5 6 1 0 0 0\n2.25 7 8 9 0 0.6 0 -0.8\n"
TURNED = "qw,qx,qy,qz"


def tum(text: str, max_gap: float | None = None) -> Trajectory:
    return read_trajectory(text.encode(), "tum", max_gap)


def csv(text: str, max_gap: float | None = None, radians_per_unit: float = 1.0) -> Trajectory:
    return read_trajectory(text.encode(), "csv", max_gap, radians_per_unit)


def tum_at(*times: str) -> str:
    return "".join(f"{time} 0 0 0 0 0 0 1\n" for time in times)


def turned_by(*degrees: float) -> str:
    halves = [math.radians(angle) / 2 for angle in degrees]
    return "".join(f"{i} 0 0 0 0 0 {math.sin(half)!r} {math.cos(half)!r}\n" for i, half in enumerate(halves))


def refusal(data: bytes, layout: str, max_gap: float | None = None) -> TrajectoryError:
    with pytest.raises(TrajectoryError) as caught:
        read_trajectory(data, layout, max_gap)
    return caught.value


def test_a_tum_file_is_read_pose_by_pose() -> None:
    found = tum(TUM)
    assert found.times.tolist() == [0.5, 1.5, 2.25]
    assert found.translations.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    np.testing.assert_allclose(found.quaternions, [[1, 0, 0, 0], [0, 1, 0, 0], [-0.8, 0, 0.6, 0]], rtol=0, atol=2e-16)
    assert found.lines.tolist() == [2, 4, 5]
    assert found.exact_times == (Decimal("0.5"), Decimal("1.5"), Decimal("2.25"))


def test_arrays_are_float64_and_read_only() -> None:
    for found in (
        tum(TUM),
        tum(TUM).in_scene_time("first", 0.0),
        csv("t,x,y,z\n0,1,2,3\n"),
        csv(f"t,x,y,z,{TURNED}\n0,0,0,0,1,0,0,0"),
    ):
        for array in (found.times, found.translations, found.quaternions):
            assert array.dtype == np.float64
            assert array.flags.c_contiguous
            assert not array.flags.writeable
        assert found.lines.dtype == np.int64
        assert not found.lines.flags.writeable


@pytest.mark.parametrize(
    "text",
    [
        TUM,
        TUM.replace("\n", "\r\n"),
        TUM.replace("\n", "\r"),
        "\ufeff" + TUM,
        TUM.replace(" ", "\t  "),
        TUM.rstrip("\n"),
        TUM.replace("0 0 0 1\n", "0 0 0 1 # the first, déjà_vu\n"),
        TUM.replace("# timestamp tx", "  # \u2028 naïve"),
        TUM.replace("0.5 ", "+5.e-1 ").replace(" 7 ", " 0.7E+1 ").replace("0.6", ".6"),
        TUM.replace(" 0.6 0 ", " 0.6 -1e-99999999999999999999 "),
    ],
)
def test_however_a_tum_file_is_spelt_it_holds_the_same(text: str) -> None:
    found, expected = tum(text), tum(TUM)
    assert found.times.tolist() == expected.times.tolist()
    assert found.translations.tolist() == expected.translations.tolist()
    assert found.quaternions.tolist() == expected.quaternions.tolist()
    assert found.lines.tolist() == expected.lines.tolist()


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("t,x,y,z\n0,1,2,3\n1,4,5,6\n", [2, 3]),
        ("t;x;y;z\n0;1;2;3\n1;4;5;6\n", [2, 3]),
        ("t\tx\ty\tz\n0\t1\t2\t3\n1\t4\t5\t6\n", [2, 3]),
        ("\ufeffTime, TX ,tY,Z\r\n0, 1, 2 ,3\r\n1,4,5,6\r\n", [2, 3]),
        ("z,timestamp,y,x\n3,0,2,1\n6,1,5,4", [2, 3]),
        ('"t","x","y","z"\n"0","1","2","3"\n\n1,4,5,6\n', [2, 4]),
        ('t,x,y,z\n"0",1,2,"\n3"\n1,4,5,6\n', [2, 4]),
        ('# made by hand, "t\n\nt,x,y,z\n0,1,2,3\n# "half, way\n1,4,5,6\n,,,\n ,,,\n', [4, 6]),
        ("# t,x,y,z\n0,1,2,3\n1,4,5,6\n", [2, 3]),
        ("#t;x;y;z\n0;1;2;3\n1;4;5;6\n", [2, 3]),
        ('t,x,note,y,z,\n0,1,"a, b ""c""",2,3,\n1,4,nan,5,6,\n', [2, 3]),
        ("\tt\tx\ty\tz\n0\t0\t1\t2\t3\n1\t1\t4\t5\t6\n", [2, 3]),
    ],
)
def test_however_a_csv_file_is_spelt_it_holds_the_same(text: str, lines: list[int]) -> None:
    found = csv(text)
    assert found.times.tolist() == [0, 1]
    assert found.translations.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert found.quaternions.tolist() == [[1, 0, 0, 0]] * 2
    assert found.lines.tolist() == lines


def test_columns_come_in_any_order() -> None:
    cells = {"t": "2", "x": "3", "y": "4", "z": "5", "qw": "0.1", "qx": "-0.7", "qy": "0.1", "qz": "-0.7"}
    for order in list(permutations(cells))[::997]:
        found = csv(f"{','.join(order)}\n{','.join(cells[name] for name in order)}\n")
        assert (found.times[0], *found.translations[0]) == (2, 3, 4, 5)
        np.testing.assert_allclose(found.quaternions[0], [0.1, -0.7, 0.1, -0.7], rtol=1e-15)


@pytest.mark.parametrize("layout", ["tum", "csv"])
def test_random_poses_come_back_as_they_were_written(layout: str) -> None:
    rng = np.random.default_rng(7)
    times = np.cumsum(rng.uniform(1e-3, 1.0, 5000)) + 1.3e9
    places, turns = rng.normal(size=(5000, 3)) * 1e3, Rotation.random(5000, rng=rng)
    rows = np.column_stack((times, places, turns.as_quat()))
    separator = " " if layout == "tum" else ","
    text = "\n".join(separator.join(map(repr, row)) for row in rows.tolist())
    found = read_trajectory(("" if layout == "tum" else "t,x,y,z,qx,qy,qz,qw\n").encode() + text.encode(), layout, None)
    assert found.times.tolist() == times.tolist()
    assert found.translations.tolist() == places.tolist()
    np.testing.assert_allclose(found.quaternions, turns.as_quat(scalar_first=True), rtol=0, atol=1e-15)
    assert np.abs(np.linalg.norm(found.quaternions, axis=1) - 1).max() < 5e-16


@pytest.mark.parametrize("unit", ["rad", "deg"])
def test_roll_pitch_yaw_turn_about_fixed_axes(unit: str) -> None:
    rng = np.random.default_rng(8)
    angles = rng.uniform(-400, 400, (1000, 3)) if unit == "deg" else rng.uniform(-7, 7, (1000, 3))
    text = "t,x,y,z,roll,pitch,yaw\n" + "\n".join(
        f"{i},0,0,0,{r!r},{p!r},{y!r}" for i, (r, p, y) in enumerate(angles.tolist())
    )
    found = csv(text, radians_per_unit=math.radians(1.0) if unit == "deg" else 1.0)
    expected = Rotation.from_euler("xyz", angles, degrees=unit == "deg").as_matrix()
    got = Rotation.from_quat(found.quaternions, scalar_first=True).as_matrix()
    np.testing.assert_allclose(got, expected, rtol=0, atol=3e-15)


def test_times_from_the_first_pose_are_the_nearest_to_the_decimals_differences() -> None:
    found = tum(tum_at("1305031098.6659", "1305031098.6758", "1305031102.1758"))
    assert found.times.tolist() == [1305031098.6659, 1305031098.6758, 1305031102.1758]
    assert (found.times[1] - found.times[0]) != 0.0099
    assert found.in_scene_time("first", 0.0).times.tolist() == [0, 0.0099, 3.5099]
    assert found.in_scene_time("first", 0.0).in_scene_time("first", 0.0).times.tolist() == [0, 0.0099, 3.5099]


def test_random_times_are_shifted_exactly() -> None:
    rng = random.Random(9)
    for scale in (9, 15, 2, -3):
        values = sorted(rng.sample(range(10**17, 10**18), 500))
        texts = [f"{value // 10**17}.{value % 10**17:017d}e{scale - 1:+d}" for value in values]
        shifted = tum(tum_at(*texts)).in_scene_time("first", 0.0).times
        unit = Fraction(10) ** (scale - 18)
        assert shifted.tolist() == [float((value - values[0]) * unit) for value in values]


def test_wide_ranges_of_times_are_shifted_without_losing_order() -> None:
    found = tum(tum_at("-1e-50", "1e-50", "1e15")).in_scene_time("first", 0.0)
    assert found.times.tolist() == [0, 2e-50, 1e15]
    fault = refusal(tum_at("-1e15", "1e-50", "2e-50").encode(), "tum")
    assert (fault.line, fault.message) == (
        3,
        "lines 2 and 3 are 1e-50 s apart, too little to be told apart beside the file's other times",
    )


def test_numbers_that_are_nearly_nothing_are_the_nearest_floats() -> None:
    found = csv(f"t,x,y,z,{TURNED}\n-0,1e-61,-1e-400,-0.0,1,0,1e-99,0\n")
    assert found.translations[0].tolist() == [1e-61, 0, 0]
    assert found.quaternions[0].tolist() == [1, 0, 1e-99, 0]
    assert not np.signbit(found.translations[0]).any()
    assert found.times[0] == 0
    assert tum(tum_at("0e999999999999999999999", "1")).times.tolist() == [0, 1]


@pytest.mark.parametrize(
    ("text", "line", "phrase"),
    [
        ("", None, "no poses"),
        ("# nothing\n\n", None, "no poses"),
        ("0 0 0 0 0 0 0\n", 1, "expected 8 columns (timestamp tx ty tz qx qy qz qw), got 7"),
        (tum_at("0") + "1 0 0 0 0 0 0 1 9\n", 2, "got 9"),
        (tum_at("0") + "\n1 0 x 0 0 0 0 1\n2\n3 0 0 0 0 0 0 1,\n", 3, "expected a number in ty, got 'x' (and 2 more)"),
        ("0 0 0 0 0 0 1_0 1\n", 1, "expected a number in qz, got '1_0'"),
        ("0 0 0 0 0 0 ٠ 1\n", 1, "expected a number in qz"),
        ("0 0 0 0 0 0 0x1 1\n", 1, "got '0x1'"),
        ("0 0 0 0 0 0 \0 1\n", 1, r"got '\x00'"),
        ("0 0 0 0,5 0 0 0 1\n", 1, "got '0,5' (write the decimal point as '.')"),
        ("nan 0 0 0 0 0 0 1\n", 1, "expected a finite number in timestamp, got 'nan'"),
        (tum_at("0") + "1 0 0 -INF 0 0 0 1\n", 2, "expected a finite number in tz, got '-INF'"),
        ("0 1e400 0 0 0 0 0 1\n", 1, "expected numbers up to 1e+15 in tx, got '1e400'"),
        ("0 0 -1.1e15 0 0 0 0 1\n", 1, "expected numbers up to 1e+15 in ty"),
        (tum_at("1403715529112143517"), 1, "times up to 1e+15 s, got '1403715529112143517' (is it in nanoseconds?)"),
        (tum_at("0." + "1" * 99), 1, "expected a time of up to 100 characters, got 101"),
        (tum_at("0", "0.1", "0.1"), 3, "lines 2 and 3 are both at 0.1 s, expected one pose at a time"),
        (tum_at("0", "1", "1.0", "10e-1", "0.5"), 3, "one pose at a time, or duplicates: first or last (and 2 more)"),
        (tum_at("0", "0.2") + "#\n" + tum_at("0.1"), 4, "expected a time after that of line 2 (0.2 s), got 0.1 s"),
        (tum_at("1305031098.66590001", "1305031098.66590002"), 2, "lines 1 and 2 are 1e-08 s apart, too little"),
        ("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1.0011\n", 2, "expected a unit quaternion, got one of length 1.0011"),
        ("0 0 0 0 0 0 0 0.9989\n", 1, "length 0.9989"),
        ("0 0 0 0 0 0 0 0\n", 1, "length 0"),
        ("0 0 0 0 1e15 1e15 1e15 1e15\n", 1, "length 2"),
        ("0 0 0 0 0 0 0 2\n-1 0 0 0 0 0 0 3\n", 1, "length 2 (and 2 more)"),
    ],
)  # fmt: skip
def test_bad_tum_files_are_refused_at_their_line(text: str, line: int | None, phrase: str) -> None:
    fault = refusal(text.encode(), "tum")
    assert phrase in fault.message
    assert fault.line == line
    assert fault.message.isprintable()


@pytest.mark.parametrize(
    ("text", "line", "phrase"),
    [
        ("", None, "the file is empty"),
        ("\n# a remark, and another\n", None, "the file is empty"),
        ("t,x,y,z\n", None, "no poses"),
        ("0,1,2,3\n", 1, "expected a header that names the columns t, x, y, z"),
        ("t x y z\n0 1 2 3\n", 1, "separated by commas, semicolons or tabs, got 't x y z'"),
        ('"t\nx"\n', 1, "expected a header"),
        ("\nx,y,z\n1,2,3\n", 2, "the header lacks t"),
        ("tme,x,y,z\n", 1, "the header lacks t; it has 'tme' (did you mean 'time'?)"),
        ("t,x,y\n", 1, "the header lacks z"),
        (f"t,x,y,z,{TURNED[:-3]}\n", 1, "the header lacks qz"),
        ("t,x,y,z,qw,qx,qy,q_z\n", 1, "the header lacks qz; it has 'q_z' (did you mean 'qz'?)"),
        ("t,x,y,z,roll,Pitch\n", 1, "the header lacks yaw"),
        (f"t,x,y,z,{TURNED},yaw\n", 1, "a quaternion and roll, pitch, yaw, expected one of them"),
        ("t,x,y,z,Time\n", 1, "the header names t twice, as 't' and as 'Time'"),
        ("t,x,tx,y,z\n", 1, "the header names x twice, as 'x' and as 'tx'"),
        ("t,x,y,z\n0,1,2\n", 2, "expected 4 columns as in the header, separated by commas, got 3"),
        ("t;x;y;z\n0;1;2;3\n1,1,2,3\n", 3, "separated by semicolons, got 1"),
        ("t;x;y;z\n0;1,5;2;3\n", 2, "expected a number in 'x', got '1,5' (write the decimal point as '.')"),
        ("t,x,y,Z \n\n0,1,2,\n", 3, "expected a number in 'Z', got nothing"),
        ('t,x,y,z\n0,1,2,3\n1,1,2,"3\n4,5,6,7\n', 4, "cannot be read as CSV"),
        ('t,x,y,z\n0,1,2,"3"4\n', 2, "cannot be read as CSV"),
        ("t,x,y,z\n0,1,2," + "3" * 200_000 + "\n", 2, "cannot be read as CSV: field larger"),
        ('t,x,y,z,n\n0,1,2,3,"\n\n"\n0,1,2,3,4', 5, "lines 2 and 5 are both at 0 s"),
        (f"t,x,y,z,{TURNED}\n0,1,2,3,1,0,0,0\n1,1,2,3,1,0,0,1\n", 3, "got one of length 1.41421"),
    ],
)
def test_bad_csv_files_are_refused_at_their_line(text: str, line: int | None, phrase: str) -> None:
    fault = refusal(text.encode(), "csv")
    assert phrase in fault.message
    assert fault.line == line
    assert fault.message.isprintable()


@pytest.mark.parametrize("layout", ["tum", "csv"])
@pytest.mark.parametrize(
    ("tail", "line", "byte"),
    [(b"\xff", 3, "ff"), (b"\r\n\n\r# caf\xe9 \n", 6, "e9"), (b"# \xe2\x82", 3, "e2"), (b"\x80" * 99999, 3, "80")],
)
def test_what_is_no_utf8_is_refused_at_its_line(layout: str, tail: bytes, line: int, byte: str) -> None:
    head = tum_at("0", "1").encode() if layout == "tum" else b"t,x,y,z\n0,1,2,3\n"
    fault = refusal(head + tail, layout)
    assert (fault.line, fault.message) == (line, f"expected UTF-8 text, got the byte 0x{byte}")


def test_a_tab_after_a_quoted_cell_is_told_in_one_printable_line() -> None:
    with pytest.raises(TrajectoryError) as caught:
        read_trajectory(b't\tx\ty\tz\n0\t"1\t"2\t3\t4\n', "csv")
    assert caught.value.message == "the row cannot be read as CSV: '\\t' expected after '\"'"


def test_a_gap_is_measured_in_the_files_decimals() -> None:
    text = "#\n" + tum_at("1305031098.1", "1305031098.2", "1305031098.3", "1305031098.6")
    assert len(tum(text, max_gap=0.3).times) == 4
    fault = refusal(text.encode(), "tum", max_gap=0.1)
    assert (fault.line, fault.message) == (5, "lines 4 and 5 are 0.3 s apart, expected at most 0.1 s (max_gap)")
    assert refusal(text.encode(), "tum", max_gap=0.0999999).message.endswith("(and 2 more)")
    assert len(tum(tum_at("3"), max_gap=1e-15).times) == 1


def test_faults_are_told_from_the_start_of_the_file_whatever_their_kind() -> None:
    rows = ["0 0 0 0 0 0 0 1", "5 0 0 0 0 0 0 1", "6 0 0 0 0 0 0 2", "6 0 0 0 0 0 0 1"]
    fault = refusal("\n".join(rows).encode(), "tum", max_gap=2.0)
    assert (fault.line, fault.message) == (
        2,
        "lines 1 and 2 are 5 s apart, expected at most 2 s (max_gap) (and 2 more)",
    )


def test_faults_far_into_a_long_file_are_told_by_their_line() -> None:
    rows = [f"{i} 0 0 0 0 0 0 1" for i in range(20_000)]
    rows[17_171] = rows[17_171].replace("0 0", "0 O", 1)
    fault = refusal("\n".join(rows).encode(), "tum")
    assert (fault.line, "got 'O'" in fault.message) == (17_172, True)


def test_a_file_beyond_the_limit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    assert trajectories.LARGEST_TRAJECTORY == 256 * 2**20
    monkeypatch.setattr(trajectories, "LARGEST_TRAJECTORY", len(TUM) - 1)
    assert refusal(TUM.encode(), "tum").message == f"the file has {len(TUM)} bytes, expected up to {len(TUM) - 1}"


def test_an_unknown_layout_is_the_callers_mistake() -> None:
    with pytest.raises(ValueError, match="unknown layout 'ros'"):
        read_trajectory(b"", "ros", None)


def test_columns_that_are_left_out_are_named() -> None:
    assert csv("t,x,y,z\n0,0,0,0\n").warnings == ()
    assert csv(f"t,x,y,z,{TURNED},vx,Note\n0,0,0,0,1,0,0,0,9,\n").warnings == (
        "has columns that are left out: 'vx', 'Note'",
    )
    (unturned,) = csv("t,x,y,z,q_w\n0,0,0,0,1\n").warnings
    assert unturned == "has columns that are left out: 'q_w' (did you mean 'qw'?), and no rotation"
    many = csv("t,x,y,z" + ",w" * 500 + "\n0,0,0,0" + ",1" * 500).warnings[0]
    assert "and 492 more" in many
    assert len(many) < 300


def test_lengths_off_1_are_told_and_normalised() -> None:
    rows = ["0 0 0 0 0 0 0 1", "1 0 0 0 0 0 0 1.000009", "2 0 0 0 0 0 0.6004 0.8", "3 0 0 0 0 0 0 0.9999"]
    found = tum("#\n" + "\n".join(rows))
    assert found.loose == "has 2 quaternions whose length is off 1, by up to 0.00024 in line 4"
    assert found.stretch == pytest.approx(0.6004**2 + 0.8**2 - 1.0)
    assert found.warnings == ()
    assert np.abs(np.linalg.norm(found.quaternions, axis=1) - 1).max() < 3e-16
    assert found.quaternions[2, 3] / found.quaternions[2, 0] == pytest.approx(0.6004 / 0.8, rel=1e-15)


def test_wide_turns_between_poses_are_told() -> None:
    assert tum(turned_by(0, 149, 0, 149)).turns == ()
    (wide,) = tum(turned_by(0, 10, 161, 0)).turns
    assert wide.startswith("lines 2 and 3 are 151.0 degrees apart (and 1 more such): the shorter way is taken")
    ambiguous, wide = tum(turned_by(0, 180, 20)).turns
    assert ambiguous == "lines 1 and 2 are 180.0 degrees apart: which way round is ambiguous, add a pose between"
    assert wide == "lines 2 and 3 are 160.0 degrees apart: the shorter way is taken, is a pose missing?"
    assert tum("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 -1\n").turns == ()


NANOSECONDS = b"#timestamp\n1403636580838555648,1,2,3,1,0,0,0,5\n1403636580843555328,1,2,3,0,1,0,0,6\n"
SEEDS = [
    ("euroc", NANOSECONDS),
    ("kitti", b"1 0 0 1 0 1 0 2 0 0 1 3\n0 -1 0 4 1 0 0 5 0 0 1 6\n"),
    ("tum", TUM.encode()),
    ("tum", tum_at("1.403715529112143517e+09", "1.403715529212142944e+09").encode()),
    ("tum", b"t,x,y,z\n0,1,2,3\n"),
    ("csv", b"t,x,y,z\n0,1,2,3\n1,4,5,6\n"),
    ("csv", b't;qw;qx;qy;qz;x;y;z;"n"\r\n0;1;0;0;0;1;2;3;"a;b"\r\n1;1;0;0;0;4;5;6;c\r\n'),
    ("csv", b"\xef\xbb\xbftime\ttx\tty\ttz\troll\tpitch\tyaw\n0\t1\t2\t3\t10\t20\t30\n.5\t1\t2\t3\t11\t22\t33\n"),
]
PIECES = [
    *(b"nan", b"-inf", b"1e400", b"1e-400", b"1_0", b"\xff", b"\0", b'"', b"\n", b"\r", b"#", b",", b";", b"\t", b" "),
    *(b".", b"e", b"-", b"9" * 120, b"1e999999999999999999999", b"0e-99999999999999999999", b"\xc2\xa0", b"\xd9\xa1"),
    *(b"qw", b"yaw", b"\xe2\x80\xa8", b"\x1c", b"\x0b", b"1e15", b"1e-61", b"sNaN", b"Infinity", b"x", b"1", b"00"),
]  # fmt: skip


def mutated(data: bytes, rng: random.Random) -> bytes:
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        at = rng.randint(0, len(data))
        match rng.randint(0, 4):
            case 0:
                data = data[:at] + rng.choice(PIECES) + data[at:]
            case 1:
                data = data[:at] + data[at + rng.randint(1, 3) :]
            case 2:
                data = data[:at] + rng.choice(PIECES) + data[at + 1 :]
            case 3:
                data = data[: max(0, at + rng.randint(-9, 9))] + data[at:]
            case _:
                data = data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :]
    return data


def read_or_refused(data: bytes, layout: str, max_gap: float | None) -> Trajectory | TrajectoryError:
    try:
        with time_limited():
            clock = Decimal("0.1") if layout == "kitti" else None
            return read_trajectory(data, layout, max_gap, 0.017, clock=clock)
    except TrajectoryError as error:
        return error


@pytest.mark.parametrize("count", [6000, pytest.param(100_000, marks=pytest.mark.deep)])
def test_whatever_a_file_holds_it_is_read_or_refused(count: int) -> None:
    rng = random.Random(10)
    read = 0
    for _ in range(count):
        layout, seed = rng.choice(SEEDS)
        data = mutated(seed, rng)
        found = read_or_refused(data, layout, rng.choice((None, 1.0)))
        if isinstance(found, TrajectoryError):
            assert found.message.isprintable()
            assert len(found.message) < 300
            assert found.line is None or 1 <= found.line <= data.count(b"\n") + data.count(b"\r") + 1
            continue
        read += 1
        for one in (found, found.in_scene_time("first", 0.0)):
            assert np.all(np.diff(one.times) > 0)
            assert np.isfinite(one.translations).all()
            assert np.abs(np.linalg.norm(one.quaternions, axis=1) - 1).max() < 1e-15
            assert [float(time) for time in one.exact_times] == one.times.tolist()
        assert len(found.times) == len(found.translations) == len(found.quaternions) == len(found.lines)
    assert read > count // 10


@needs_shared
@pytest.mark.parametrize(("file", "loose"), [("freiburg1_xyz-groundtruth.txt", True), ("georeferenced.tum", False)])
def test_trajectories_from_the_field_are_read_as_numpy_reads_them(file: str, loose: bool) -> None:
    path = SHARED / "traj" / file
    expected = np.loadtxt(path)
    found = read_trajectory(path.read_bytes(), "tum", None)
    assert found.times.tolist() == expected[:, 0].tolist()
    assert found.translations.tolist() == expected[:, 1:4].tolist()
    unit = expected[:, [7, 4, 5, 6]] / np.linalg.norm(expected[:, 4:], axis=1)[:, None]
    np.testing.assert_allclose(found.quaternions, unit, rtol=0, atol=3e-16)
    stamps = [line.split()[0] for line in path.read_text().splitlines() if not line.startswith("#")]
    exact = [float(Fraction(stamp) - Fraction(stamps[0])) for stamp in stamps]
    assert found.in_scene_time("first", 0.0).times.tolist() == exact
    assert ("whose length is off 1" in found.loose) == loose


@needs_shared
def test_a_trajectory_from_the_field_with_equal_stamps_is_refused() -> None:
    fault = refusal((SHARED / "traj" / "V102.txt").read_bytes(), "tum")
    assert fault.line == 433
    assert (
        fault.message == "lines 432 and 433 are both at 1403715572.2121432 s, expected one pose at a time, "
        "or duplicates: first or last (and 3 more)"
    )


@needs_shared
def test_frames_from_the_field_are_read() -> None:
    data = (SHARED / "fcl" / "manyframes_a.csv").read_bytes()
    found = read_trajectory(data, "csv", 0.01)
    expected = np.loadtxt(data.decode().splitlines(), delimiter=",", skiprows=1)
    assert np.column_stack((found.times, found.translations, found.quaternions)).tolist() == expected.tolist()
    assert found.warnings == ()
    assert refusal(data, "csv", 0.0099).message.startswith("lines 2 and 3 are 0.01 s apart")


@needs_shared
@pytest.mark.parametrize("layout", ["tum", "csv"])
def test_files_of_other_kinds_are_refused(layout: str) -> None:
    files = [
        path
        for folder in ("meshes", "gltf", "gears")
        for path in sorted((SHARED / folder).rglob("*"))
        if path.is_file()
    ]
    files += [SHARED / "traj" / "fetch_path.yml", SHARED / "fcl" / "manyframes_a.obj"]
    for path in files:
        refusal(path.read_bytes(), layout)
