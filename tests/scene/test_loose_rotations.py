"""Rotations that are not quite rotations: taken silently to 1e-5, with a warning to 1e-3, refused beyond."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scene_files import HEAD, body, fault, load, warnings
from scipy.linalg import polar
from scipy.spatial.transform import Rotation

TURNS = Rotation.random(12, np.random.default_rng(3)).as_matrix()
QUARTER = "[0, -1, 0, 0], [%r, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]"
"""A quarter turn about z that may stretch what lies along x."""


def written(turn: np.ndarray, decimals: int) -> str:
    rows = [[*map(float, row), 0.0] for row in np.round(turn, decimals)]
    return f"matrix: {[*rows, [0, 0, 0, 1]]}"


@pytest.mark.parametrize("decimals", [6, 7, 12])
@pytest.mark.parametrize("turn", TURNS)
def test_a_matrix_of_six_decimals_is_the_nearest_rotation_without_a_word(
    tmp_path: Path, turn: np.ndarray, decimals: int
) -> None:
    read = body(tmp_path, f"pose: {{{written(turn, decimals)}}}").pose[:3, :3]
    np.testing.assert_allclose(read, polar(np.round(turn, decimals))[0], rtol=0, atol=1e-15)
    assert warnings(tmp_path, f"{HEAD}bodies: {{a: {{pose: {{{written(turn, decimals)}}}}}}}") == []


@pytest.mark.parametrize("turn", TURNS)
def test_how_far_the_nearest_rotation_moves_points_is_told_and_never_less_than_it_does(
    tmp_path: Path, turn: np.ndarray
) -> None:
    box = np.array([[x, y, z] for x in (-20, 20) for y in (-300, 300) for z in (-5, 5)], dtype=float)
    shape = "shapes: [{box: [40, 600, 10]}]"
    (line,) = warnings(tmp_path, f"{HEAD}bodies: {{a: {{pose: {{{written(turn, 4)}}}, {shape}}}}}")
    assert line.startswith("4:29: bodies.a.pose.matrix: the matrix is off a rotation by ")
    told = float(line.split(" by up to ")[1].removesuffix(" mm"))
    coarse = np.round(turn, 4)
    moved = np.linalg.norm(box @ (coarse - polar(coarse)[0]).T, axis=1).max()
    assert moved <= told <= 1e-4 * 3**0.5 * 301 * 1.1


@pytest.mark.parametrize(
    ("pose", "told"),
    [
        ("matrix: [" + QUARTER % 1.0009 + "]", "the matrix is off a rotation by 0.0009"),
        ("matrix: [" + QUARTER % 0.9991 + "]", "the matrix is off a rotation by 0.0009"),
        ("quat_wxyz: [1.00045, 0, 0, 0]", "the quaternion's length is off 1 by 0.00045"),
        ("quat_xyzw: [0, 0, 0.99955, 0]", "the quaternion's length is off 1 by 0.00045"),
    ],
)
def test_matrices_and_quaternions_are_told_of_on_one_scale(tmp_path: Path, pose: str, told: str) -> None:
    """A quaternion that is read without being normalised stretches by the square of its length."""
    scene = f"{HEAD}bodies: {{a: {{pose: {{{pose}}}, shapes: [{{sphere: 1000}}]}}}}"
    (line,) = warnings(tmp_path, scene)
    text = f"{told}: the nearest rotation is taken, which moves points of the body by up to "
    assert line.split(": ", 2)[2].startswith(text)
    assert float(line.split(" by up to ")[1].removesuffix(" mm")) == pytest.approx(0.9, abs=0.0101)


@pytest.mark.parametrize(
    "pose",
    [
        "matrix: [" + QUARTER % 1.000009 + "]",
        "quat_wxyz: [0.7071, 0, 0, 0.7071]",
        "quat_xyzw: [0, 0, 0, 1.000009]",
    ],
)
def test_up_to_a_hundred_thousandth_nothing_is_told(tmp_path: Path, pose: str) -> None:
    assert warnings(tmp_path, f"{HEAD}bodies: {{a: {{pose: {{{pose}}}, shapes: [{{sphere: 1e6}}]}}}}") == []


@pytest.mark.parametrize(
    ("pose", "phrase"),
    [
        ("matrix: [" + QUARTER % 1.00101 + "]", "got a matrix that scales or shears by 0.001"),
        ("matrix: [[1, 3e-3, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]", "scales or shears by 0.0015"),
        ("matrix: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1.0001, 0], [0, 0, 0, 1]]", "mirrors"),
        ("quat_wxyz: [1.0011, 0, 0, 0]", "expected a unit quaternion, got one of length 1.0011"),
    ],
)
def test_beyond_a_thousandth_it_is_no_rotation(tmp_path: Path, pose: str, phrase: str) -> None:
    assert phrase in fault(tmp_path, f"{HEAD}bodies: {{a: {{pose: {{{pose}}}}}}}")


SHEARED = "matrix: [" + QUARTER % 1.0005 + "]"


def moved_of(line: str) -> float:
    """Return the mm that a warning tells."""
    return float(line.split(" by up to ")[1].split(" mm")[0])


def test_points_that_a_rotation_carries_on_other_bodies_and_motions_count(tmp_path: Path) -> None:
    """500 of the ball, 2000 to its parent, 3000 of the parent's slide: 5500 mm from the loose rotation."""
    slide = "{type: harmonic, direction: [1, 0, 0], amplitude: 3000, period: 1}"
    text = (
        f"{HEAD}bodies:\n  a: {{pose: {{{SHEARED}}}, motion: {slide}}}\n"
        "  b: {parent: a, pose: {xyz: [0, 2000, 0]}, shapes: [{sphere: 500}]}\n"
    )
    (line,) = warnings(tmp_path, text)
    assert moved_of(line) == pytest.approx(0.0005 * 5500, rel=0.04)


def test_each_shape_is_told_of_by_its_own_points_and_the_keys_together_by_the_worst(tmp_path: Path) -> None:
    keys = "{t: 0, quat_wxyz: [1.0002, 0, 0, 0]}, {t: 0.5, quat_wxyz: [1.0004, 0, 0, 0]}, {t: 1}"
    text = (
        f"{HEAD}bodies:\n  a:\n    shapes:\n      - {{sphere: 10, pose: {{{SHEARED}}}}}\n"
        f"      - {{sphere: 1000, pose: {{{SHEARED}}}}}\n"
        f"    motion: {{type: keyframes, keys: [{keys}]}}\n"
    )
    first, second, third = warnings(tmp_path, text)
    assert first.startswith("7:37: bodies.a.shapes[0].pose.matrix: ")
    assert moved_of(first) == pytest.approx(0.005, rel=0.01)
    assert moved_of(second) == pytest.approx(0.5, rel=0.01)
    assert ": bodies.a.motion.keys[1].quat_wxyz: " in third
    assert moved_of(third) == pytest.approx(0.8, abs=0.011)
    assert third.endswith(" (and 1 key less)")


def test_reading_again_gives_the_same_floats(tmp_path: Path) -> None:
    text = f"{HEAD}bodies: {{a: {{pose: {{{written(TURNS[0], 5)}}}}}}}"
    one, other = (load(tmp_path, text).scene.bodies[0].pose for _ in range(2))
    assert one.tobytes() == other.tobytes()
