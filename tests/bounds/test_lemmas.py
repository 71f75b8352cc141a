"""Lemmas of docs/guarantees.md that other tests see only from afar: each bound above the truth, and not far above.

The truth is a closed form, or dense samples of the bodies' own poses. `python -m spoilt`, from tests/, spoils each
lemma on purpose and sees that a test objects.
"""

from math import asinh, hypot, inf, nextafter, pi

import numpy as np
import pytest
from drawn_motions import RandomCourse, random_unit, vector

from closecall.scheduler.bounds import motion_bound
from closecall.scheduler.bounds.body_slab import Points, lasting_slab
from closecall.scheduler.bounds.triangle_slabs import TriangleSlabs
from closecall.scheduler.kinematics.chain import Chain, Joint, Twist
from closecall.scheduler.kinematics.relative_motion import RelativeMotion, RelativeRates
from closecall.scheduler.model.extent import Ball, Extent
from closecall.scheduler.motions import Ballistic, Constant, Harmonic, Keyframes, Limits, Motion, Translation
from closecall.scheduler.motions.acceleration_set import STILL as STANDING
from closecall.scheduler.motions.acceleration_set import AccelerationSet
from closecall.scheduler.narrow.triangle_pairs import NearTriangles
from oracle.rigid import rigid, rotations

O = (0.0, 0.0, 0.0)  # noqa: E741
CASES = 50
ROUNDING = 1e-9


def carried(points, *motions: Motion) -> Chain:
    """Return the chain of motions, outermost first, that carries points (n, 3) m."""
    points = np.asarray(points, dtype=float)
    radius = float(np.linalg.norm(points, axis=1).max())
    joints = tuple(Joint(np.eye(4), motion) for motion in motions)
    return Chain(joints, np.eye(4), Extent(points, np.zeros(len(points)), Ball(O, radius)))


STILL = carried([O])


def across(rng, axis) -> np.ndarray:
    """Return a random unit vector across a unit vector."""
    found = np.cross(axis, random_unit(rng))
    return found / np.linalg.norm(found)


class Ring:
    """Points on a circle about an axis that they spin about, and fly across it."""

    def __init__(self, rng, axis) -> None:
        radius, self.spin = float(rng.uniform(0.1, 3.0)), float(rng.normal() * 3.0) * np.array(axis)
        first = across(rng, axis)
        angles = np.linspace(0.0, 2.0 * pi, 200)[:, None]
        self.points = radius * (np.cos(angles) * first + np.sin(angles) * np.cross(axis, first))
        self.velocity, self.acceleration = (across(rng, axis) * float(rng.uniform(0.0, 5.0)) for _ in range(2))
        self.chain = carried(self.points, Ballistic(*map(vector, (self.velocity, self.acceleration, self.spin))))

    def velocities(self) -> np.ndarray:
        return self.velocity + np.cross(self.spin, self.points)

    def accelerations(self) -> np.ndarray:
        return self.acceleration - (self.spin @ self.spin) * self.points


def farthest(one, other) -> float:
    """Return the largest distance of any of the vectors (n, 3) from any of (k, 3)."""
    return float(np.linalg.norm(one[:, None] - other, axis=2).max())


def test_the_lectures_speed_and_acceleration_are_those_of_the_outermost_points():
    """Of two rings about one axis some two points run opposite ways: the bounds are exact."""
    rng = np.random.default_rng(1)
    for _ in range(CASES):
        axis = random_unit(rng)
        one, other = Ring(rng, axis), Ring(rng, axis)
        motion = RelativeMotion(one.chain, other.chain)
        near = motion.approach(motion.at(0.0), 1.0)
        speed, acceleration = (
            farthest(one.velocities(), other.velocities()),
            farthest(one.accelerations(), other.accelerations()),
        )
        assert speed * (1.0 - ROUNDING) <= near.speed <= 1.001 * speed
        assert acceleration * (1.0 - ROUNDING) <= near.acceleration <= 1.001 * acceleration


def test_no_two_points_get_farther_than_the_lecture_says():
    rng = np.random.default_rng(2)
    ratios = []
    for _ in range(CASES):
        course = RandomCourse(rng)
        near = course.motion.approach(course.state, course.duration)
        starts, truth = points_at(course.motion, course.t), 0.0
        for s in np.linspace(0.0, near.horizon, 20)[1:].tolist():
            moved = [now - start for now, start in zip(points_at(course.motion, course.t + s), starts, strict=True)]
            truth = farthest(*moved)
            assert near.distance(s) * (1.0 + ROUNDING) >= truth - course.motion.rounding((course.t, course.t + s))
        ratios.append(near.distance(near.horizon) / truth)
        assert near.distance(nextafter(near.horizon, inf)) == inf
    assert np.median(ratios) < 30.0


def points_at(motion: RelativeMotion, t: float) -> list[np.ndarray]:
    """Return the points (n, 3) m of both bodies at a time (s)."""
    state = motion.at(t)
    chains = ((motion.a, state.a), (motion.b, state.b))
    return [chain.extent.points @ moment.pose[:3, :3].T + moment.pose[:3, 3] for chain, moment in chains]


@pytest.mark.parametrize("seed", range(10))
def test_what_slides_out_on_a_turntable_goes_a_spiral(seed):
    """From the middle at v, the table at w: it goes the spiral of Archimedes, and Coriolis accelerates it."""
    rng = np.random.default_rng(seed)
    axis = random_unit(rng)
    speed, spin, duration = (float(10.0 ** rng.uniform(-1.0, 1.0)) for _ in range(3))
    slide = Constant(vector(speed * across(rng, axis)), O)
    chain = carried([O], Constant(O, vector(spin * np.array(axis))), slide)
    turned = spin * duration
    truth = 0.5 * speed * (duration * hypot(1.0, turned) + asinh(turned) / spin)
    assert truth * (1.0 - ROUNDING) <= chain.path_length(chain.at(0.0), duration) <= 2.5 * truth
    motion = RelativeMotion(chain, STILL)
    near = motion.approach(motion.at(0.0), duration)
    truth = hypot(spin * spin * speed * duration, 2.0 * spin * speed)
    assert truth * (1.0 - ROUNDING) <= near.acceleration <= 1.5 * truth
    assert near.speed == pytest.approx(speed, rel=1e-9)


def test_spins_about_crossed_axes_accelerate_each_other():
    """A top that spins about its own axis, which turns: its angular velocity changes by the product of the two."""
    rng = np.random.default_rng(3)
    for _ in range(CASES):
        axis = random_unit(rng)
        outer, inner = float(rng.uniform(0.1, 9.0)), float(rng.uniform(0.1, 9.0))
        spins = Constant(O, vector(outer * np.array(axis))), Constant(O, vector(inner * across(rng, axis)))
        chain = carried([(0.0, 0.0, 1.0)], *spins)
        found = chain.rates(chain.at(0.0), 1.0).angular_acceleration
        assert outer * inner * (1.0 - ROUNDING) <= found <= outer * inner * (1.0 + ROUNDING)


@pytest.mark.parametrize("duration", [0.42, 0.45, 0.5, 1.0, 1.5])
def test_what_swings_to_and_fro_is_not_proved_apart_by_where_it_ends(duration):
    """A dart swings by 1 m towards a wall 0.6 m away and back: it was 0.4 m inside, wherever it is seen again."""
    swing = RelativeMotion(carried([O], Harmonic((1.0, 0.0, 0.0), 1.0, 1.0, 0.0)), STILL)
    times = np.linspace(0.0, duration, 2001)
    gaps = 0.6 - np.sin(2.0 * pi * times)
    proof = motion_bound.proof(swing, swing.at(0.0), 0.6, duration, float(gaps[-1]))
    assert gaps[-1] > 0.0
    assert proof.clearance <= float(gaps.min()) + 1e-6
    assert 0.4 - 1e-6 <= proof.depth_limit <= 0.4 + 2.0 * duration


def test_two_measurements_prove_as_much_as_the_way_between_leaves():
    """On a straight line towards a wall that stays: of 2 m before and 1 m after, 1 m is left, and is proved."""
    line = RelativeMotion(carried([O], Constant((1.0, 0.0, 0.0), O)), STILL)
    proof = motion_bound.proof(line, line.at(0.0), 2.0, 1.0, 1.0)
    assert 0.999 < proof.clearance <= 1.0


def test_balls_of_unknown_paths_grow_by_what_their_limits_allow():
    limits = Limits(0.0, 0.5, 2.0, 3.0)
    motion = RelativeMotion(STILL, STILL, (limits,))
    for t, duration in ((0.0, 0.2), (0.3, 1.0), (2.0, 4.0)):
        grown = limits.reach(t + duration) - limits.reach(t)
        for bound in (motion.displacement, motion.path_length):
            assert bound(motion.at(t), duration) == pytest.approx(grown, rel=1e-12)
        near = motion.approach(motion.at(t), duration)
        assert near.distance(min(duration, near.horizon)) >= limits.reach(
            t + min(duration, near.horizon)
        ) - limits.reach(t)


def test_the_lecture_looks_no_farther_than_the_next_knot():
    """A body stands until its next key, however long the sleep, and then goes fast."""
    rng = np.random.default_rng(4)
    for _ in range(CASES):
        times = np.cumsum(rng.uniform(0.1, 1.0, 3))
        places = np.array([O, O, (10.0, 0.0, 0.0)])
        turns = np.tile((1.0, 0.0, 0.0, 0.0), (3, 1))
        motion = RelativeMotion(STILL, carried([O], Keyframes(times, places, turns, Translation.LINEAR, False)))
        now = float(rng.uniform(times[0], times[1]))
        near = motion.approach(motion.at(now), 9.0)
        assert times[1] - 1e-9 <= now + near.horizon <= times[1]
        assert near.distance(near.horizon) == 0.0
        assert near.distance(9.0) == inf


def test_what_turns_about_an_axis_stays_in_what_is_said_to_hold_it():
    """Accelerations of a frame that another one turns, in every direction, at every angle of the turn."""
    rng = np.random.default_rng(5)
    for _ in range(CASES):
        kind = int(rng.integers(0, 3))
        disc, line = (random_unit(rng), float(rng.uniform(0.1, 2.0))), vector(rng.normal(size=3))
        spread = AccelerationSet(
            0.0 if kind else float(rng.uniform(0.0, 1.0)), (disc,) * (kind != 1), (line,) * (kind != 2)
        )
        axis = random_unit(rng)
        held = spread.swept_about(axis)
        turns = rigid(rotations(np.array(axis), np.linspace(0.0, 2.0 * pi, 181)), np.zeros((181, 3)))
        for direction in [axis, *(random_unit(rng) for _ in range(5))]:
            truth = max(spread.turned(turn).support(direction) for turn in turns)
            assert truth * (1.0 - ROUNDING) <= held.support(direction) <= 2.0 * truth + ROUNDING


def drifting(rng, speed: float) -> Twist:
    """Return a motion at this speed (m/s) along z, with a drift across it and a spin about it."""
    return Twist(O, vector((*rng.normal(size=2), speed)), (0.0, 0.0, float(rng.normal())))


def test_triangles_that_fly_at_each_other_close_their_slab_at_both_speeds():
    """One above the other, each at a speed of its own and with a drift along the slab, which does not close it."""
    rng = np.random.default_rng(6)
    flat = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    for _ in range(CASES):
        gap, (up, down) = float(rng.uniform(0.1, 2.0)), rng.uniform(0.1, 3.0, 2).tolist()
        twists = drifting(rng, up), drifting(rng, -down)
        triangles = NearTriangles(flat[None], flat[None] + [0.0, 0.0, gap], np.zeros(1))
        slabs = TriangleSlabs(
            triangles, twists, (0.0, 0.0, 1.0), 0.0, inf, RelativeRates(0.0, 0.0, 100.0, O, STANDING), 0.0
        )
        truth = gap / (up + down)
        assert truth * (1.0 - ROUNDING) <= slabs.sleep(0.0) <= truth
        half = 0.5 * truth
        assert 0.5 * gap * (1.0 - ROUNDING) <= slabs.clearance(half, 0.0) <= 0.5 * gap * (1.0 + ROUNDING)


def test_errors_of_measurement_are_taken_off_slabs():
    """Between two triangles at rest, one above the other: of the gap, all but the error is certain."""
    flat = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    rest, future = Twist(O, O, O), RelativeRates(0.0, 0.0, 100.0, O, STANDING)
    for gap, error in ((1.0, 0.25), (0.3, 0.1), (1e-3, 1e-4)):
        above = flat + np.array([0.0, 0.0, gap])
        one, other = (Points(corners, np.zeros(3), rest) for corners in (flat, above))
        whole = lasting_slab(one, other, (flat, above), error, 0.0, future, 0.0)
        assert whole is not None
        triangles = NearTriangles(flat[None], above[None], np.zeros(1))
        each = TriangleSlabs(triangles, (rest, rest), (0.0, 0.0, 1.0), error, inf, future, 0.0)
        for certain in (whole.clearance(1.0), each.clearance(1.0, 0.0)):
            assert 0.999 * (gap - error) <= certain <= gap - error
