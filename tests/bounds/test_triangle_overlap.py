"""How long triangles certainly go on meeting, held against dense samples of moving ones and against closed forms."""

from math import inf, sqrt

import numpy as np
import pytest
from drawn_motions import CONTINUOUS, random_chain, random_unit, vector
from scipy.spatial.transform import Rotation
from small_scenes import box, events_of

from closecall.scheduler.bounds.triangle_overlap import TriangleOverlap, proper
from closecall.scheduler.kinematics.chain import Part, Twist
from closecall.scheduler.kinematics.relative_motion import RelativeMotion, RelativeRates
from closecall.scheduler.model.events import Reason, Span, Verdict, Wakeup
from closecall.scheduler.model.scene import Body
from closecall.scheduler.motions import Constant, Fixed, Harmonic
from closecall.scheduler.motions.acceleration_set import STILL as CONSTANT
from closecall.scheduler.motions.acceleration_set import AccelerationSet, ball
from closecall.scheduler.narrow.triangle_pairs import NearTriangles
from oracle.triangles import separation

CASES = 120
SAMPLES = 20
ROUNDING = 1e-12

STILL = Twist((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
FLOOR = np.array([[[-1.0, -1, 0], [3, -1, 0], [-1, 3, 0]]])


def moved(pose, corners) -> np.ndarray:
    return corners @ pose[:3, :3].T + pose[:3, 3]


def distance(one, other) -> float:
    """Return m: the distance of two triangles (3, 3), 0 where they meet."""
    return max(0.0, float(separation(one[None].transpose(2, 0, 1), other[None].transpose(2, 0, 1))[0]))


def moving(v, w=(0.0, 0.0, 0.0)) -> Twist:
    return Twist((0.0, 0.0, 0.0), v, w)


def ahead(varying=CONSTANT, steady=(0.0, 0.0, 0.0), horizon=inf) -> RelativeRates:
    return RelativeRates(0.0, 0.0, horizon, steady, varying)


def overlaps(one, other, twist, future, error=0.0, radius=0.0) -> TriangleOverlap:
    near = proper(NearTriangles(one, other, np.full(len(one), radius)))
    return TriangleOverlap(near, (twist, STILL), error, future, 0.0)


def test_triangles_on_random_motions_meet_as_long_as_is_said():
    rng = np.random.default_rng(1)
    held = 0
    for _ in range(CASES):
        size, shape = float(10.0 ** rng.uniform(-2, 0.5)), rng.integers(0, 4)
        own = [rng.normal(size=(3, 3)) * size for _ in range(2)]
        if shape == 0:
            own[1][1:] = own[1][:1]  # a point
        if shape == 1:
            own[1][1] = own[1][2]  # a segment
        radius = 0.3 * size if rng.random() < 0.5 else 0.0
        a, b = (random_chain(rng, corners, 0.0, CONTINUOUS) for corners in own)
        motion, t = RelativeMotion(a, b), float(rng.uniform(-1, 1))
        state = motion.at(t)
        placed = moved(state.a.pose, own[0]), moved(state.b.pose, own[1])
        meeting = [rng.dirichlet(np.ones(3)) @ corners for corners in placed]
        shift = meeting[0] - meeting[1] + np.array(random_unit(rng)) * radius * rng.random()
        one, other = placed[0], placed[1] + shift
        near = motion.approach(state, float(10.0 ** rng.uniform(-4, 0.5)), Part.CORE)
        twists = state.a.twist, state.b.twist
        twists = twists[0], twists[1]._replace(origin=vector(np.array(twists[1].origin) + shift))
        pairs = proper(NearTriangles(one[None], other[None], np.array([radius])))
        found = TriangleOverlap(pairs, twists, 0.0, near, 0.0)
        sleep = found.sleep()
        held += sleep > 0.0
        for s in np.linspace(0.0, sleep, SAMPLES):
            poses = motion.at(t + float(s))
            gap = distance(moved(poses.a.pose, own[0]), moved(poses.b.pose, own[1]) + shift)
            assert gap <= radius + ROUNDING
    assert held > CASES // 4


def test_they_meet_however_each_is_moved_by_less_than_their_depth():
    rng = np.random.default_rng(2)
    deep = 0
    for _ in range(CASES):
        one, other = rng.normal(size=(2, 1, 3, 3))
        depth = overlaps(one, other, STILL, ahead()).depth
        assert depth == 0.0 or distance(one[0], other[0]) == 0.0
        if depth == 0.0:
            continue
        deep += 1
        for _ in range(10):
            turn = Rotation.from_rotvec(rng.normal(size=3) * depth).as_matrix()
            there = other @ turn.T + np.array(random_unit(rng)) * depth * rng.random()
            way = np.linalg.norm(there - other, axis=2).max()
            if way < depth:
                assert distance(one[0], there[0]) == 0.0
    assert deep > CASES // 20


@pytest.mark.parametrize("height", [0.0, 0.5])
def test_what_slides_over_a_face_is_held_up_to_the_border(height):
    """A triangle standing on, or through, the floor, slides by 2 m in x until its foot reaches x + y = 2."""
    foot = np.array([[[-0.5, -0.5, -height], [-0.5, -0.5, 1.0], [-0.6, -0.6, 1.0]]])
    slides = overlaps(foot, FLOOR, moving((1.5, 0.0, 0.0)), ahead(), error=1e-12)
    assert slides.sleep() == pytest.approx(3.0 / 1.5, rel=0.05 + 0.2 * height)
    assert overlaps(foot, FLOOR, moving((1.5, 0.0, 0.01)), ahead(), error=1e-12).sleep() <= height / 0.01 + 1e-9


def test_parallel_faces_at_rest_on_each_other_are_held():
    lying = FLOOR * 0.25
    assert overlaps(lying, FLOOR, moving((0.0, 0.0, 0.0)), ahead(), error=1e-12).sleep() == inf
    slides = overlaps(lying, FLOOR, moving((1.0, 0.0, 0.0)), ahead(), error=1e-12).sleep()
    # its last corner leaves at x = -0.25, y = -0.25 or its edge passes: the floor's edge is x + y = 2
    assert slides == pytest.approx(2.5, rel=1e-6)


def test_sliding_faster_and_faster_along_a_face_does_not_part_them():
    lying = FLOOR * 0.25
    faster = ahead(AccelerationSet(0.0, (), ((3.0, 0.0, 0.0),)), (1.0, 0.0, 0.0))
    assert overlaps(lying, FLOOR, STILL, faster, error=1e-12).sleep() == pytest.approx(sqrt(2.0 * 2.5 / 4.0), rel=1e-6)
    upwards = ahead(ball(1e-3))
    assert overlaps(lying, FLOOR, STILL, upwards, error=1e-12).sleep() == pytest.approx(sqrt(2e-12 / 1e-3), rel=1e-2)


def test_a_ball_rolls_over_a_face_up_to_the_border():
    centre = np.full((1, 3, 3), [-0.5, -0.5, 0.3])
    rolls = overlaps(centre, FLOOR, moving((1.0, 0.0, 0.0)), ahead(), error=1e-12, radius=0.3)
    assert rolls.sleep() == pytest.approx(3.0, rel=1e-6)
    lifted = overlaps(centre, FLOOR, moving((1.0, 0.0, 0.01)), ahead(), error=1e-12, radius=0.31)
    assert lifted.sleep() == pytest.approx(1.0, rel=1e-6)
    assert overlaps(centre, FLOOR, STILL, ahead(), error=1e-12, radius=0.29).sleep() == 0.0


def test_points_and_segments_alone_are_not_judged():
    point = np.zeros((1, 3, 3))
    assert overlaps(point, point, STILL, ahead(), radius=1.0).sleep() == 0.0


def lifted(z) -> np.ndarray:
    pose = np.eye(4)
    pose[2, 3] = z
    return pose


SPIN = Constant((1.0, 0.0, 0.0), (0.0, 0.0, 1.5))
SLOWER = Constant((1.0, 0.0, 0.0), (0.0, 0.0, 0.5))


@pytest.mark.parametrize(
    ("lower", "upper", "height"),
    [
        (SPIN, SPIN, 0.0),  # coincident copies that move alike
        (SPIN, SLOWER, 1.0),  # parallel faces that turn on each other
        (Fixed(), Harmonic((1.0, 0.0, 0.0), 0.3, 2.0, 0.2), 1.0),  # slides to and fro
        (Fixed(), Harmonic((1.0, 0.0, 0.0), 0.3, 2.0, 0.2), 0.999),  # the same, 1 mm deep
    ],
)
def test_bodies_that_rest_or_slide_on_each_other_touch_all_the_time_and_sleep(lower, upper, height):
    cube = box(1.0, 1.0, 1.0)
    events = events_of(Body("a", None, np.eye(4), lower, (cube,)), Body("b", None, lifted(height), upper, (cube,)))
    (span,) = [event for event in events if isinstance(event, Span)]
    assert (span.verdict, span.start, span.end) == (Verdict.CONTACT, 0.0, 4.0)
    assert sum(isinstance(event, Wakeup) and event.reason is Reason.CONTACT for event in events) < 50 * 4
