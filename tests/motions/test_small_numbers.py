"""No number of a scene is dropped because it is small: what it is multiplied with decides what it does."""

from __future__ import annotations

from fractions import Fraction
from math import hypot, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_process import closecall
from scene_files import HEAD, MOTION, body, fault, load, motion

from closecall.scheduler.geometry.vector import unit
from closecall.scheduler.motions import Ballistic, LeverArms, Polynomial, Trapezoid
from oracle.check import check_log
from oracle.logs import read_log

FACTORS = (1e-15, 1e-61, 1e-155, 1e-170, 2.0**-900, 1e-280)
"""Squares of the third are subnormal, those of the next ones are 0 in floats."""

SI = "closecall: 1\nunits: {length: m, angle: rad}\n"
DIRECTION = (0.6, 0.0, 0.8)


def begins(folder: Path, text: str) -> list[float]:
    """Run a scene, hold its log against the oracle, and return when (s) contacts begin."""
    (folder / "scene.yaml").write_text(text)
    done = closecall("run", "scene.yaml", "-o", "out.mcap", "--log", "certificate", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert check_log(folder / "scene.yaml", folder / "out.mcap") == []
    collisions = read_log(folder / "out.mcap").of("collisions")
    return [event["time_touching"] for event in collisions if event["phase"] == "BEGIN"]


@pytest.mark.parametrize(("degree", "coefficient"), [(10, 5e-61), (20, 5e-121)])
def test_a_tiny_coefficient_of_a_high_power_carries_a_body_into_another(
    tmp_path: Path, degree: int, coefficient: float
) -> None:
    coefficients = [[0, 0, 0]] * degree + [[coefficient, 0, 0]]
    text = (
        f"{SI}time: {{start: 0, end: 1.0e+6}}\nsettings: {{time_resolution: 1, contact_tolerance: 0.001}}\nbodies:\n"
        f"  a: {{shapes: [{{sphere: 0.1}}], motion: {{type: polynomial, coefficients: {coefficients}}}}}\n"
        "  b: {pose: {xyz: [0.5, 0, 0]}, shapes: [{sphere: 0.1}]}\n"
    )
    (begin,) = begins(tmp_path, text)
    assert begin == pytest.approx((0.3 / coefficient) ** (1 / degree), abs=0.01)


def test_a_screw_about_a_tiny_slanted_axis_meets_what_lies_on_its_way(tmp_path: Path) -> None:
    """Half a turn about (9, 0, 11) carries (1, 0, 0) to 2 (n . p) n - p, where the post stands."""
    n = np.array((9.0, 0.0, 11.0)) / hypot(9.0, 11.0)
    post = (2.0 * n[0] * n - (1.0, 0.0, 0.0)).tolist()
    text = (
        f"{SI}time: {{start: 0, end: 1}}\nbodies:\n"
        f"  f: {{motion: {{type: screw, axis: [9.0e-61, 0, 1.1e-60], rate: {pi}}}}}\n"
        "  a: {parent: f, pose: {xyz: [1, 0, 0]}, shapes: [{sphere: 0.1}]}\n"
        f"  b: {{pose: {{xyz: {post}}}, shapes: [{{sphere: 0.1}}]}}\n"
    )
    (begin,) = begins(tmp_path, text)
    radius = np.sqrt(1.0 - n[0] ** 2)
    assert begin == pytest.approx(1.0 - 2.0 * np.arcsin(0.1 / radius) / pi, abs=1e-5)


DIRECTIONS: dict[str, tuple[str, str]] = {
    "screw": ("{type: screw, axis: %s, rate: 90}", "axis_direction"),
    "swing": ("{type: swing, axis: %s, amplitude: 30, period: 1}", "axis_direction"),
    "harmonic": ("{type: harmonic, direction: %s, amplitude: 3, period: 1}", "direction"),
    "orbit": ("{type: orbit, axis: %s, start: [0, 1.0e-200, 0], radius: 3, rate: 90}", "axis_direction"),
    "start": ("{type: orbit, axis: [0, 2.0e-170, 0], start: %s, radius: 3, rate: 90}", "start"),
    "profile": (
        "{type: profile, kind: turn, axis: %s, from: 0, to: 90, max_velocity: 9, max_acceleration: 9}",
        "axis_direction",
    ),
}


@pytest.mark.parametrize("kind", DIRECTIONS)
@pytest.mark.parametrize("factor", FACTORS)
def test_a_direction_of_any_length_is_the_same_direction(tmp_path: Path, kind: str, factor: float) -> None:
    text, attribute = DIRECTIONS[kind]
    read = motion(tmp_path, text % [3.0 * factor, 0.0, 4.0 * factor])
    assert getattr(read, attribute) == pytest.approx(DIRECTION, rel=1e-15)


@pytest.mark.parametrize("factor", FACTORS)
def test_an_axis_of_a_pose_may_have_any_length(tmp_path: Path, factor: float) -> None:
    read = body(tmp_path, f"pose: {{axis_angle: {{axis: {[factor, factor, factor]}, angle: 120}}}}")
    np.testing.assert_allclose(read.pose[:3, :3], [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=1e-15)


@pytest.mark.parametrize("vector", ["[7.0e-324, 0, 1.0e-323]", "[0, 9.0e-291, 0]"])
def test_a_direction_that_floats_have_no_digits_for_is_refused(tmp_path: Path, vector: str) -> None:
    line = fault(tmp_path, f"{MOTION}{{type: screw, axis: {vector}, rate: 1}}")
    assert line.startswith("6:33: bodies.a.motion.axis: expected a direction, got a vector of length ")
    assert line.endswith("too short for its digits: multiply it by 1e300")


def test_numbers_are_read_as_the_nearest_floats(tmp_path: Path) -> None:
    read = load(
        tmp_path,
        f"{SI}time: {{start: 1.0e-300, end: 1}}\nbodies: {{a: {{pose: {{xyz: [1.0e-61, -5.0e-324, -0.0]}}}}}}\n",
    ).scene
    assert read.start == 1e-300
    assert read.bodies[0].pose[:3, 3].tolist() == [1e-61, -5e-324, 0.0]
    spin = motion(tmp_path, "{type: constant, velocity: [1.0e-200, 0, 0], angular_velocity: [0, 0, 1.0e-310]}")
    assert isinstance(spin, Ballistic)
    assert spin.velocity == (1e-203, 0.0, 0.0)
    assert spin.angular_velocity[2] > 0.0
    assert np.isfinite(spin.pose(1e15)).all()


@pytest.mark.parametrize("factor", [*FACTORS, 1e-308, 5e-320])
def test_a_unit_vector_has_length_1_however_short_what_it_is_made_of(factor: float) -> None:
    found = unit((3.0 * factor, 0.0, 4.0 * factor))
    assert found == pytest.approx(DIRECTION, rel=1e-3)
    assert hypot(*found) == pytest.approx(1.0, abs=1e-15)


def test_a_subnormal_spin_does_not_shorten_the_way_gone_along_its_axis() -> None:
    """The axis of such a spin has no digits left: (1, 1, 1) times the least float divides to (0.6, 0.6, 0.6)."""
    for spin in ((5e-324, 5e-324, 5e-324), (1.5e-323, 1e-323, 0.0)):
        moving = Ballistic((1.0, 1.0, 1.0), (0.0, 0.0, 0.0), spin)
        truth = 2.0 * 3.0**0.5
        assert moving.displacement(0.0, 2.0, LeverArms(1.0, 1.0)) == pytest.approx(truth, rel=1e-15)
        assert moving.path_length(0.0, 2.0, LeverArms(1.0, 1.0)) == pytest.approx(truth, rel=1e-15)


@pytest.mark.parametrize("travel", [5e-324, 1e-310, 1e-170, 1e-30])
def test_the_least_way_of_a_profile_takes_its_time(travel: float) -> None:
    slide = Trapezoid(False, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, travel, 1.0, 1e15, 0.0)
    stopped = slide.knot_after(slide.knot_after(slide.knot_after(-1.0)))
    assert stopped == pytest.approx(2.0 * float(travel**0.5) / 1e15**0.5, rel=1e-9)
    assert slide.pose(1.0)[0, 3] == travel


@pytest.mark.parametrize("gap", [5e-324, 1e-170, 9e-16])
def test_keys_too_near_to_each_other_for_a_speed_between_them_are_refused(tmp_path: Path, gap: float) -> None:
    keys = f"[{{t: 0}}, {{t: {gap!r}, xyz: [1, 0, 0]}}, {{t: 1}}]"
    for way in ("linear", "cubic"):
        line = fault(tmp_path, f"{MOTION}{{type: keyframes, interpolation: {{translation: {way}}}, keys: {keys}}}")
        assert line.endswith(f"two poses are {gap!r} s apart, expected at least 1e-15 s")


def test_keys_a_quadrillionth_of_a_second_apart_have_finite_bounds(tmp_path: Path) -> None:
    keys = "[{t: 0}, {t: 1.0e-15, xyz: [1.0e+15, 0, 0]}, {t: 1}]"
    read: Any = motion(tmp_path, f"{{type: keyframes, interpolation: {{translation: cubic}}, keys: {keys}}}")
    assert np.isfinite(read.path.fastest)
    assert read.path_length(0.0, 1.0, LeverArms(1.0, 1.0)) >= 2e12


def test_a_time_too_short_to_be_run_is_refused(tmp_path: Path) -> None:
    line = fault(tmp_path, HEAD.replace("end: 1", "end: 1.0e-16") + "bodies: {a: {}}\n")
    assert line == "3:23: time.end: expected an end after the start (0 s) by at least 1e-15 s, got 1e-16 s"
    line = fault(tmp_path, HEAD + "bodies: {a: {exists: [0, 1.0e-300]}}\n")
    assert line.endswith("to exist until after it begins (0 s) by at least 1e-15 s, got 1e-300 s")


def test_the_way_of_a_tiny_coefficient_is_that_of_exact_fractions() -> None:
    rng = np.random.default_rng(5)
    for degree in (3, 10, 15, 20):
        for latest in (1.0, 1e6, 1e12, 1e15):
            sizes = [float(rng.uniform(0.1, 1.0)) / latest**k for k in range(degree + 1)]
            moving = Polynomial(tuple((size, 0.0, -size) for size in sizes), (0.0, 0.0, 0.0))
            for share in (1.0, 0.3):
                t = share * latest
                truth = float(sum(Fraction(size) * Fraction(t) ** k for k, size in enumerate(sizes)))
                assert moving.pose(t)[0, 3] == pytest.approx(truth, rel=1e-13)
                way = moving.displacement(0.0, t, LeverArms(0.0, 0.0))
                assert (truth - sizes[0]) * 2.0**0.5 * (1.0 - 1e-12) <= way <= (truth - sizes[0]) * 2.0**0.5 * 1.1


def test_coordinates_of_a_mesh_file_below_1e_60_are_read_as_0(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 9e-61\nv 1 0 2e-60\nv 0 1 -5e-324\nf 1 2 3\n")
    meshes = "meshes: {m: {file: m.obj, units: m}}\nbodies: {a: {shapes: [{mesh: m, scale: 1.0e+15}]}}\n"
    (shape,) = load(tmp_path, HEAD + meshes).scene.bodies[0].shapes
    assert shape.mesh.vertices[:, 2].tolist() == pytest.approx([0.0, 2e-45, 0.0], rel=1e-15, abs=0.0)
