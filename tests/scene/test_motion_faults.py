"""Motions that are grammatical and yet cannot be: directions, keys, times that do not fit, each told at its place."""

from __future__ import annotations

from pathlib import Path

import pytest
from scene_files import HEAD, MOTION, fault, faults, load

ORBIT = "{type: orbit, axis: [0, 0, 2], radius: 1, rate: 1, start: "
PROFILE = "from: 0, to: 5, max_velocity: 1, max_acceleration: 1}"


def keyframes(keys: str, options: str = "") -> str:
    return f"{MOTION}{{type: keyframes, {options}keys: [{keys}]}}\n"


@pytest.mark.parametrize(
    ("motion", "begin", "phrase"),
    [
        (
            "{type: screw, axis: [0, 0, 0], rate: 1}",
            "6:33: bodies.a.motion.axis: ",
            "expected a direction, got the zero vector",
        ),
        (
            "{type: harmonic, direction: [0, 0, 1e-320], amplitude: 1, period: 1}",
            "6:41: bodies.a.motion.direction: ",
            "got a vector of length 1e-320, too short for its digits: multiply it by 1e300",
        ),
        ("{type: swing, axis: [0, 0, 0], amplitude: 1, period: 1}", "6:33: bodies.a.motion.axis: ", "the zero vector"),
        (f"{{type: profile, kind: turn, axis: [0, 0, 0], {PROFILE}", "6:47: bodies.a.motion.axis: ", "the zero vector"),
        (ORBIT.replace("2", "0") + "[1, 0, 0]}", "6:33: bodies.a.motion.axis: ", "the zero vector"),
        (ORBIT + "[0, 0, 0]}", "6:71: bodies.a.motion.start: ", "the zero vector"),
        (
            ORBIT + "[1, 0, 1]}",
            "6:71: bodies.a.motion.start: ",
            "expected a direction perpendicular to the axis, got one at 45 degrees to it",
        ),
        (ORBIT + "[0, 0, -1]}", "6:71: bodies.a.motion.start: ", "got one at 180 degrees to it"),
        (ORBIT + "[1, 0, 2e-6]}", "6:71: bodies.a.motion.start: ", "got one at 89.9999 degrees to it"),
        (
            f"{{type: profile, kind: slide, axis: [1, 0, 0], point: [0, 0, 0], {PROFILE}",
            "6:66: bodies.a.motion.point: ",
            "a slide has no point, leave the key out (or is it a turn?)",
        ),
    ],
)
def test_a_senseless_direction_or_point_is_refused(tmp_path: Path, motion: str, begin: str, phrase: str) -> None:
    told = faults(tmp_path, MOTION + motion)
    assert told[0].startswith(begin)
    assert phrase in told[0]


def test_a_start_within_a_millionth_of_perpendicular_is_accepted(tmp_path: Path) -> None:
    load(tmp_path, f"{MOTION}{ORBIT}[1, 0, 9e-7]}}")


@pytest.mark.parametrize(
    ("text", "begin", "phrase"),
    [
        (keyframes("{t: 0}, {t: 1}, {t: 0.5}"), "6:58: bodies.a.motion.keys[2].t: ", "before it (1 s), got 0.5 s"),
        (
            keyframes("{t: 0}, {t: 0}, {t: 1}"),
            "6:50: bodies.a.motion.keys[1].t: ",
            "two keys at 0 s, expected one pose at a time",
        ),
        (
            keyframes("{t: 0.5}, {t: 1}"),
            "6:42: bodies.a.motion.keys[0].t: ",
            "expected the first pose at 0 s or before, or say before: hold or loop, got 0.5 s",
        ),
        (
            keyframes("{t: 0}, {t: 0.9}"),
            "6:50: bodies.a.motion.keys[1].t: ",
            "expected the last pose at 1 s or after, or say after: hold or loop, got 0.9 s",
        ),
        (
            keyframes("{t: 0}, {t: 1}", "t0: 0.25, "),
            "6:52: bodies.a.motion.keys[0].t: ",
            "expected the first pose at 0 s or before, or say before: hold or loop, got 0.25 s",
        ),
        (keyframes("{t: 0}, {t: 1}", "t0: -0.25, "), "6:61: bodies.a.motion.keys[1].t: ", "got 0.75 s"),
        (
            keyframes("{t: 0}, {t: 1e-9}", "t0: 1e9, before: hold, after: hold, "),
            "6:35: bodies.a.motion.t0: ",
            "times so near to each other are equal once 1000000000 s is added",
        ),
        (keyframes("{t: 0, quat_wxyz: [2, 0, 0, 0]}, {t: 1}"), "6:56: bodies.a.motion.keys[0].quat_wxyz: ", "length 2"),
        (
            keyframes("{t: 0}", "before: hold, after: loop, "),
            "6:52: bodies.a.motion.after: ",
            "one pose cannot be repeated, expected two or more, or hold",
        ),
        (keyframes("{t: 1}", "before: loop, "), "6:39: bodies.a.motion.before: ", "one pose cannot be repeated"),
        (
            keyframes("{t: 0, velocity: [1, 0, 0]}, {t: 1, velocity: [1, 0, 0]}"),
            "6:55: bodies.a.motion.keys[0].velocity: ",
            "a key's velocity needs interpolation: {translation: cubic}, or leave it out",
        ),
        (
            keyframes("{t: 0}, {t: 0.5, velocity: [1, 0, 0]}, {t: 1}", "interpolation: {translation: cubic}, "),
            "6:102: bodies.a.motion.keys[1].velocity: ",
            "expected a velocity at every key or at none, key 0 has none",
        ),
        (
            keyframes("{t: 0, name: ''}, {t: 1}"),
            "6:51: bodies.a.motion.keys[0].name: ",
            "expected a name, got a blank one",
        ),
        (
            keyframes("{t: 0, name: a/b}, {t: 1}"),
            "6:51: bodies.a.motion.keys[0].name: ",
            "the character / is not allowed in a name",
        ),
        (keyframes('{t: 0, name: "a\\u202e"}, {t: 1}'), "6:51: bodies.a.motion.keys[0].name: ", "U+202E"),
    ],
)
def test_keys_that_do_not_fit_are_refused_at_their_place(tmp_path: Path, text: str, begin: str, phrase: str) -> None:
    line = fault(tmp_path, text)
    assert line.startswith(begin)
    assert phrase in line


def test_every_key_out_of_order_is_told(tmp_path: Path) -> None:
    told = faults(tmp_path, keyframes("{t: 0}, {t: 2}, {t: 1}, {t: 1}, {t: 0.5}, {t: 3}"))
    assert [line.split(": ")[1] for line in told] == [f"bodies.a.motion.keys[{i}].t" for i in (2, 3, 4)]


def test_before_and_after_say_what_happens_where_there_are_no_keys(tmp_path: Path) -> None:
    for word in ("hold", "loop"):
        load(tmp_path, keyframes("{t: 0.4}, {t: 0.6}", f"before: {word}, after: {word}, "))
        assert len(faults(tmp_path, keyframes("{t: 0.4}, {t: 0.6}", f"before: {word}, "))) == 1
        assert len(faults(tmp_path, keyframes("{t: 0.4}, {t: 0.6}", f"after: {word}, "))) == 1


def test_keys_that_repeat_faster_than_the_scenes_time_can_tell_are_refused(tmp_path: Path) -> None:
    head = HEAD.replace("end: 1}", "end: 1e9}\nsettings: {contact_tolerance: 1e-3}")
    motion = "{type: keyframes, after: loop, keys: [{t: 0}, {t: 1e-7, xyz: [1, 0, 0]}]}"
    line = fault(tmp_path, f"{head}bodies: {{a: {{motion: {motion}}}}}")
    assert line.startswith("5:47: bodies.a.motion.after: ")
    assert "poses over 1e-07 s are too short a loop for the scene's time, expected at least 7.62939e-06 s" in line
    load(tmp_path, f"{head}bodies: {{a: {{motion: {motion.replace('1e-7', '1e-5')}}}}}")


@pytest.mark.parametrize(
    ("span", "begin", "phrase"),
    [
        ("[1, 1]", "4:26: bodies.a.exists[1]: ", "expected to exist until after it begins (1 s), got 1 s"),
        ("[0.5, 0.25]", "4:28: bodies.a.exists[1]: ", "expected to exist until after it begins (0.5 s), got 0.25 s"),
        ("[1, 2]", "4:22: bodies.a.exists: ", "the body never exists within the scene's time, 0 to 1 s"),
        ("[-3, 0]", "4:22: bodies.a.exists: ", "the body never exists within the scene's time, 0 to 1 s"),
    ],
)
def test_a_body_must_exist_for_some_of_the_time(tmp_path: Path, span: str, begin: str, phrase: str) -> None:
    line = fault(tmp_path, f"{HEAD}bodies: {{a: {{exists: {span}}}}}")
    assert line.startswith(begin)
    assert phrase in line


def test_keys_need_cover_only_the_time_in_which_the_body_or_what_it_carries_exists(tmp_path: Path) -> None:
    keys = "motion: {type: keyframes, keys: [{t: 0.2}, {t: 0.6}]}"
    load(tmp_path, f"{HEAD}bodies:\n  a: {{exists: [0.25, 0.5], {keys}}}\n")
    told = faults(
        tmp_path,
        f"{HEAD}bodies:\n  a: {{exists: [0.25, 0.5], {keys}}}\n"
        "  b: {parent: a, exists: [0.5, 0.75]}\n  c: {parent: b, exists: [0.1, 0.5]}\n",
    )
    assert [line.split(": ")[1] for line in told] == ["bodies.a.motion.keys[0].t", "bodies.a.motion.keys[1].t"]
    assert "at 0.1 s or before" in told[0]
    assert "at 0.75 s or after" in told[1]


@pytest.mark.parametrize(
    "motion",
    [
        "{type: polynomial, coefficients: [[0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0]]}",
        f"{{type: polynomial, coefficients: [{', '.join(['[1e15, 1e15, 1e15]'] * 21)}], t0: 1e15}}",
        "{type: ballistic, velocity: [1, 0, 0], acceleration: [0, 0, -1e15]}",
    ],
)
def test_a_motion_that_leaves_the_world_is_refused(tmp_path: Path, motion: str) -> None:
    head = HEAD.replace("end: 1}", "end: 1e12}\nsettings: {contact_tolerance: 1, time_resolution: 1}")
    line = fault(tmp_path, f"{head}bodies:\n  a:\n    motion: {motion}\n    shapes: [{{sphere: 1}}]\n")
    assert line.startswith("7:13: bodies.a.motion: ")
    assert "m within the scene's time, expected at most 1e+30 m" in line
