"""The pure numbers: the lecture's bound in its sound form, the search for the longest sleep, the two-sided proof."""

import math
from fractions import Fraction

import numpy as np
import pytest

from closecall.scheduler.bounds.closed_form import longest_sleep, time_bound, two_sided_clearance
from closecall.scheduler.geometry.rounding import shortened


@pytest.mark.parametrize(
    ("clearance", "speed", "acceleration", "seconds"),
    [
        (1.0, 2.0, 0.0, 0.5),
        (1.0, 0.0, 2.0, 1.0),
        (1e-3, 10.0, 1e-15, 1e-4),  # the textbook form cancels to 0 here
        (0.0, 3.0, 1.0, 0.0),
        (1.0, 0.0, 0.0, math.inf),
        (1.5, 1.0, 1.0, 1.0),
        (1.5, -1.0, 1.0, 3.0),  # parts first
        (1e-3, -10.0, 1e-15, 2e16),
        (1.0, -2.0, 0.0, math.inf),
    ],
)
def test_time_bound_is_the_root_of_the_quadratic(clearance, speed, acceleration, seconds):
    assert time_bound(clearance, speed, acceleration) == pytest.approx(seconds, rel=1e-14)


def test_time_bound_never_exceeds_the_root_in_random_cases():
    rng = np.random.default_rng(1)
    for _ in range(2000):
        d, v, a = (float(x) for x in 10 ** rng.uniform(-9, 6, 3))
        v *= float(rng.choice([1.0, -1.0]))
        t = shortened(0.0, time_bound(d, v, a))
        assert v * t + 0.5 * a * t * t < d


def test_a_sleep_from_any_time_ends_before_the_bound_does():
    """In Unix time a sum is rounded by 1.2e-7 s; a sleep of fewer floats than that is none."""
    rng = np.random.default_rng(3)
    for _ in range(2000):
        now, bound = float(rng.normal() * 10.0 ** rng.uniform(-3, 9)), float(10.0 ** rng.uniform(-9, 6))
        assert Fraction(now + shortened(now, bound)) <= Fraction(now) + Fraction(bound)


def test_longest_sleep_returns_a_time_it_has_evaluated_below_the_clearance_and_close_to_the_root():
    rng = np.random.default_rng(2)
    for _ in range(500):
        slope, power, clearance = 10 ** rng.uniform(-3, 3), rng.uniform(0.4, 3), 10 ** rng.uniform(-6, 2)
        horizon, guess = 10 ** rng.uniform(-2, 3), 10 ** rng.uniform(-6, 3)
        seen = {}

        def displacement(t, slope=slope, power=power, seen=seen):
            return seen.setdefault(t, slope * t**power)

        found = longest_sleep(displacement, clearance, horizon, guess)
        root = (clearance / slope) ** (1 / power)
        assert 0 < found <= horizon
        assert seen[found] < clearance
        assert found >= 0.9 * min(root, horizon)
        assert len(seen) <= 66


def test_longest_sleep_of_a_saturating_displacement_is_the_whole_horizon():
    assert longest_sleep(lambda t: min(t, 0.5), 0.6, 1000.0, 0.1) == 1000.0


def test_two_sided_clearance_needs_arc_length_not_displacement():
    """A harmonic over a full period: displacement 1, arc length 4, distances 0.6 at both ends, true gap -0.4."""
    assert two_sided_clearance(0.6, 0.6, 1.0) > 0.0  # what a displacement would wrongly certify
    assert two_sided_clearance(0.6, 0.6, 4.0) == pytest.approx(-1.4)
