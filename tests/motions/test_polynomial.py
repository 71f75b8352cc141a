"""Polynomials: Bernstein bounds on curves that are known otherwise, and up to the twentieth degree."""

import numpy as np
import pytest
from drawn_motions import random_vector, vector

from closecall.scheduler.motions import Ballistic, LeverArms, Polynomial
from closecall.scheduler.motions.bernstein import Arc

POINT = LeverArms(0.0, 0.0)
O = (0.0, 0.0, 0.0)  # noqa: E741


def test_up_to_the_second_degree_it_is_the_ballistic_motion():
    rng = np.random.default_rng(1)
    for _ in range(100):
        start, v, a, w = (random_vector(rng) for _ in range(4))
        one = Polynomial((start, v, vector(0.5 * np.array(a))), w)
        other = Ballistic(v, a, w)
        t, duration = float(rng.normal()), float(rng.uniform(0.01, 2))
        assert np.allclose(one.pose(t)[:3, 3], other.pose(t)[:3, 3] + start, atol=1e-13)
        assert np.allclose(np.concatenate(one.velocities(t)), np.concatenate(other.velocities(t)))
        assert one.rates(t, duration).steady == pytest.approx(a)
        assert one.rates(t, duration).acceleration == 0.0
        exact = other.displacement(t, duration, POINT)
        assert exact * (1 - 1e-12) <= one.displacement(t, duration, POINT) <= 1.03 * exact


def test_a_way_there_and_back_costs_its_farthest_point_and_not_its_length():
    """x = t (1 - t), farthest 1/4 and back at t = 1."""
    motion = Polynomial((O, (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)), O)
    assert motion.displacement(0.0, 1.0, POINT) == pytest.approx(0.25, rel=0.02)
    assert motion.path_length(0.0, 1.0, POINT) == pytest.approx(0.5, rel=0.02)
    assert motion.displacement(0.0, 0.0, POINT) == motion.path_length(0.0, 0.0, POINT) == 0.0


@pytest.mark.parametrize("degree", [5, 12, 20])
def test_chebyshev_polynomials_oscillate_within_their_bounds(degree):
    """|T_n| <= 1 on [-1, 1] and its way is 2 n, while the terms are up to millions: they cancel."""
    terms = np.polynomial.chebyshev.cheb2poly([0.0] * degree + [1.0])
    motion = Polynomial(tuple((float(c), 0.0, 0.0) for c in terms), O)
    assert motion.displacement(-1.0, 2.0, POINT) + 1.0 + motion.pose(-1.0)[0, 3] + 1e-6 >= 2.0
    assert motion.displacement(-1.0, 2.0, POINT) < 3.0
    assert 2 * degree <= motion.path_length(-1.0, 2.0, POINT) < 3.5 * degree
    assert motion.rates(-1.0, 2.0).speed >= degree**2
    assert motion.rates(-1.0, 2.0).speed < 1.3 * degree**2


def test_shifting_far_loses_no_soundness():
    """Around t = 1000 the twentieth degree's terms are 1e60: the bounds stay above exact integers' differences."""
    rng = np.random.default_rng(2)
    for _ in range(50):
        terms = rng.integers(-9, 10, 21)
        motion = Polynomial(tuple((float(c), 0.0, 0.0) for c in terms), O)
        t, step = int(rng.integers(-1000, 1000)), int(rng.integers(1, 2000))

        def exact(at: int, terms=terms) -> int:
            return sum(int(c) * at**k for k, c in enumerate(terms))

        ways = [abs(exact(t + s) - exact(t)) for s in range(0, step + 1, max(1, step // 50))]
        assert motion.displacement(float(t), float(step), POINT) >= float(max(ways)) * (1 - 1e-15)


def test_cutting_into_cells_is_exact_for_the_curve():
    """The control points of a straight line are on it, whatever the duration."""
    line = Arc(np.array([[0.0, 0, 0], [3.0, 4.0, 0]]), np.array([0.0, 5.0]), 0.7)
    for duration in np.concatenate((np.linspace(0.001, 3, 50), [0.35, 0.7, 1.4])):
        assert 5 * duration * (1 - 1e-12) <= line.supremum(duration) <= 5 * duration * 1.01
        assert 5 * duration * (1 - 1e-12) <= line.derivative().integral(duration) <= 5 * duration * 1.01
