"""What floating point takes off the poses, held against extended precision and fractions, stays within their account.

Large times, phases and coordinates. Each test also sees errors that an account a hundred times smaller would miss.
"""

import numpy as np
import pytest
from drawn_motions import EPSILON, random_vector
from rounding_cases import CASES, ROUNDING_CASES, SMOOTH, random_smooth, smooth_point, span_of, wide, worst_share

from closecall.scheduler.geometry.rounding import RELATIVE_ROUNDING
from closecall.scheduler.geometry.vector import distance_to_line
from closecall.scheduler.motions import (
    LeverArms,
)


@pytest.mark.parametrize("name", ROUNDING_CASES)
def test_the_account_covers_the_rounding_of_poses(name):
    kind, cases = ROUNDING_CASES[name]
    drawn = list(cases())
    assert all(type(motion) is kind for motion, *_ in drawn)
    assert 0.01 < worst_share(drawn) < 1.0


@pytest.mark.parametrize("kind", SMOOTH)
def test_the_account_covers_the_rounding_of_displacements_as_well(kind):
    """A sine's change over a microsecond after a million seconds keeps few digits of its own."""
    rng = np.random.default_rng(9)
    shares = []
    for _ in range(4 * CASES):
        motion, (t, _), q = random_smooth(rng, kind), span_of(rng), random_vector(rng)
        duration = float(10.0 ** rng.uniform(-9, 2))
        radius = float(np.linalg.norm(q)) * (1 + 4 * EPSILON)
        across = radius if motion.axis is None else distance_to_line(q, motion.axis.point, motion.axis.direction)
        bound = motion.displacement(t, duration, LeverArms(radius, across))
        start = smooth_point(motion, q, t)
        wrong = wide(motion.pose(t)[:3, :3]) @ wide(q) + wide(motion.pose(t)[:3, 3]) - start
        away = smooth_point(motion, q, t, duration) - start
        short = float(np.sqrt(away @ away) + np.sqrt(wrong @ wrong)) - bound * (1 + RELATIVE_ROUNDING)
        allowed = 8 * EPSILON * motion.rounding_scale((min(t, t + duration), t + duration), radius)
        shares.append(short / allowed)
    assert 0.01 < max(shares) < 1.0
