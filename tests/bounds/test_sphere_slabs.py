"""Slabs between bounding balls, held against dense samples of their closed-form gap."""

from math import hypot, inf

import numpy as np
import pytest
from drawn_motions import CONTINUOUS, RandomCourse, random_chain, random_unit, vector
from small_scenes import box, events_of

from closecall.scheduler.bounds.sphere_slabs import MOST_SLABS, SphereSlab, SphereSlabs
from closecall.scheduler.geometry.vector import subtract
from closecall.scheduler.kinematics.chain import Chain, Joint, Part
from closecall.scheduler.kinematics.relative_motion import RelativeMotion, RelativeRates
from closecall.scheduler.model.events import Bound, Span, Wakeup
from closecall.scheduler.model.extent import Ball, Extent
from closecall.scheduler.model.scene import Body
from closecall.scheduler.motions import Constant, Fixed, Keyframes, Translation
from closecall.scheduler.motions.acceleration_set import STILL, AccelerationSet, ball

CASES = 150
PATHS = 40
SAMPLES = 40
ROUNDING = 1e-9
STEADY = RelativeRates(0.0, 0.0, 10.0, (0.0, 0.0, 0.0), STILL)


class Case:
    """Two balls on random chains of motions, apart by a random way, and the slab between them."""

    def __init__(self, rng) -> None:
        size = float(10.0 ** rng.uniform(-2, 0.5))
        points = [rng.normal(size=(5, 3)) * size for _ in range(2)]
        self.t, duration = float(rng.uniform(-1, 1)), float(10.0 ** rng.uniform(-3, 0.5))
        one, other = (random_chain(rng, cloud, 0.0, CONTINUOUS) for cloud in points)
        self.radii = one.ball.radius + other.ball.radius
        self.motion = RelativeMotion(one, other)
        state = self.motion.at(self.t)
        apart = np.array(random_unit(rng)) * self.radii * float(rng.uniform(1.05, 4))
        self.shift = apart - (np.array(state.b.centre) - np.array(state.a.centre))
        closing = subtract(state.a.twist.of(state.a.centre), state.b.twist.of(state.b.centre))
        near = self.motion.approach(state, duration, Part.CENTRE)
        self.beyond = float(rng.choice([0.0, 0.02])) * self.radii
        self.slab = SphereSlab(vector(apart), self.radii, closing, self.beyond, near, 0.0)

    def nearest(self, duration) -> float:
        """Return the least gap (m) at samples of the time from t on."""
        times = self.t + np.linspace(0.0, duration, SAMPLES)
        state = [self.motion.at(float(t)) for t in times]
        ways = np.array([np.subtract(moment.b.centre, moment.a.centre) for moment in state]) + self.shift
        return float(np.linalg.norm(ways, axis=1).min()) - self.radii


def test_balls_stay_apart_while_the_slab_does():
    rng = np.random.default_rng(1)
    slept = 0
    for _ in range(CASES):
        case = Case(rng)
        sleep = case.slab.sleep(case.beyond)
        assert 0.0 <= sleep <= case.slab.horizon
        if sleep > 0.0:
            slept += 1
            assert case.nearest(sleep) >= case.beyond - ROUNDING
    assert slept > CASES // 2


def test_the_clearance_of_the_slab_is_kept():
    rng = np.random.default_rng(2)
    told = 0
    for _ in range(CASES):
        case = Case(rng)
        duration = case.slab.horizon * float(10.0 ** rng.uniform(-3, 0))
        clearance = case.slab.clearance(duration)
        told += clearance > 0.0
        assert clearance <= 0.0 or case.nearest(duration) >= clearance - ROUNDING
        assert case.slab.clearance(2.0 * case.slab.horizon) == -inf
    assert told > CASES // 3


@pytest.mark.parametrize("speed", [5e-324, 1e-170, 1e150])
def test_balls_at_extreme_speeds_have_a_slab(speed):
    across = SphereSlab((3.0, 0.0, 0.0), 1.0, (0.0, speed, 0.0), 0.0, STEADY, 0.0)
    assert across.sleep(0.0) == 10.0
    assert across.clearance(10.0) == pytest.approx(2.0)


class Path(RandomCourse):
    """Two balls on random chains of motions, so large that they are apart at first, and the slabs between them."""

    def __init__(self, rng) -> None:
        super().__init__(rng)
        self.grown = self.apart(self.state) * (1.0 - float(rng.uniform(0.05, 1.0))) - self.motion.radii
        self.beyond = float(rng.choice([0.0, 0.02])) * self.motion.radii
        self.slabs = SphereSlabs(self.motion, self.grown, self.state, self.duration, self.beyond)

    def nearest(self, duration) -> float:
        """Return the least gap (m) at samples of the time from t on."""
        return min(self.samples(duration, 2 * SAMPLES)) - self.motion.radii - self.grown


def test_balls_stay_apart_while_slabs_follow_each_other():
    rng = np.random.default_rng(3)
    slept = followed = 0
    for _ in range(PATHS):
        path = Path(rng)
        for spare in (path.beyond, 3.0 * path.beyond):
            sleep = path.slabs.sleep(spare)
            assert 0.0 <= sleep <= path.duration
            slept += sleep > 0.0
            followed += path.t + sleep > path.motion.knot_after(path.t)
            assert sleep == 0.0 or path.nearest(sleep) >= spare - ROUNDING
            assert sleep == 0.0 or path.slabs.clearance(sleep) >= spare - ROUNDING
    assert slept > PATHS
    assert followed > PATHS // 20


def test_the_clearance_of_slabs_that_follow_each_other_is_kept():
    rng = np.random.default_rng(4)
    told = followed = 0
    for _ in range(PATHS):
        path = Path(rng)
        for duration in (path.duration * float(rng.uniform(0, 1)), path.slabs.sleep(path.beyond)):
            clearance = path.slabs.clearance(duration)
            told += clearance > -inf
            followed += clearance > -inf and path.t + duration > path.motion.knot_after(path.t)
            assert clearance == -inf or path.nearest(duration) >= clearance - ROUNDING
        assert path.slabs.clearance(1.01 * path.duration) == -inf
    assert told > PATHS
    assert followed > PATHS // 20


def bouncing(count, seconds) -> RelativeMotion:
    """A ball 1 m wide that goes to and fro between 2 m and 3 m from another, from key to key, as often as that."""
    times = np.linspace(0.0, seconds, count + 1)
    places = np.array([(2.0 + index % 2, 0.0, 0.0) for index in range(count + 1)])
    turns = np.tile((1.0, 0.0, 0.0, 0.0), (count + 1, 1))
    path = Keyframes(times, places, turns, Translation.LINEAR, step_rotation=False)
    extent = Extent(np.zeros((1, 3)), np.array([0.5]), Ball((0.0, 0.0, 0.0), 0.5))
    return RelativeMotion(Chain((), np.eye(4), extent), Chain((Joint(np.eye(4), path),), np.eye(4), extent))


def test_what_bounces_is_slept_past_all_its_keys():
    motion = bouncing(10, 10.0)
    slabs = SphereSlabs(motion, 0.0, motion.at(0.3), 9.7, 0.0)
    assert slabs.sleep(0.0) == 9.7
    assert slabs.clearance(9.7) == pytest.approx(1.0, rel=1e-9)
    assert slabs.clearance(1.2) == pytest.approx(1.3, rel=1e-9)  # it comes back from 3 m as far as 2.5 m
    assert slabs.sleep(1.25) == pytest.approx(1.45, rel=1e-9)  # and as 2.25 m after that, and again and again


def test_keys_that_lie_close_together_are_not_followed_for_ever():
    motion = bouncing(10 * MOST_SLABS, 10.0)
    assert 0.0 < SphereSlabs(motion, 0.0, motion.at(0.0), 10.0, 0.0).sleep(0.0) < 0.1


def test_what_passes_by_on_a_straight_line_is_slept_past():
    """From 5 m away at 1 m/s, past at 0.3 m: the slab across the way when nearest lasts, the one across it now not."""
    slab = SphereSlab((5.0, 0.8, 0.0), 0.5, (1.0, 0.0, 0.0), 0.0, STEADY, 0.0)
    assert slab.sleep(0.0) == 10.0
    assert slab.clearance(10.0) == pytest.approx(0.3, rel=1e-9)


def test_what_comes_straight_on_is_slept_on_until_it_is_there():
    slab = SphereSlab((0.0, 5.0, 0.0), 0.5, (0.0, 1.0, 0.0), 0.0, STEADY, 0.0)
    assert slab.sleep(0.0) == pytest.approx(4.5, rel=1e-9)
    assert slab.sleep(0.0) < 4.5
    assert slab.sleep(1.5) == pytest.approx(3.0, rel=1e-9)
    assert slab.sleep(4.5) == 0.0


def test_what_may_brake_or_turn_back_is_given_the_time_that_takes():
    """It opens at 1 m/s, and may come back by 2 m/s^2: 0.5 + s - s^2 = 0 at (1 + sqrt(3)) / 2 s."""
    ahead = RelativeRates(0.0, 2.0, 10.0, (0.0, 0.0, 0.0), ball(2.0))
    slab = SphereSlab((0.0, 0.0, 1.0), 0.5, (0.0, 0.0, -1.0), 0.0, ahead, 0.0)
    assert slab.sleep(0.0) == pytest.approx((1.0 + hypot(1.0, 2.0**0.5)) / 2.0, rel=1e-9)


def test_of_slabs_that_last_the_widest_is_taken():
    """It comes at 1 m/s, and swerves across by up to 2 m/s^2: across the way between the middles now less is lost."""
    ahead = RelativeRates(0.0, 2.0, 1.0, (0.0, 0.0, 0.0), AccelerationSet(lines=((0.0, 2.0, 0.0),)))
    slab = SphereSlab((5.0, 0.8, 0.0), 0.5, (1.0, 0.0, 0.0), 0.0, ahead, 0.0)
    now = hypot(5.0, 0.8)
    assert slab.clearance(1.0) == pytest.approx(now - 0.5 - (5.0 + 0.8) / now, rel=1e-9)


def test_slack_and_errors_are_taken_off():
    slab = SphereSlab((0.0, 5.0, 0.0), 0.6, (0.0, 1.0, 0.0), 0.0, STEADY, 0.1)
    assert slab.sleep(0.0) == pytest.approx(4.0, rel=1e-9)


def test_bodies_that_spin_on_the_spot_need_no_second_look():
    """Two boxes whose corners move at 87 m/s, and whose balls stay 1.27 m apart."""
    spins = Constant((0.0, 0.0, 0.0), (0.0, 0.0, 100.0))
    far = np.eye(4)
    far[0, 3] = 3.0
    bodies = [
        Body("one", None, np.eye(4), Fixed(), (box(1, 1, 1),)),
        Body("other", None, far, spins, (box(1, 1, 1),)),
    ]
    events = events_of(*bodies)
    wakeups = [event for event in events if isinstance(event, Wakeup)]
    assert [wakeup.bound for wakeup in wakeups] == [Bound.SPHERE_SLABS, Bound.NONE]
    (span,) = [event for event in events if isinstance(event, Span)]
    assert span.clearance == pytest.approx(3.0 - 3.0**0.5, rel=1e-9)
