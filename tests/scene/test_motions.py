"""Each motion of a scene becomes the scheduler's: metres and radians, unit directions, its own time."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scene_files import HEAD, load, motion

from closecall.scheduler.motions import (
    Ballistic,
    Constant,
    Delayed,
    Fixed,
    Harmonic,
    Keyframes,
    Looped,
    Motion,
    Orbit,
    Polynomial,
    Screw,
    Swing,
    Translation,
    Trapezoid,
)

X, Y, Z, ORIGIN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
ROUND = "axis: [0, 0, 5], start: [0, 3, 0], radius: 250, rate: 90"
MOVE = "axis: [0, 2, 0], from: 90, to: -180, max_velocity: 360, max_acceleration: 720"
SMOOTH: list[tuple[str, Motion]] = [
    (
        "type: constant, velocity: [1000, 0, -500], angular_velocity: [0, 180, 0]",
        Constant((1.0, 0.0, -0.5), (0.0, math.pi, 0.0)),
    ),
    (
        "type: ballistic, velocity: [0, 0, 2000], acceleration: [0, 0, -9810], angular_velocity: [90, 0, 0]",
        Ballistic((0.0, 0.0, 2.0), (0.0, 0.0, -9.81), (math.pi / 2, 0.0, 0.0)),
    ),
    (
        "type: screw, axis: [0, 0, 5], point: [10, 20, 30], rate: 360, pitch: -4",
        Screw(Z, (0.01, 0.02, 0.03), 2 * math.pi, -0.004),
    ),
    (f"type: orbit, {ROUND}, phase: 45, facing: true", Orbit(Z, Y, 0.25, math.pi / 2, math.pi / 4, True)),
    (f"type: orbit, {ROUND}", Orbit(Z, Y, 0.25, math.pi / 2, 0.0, False)),
    (
        "type: harmonic, direction: [0, -3, 4], amplitude: 250, period: 2, phase: 45",
        Harmonic((0.0, -0.6, 0.8), 0.25, 2.0, math.pi / 4),
    ),
    (
        "type: swing, axis: [0, 2, 0], point: [0, 0, 500], amplitude: 60, period: 0.7, phase: -90",
        Swing(Y, (0.0, 0.0, 0.5), math.pi / 3, 0.7, -math.pi / 2),
    ),
    (
        "type: polynomial, coefficients: [[1, 2, 3], [0, 0, 1000]], angular_velocity: [0, 0, 180]",
        Polynomial(((0.001, 0.002, 0.003), (0.0, 0.0, 1.0)), (0.0, 0.0, math.pi)),
    ),
]


@pytest.mark.parametrize(("text", "expected"), SMOOTH)
def test_motions_are_converted_to_metres_and_radians(tmp_path: Path, text: str, expected: Motion) -> None:
    assert motion(tmp_path, f"{{{text}}}") == expected


@pytest.mark.parametrize(("text", "expected"), SMOOTH)
def test_t0_is_the_scene_time_at_which_a_motions_own_time_begins(tmp_path: Path, text: str, expected: Motion) -> None:
    delayed = motion(tmp_path, f"{{{text}, t0: 0.75}}")
    assert delayed == Delayed(expected, 0.75)
    np.testing.assert_array_equal(delayed.pose(1.0), expected.pose(0.25))
    assert motion(tmp_path, f"{{{text}, t0: 0}}") == expected


def test_a_profile_slides_in_lengths_and_turns_in_angles(tmp_path: Path) -> None:
    slide = motion(tmp_path, f"{{type: profile, kind: slide, {MOVE}}}")
    assert slide == Trapezoid(False, Y, ORIGIN, 0.09, -0.18, 0.36, 0.72, 0.0)
    turn = motion(tmp_path, f"{{type: profile, kind: turn, {MOVE}, point: [1, 2, 3], t0: 0.5}}")
    right = math.pi / 2
    assert turn == Trapezoid(True, Y, (0.001, 0.002, 0.003), right, -2 * right, 4 * right, 8 * right, 0.5)


def test_a_profile_rests_until_its_t0_and_after_its_end(tmp_path: Path) -> None:
    move = "from: 100, to: 400, max_velocity: 600, max_acceleration: 1200"
    slide = motion(tmp_path, f"{{type: profile, kind: slide, axis: [1, 0, 0], {move}, t0: 2}}")
    expected = [(0.0, 0.1), (2.0, 0.1), (2.25, 0.1375), (2.5, 0.25), (2.75, 0.3625), (3.0, 0.4), (9.0, 0.4)]
    assert [(t, slide.pose(t)[0, 3]) for t, _ in expected] == [(t, pytest.approx(x, abs=1e-15)) for t, x in expected]


def test_a_body_without_motion_is_fixed(tmp_path: Path) -> None:
    assert load(tmp_path, f"{HEAD}bodies: {{a: {{}}}}").scene.bodies[0].motion == Fixed()


def test_radians_and_inches_are_taken_as_they_are(tmp_path: Path) -> None:
    text = HEAD.replace("mm", "in").replace("deg", "rad")
    screw = "{type: screw, axis: [1, 0, 0], rate: 2.5, pitch: 10}"
    read = load(tmp_path, f"{text}bodies: {{a: {{motion: {screw}}}}}").scene.bodies[0].motion
    assert read == Screw(X, ORIGIN, 2.5, 0.254)


def test_what_is_left_of_an_orbits_start_along_its_axis_is_projected_out(tmp_path: Path) -> None:
    orbit = motion(tmp_path, "{type: orbit, axis: [0, 0, 1], start: [3, 4, 4e-6], radius: 1000, rate: 0}")
    assert isinstance(orbit, Orbit)
    assert orbit.start == pytest.approx((0.6, 0.8, 0.0), abs=1e-15)
    assert orbit.start[2] == 0.0


def keyframes(folder: Path, keys: str, options: str = "") -> Motion:
    return motion(folder, f"{{type: keyframes, {options}keys: [{keys}]}}")


def test_keyframes_are_converted_key_by_key(tmp_path: Path) -> None:
    keys = "{t: -1}, {t: 0.5, xyz: [1, 2, 3], rpy: [0, 0, 90]}, {t: 1, quat_xyzw: [0, 0, 0.6, 0.8]}"
    read = keyframes(tmp_path, keys)
    assert isinstance(read, Keyframes)
    assert read.times.tolist() == [-1, 0.5, 1]
    assert read.translations.tolist() == [[0, 0, 0], [0.001, 0.002, 0.003], [0, 0, 0]]
    half = math.sqrt(0.5)
    np.testing.assert_allclose(read.quaternions, [[1, 0, 0, 0], [half, 0, 0, half], [0.8, 0, 0, 0.6]], atol=1e-16)
    assert (read.translation, read.step_rotation) == (Translation.LINEAR, False)
    assert read.key_velocities is None
    assert not any(array.flags.writeable for array in (read.times, read.translations, read.quaternions))


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ("", (Translation.LINEAR, False)),
        ("interpolation: {}, ", (Translation.LINEAR, False)),
        ("interpolation: {translation: linear, rotation: slerp}, ", (Translation.LINEAR, False)),
        ("interpolation: {translation: step}, ", (Translation.STEP, False)),
        ("interpolation: {rotation: step}, ", (Translation.LINEAR, True)),
        ("interpolation: {translation: cubic, rotation: step}, ", (Translation.CUBIC, True)),
    ],
)
def test_each_interpolation_is_the_schedulers(tmp_path: Path, options: str, expected: tuple[Translation, bool]) -> None:
    read = keyframes(tmp_path, "{t: 0}, {t: 1}", options)
    assert isinstance(read, Keyframes)
    assert (read.translation, read.step_rotation) == expected


def test_velocities_of_cubic_keys_are_in_metres_per_second(tmp_path: Path) -> None:
    keys = "{t: 0, velocity: [1000, 0, 0]}, {t: 1, xyz: [1000, 0, 0], velocity: [0, -500, 0]}"
    read = keyframes(tmp_path, keys, "interpolation: {translation: cubic}, ")
    assert isinstance(read, Keyframes)
    assert read.key_velocities is not None
    assert read.key_velocities.tolist() == [[1, 0, 0], [0, -0.5, 0]]
    assert not read.key_velocities.flags.writeable
    np.testing.assert_allclose(read.velocities(0.0)[0], [1, 0, 0], atol=1e-12)
    assert read.pose(0.5)[:2, 3] == pytest.approx([0.5 + 0.125, 0.0625])


def test_t0_moves_the_keys(tmp_path: Path) -> None:
    read = keyframes(tmp_path, "{t: 10}, {t: 11, xyz: [1000, 0, 0]}", "t0: -10, ")
    assert isinstance(read, Keyframes)
    assert read.times.tolist() == [0.0, 1.0]


def test_keys_hold_where_they_are_told_to(tmp_path: Path) -> None:
    read = keyframes(tmp_path, "{t: 0.25}, {t: 0.5, xyz: [1000, 0, 0]}", "before: hold, after: hold, ")
    assert isinstance(read, Keyframes)
    assert [read.pose(t)[0, 3] for t in (0.0, 0.375, 1.0)] == [0.0, 0.5, 1.0]
    lone = keyframes(tmp_path, "{t: 0.25, xyz: [1000, 0, 0]}", "before: hold, after: hold, ")
    assert [lone.pose(t)[0, 3] for t in (0.0, 0.25, 1.0)] == [1.0, 1.0, 1.0]


@pytest.mark.parametrize(("before", "after"), [("loop", "hold"), ("hold", "loop"), ("loop", "loop")])
def test_keys_repeat_where_they_are_told_to(tmp_path: Path, before: str, after: str) -> None:
    options = f"before: {before}, after: {after}, t0: 0.125, "
    read = keyframes(tmp_path, "{t: 0.25}, {t: 0.5, xyz: [1000, 0, 0]}", options)
    assert isinstance(read, Looped)
    assert (read.before, read.after) == (before == "loop", after == "loop")
    assert read.keys.times.tolist() == [0.375, 0.625]
    assert read.pose(0.25)[0, 3] == (0.5 if before == "loop" else 0.0)
    assert read.pose(0.75)[0, 3] == (0.5 if after == "loop" else 1.0)
