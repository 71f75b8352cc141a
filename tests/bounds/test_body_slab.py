"""The slab between whole bodies, held against dense samples of moving convex sets (by GJK of the oracle)."""

from math import inf, sqrt

import numpy as np
import pytest
from drawn_motions import CONTINUOUS, random_chain, random_unit, vector
from small_scenes import box

from closecall.scheduler.bounds.body_slab import BodySlab, Points, lasting_slab
from closecall.scheduler.kinematics.chain import Part, Twist
from closecall.scheduler.kinematics.relative_motion import RelativeMotion, RelativeRates
from closecall.scheduler.model.scene import Body, PairRules, Scene
from closecall.scheduler.motions import Fixed, Harmonic
from closecall.scheduler.motions.acceleration_set import STILL, ball
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide
from closecall.scheduler.pairs.separation import SeparationSleep, Tuning
from oracle.gjk import distances

CASES = 50
SAMPLES = 20
ROUNDING = 1e-9

AT_REST = Twist((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])


def moved(pose, points) -> np.ndarray:
    return points @ pose[:3, :3].T + pose[:3, 3]


def hull_distance(one, other) -> float:
    """Return m: the distance of two hulls of points (n, 3), negative where they overlap."""

    def support(points):
        return lambda directions, _: points[(directions @ points.T).argmax(axis=1)]

    return float(distances(support(one), support(other), 1, (one[:1] - other[:1]))[0])


def nearest_faces(one, other) -> tuple[np.ndarray, np.ndarray]:
    """Return three points of each that are the farthest towards the other."""
    way = other.mean(axis=0) - one.mean(axis=0)
    return one[np.argsort(one @ way)[-3:]], other[np.argsort(other @ way)[:3]]


class Case:
    """Two clouds of points on random chains of motions, apart by a random way, and the slab between them."""

    def __init__(self, rng) -> None:
        size = float(10.0 ** rng.uniform(-2, 0.5))
        self.own = [rng.normal(size=(int(rng.integers(4, 12)), 3)) * size for _ in range(2)]
        self.radii = [float(rng.choice([0.0, 0.2 * size])) for _ in range(2)]
        self.t, duration = float(rng.uniform(-1, 1)), float(10.0 ** rng.uniform(-4, 0.3))
        a, b = (random_chain(rng, points, 0.0, CONTINUOUS) for points in self.own)
        self.motion = RelativeMotion(a, b)
        state = self.motion.at(self.t)
        poses = state.a.pose, state.b.pose
        apart = np.array(random_unit(rng)) * size * float(rng.uniform(2, 8))
        self.shift = poses[0][:3, 3] - poses[1][:3, 3] + apart
        one, other = self.placed(self.t)
        twists = state.a.twist, state.b.twist
        twists = twists[0], twists[1]._replace(origin=vector(np.array(twists[1].origin) + self.shift))
        bodies = [
            Points(places, np.full(len(places), radius), twist)
            for places, radius, twist in zip((one, other), self.radii, twists, strict=True)
        ]
        near = self.motion.approach(state, duration, Part.CORE)
        self.horizon = near.horizon
        self.slab = lasting_slab(bodies[0], bodies[1], nearest_faces(one, other), 0.0, 0.0, near, 0.0)

    def placed(self, t) -> tuple[np.ndarray, np.ndarray]:
        state = self.motion.at(t)
        return moved(state.a.pose, self.own[0]), moved(state.b.pose, self.own[1]) + self.shift

    def nearest(self, duration) -> float:
        """Return the least distance (m) at samples of the time from t on."""
        times = self.t + np.linspace(0.0, duration, SAMPLES)
        return min(hull_distance(*self.placed(float(t))) for t in times) - sum(self.radii)


def test_bodies_stay_apart_while_the_slab_does():
    rng = np.random.default_rng(1)
    slept = 0
    for _ in range(CASES):
        case = Case(rng)
        spare = 0.3 * max(0.0, case.nearest(0.0)) if rng.random() < 0.5 else 0.0
        if case.slab is None:
            continue
        sleep = case.slab.sleep(spare)
        assert 0.0 <= sleep <= case.horizon
        if sleep > 0.0:
            slept += 1
            assert case.nearest(sleep) >= spare - ROUNDING
    assert slept > CASES // 4


def test_the_clearance_of_the_slab_is_kept():
    rng = np.random.default_rng(2)
    told = 0
    for _ in range(CASES):
        case = Case(rng)
        if case.slab is None:
            continue
        duration = case.horizon * float(10.0 ** rng.uniform(-3, 0))
        clearance = case.slab.clearance(duration)
        told += clearance > 0.0
        assert clearance <= 0.0 or case.nearest(duration) >= clearance - ROUNDING
        assert case.slab.clearance(2.0 * case.horizon) == -inf
    assert told > CASES // 5


def slab(twist, ahead, gap=1e-3) -> BodySlab:
    """Return the slab between a square that moves and one above it at rest."""
    above = SQUARE + np.array([0.0, 0.0, gap])
    one = Points(SQUARE, np.zeros(4), twist)
    other = Points(above, np.zeros(4), AT_REST)
    found = lasting_slab(one, other, (SQUARE[:3], above[:3]), 0.0, 0.0, ahead, 0.0)
    assert found is not None
    return found


def test_motion_along_the_slab_costs_nothing():
    ahead = RelativeRates(1e3, 10.0, 3.0, (9.81, 0.0, -1.0), STILL)
    assert slab(AT_REST._replace(velocity=(1e3, 5e2, 0.0)), ahead).sleep(0.0) == 3.0


@pytest.mark.parametrize("varying", [0.0, 0.5])
def test_an_acceleration_closes_it_by_its_part_across(varying):
    """From rest, 1 mm apart, at 2 m/s^2 upwards: after sqrt(2 x 0.001 / 2) s."""
    ahead = RelativeRates(0.0, 10.0, 3.0, (9.0, 0.0, 2.0), ball(varying))
    found = slab(AT_REST, ahead).sleep(0.0)
    assert sqrt(2e-3 / (2.0 + varying)) * 0.99 < found <= sqrt(2e-3 / (2.0 + varying))


def test_a_square_that_tilts_closes_it_with_its_far_corner():
    """About the y axis through its edge at x = 0, at 0.1 rad/s towards the other: the corner rises by 0.1 m/s."""
    ahead = RelativeRates(0.1, 0.0, 1.0, (0.0, 0.0, 0.0), STILL)
    found = slab(AT_REST._replace(angular_velocity=(0.0, -0.1, 0.0)), ahead).sleep(0.0)
    assert found == pytest.approx(1e-2, rel=1e-6)


def test_nothing_is_slept_on_where_a_distance_is_hardly_above_what_it_is_to_keep():
    """By less than what is granted to rounding: there is nothing to spend, nor less than nothing."""
    bodies = (
        Body("a", None, np.eye(4), Harmonic((1.0, 0.0, 0.0), 0.05, 1.0, 1.0), (box(1.0, 1.0, 1.0),)),
        Body(
            "b", None, np.array([[1.0, 0, 0, 1.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]), Fixed(), (box(1, 1, 1),)
        ),
    )
    (pair,) = pairs_that_might_collide(Scene(bodies, 0.0, 1.0, PairRules()), NarrowPhase(bodies), 0.0)
    measurement = pair.measure_exactly(0.0)
    keeps = measurement.clearance * (1.0 - 1e-15)
    assert SeparationSleep(pair, measurement, keeps, Tuning()).sleep(1.0, 1e-3)[0] < 1e-12
