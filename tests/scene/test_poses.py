"""Poses mean the same however they are spelt, and what is no rotation is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scene_files import HEAD, body, faults
from scipy.spatial.transform import Rotation


def rotation_of(folder: Path, pose: str) -> np.ndarray:
    return body(folder, f"pose: {{{pose}}}").pose[:3, :3]


QUARTER_ABOUT_Z = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]


@pytest.mark.parametrize(
    "pose",
    [
        "rpy: [0, 0, 90]",
        "quat_wxyz: [0.70710678, 0, 0, 0.70710678]",
        "quat_xyzw: [0, 0, -0.70710678, -0.70710678]",
        "axis_angle: {axis: [0, 0, 3], angle: 90}",
        "axis_angle: {axis: [0, 0, -1], angle: -90}",
        "matrix: [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]",
    ],
)
def test_a_quarter_turn_is_the_same_however_it_is_spelt(tmp_path: Path, pose: str) -> None:
    np.testing.assert_allclose(rotation_of(tmp_path, pose), QUARTER_ABOUT_Z, atol=1e-15)


def test_rpy_turns_about_fixed_axes_x_then_y_then_z(tmp_path: Path) -> None:
    expected = Rotation.from_euler("xyz", [10, 20, 30], degrees=True).as_matrix()
    np.testing.assert_allclose(rotation_of(tmp_path, "rpy: [10, 20, 30]"), expected, atol=1e-15)


@pytest.mark.parametrize("pose", ["rpy: [0, 0, %r]", "axis_angle: {axis: [0, 0, 1], angle: %r}"])
def test_whole_turns_are_taken_off_exactly(tmp_path: Path, pose: str) -> None:
    np.testing.assert_allclose(rotation_of(tmp_path, pose % (360e9 + 90)), QUARTER_ABOUT_Z, atol=1e-15)


@pytest.mark.parametrize("turn", Rotation.random(20, np.random.default_rng(1)).as_matrix())
def test_a_matrix_is_made_orthonormal_to_the_last_bit_and_its_translation_converted(
    tmp_path: Path, turn: np.ndarray
) -> None:
    blurred = turn + np.random.default_rng(1).uniform(-2e-7, 2e-7, (3, 3))
    rows = [[*map(float, row), 1000.0 * i] for i, row in enumerate(blurred)]
    pose = body(tmp_path, f"pose: {{matrix: {[*rows, [0, 0, 0, 1]]}}}").pose
    np.testing.assert_allclose(pose[:3, :3], turn, atol=1e-6)
    np.testing.assert_allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3), atol=1e-15)
    assert pose[:3, 3].tolist() == [0, 1, 2]
    assert pose[3].tolist() == [0, 0, 0, 1]
    assert not pose.flags.writeable


@pytest.mark.parametrize(
    "turn", [np.diag(d) for d in ([1, -1, -1], [-1, 1, -1], [-1, -1, 1])] + [np.roll(np.eye(3), 1, axis=0)]
)
def test_half_turns_survive_the_way_through_a_quaternion(tmp_path: Path, turn: np.ndarray) -> None:
    rows = [[*map(float, row), 0] for row in turn]
    np.testing.assert_allclose(rotation_of(tmp_path, f"matrix: {[*rows, [0, 0, 0, 1]]}"), turn, atol=1e-15)


@pytest.mark.parametrize(
    ("pose", "column", "place", "phrase"),
    [
        ("quat_wxyz: [0, 0, 0, 0]", 32, "quat_wxyz", "of length 0"),
        ("quat_wxyz: [1.002, 0, 0, 0]", 32, "quat_wxyz", "of length 1.002"),
        ("quat_xyzw: [0, 0, 0, 0.998]", 32, "quat_xyzw", "expected a unit quaternion"),
        ("axis_angle: {axis: [0, 0, 0], angle: 1}", 40, "axis_angle.axis", "got the zero vector"),
        (
            "matrix: [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]",
            29,
            "matrix",
            "scales or shears",
        ),
        (
            "matrix: [[1, 1, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]",
            29,
            "matrix",
            "scales or shears",
        ),
        ("matrix: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]", 29, "matrix", "mirrors"),
        ("matrix: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [1, 2, 3, 1]]", 29, "matrix", "last row"),
        (
            "matrix: [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]]",
            29,
            "matrix",
            "scales or shears",
        ),
    ],
)
def test_what_is_no_rotation_is_refused(tmp_path: Path, pose: str, column: int, place: str, phrase: str) -> None:
    (line,) = faults(tmp_path, f"{HEAD}bodies: {{a: {{pose: {{{pose}}}}}}}")
    assert line.startswith(f"4:{column}: bodies.a.pose.{place}: ")
    assert phrase in line


def test_a_quaternion_within_a_thousandth_is_normalised(tmp_path: Path) -> None:
    np.testing.assert_allclose(rotation_of(tmp_path, "quat_wxyz: [1.0009, 0, 0, 0]"), np.eye(3), atol=1e-16)
