"""Every bound of every motion against dense sampling of its own poses, and the poses against their formulas."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from closecall.scheduler.chain import Ball, Chain, Extent, Joint, chain_to, origin_reach
from closecall.scheduler.motions import (
    Ballistic,
    Constant,
    Fixed,
    Harmonic,
    Keyframes,
    Motion,
    Reach,
    Screw,
    Swing,
)
from closecall.scheduler.scene import Body
from closecall.scheduler.vector import Vector

CASES = 300
SAMPLES = 400
ROUNDING = 1e-9


def vector(array) -> Vector:
    x, y, z = map(float, array)
    return x, y, z


def random_unit(rng) -> Vector:
    v = rng.normal(size=3)
    return vector(v / np.linalg.norm(v))


def random_vector(rng, size=1.0) -> Vector:
    return vector(rng.normal(size=3) * size)


def constant(rng) -> Motion:
    spin = random_vector(rng, 3.0) if rng.random() < 0.8 else (0.0, 0.0, 0.0)
    return Constant(random_vector(rng), spin)


def ballistic(rng) -> Motion:
    return Ballistic(random_vector(rng), random_vector(rng, 4.0), random_vector(rng, rng.choice([0.0, 3.0])))


def screw(rng) -> Motion:
    return Screw(random_unit(rng), random_vector(rng), float(rng.normal() * 4), float(rng.normal()))


def harmonic(rng) -> Motion:
    return Harmonic(random_unit(rng), float(rng.normal()), float(rng.uniform(0.05, 3)), float(rng.uniform(-9, 9)))


def swing(rng) -> Motion:
    amplitude, period, phase = float(rng.normal() * 2), float(rng.uniform(0.05, 3)), float(rng.uniform(-9, 9))
    return Swing(random_unit(rng), random_vector(rng), amplitude, period, phase)


def keyframes(rng, step_translation=False, step_rotation=False) -> Motion:
    count = int(rng.integers(2, 7))
    times = np.cumsum(rng.uniform(0.1, 1.5, count)) - 2.0
    quaternions = rng.normal(size=(count, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1)[:, None]
    return Keyframes(times, rng.normal(size=(count, 3)), quaternions, step_translation, step_rotation)


def stepped_translation(rng) -> Motion:
    return keyframes(rng, step_translation=True)


def stepped_rotation(rng) -> Motion:
    return keyframes(rng, step_rotation=True)


KINDS = [constant, ballistic, screw, harmonic, swing, keyframes, stepped_translation, stepped_rotation]


def reach_of(motion: Motion, points: np.ndarray) -> Reach:
    radius = float(np.max(np.linalg.norm(points, axis=1)))
    if motion.axis is None:
        return Reach(radius, radius)
    arms = np.cross(points - np.array(motion.axis.point), np.array(motion.axis.direction))
    return Reach(radius, float(np.max(np.linalg.norm(arms, axis=1))))


def interval(rng, motion: Motion) -> tuple[float, float]:
    """Return a random t and duration without a jump after t and before or at t + duration."""
    t = float(rng.uniform(-2, 2))
    duration = float(rng.choice([1e-4, 0.01, 0.1, 1.0, 4.0]) * rng.uniform(0.1, 1))
    return t, min(duration, (motion.stop_after(t) - t) * (1 - 1e-9))


def paths(motion: Motion, t: float, duration: float, points: np.ndarray) -> np.ndarray:
    """Return the points at SAMPLES times, (SAMPLES, points, 3)."""
    poses = np.array([motion.pose(float(s)) for s in np.linspace(t, t + duration, SAMPLES)])
    return np.einsum("tij,pj->tpi", poses[:, :3, :3], points) + poses[:, None, :3, 3]


@pytest.mark.parametrize("kind", KINDS)
def test_no_point_leaves_its_displacement_bound_or_outruns_its_path_length(kind):
    rng = np.random.default_rng(1)
    for _ in range(CASES):
        motion = kind(rng)
        points = rng.normal(size=(12, 3)) * rng.uniform(0.01, 2)
        reach = reach_of(motion, points)
        t, duration = interval(rng, motion)
        track = paths(motion, t, duration, points)
        moved = np.max(np.linalg.norm(track - track[0], axis=2))
        travelled = np.max(np.sum(np.linalg.norm(np.diff(track, axis=0), axis=2), axis=0))
        assert motion.displacement(t, duration, reach) >= moved - ROUNDING
        assert motion.path_length(t, duration, reach) >= travelled - ROUNDING


@pytest.mark.parametrize("kind", KINDS)
def test_displacement_never_decreases_with_duration(kind):
    rng = np.random.default_rng(2)
    for _ in range(CASES):
        motion = kind(rng)
        t, duration = interval(rng, motion)
        reach = Reach(1.3, 0.7) if motion.axis else Reach(1.3, 1.3)
        grown = [motion.displacement(t, float(s), reach) for s in np.linspace(0, duration, 60)]
        assert np.min(np.diff(grown)) >= -ROUNDING


@pytest.mark.parametrize("kind", KINDS)
def test_the_displacement_bound_is_tight_for_one_point(kind):
    """The median over random cases of bound over truth: none above 2 for a single motion."""
    rng = np.random.default_rng(3)
    ratios = []
    for _ in range(CASES):
        motion = kind(rng)
        point = rng.normal(size=(1, 3))
        t, duration = interval(rng, motion)
        track = paths(motion, t, duration, point)
        truth = np.max(np.linalg.norm(track - track[0], axis=2))
        if truth > 1e-6:
            ratios.append(motion.displacement(t, duration, reach_of(motion, point)) / truth)
    assert np.median(ratios) < 2.0


@pytest.mark.parametrize("kind", KINDS)
def test_rates_bound_the_origin_and_the_turning_up_to_the_next_knot(kind):
    rng = np.random.default_rng(4)
    for _ in range(CASES):
        motion = kind(rng)
        t, duration = interval(rng, motion)
        duration = min(duration, (motion.knot_after(t) - t) * (1 - 1e-9))
        rates = motion.rates(t, duration)
        step = min(1e-4, duration / 50)
        for s in np.linspace(t + step, t + duration - step, 25):
            before, here, after = (motion.pose(float(s + d)) for d in (-step, 0.0, step))
            velocity = (after[:3, 3] - before[:3, 3]) / (2 * step)
            assert np.linalg.norm(velocity) <= rates.speed * (1 + 1e-6) + 1e-6
            acceleration = (after[:3, 3] - 2 * here[:3, 3] + before[:3, 3]) / step**2
            slack = 1e-5 * (1 + rates.acceleration) + 1e-14 / step**2
            assert np.linalg.norm(acceleration - np.array(rates.steady)) <= rates.acceleration + slack
            turn = Rotation.from_matrix(after[:3, :3] @ before[:3, :3].T).magnitude() / (2 * step)
            assert turn <= rates.angular_speed * (1 + 1e-6) + 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_velocities_are_the_derivative_of_the_pose(kind):
    rng = np.random.default_rng(5)
    for _ in range(CASES):
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
    for _ in range(CASES):
        pose = kind(rng).pose(float(rng.uniform(-50, 50)))
        assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-14)
        assert np.linalg.det(pose[:3, :3]) > 0
        assert pose[3].tolist() == [0, 0, 0, 1]


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


def test_slerp_turns_the_short_way_at_a_constant_rate():
    quarter = [np.cos(np.pi / 4), 0, 0, np.sin(np.pi / 4)]
    keys = Keyframes(np.array([0.0, 2.0]), np.zeros((2, 3)), np.array([[1, 0, 0, 0], -np.array(quarter)]), False, False)
    for t in (0.0, 0.5, 1.9):
        assert np.allclose(keys.pose(t)[:3, :3], Rotation.from_rotvec([0, 0, np.pi / 4 * t]).as_matrix())
    assert keys.velocities(1.0)[1] == pytest.approx((0, 0, np.pi / 4))


def test_a_step_is_a_stop_just_before_and_at_the_jump_and_the_pose_is_the_new_one():
    keys = Keyframes(
        np.array([0.0, 1.0, 2.0]),
        np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 0]]),
        np.tile([1.0, 0, 0, 0], (3, 1)),
        True,
        False,
    )
    before = float(np.nextafter(1.0, 0.0))
    assert keys.stop_after(0.2) == before
    assert keys.stop_after(before) == 1.0
    assert keys.stop_after(1.0) == np.inf
    assert keys.pose(before)[0, 3] == 0.0
    assert keys.pose(1.0)[0, 3] == 1.0
    assert keys.displacement(0.2, before - 0.2, Reach(1.0, 1.0)) == 0.0


def random_chain(rng, points, radius) -> Chain:
    """Return a chain of one to four joints that carries these points, each rounded by `radius`."""
    joints = []
    for _ in range(int(rng.integers(1, 5))):
        rest = np.eye(4)
        rest[:3, :3] = Rotation.random(rng=rng).as_matrix()
        rest[:3, 3] = rng.normal(size=3)
        kind = KINDS[int(rng.integers(0, 6))]
        joints.append(Joint(rest, kind(rng)))
    tail = np.eye(4)
    tail[:3, 3] = rng.normal(size=3) * 0.3
    centre = points.mean(axis=0)
    ball = Ball(vector(centre), float(np.max(np.linalg.norm(points - centre, axis=1)) + radius))
    return Chain(tuple(joints), tail, Extent(points, np.full(len(points), radius), ball))


def test_bounds_hold_through_random_chains_of_moving_parents():
    rng = np.random.default_rng(7)
    for _ in range(CASES):
        points = rng.normal(size=(10, 3)) * 0.5
        chain = random_chain(rng, points, 0.0)
        t, duration = float(rng.uniform(-2, 1)), float(rng.choice([0.01, 0.1, 1.0]) * rng.uniform(0.1, 1))
        moment = chain.at(t)
        poses = np.array([chain.at(float(s)).pose for s in np.linspace(t, t + duration, SAMPLES)])
        track = np.einsum("tij,pj->tpi", poses[:, :3, :3], points) + poses[:, None, :3, 3]
        assert chain.displacement(moment, duration) >= np.max(np.linalg.norm(track - track[0], axis=2)) - ROUNDING
        travelled = np.max(np.sum(np.linalg.norm(np.diff(track, axis=0), axis=2), axis=0))
        assert chain.path_length(moment, duration) >= travelled - ROUNDING


def test_chain_rates_bound_the_speed_and_acceleration_of_every_point():
    rng = np.random.default_rng(8)
    for _ in range(CASES):
        points = rng.normal(size=(10, 3)) * 0.5
        chain = random_chain(rng, points, 0.0)
        t = float(rng.uniform(-2, 1))
        moment = chain.at(t)
        duration = min(0.3, chain.knot_after(t) - t)
        rates, step = chain.rates(moment, duration), min(1e-4, duration / 10)
        speed = rates.speed + rates.angular_speed * chain.radius
        acceleration = np.linalg.norm(rates.steady) + rates.acceleration
        acceleration += (rates.angular_acceleration + rates.angular_speed**2) * chain.radius
        for s in np.linspace(t + step, t + duration - step, 10):
            a, b, c = (points @ p[:3, :3].T + p[:3, 3] for p in (chain.at(float(s + d)).pose for d in (-step, 0, step)))
            assert np.max(np.linalg.norm(c - a, axis=1)) / (2 * step) <= speed * (1 + 1e-6)
            slack = 1e-4 * acceleration + 1e-13 / step**2
            assert np.max(np.linalg.norm(a - 2 * b + c, axis=1)) / step**2 <= acceleration + slack


def test_a_long_way_travelled_does_not_coarsen_the_bounds_of_what_follows():
    """A thousand keys 1 mm apart after 1e5 m: the running sums are kept in two floats each."""
    x = np.concatenate(([0.0, 1e5 + 0.1], 1e5 + 0.1 + 1e-3 * np.arange(1, 1001)))
    keys = Keyframes(
        np.arange(len(x), dtype=np.float64),
        np.column_stack((x, x * 0, x * 0)),
        np.tile([1.0, 0, 0, 0], (len(x), 1)),
        False,
        False,
    )
    for first in (1, 7, 500):
        truth = abs(keys.pose(1001.0)[0, 3] - keys.pose(float(first))[0, 3])
        assert keys.displacement(float(first), 1001.0 - first, Reach(0.0, 0.0)) >= truth - 1e-10
        assert keys.rounding_scale(1001.0, 1.0) < 1e6


def test_a_glitch_elsewhere_does_not_loosen_the_error_of_a_pose_at_rest():
    """A jump of 1 m in 1 ns, far from the times of interest, once made the error grow to millimetres."""
    times = np.array([0.0, 1.0, 1.0 + 1e-9, 1000.0])
    x = np.array([[0.0, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0]])
    keys = Keyframes(times, x, np.tile([1.0, 0, 0, 0], (4, 1)), False, False)
    assert 8 * np.finfo(float).eps * keys.rounding_scale(1000.0, 1.0) < 1e-13


def test_fixed_frames_that_cancel_are_counted_in_the_rounding():
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[0, 0, 3], poses[1, 0, 3] = 6.4e6, -6.4e6
    motions = (Fixed(), Fixed(), Constant((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    bodies = tuple(
        Body(str(i), i - 1 if i else None, pose, motion, ())
        for i, (pose, motion) in enumerate(zip(poses, motions, strict=True))
    )
    extent = Extent(np.zeros((1, 3)), np.zeros(1), Ball((0.0, 0.0, 0.0), 0.0))
    assert chain_to(bodies, 2, None, extent).rounding(1.0) > 6.4e6 * np.finfo(float).eps


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
        v, w = chain.velocities(moment)
        assert np.linalg.norm((after[:3, 3] - moment.pose[:3, 3]) / step - v) < 1e-3 * (1 + np.linalg.norm(v))
        turn = Rotation.from_matrix(after[:3, :3] @ moment.pose[:3, :3].T).as_rotvec() / step
        assert np.linalg.norm(turn - w) < 1e-3 * (1 + np.linalg.norm(w))


def test_rounding_covers_what_poses_lose_at_large_coordinates_and_times():
    """A slide's poses against extended precision, 40 fast ones over a long time."""
    wide = np.longdouble
    circle = 2 * wide("3.14159265358979323846264338327950288")
    rng = np.random.default_rng(10)
    for _ in range(40):
        motion = Harmonic(random_unit(rng), float(rng.normal() * 1e3), float(rng.uniform(1e-4, 1e-2)), 1.0)
        t = float(rng.uniform(10, 1e6))
        phase = circle * np.fmod(wide(t), wide(motion.period)) / wide(motion.period) + wide(motion.phase)
        error = abs(float(wide(motion.amplitude) * np.sin(phase) - np.dot(motion.pose(t)[:3, 3], motion.direction)))
        assert error <= 8 * np.finfo(float).eps * motion.rounding_scale(1e6, 1.0)
    assert origin_reach(Harmonic((1.0, 0.0, 0.0), 1.0, 1.0, 0.0)) == Reach(0.0, 0.0)
