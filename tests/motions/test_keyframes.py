"""Keyframes: how they run from key to key, where they jump, and what long or rough ones cost."""

from fractions import Fraction
from math import inf, nextafter

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from closecall.scheduler.motions import Keyframes, LeverArms, Translation
from closecall.scheduler.motions.key_interval import Boxes, end_of


def test_slerp_turns_the_short_way_at_a_constant_rate():
    quarter = [np.cos(np.pi / 4), 0, 0, np.sin(np.pi / 4)]
    keys = Keyframes(
        np.array([0.0, 2.0]), np.zeros((2, 3)), np.array([[1, 0, 0, 0], -np.array(quarter)]), Translation.LINEAR, False
    )
    for t in (0.0, 0.5, 1.9):
        assert np.allclose(keys.pose(t)[:3, :3], Rotation.from_rotvec([0, 0, np.pi / 4 * t]).as_matrix())
    assert keys.velocities(1.0)[1] == pytest.approx((0, 0, np.pi / 4))


def test_a_step_is_a_stop_just_before_and_at_the_jump_and_the_pose_is_the_new_one():
    keys = Keyframes(
        np.array([0.0, 1.0, 2.0]),
        np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 0]]),
        np.tile([1.0, 0, 0, 0], (3, 1)),
        Translation.STEP,
        False,
    )
    before = float(np.nextafter(1.0, 0.0))
    assert keys.stop_after(0.2) == before
    assert keys.stop_after(before) == 1.0
    assert keys.stop_after(1.0) == np.inf
    assert keys.pose(before)[0, 3] == 0.0
    assert keys.pose(1.0)[0, 3] == 1.0
    assert keys.displacement(0.2, before - 0.2, LeverArms(1.0, 1.0)) == 0.0


def test_a_long_way_travelled_does_not_coarsen_the_bounds_of_what_follows():
    """A thousand keys 1 mm apart after 1e5 m: the running sums are kept in two floats each."""
    x = np.concatenate(([0.0, 1e5 + 0.1], 1e5 + 0.1 + 1e-3 * np.arange(1, 1001)))
    keys = Keyframes(
        np.arange(len(x), dtype=np.float64),
        np.column_stack((x, x * 0, x * 0)),
        np.tile([1.0, 0, 0, 0], (len(x), 1)),
        Translation.LINEAR,
        False,
    )
    for first in (1, 7, 500):
        truth = abs(keys.pose(1001.0)[0, 3] - keys.pose(float(first))[0, 3])
        assert keys.displacement(float(first), 1001.0 - first, LeverArms(0.0, 0.0)) >= truth - 1e-10
        assert keys.rounding_scale((0.0, 1001.0), 1.0) < 1e6


def test_a_glitch_elsewhere_does_not_loosen_the_error_of_a_pose_at_rest():
    """A jump of 1 m in 1 ns, far from the times of interest, once made the error grow to millimetres."""
    times = np.array([0.0, 1.0, 1.0 + 1e-9, 1000.0])
    x = np.array([[0.0, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0]])
    keys = Keyframes(times, x, np.tile([1.0, 0, 0, 0], (4, 1)), Translation.LINEAR, False)
    assert 8 * np.finfo(float).eps * keys.rounding_scale((0.0, 1000.0), 1.0) < 1e-13


def test_cubic_keys_are_passed_at_their_velocities():
    rng = np.random.default_rng(1)
    times = np.array([-1.0, 0.5, 0.7, 3.0])
    places, speeds = rng.normal(size=(2, 4, 3))
    keys = Keyframes(times, places, np.tile([1.0, 0, 0, 0], (4, 1)), Translation.CUBIC, False, speeds)
    for t, place, speed in zip(times[:3], places, speeds, strict=False):
        assert np.allclose(keys.pose(t)[:3, 3], place)
        assert np.allclose(keys.velocities(t)[0], speed)
        assert np.allclose(keys.pose(float(np.nextafter(t, -9)))[:3, 3], place)
    assert keys.velocities(3.0)[0] == keys.velocities(-2.0)[0] == (0, 0, 0)
    assert keys.stop_after(-9.0) == np.inf


def test_catmull_rom_passes_keys_of_a_parabola_along_it():
    """Away from the ends, the velocities of a parabola's keys are its own, however they are spaced."""
    times = np.array([0.0, 0.3, 1.5, 1.7, 4.0])
    curve = np.column_stack((times, times**2, 0 * times))
    keys = Keyframes(times, curve, np.tile([1.0, 0, 0, 0], (5, 1)), Translation.CUBIC, False)
    for t in np.linspace(0.3, 1.7, 50):
        assert np.allclose(keys.pose(float(t))[:3, 3], [t, t * t, 0])
    assert keys.velocities(0.0)[0] == pytest.approx((1.0, 0.3, 0.0))


def test_a_single_cubic_key_is_held():
    keys = Keyframes(np.array([1.0]), np.ones((1, 3)), np.array([[1.0, 0, 0, 0]]), Translation.CUBIC, False)
    assert keys.pose(0.0)[0, 3] == keys.pose(5.0)[0, 3] == 1.0
    assert keys.displacement(0.0, 9.0, LeverArms(1.0, 1.0)) == keys.path_length(0.0, 9.0, LeverArms(1.0, 1.0)) == 0.0


@pytest.mark.parametrize("translation", [Translation.LINEAR, Translation.CUBIC])
def test_going_to_and_fro_costs_how_far_it_gets_and_not_the_way(translation):
    """A jittering record: 5000 keys within 1 mm of one place."""
    rng = np.random.default_rng(2)
    x = rng.uniform(-5e-4, 5e-4, (5000, 3))
    keys = Keyframes(np.arange(5000.0), x, np.tile([1.0, 0, 0, 0], (5000, 1)), translation, False)
    for t, duration in ((0.5, 4000.0), (17.3, 30.0), (100.0, 1024.0)):
        assert keys.displacement(t, duration, LeverArms(1.0, 1.0)) < 2.5e-3
        assert keys.path_length(t, duration, LeverArms(1.0, 1.0)) > 2e-4 * duration


def test_the_farthest_of_many_boxes_is_that_of_all():
    rng = np.random.default_rng(3)
    for _ in range(300):
        corners = rng.normal(size=(int(rng.integers(1, 40)), 3))
        boxes = Boxes(corners, corners)
        first, last = sorted(rng.integers(0, len(corners) + 1, 2).tolist())
        place = rng.normal(size=3)
        truth = max((float(np.linalg.norm(c - place)) for c in corners[first:last]), default=0.0)
        found = boxes.farthest(tuple(place.tolist()), first, last)
        assert truth * (1 - 1e-15) <= found
        if last - first <= 1:
            assert found == pytest.approx(truth)


def test_a_stretch_of_keys_ends_at_the_first_float_that_time_and_duration_are_not_past() -> None:
    rng = np.random.default_rng(11)
    for _ in range(2000):
        t, duration = float(rng.normal() * 10.0 ** rng.uniform(-3, 6)), float(10.0 ** rng.uniform(-14, 4))
        end, exact = end_of(t, duration), Fraction(t) + Fraction(duration)
        assert Fraction(nextafter(end, -inf)) < exact <= Fraction(end)
