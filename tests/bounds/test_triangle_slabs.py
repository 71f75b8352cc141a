"""The directional bound, held against dense samples of moving triangles."""

from math import inf

import numpy as np
import pytest
from drawn_motions import CONTINUOUS, random_chain, random_unit, vector

from closecall.scheduler.bounds import triangle_slabs as directional
from closecall.scheduler.bounds.triangle_slabs import TriangleSlabs
from closecall.scheduler.kinematics.chain import Twist
from closecall.scheduler.kinematics.relative_motion import RelativeMotion, RelativeRates
from closecall.scheduler.motions.acceleration_set import STILL, ball
from closecall.scheduler.narrow.triangle_pairs import NearTriangles
from oracle.triangles import separation

CASES = 30
SAMPLES = 30
ROUNDING = 1e-12


def moved(pose, corners) -> np.ndarray:
    return corners @ pose[:3, :3].T + pose[:3, 3]


def distances(one, other) -> np.ndarray:
    """Return (k,) m: the distances of triangles (k, 3, 3), negative where they cross."""
    return separation(np.moveaxis(one, 2, 0), np.moveaxis(other, 2, 0))


class Case:
    """Two clouds of triangles on random chains of motions, and their slabs at a random time."""

    def __init__(self, rng) -> None:
        count, size = int(rng.integers(1, 9)), float(10.0 ** rng.uniform(-2, 0.5))
        self.t, self.duration = float(rng.uniform(-1, 1)), float(10.0 ** rng.uniform(-4, 0.5))
        own = [rng.normal(size=(count, 3, 3)) * size for _ in range(2)]
        if rng.random() < 0.3:
            own[1][:, 1:] = own[1][:, :1]  # points
        a, b = (random_chain(rng, corners.reshape(-1, 3), 0.0, CONTINUOUS) for corners in own)
        self.motion, self.own = RelativeMotion(a, b), own
        self.state = self.motion.at(self.t)
        poses = self.state.a.pose, self.state.b.pose
        apart = vector(np.array(random_unit(rng)) * float(10.0 ** rng.uniform(-1, 1)))
        self.shift = poses[0][:3, 3] - poses[1][:3, 3] + apart  # so that they are near each other, but seldom touch
        one, other = moved(poses[0], own[0]), moved(poses[1], own[1]) + self.shift
        i, j = (index.reshape(-1) for index in np.meshgrid(range(count), range(count)))
        self.pairs = i, j
        near = self.motion.approach(self.state, self.duration)
        self.horizon = near.horizon
        twists = self.state.a.twist, self.state.b.twist
        twists = twists[0], twists[1]._replace(origin=vector(np.array(twists[1].origin) + self.shift))
        triangles = NearTriangles(one[i], other[j], np.zeros(len(i)))
        direction = random_unit(rng) if rng.random() < 0.3 else vector(np.array(apart) / np.linalg.norm(apart))
        self.slabs = TriangleSlabs(triangles, twists, direction, 0.0, inf, near, 0.0)

    def nearest(self, duration: float) -> float:
        """Return the least distance (m) of any two triangles at samples of the time from t on."""
        i, j = self.pairs
        least = inf
        for s in np.linspace(0.0, duration, SAMPLES):
            poses = self.motion.at(self.t + float(s))
            one, other = moved(poses.a.pose, self.own[0]), moved(poses.b.pose, self.own[1]) + self.shift
            least = min(least, float(distances(one[i], other[j]).min()))
        return least


def test_triangles_stay_apart_while_their_slabs_do():
    rng = np.random.default_rng(1)
    slept = 0
    for _ in range(CASES):
        case = Case(rng)
        sleep = case.slabs.sleep(0.0)
        assert 0.0 <= sleep <= case.horizon
        if sleep > 0.0:
            slept += 1
            assert case.nearest(sleep) > -ROUNDING
    assert slept > CASES // 3


def test_the_clearance_of_slabs_is_kept():
    rng = np.random.default_rng(2)
    told = 0
    for _ in range(CASES):
        case = Case(rng)
        duration = case.horizon * float(10.0 ** rng.uniform(-3, 0))
        clearance = case.slabs.clearance(duration, 0.0)
        told += clearance > 0.0
        assert max(0.0, case.nearest(duration)) >= clearance - ROUNDING
        assert case.slabs.clearance(2.0 * case.horizon, 0.0) == -inf
    assert told > CASES // 5


def test_a_spare_width_is_kept_too():
    rng = np.random.default_rng(3)
    for _ in range(CASES):
        case = Case(rng)
        spare = 0.5 * max(0.0, case.nearest(0.0))
        sleep = case.slabs.sleep(spare)
        if sleep > 0.0:
            assert case.nearest(sleep) >= spare - ROUNDING


def test_only_pairs_that_set_the_bound_need_directions_of_their_own(monkeypatch):
    """The answer is the same as with directions of its own for each pair."""
    found = []
    for first_pairs in (1, 1_000_000):
        monkeypatch.setattr(directional, "FIRST_PAIRS", first_pairs)
        rng = np.random.default_rng(4)
        cases = [Case(rng) for _ in range(CASES)]
        found.append([(case.slabs.sleep(0.0), case.slabs.clearance(0.5 * case.horizon, 0.0)) for case in cases])
    assert np.array(found[0]) == pytest.approx(np.array(found[1]), rel=1e-9, abs=1e-12)


def test_faces_that_slide_past_each_other_sleep_up_to_the_horizon():
    """Closing across the gap counts alone, however fast they slide: 1000 m/s beside a gap of 1 um."""
    square = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1.0, 0, 0], [1, 1, 0], [0, 1, 0]]])
    i, j = (index.reshape(-1) for index in np.meshgrid(range(2), range(2)))
    near = NearTriangles(square[i], square[j] + [0, 0, 1e-6], np.zeros(4))
    still = Twist((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    slides = Twist((0.0, 0.0, 0.0), (1000.0, 500.0, 0.0), (0.0, 0.0, 0.0))
    for steady in ((0.0, 0.0, 0.0), (9.81, -3.0, 0.0), (9.81, 0.0, -1.0)):
        ahead = RelativeRates(1118.1, 10.3, 3.0, steady, STILL)
        assert TriangleSlabs(near, (slides, still), (0.0, 0.0, 1.0), 0.0, 1.0, ahead, 0.0).sleep(0.0) == pytest.approx(
            3.0
        )


@pytest.mark.parametrize("varying", [0.0, 0.5])
def test_a_steady_acceleration_closes_a_gap_by_its_part_across_it(varying):
    """From rest, 1 mm apart, at 2 m/s^2 upwards: after sqrt(2 x 0.001 / 2) s."""
    square = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    still = Twist((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    near = NearTriangles(square, square + np.array([0.0, 0.0, 1e-3]), np.zeros(1))
    ahead = RelativeRates(0.0, 10.0, 3.0, (9.0, 0.0, 2.0), ball(varying))
    found = TriangleSlabs(near, (still, still), (0.0, 0.0, 1.0), 0.0, 1.0, ahead, 0.0).sleep(0.0)
    assert found == pytest.approx(np.sqrt(2.0 * 1e-3 / (2.0 + varying)))
