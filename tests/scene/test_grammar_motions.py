"""What the grammar of motions accepts, what it refuses and in which words."""

from __future__ import annotations

from pathlib import Path

import pytest
from scene_files import MOTION, faults, load

KEYS = "keys: [{t: 0}, {t: 1}]"


@pytest.mark.parametrize(
    "motion",
    [
        "{type: constant}",
        "{type: constant, velocity: [1, 2, 3], angular_velocity: [0, 0, 1e-3], t0: -0.5}",
        "{type: ballistic, velocity: [1, 2, 3], acceleration: [0, 0, -9.81], angular_velocity: [0, 0, 1]}",
        "{type: screw, axis: [0, 0, 1], point: [1, 0, 0], rate: 90, pitch: 0.01}",
        "{type: screw, axis: [0, 0, 1], rate: 90}",
        "{type: orbit, axis: [0, 0, 1], start: [1, 0, 0], radius: 2, rate: 90, phase: 5, facing: true}",
        "{type: orbit, axis: [0, 0, 1], start: [1, 0, 0], radius: 2, rate: -90}",
        "{type: harmonic, direction: [1, 0, 0], amplitude: 0.4, period: 2, phase: 90}",
        "{type: harmonic, direction: [1, 0, 0], amplitude: 0.4, period: 2}",
        "{type: swing, axis: [0, 1, 0], point: [0, 0, 1], amplitude: 60, period: 0.7, phase: 1}",
        "{type: polynomial, coefficients: [[1, 2, 3]]}",
        f"{{type: polynomial, coefficients: [{', '.join(['[0, 0, 1]'] * 21)}], angular_velocity: [0, 0, 1]}}",
        "{type: profile, kind: slide, axis: [1, 0, 0], from: 0, to: 5, max_velocity: 1, max_acceleration: 1}",
        "{type: profile, kind: turn, axis: [1, 0, 0], point: [1, 2, 3], from: 9, to: 9, max_velocity: 1, "
        "max_acceleration: 1, t0: 0.5}",
        "{type: keyframes, keys: [{t: 0}, {t: 1, xyz: [1, 2, 3], quat_wxyz: [1, 0, 0, 0]}]}",
        f"{{type: keyframes, {KEYS}, interpolation: {{translation: step, rotation: step}}}}",
        "{type: keyframes, keys: [{t: 0.5, name: home}], before: hold, after: hold}",
        f"{{type: keyframes, {KEYS}, before: loop, after: loop, t0: 3, interpolation: {{translation: cubic}}}}",
    ],
)
def test_every_motion_is_accepted_with_each_of_its_keys(tmp_path: Path, motion: str) -> None:
    load(tmp_path, MOTION + motion)


@pytest.mark.parametrize(
    ("motion", "begin", "phrase"),
    [
        ("fast", "6:13: bodies.a.motion: ", "expected a mapping with the key 'type', got 'fast'"),
        ("{}", "6:5: bodies.a.motion: ", "missing key 'type', expected one of constant, ballistic, screw, orbit"),
        ("{type: 5}", "6:20: bodies.a.motion.type: ", "unknown motion 5, expected constant"),
        ("{type: [a]}", "6:20: bodies.a.motion.type: ", "unknown motion a list"),
        ("{type: Orbit}", "6:20: bodies.a.motion.type: ", "unknown motion 'Orbit' (did you mean 'orbit'?)"),
        ("{type: balistic}", "6:20: bodies.a.motion.type: ", "(did you mean 'ballistic'?)"),
        ("{type: keyframe}", "6:20: bodies.a.motion.type: ", "(did you mean 'keyframes'?)"),
        (
            "{type: constant, veloctiy: [0, 0, 0]}",
            "6:30: bodies.a.motion: ",
            "unknown key 'veloctiy' (did you mean 'velocity'?), expected t0, type, velocity or angular_velocity",
        ),
        ("{type: constant, constant: 1}", "6:30: bodies.a.motion: ", "unknown key 'constant'"),
        ("{type: constant, t0: later}", "6:34: bodies.a.motion.t0: ", "expected a number, got 'later'"),
        ("{type: constant, velocity: 5}", "6:40: bodies.a.motion.velocity: ", "expected a list, got 5"),
        ("{type: ballistic, acceleration: [1, 2]}", "6:45: bodies.a.motion.acceleration: ", "3 numbers, got 2"),
        ("{type: screw, rate: 1}", "6:5: bodies.a.motion: ", "missing key 'axis'"),
        ("{type: screw, axis: [0, 0, 1]}", "6:5: bodies.a.motion: ", "missing key 'rate'"),
        ("{type: screw, axis: x, rate: 1}", "6:33: bodies.a.motion.axis: ", "expected a list, got 'x'"),
        (
            "{type: orbit, axis: [0, 0, 1], start: [1, 0, 0], radius: 0, rate: 1}",
            "6:70: bodies.a.motion.radius: ",
            "expected a number greater than 0, got 0",
        ),
        (
            "{type: orbit, axis: [0, 0, 1], start: [1, 0, 0], radius: 1, rate: 1, facing: 1}",
            "6:90: bodies.a.motion.facing: ",
            "expected true or false, got 1",
        ),
        (
            "{type: orbit, axis: [0, 0, 1], start: [1, 0, 0], radius: 1, rate: 1, face: true}",
            "6:82: bodies.a.motion: ",
            "unknown key 'face' (did you mean 'facing'?)",
        ),
        ("{type: orbit, axis: [0, 0, 1], radius: 1, rate: 1}", "6:5: bodies.a.motion: ", "missing key 'start'"),
        (
            "{type: swing, axis: [0, 0, 1], amplitude: 1, period: 0}",
            "6:66: bodies.a.motion.period: ",
            "expected a number greater than 0, got 0",
        ),
        (
            "{type: harmonic, direction: [0, 0, 1], amplitude: 1, period: -2}",
            "6:74: bodies.a.motion.period: ",
            "got -2",
        ),
        ("{type: polynomial}", "6:5: bodies.a.motion: ", "missing key 'coefficients'"),
        (
            "{type: polynomial, coefficients: []}",
            "6:46: bodies.a.motion.coefficients: ",
            "expected at least one entry, got none",
        ),
        (
            "{type: polynomial, coefficients: [[1, 2]]}",
            "6:47: bodies.a.motion.coefficients[0]: ",
            "expected 3 numbers, got 2",
        ),
        (
            "{type: polynomial, coefficients: [1, 2, 3]}",
            "6:47: bodies.a.motion.coefficients[0]: ",
            "expected a list, got 1",
        ),
        (
            f"{{type: polynomial, coefficients: [{', '.join(['[0, 0, 1]'] * 22)}]}}",
            "6:46: bodies.a.motion.coefficients: ",
            "expected at most 21 entries, got 22",
        ),
        (
            "{type: profile, kind: roll, axis: [1, 0, 0], from: 0, to: 5, max_velocity: 1, max_acceleration: 1}",
            "6:35: bodies.a.motion.kind: ",
            "expected slide or turn, got 'roll'",
        ),
        (
            "{type: profile, kind: slide, axis: [1, 0, 0], to: 5, max_velocity: 1, max_acceleration: 1}",
            "6:5: bodies.a.motion: ",
            "missing key 'from'",
        ),
        (
            "{type: profile, kind: slide, axis: [1, 0, 0], from: 0, end: 5, max_velocity: 1, max_acceleration: 1}",
            "6:68: bodies.a.motion: ",
            "unknown key 'end', expected t0, type, kind, axis, point, from, to, max_velocity or max_acceleration",
        ),
        (
            "{type: profile, kind: slide, axis: [1, 0, 0], from: a, to: 5, max_velocity: 1, max_acceleration: 1}",
            "6:65: bodies.a.motion.from: ",
            "expected a number, got 'a'",
        ),
        (
            "{type: profile, kind: slide, axis: [1, 0, 0], from: 0, to: 5, max_velocity: 0, max_acceleration: 1}",
            "6:89: bodies.a.motion.max_velocity: ",
            "expected a number greater than 0, got 0",
        ),
        (
            "{type: profile, kind: slide, axis: [1, 0, 0], from: 0, to: 5, max_velocity: 1, max_acceleration: -1}",
            "6:110: bodies.a.motion.max_acceleration: ",
            "expected a number greater than 0, got -1",
        ),
        ("{type: keyframes}", "6:5: bodies.a.motion: ", "missing key 'keys'"),
        ("{type: keyframes, keys: []}", "6:37: bodies.a.motion.keys: ", "expected at least one entry, got none"),
        ("{type: keyframes, keys: {t: 0}}", "6:37: bodies.a.motion.keys: ", "expected a list, got a mapping"),
        ("{type: keyframes, keys: [0]}", "6:38: bodies.a.motion.keys[0]: ", "expected a mapping, got 0"),
        ("{type: keyframes, keys: [{xyz: [0, 0, 0]}]}", "6:38: bodies.a.motion.keys[0]: ", "missing key 't'"),
        ("{type: keyframes, keys: [{t: abc}]}", "6:42: bodies.a.motion.keys[0].t: ", "expected a number, got 'abc'"),
        ("{type: keyframes, keys: [{t: 0, name: 7}]}", "6:51: bodies.a.motion.keys[0].name: ", "expected text, got 7"),
        (
            "{type: keyframes, keys: [{t: 0, velocity: a}]}",
            "6:55: bodies.a.motion.keys[0].velocity: ",
            "expected a list, got 'a'",
        ),
        (
            "{type: keyframes, keys: [{t: 0, time: 0}]}",
            "6:45: bodies.a.motion.keys[0]: ",
            "unknown key 'time'",
        ),
        (
            f"{{type: keyframes, {KEYS}, before: holds}}",
            "6:63: bodies.a.motion.before: ",
            "expected error, hold or loop, got 'holds' (did you mean 'hold'?)",
        ),
        (f"{{type: keyframes, {KEYS}, after: 1}}", "6:62: bodies.a.motion.after: ", "error, hold or loop, got 1"),
        (
            f"{{type: keyframes, {KEYS}, interpolation: linear}}",
            "6:70: bodies.a.motion.interpolation: ",
            "expected a mapping, got 'linear'",
        ),
        (
            f"{{type: keyframes, {KEYS}, interpolation: {{translation: cubik}}}}",
            "6:84: bodies.a.motion.interpolation.translation: ",
            "expected linear, cubic or step, got 'cubik' (did you mean 'cubic'?)",
        ),
        (
            f"{{type: keyframes, {KEYS}, interpolation: {{rotation: lerp}}}}",
            "6:81: bodies.a.motion.interpolation.rotation: ",
            "expected slerp or step, got 'lerp' (did you mean 'slerp'?)",
        ),
        ("{type: file, file: a.csv}", "6:5: bodies.a.motion: ", "missing key 'layout'"),
        ("{type: file, layout: csv}", "6:5: bodies.a.motion: ", "missing key 'file'"),
        ("{type: file, file: '', layout: csv}", "6:32: bodies.a.motion.file: ", "expected text, got an empty one"),
        (
            "{type: file, file: a.csv, layout: kitti}",
            "6:47: bodies.a.motion.layout: ",
            "the kitti layout has no times, expected times (a file) or period (seconds from pose to pose)",
        ),
        (
            "{type: file, file: a.csv, layout: csv, duplicates: both}",
            "6:64: bodies.a.motion.duplicates: ",
            "expected error, first or last, got 'both'",
        ),
        (
            "{type: file, file: a.csv, layout: cvs}",
            "6:47: bodies.a.motion.layout: ",
            "expected tum, euroc, kitti or csv, got 'cvs' (did you mean 'csv'?)",
        ),
        (
            "{type: file, file: a.csv, layout: csv, units: km}",
            "6:59: bodies.a.motion.units: ",
            "expected m, cm, mm, in or ft, got 'km'",
        ),
        (
            "{type: file, file: a.csv, layout: csv, time_origin: last}",
            "6:65: bodies.a.motion.time_origin: ",
            "expected first or zero, got 'last'",
        ),
        (
            "{type: file, file: a.csv, layout: csv, max_gap: 0}",
            "6:61: bodies.a.motion.max_gap: ",
            "expected a number greater than 0, got 0",
        ),
        (
            "{type: file, file: a.csv, layout: csv, keys: []}",
            "6:52: bodies.a.motion: ",
            "unknown key 'keys', expected t0, interpolation, before, after, type, file, layout",
        ),
    ],
)
def test_a_motion_that_is_none_is_refused_at_its_place(tmp_path: Path, motion: str, begin: str, phrase: str) -> None:
    told = [line for line in faults(tmp_path, MOTION + motion) if line.startswith(begin)]
    assert len(told) == 1
    assert phrase in told[0]


def test_every_missing_key_of_a_motion_is_told(tmp_path: Path) -> None:
    told = faults(tmp_path, MOTION + "{type: profile, kind: slide}")
    keys = ("axis", "from", "to", "max_velocity", "max_acceleration")
    assert told == [f"6:5: bodies.a.motion: missing key '{key}'" for key in keys]
