"""Every bound of every motion against dense sampling of its own poses, and the poses against their formulas."""

from pathlib import Path

import numpy as np
import pytest
from drawn_motions import (
    KINDS,
    SAMPLES,
    interval,
    paths,
    pose_error,
    random_chain,
    random_unit,
    reach_of,
    spec_of,
)
from scipy.spatial.transform import Rotation

from closecall.scheduler.kinematics.chain import Part, chain_to, origin_reach
from closecall.scheduler.model.extent import Ball, Extent
from closecall.scheduler.model.scene import Body
from closecall.scheduler.motions import (
    Ballistic,
    Constant,
    Fixed,
    Harmonic,
    LeverArms,
    Screw,
    Swing,
)
from oracle.motions import Units, motion_at
from oracle.paths import PATHS, path_of

CASES = 100
RELATIVE = 1e-12


@pytest.mark.parametrize("kind", KINDS)
def test_no_point_leaves_its_displacement_bound_or_outruns_its_path_length(kind):
    rng = np.random.default_rng(1)
    for _ in range(CASES):
        motion = kind(rng)
        points = rng.normal(size=(12, 3)) * rng.uniform(0.01, 2)
        reach = reach_of(motion, points)
        t, duration = interval(rng, motion)
        error = 2 * pose_error(motion, t, duration, reach.radius)
        track = paths(motion, t, duration, points)
        moved = np.max(np.linalg.norm(track - track[0], axis=2))
        travelled = np.max(np.sum(np.linalg.norm(np.diff(track, axis=0), axis=2), axis=0))
        assert motion.displacement(t, duration, reach) * (1 + RELATIVE) >= moved - error
        assert motion.path_length(t, duration, reach) * (1 + RELATIVE) >= travelled - SAMPLES * error


@pytest.mark.parametrize("kind", KINDS)
def test_displacement_and_path_length_never_decrease_with_duration(kind):
    rng = np.random.default_rng(2)
    for _ in range(CASES):
        motion = kind(rng)
        t, duration = interval(rng, motion)
        reach = LeverArms(1.3, 0.7) if motion.axis else LeverArms(1.3, 1.3)
        error = 2 * pose_error(motion, t, duration, 1.3)
        for bound in (motion.displacement, motion.path_length):
            grown = np.array([bound(t, float(s), reach) for s in np.linspace(0, duration, 15)])
            assert np.min(np.diff(grown) + RELATIVE * grown[1:]) >= -error


@pytest.mark.parametrize("kind", KINDS)
def test_the_bounds_are_tight_for_one_point(kind):
    """The median over random cases of bound over truth: none above 2 for a single motion."""
    rng = np.random.default_rng(3)
    displacement, path_length = [], []
    for _ in range(CASES // 2):
        motion = kind(rng)
        point = rng.normal(size=(1, 3))
        t, duration = interval(rng, motion)
        track = paths(motion, t, duration, point)
        moved = np.max(np.linalg.norm(track - track[0], axis=2))
        if moved > 1e-6:
            reach = reach_of(motion, point)
            displacement.append(motion.displacement(t, duration, reach) / moved)
            travelled = np.sum(np.linalg.norm(np.diff(track, axis=0), axis=2))
            path_length.append(motion.path_length(t, duration, reach) / travelled)
    assert len(displacement) > CASES / 8
    assert np.median(displacement) < 2.0
    assert np.median(path_length) < 2.0


def directions_to_ask(rng, rates) -> np.ndarray:
    """Return unit directions (n, 3): the axes, those that the bounds single out, and random ones."""
    singled = [normal for normal, _ in rates.varying.discs] + [rates.axis] * (rates.axis is not None)
    return np.vstack((np.eye(3), -np.eye(3), *singled, [random_unit(rng) for _ in range(5)]))


@pytest.mark.parametrize("kind", KINDS)
def test_rates_bound_the_origin_and_the_turning_up_to_the_next_knot(kind):
    rng = np.random.default_rng(4)
    for _ in range(CASES):
        motion = kind(rng)
        t, duration = interval(rng, motion)
        duration = min(duration, (motion.knot_after(t) - t) * (1 - 1e-9))
        rates = motion.rates(t, duration)
        directions = directions_to_ask(rng, rates)
        step = min(1e-4, duration / 50)
        rounding = pose_error(motion, t, duration, 1.0)
        for s in np.linspace(t + step, t + duration - step, 8):
            before, here, after = (motion.pose(float(s + d)) for d in (-step, 0.0, step))
            velocity = (after[:3, 3] - before[:3, 3]) / (2 * step)
            assert np.linalg.norm(velocity) <= rates.speed * (1 + 1e-6) + 1e-6 + rounding / step
            acceleration = (after[:3, 3] - 2 * here[:3, 3] + before[:3, 3]) / step**2
            slack = 1e-5 * (1 + rates.acceleration) + 4 * rounding / step**2
            varying = acceleration - np.array(rates.steady)
            assert np.linalg.norm(varying) <= rates.acceleration + slack
            assert np.all(directions @ varying <= rates.varying.supports(directions) + slack)
            if rates.axis is not None and rates.angular_speed > 0.0:
                spin = Rotation.from_matrix(after[:3, :3] @ before[:3, :3].T).as_rotvec() / (2 * step)
                assert np.linalg.norm(np.cross(spin, rates.axis)) <= 1e-6 + rounding / step
            turn = np.linalg.norm(after[:3, :3] - before[:3, :3]) / np.sqrt(2) / (2 * step)
            assert turn <= rates.angular_speed * (1 + 1e-6) + 1e-6 + rounding / step


@pytest.mark.parametrize("kind", KINDS)
def test_velocities_are_the_derivative_of_the_pose(kind):
    rng = np.random.default_rng(5)
    for _ in range(CASES // 2):
        motion = kind(rng)
        t = float(rng.uniform(-2, 2))
        step = 1e-7
        if motion.knot_after(t) - t < 2 * step:
            continue
        here, after = motion.pose(t), motion.pose(t + step)
        v, w = motion.velocities(t)
        assert np.linalg.norm((after[:3, 3] - here[:3, 3]) / step - v) < 1e-4 * (1 + np.linalg.norm(v)) * 10
        turn = Rotation.from_matrix(after[:3, :3] @ here[:3, :3].T).as_rotvec() / step
        assert np.linalg.norm(turn - w) < 1e-4 * (1 + np.linalg.norm(w)) * 10


@pytest.mark.parametrize("kind", KINDS)
def test_every_pose_is_rigid(kind):
    rng = np.random.default_rng(6)
    for _ in range(CASES // 4):
        pose = kind(rng).pose(float(rng.uniform(-50, 50)))
        assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-14)
        assert np.linalg.det(pose[:3, :3]) > 0
        assert pose[3].tolist() == [0, 0, 0, 1]


@pytest.mark.parametrize("kind", KINDS)
def test_poses_are_those_of_the_scene_formats_formulas(kind):
    rng = np.random.default_rng(11)
    for _ in range(CASES // 5):
        motion = kind(rng)
        times = rng.uniform(-3, 5, 40)
        spec, units = spec_of(motion), Units(1.0, 1.0)
        keyed = spec["type"] in PATHS
        expected = path_of(spec, units, Path()).at(times) if keyed else motion_at(spec, times, units)
        found = np.array([motion.pose(float(t)) for t in times])
        assert np.abs(found - expected).max() <= 50 * pose_error(motion, -3.0, 8.0, 1.0) + 1e-12


def test_poses_follow_their_formulas():
    t = 0.37
    turn = Rotation.from_rotvec(np.array([0.3, -1.0, 2.0]) * t).as_matrix()
    pose = Ballistic((1.0, 2.0, 3.0), (0.0, 0.0, -9.81), (0.3, -1.0, 2.0)).pose(t)
    assert np.allclose(pose[:3, :3], turn)
    assert np.allclose(pose[:3, 3], [t, 2 * t, 3 * t - 9.81 * t * t / 2])
    pose = Screw((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), 2.0, 0.5).pose(t)
    assert np.allclose(pose @ [1, 0, 0, 1], [1, 0, 0.5 * 2.0 * t / (2 * np.pi), 1])
    assert np.allclose(pose @ [2, 0, 0, 1], [1 + np.cos(2 * t), np.sin(2 * t), 0.5 * 2.0 * t / (2 * np.pi), 1])
    pose = Harmonic((0.0, 1.0, 0.0), 0.4, 2.0, 0.1).pose(t)
    assert np.allclose(pose[:3, 3], [0, 0.4 * np.sin(np.pi * t + 0.1), 0])
    pose = Swing((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), 0.8, 2.0, 0.1).pose(t)
    angle = 0.8 * np.sin(np.pi * t + 0.1)
    assert np.allclose(pose @ [0, 0, 0, 1], [np.sin(angle), 1 - np.cos(angle), 0, 1])


def test_bounds_hold_through_random_chains_of_moving_parents():
    rng = np.random.default_rng(7)
    for _ in range(CASES):
        points = rng.normal(size=(10, 3)) * 0.5
        chain = random_chain(rng, points, 0.0)
        t, duration = float(rng.uniform(-2, 1)), float(rng.choice([0.01, 0.1, 1.0]) * rng.uniform(0.1, 1))
        moment = chain.at(t)
        poses = np.array([chain.at(float(s)).pose for s in np.linspace(t, t + duration, SAMPLES)])
        track = np.einsum("tij,pj->tpi", poses[:, :3, :3], points) + poses[:, None, :3, 3]
        error = 2 * chain.rounding((t, t + duration))
        moved = np.max(np.linalg.norm(track - track[0], axis=2))
        assert chain.displacement(moment, duration) * (1 + RELATIVE) >= moved - error
        travelled = np.max(np.sum(np.linalg.norm(np.diff(track, axis=0), axis=2), axis=0))
        assert chain.path_length(moment, duration) * (1 + RELATIVE) >= travelled - SAMPLES * error


def test_chain_rates_bound_the_speed_and_acceleration_of_every_point():
    rng = np.random.default_rng(8)
    for _ in range(CASES):
        points = rng.normal(size=(10, 3)) * 0.5
        chain = random_chain(rng, points, 0.0)
        t = float(rng.uniform(-2, 1))
        moment = chain.at(t)
        duration = min(0.3, chain.knot_after(t) - t)
        rates, step = chain.rates(moment, duration), min(1e-4, duration / 10)
        speed = rates.speed + rates.angular_speed * chain.radius(Part.WHOLE)
        acceleration = rates.acceleration
        acceleration += (rates.angular_acceleration + rates.angular_speed**2) * chain.radius(Part.WHOLE)
        for s in np.linspace(t + step, t + duration - step, 10):
            a, b, c = (points @ p[:3, :3].T + p[:3, 3] for p in (chain.at(float(s + d)).pose for d in (-step, 0, step)))
            assert np.max(np.linalg.norm(c - a, axis=1)) / (2 * step) <= speed * (1 + 1e-6)
            slack = 1e-4 * (acceleration + np.linalg.norm(rates.steady)) + 1e-13 / step**2
            varying = (a - 2 * b + c) / step**2 - np.array(rates.steady)
            assert np.max(np.linalg.norm(varying, axis=1)) <= acceleration + slack


def test_fixed_frames_that_cancel_are_counted_in_the_rounding():
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[0, 0, 3], poses[1, 0, 3] = 6.4e6, -6.4e6
    motions = (Fixed(), Fixed(), Constant((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    bodies = tuple(
        Body(str(i), i - 1 if i else None, pose, motion, ())
        for i, (pose, motion) in enumerate(zip(poses, motions, strict=True))
    )
    extent = Extent(np.zeros((1, 3)), np.zeros(1), Ball((0.0, 0.0, 0.0), 0.0))
    assert chain_to(bodies, 2, None, extent).rounding((0.0, 1.0)) > 6.4e6 * np.finfo(float).eps


def test_chain_velocities_are_the_derivative_of_the_last_frame():
    rng = np.random.default_rng(9)
    step = 1e-7
    for _ in range(CASES):
        chain = random_chain(rng, np.zeros((1, 3)), 0.1)
        chain.tail[:3, 3] = 0.0
        t = float(rng.uniform(-2, 2))
        if chain.knot_after(t) - t < 2 * step:
            continue
        moment, after = chain.at(t), chain.at(t + step).pose
        _, v, w = moment.twist
        assert np.linalg.norm((after[:3, 3] - moment.pose[:3, 3]) / step - v) < 1e-3 * (1 + np.linalg.norm(v))
        turn = Rotation.from_matrix(after[:3, :3] @ moment.pose[:3, :3].T).as_rotvec() / step
        assert np.linalg.norm(turn - w) < 1e-3 * (1 + np.linalg.norm(w))


def test_a_sliding_origin_is_its_own_reach():
    assert origin_reach(Harmonic((1.0, 0.0, 0.0), 1.0, 1.0, 0.0)) == LeverArms(0.0, 0.0)
