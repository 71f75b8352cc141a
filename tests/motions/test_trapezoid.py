"""Trapezoids and triangles: knots, rest before and after, no speed beyond the limit."""

from itertools import pairwise

import numpy as np
import pytest
from drawn_motions import profile

from closecall.scheduler.motions import LeverArms, Trapezoid

X = (1.0, 0.0, 0.0)
O = (0.0, 0.0, 0.0)  # noqa: E741


def knots_of(motion: Trapezoid) -> list[float]:
    knots = [motion.knot_after(-np.inf)]
    while motion.knot_after(knots[-1]) < np.inf:
        knots.append(motion.knot_after(knots[-1]))
    return knots


def test_a_trapezoid_rises_cruises_and_brakes():
    motion = Trapezoid(False, X, O, 1.0, 7.0, 2.0, 1.0, 10.0)  # 2 s up over 2 m, 1 s, 2 s down
    assert knots_of(motion) == [10.0, 12.0, 13.0, 15.0]
    assert [motion.pose(t)[0, 3] for t in (0.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 99.0)] == pytest.approx(
        [1, 1, 1.5, 3, 5, 6.5, 7, 7]
    )
    steady = [motion.rates(t, 0.1).steady[0] for t in (9.0, 10.0, 12.0, 13.0, 15.0)]
    assert steady == [0, 1, 0, -1, 0]
    assert motion.stop_after(0.0) == np.inf
    assert motion.displacement(11.0, 100.0, LeverArms(1.0, 1.0)) == pytest.approx(5.5)


def test_a_short_way_is_a_triangle_backwards_too():
    motion = Trapezoid(False, X, O, 0.0, -1.0, 9.0, 1.0, 0.0)
    assert knots_of(motion) == [0.0, 1.0, 2.0]
    assert motion.pose(1.0)[0, 3] == pytest.approx(-0.5)
    assert motion.velocities(1.0)[0][0] == pytest.approx(-1.0)


def test_a_body_that_need_not_move_rests():
    motion = Trapezoid(True, X, O, 0.4, 0.4, 1.0, 1.0, 0.0)
    assert motion.displacement(-1.0, 5.0, LeverArms(1.0, 1.0)) == 0.0
    assert motion.rates(0.0, 1e-9).speed == 0.0


def test_it_ends_exactly_at_its_ends_and_never_passes_its_limits():
    rng = np.random.default_rng(1)
    for _ in range(200):
        motion = profile(rng)
        knots = knots_of(motion)
        way = np.dot(motion.pose(knots[0])[:3, 3], motion.axis_direction)
        assert way == pytest.approx(motion.begin, rel=1e-14)
        assert np.dot(motion.pose(knots[-1])[:3, 3], motion.axis_direction) == pytest.approx(motion.end, rel=1e-14)
        for first, last in pairwise(knots):
            rates = motion.rates(first, (last - first) * 0.99)
            assert rates.speed <= motion.max_velocity * (1 + 1e-12)
            assert rates.acceleration + np.linalg.norm(rates.steady) <= motion.max_acceleration * (1 + 1e-12)


@pytest.mark.parametrize("start", [0.0, -5.0, 1e9])
def test_no_gap_opens_at_a_knot_however_late_or_short_the_move(start):
    """A ramp shorter than the spacing of floats still takes one."""
    for velocity, acceleration in ((2.0, 1.0), (2.0, 1e12), (1e-9, 1e-3)):
        motion = Trapezoid(False, X, O, 0.0, 1e-6, velocity, acceleration, start)
        knots = knots_of(motion)
        assert knots == sorted(set(knots))
        for knot in knots:
            left, right = float(np.nextafter(knot, -np.inf)), float(np.nextafter(knot, np.inf))
            for a, b in ((left, knot), (knot, right)):
                gap = abs(motion.pose(b)[0, 3] - motion.pose(a)[0, 3])
                assert gap <= motion.displacement(a, b - a, LeverArms(0.0, 0.0)) * (1 + 1e-9) + 1e-20
