"""Where a distance seems least, held against lows in closed form; its slope, against differences of measurements."""

from math import cos, exp, sin

import numpy as np
import pytest
from small_scenes import box, round_shape

from closecall.scheduler.model.scene import Body, PairRules, Scene
from closecall.scheduler.motions import Constant, Fixed, Harmonic
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide
from closecall.scheduler.pairs.tangent_search import MOST_STEPS, Tangent, TangentSearch

CLOSE = 1e-3

# Each with its slope, where it is looked at between, and its least value there.
LOWS = {
    "a parabola": (lambda t: 0.2 + (t - 1.3) ** 2, lambda t: 2.0 * (t - 1.3), (0.0, 5.0), 0.2),
    "a kink": (lambda t: 0.1 + 2.0 * abs(t - 3.1), lambda t: -2.0 if t < 3.1 else 2.0, (0.0, 5.0), 0.1),
    "a lopsided kink": (
        lambda t: max(1 - t, 0.01 * t),
        lambda t: -1.0 if 1.01 * t < 1.0 else 0.01,
        (0.0, 9.0),
        1 / 101,
    ),
    "a swing": (lambda t: 1.5 - sin(t), lambda t: -cos(t), (0.1, 4.0), 0.5),
    "a flat floor": (lambda t: 0.3 + (t - 2.0) ** 4, lambda t: 4.0 * (t - 2.0) ** 3, (0.0, 5.0), 0.3),
    "a hole": (
        lambda t: 1.0 - 0.02 * t - 0.9 * exp(-100.0 * (t - 0.8) ** 2),
        lambda t: -0.02 + 180.0 * (t - 0.8) * exp(-100.0 * (t - 0.8) ** 2),
        (0.0, 1.0),
        0.084,
    ),
    "a fall to the end": (lambda t: 3.0 - 0.5 * t, lambda t: -0.5, (0.0, 4.0), 1.0),
    "a rise from the start": (lambda t: 1.0 + t, lambda t: 1.0, (0.0, 4.0), 1.0),
}


def looked_at(distance, slope, begin: float, early: float, late: float, turn: float = 0.0) -> list[float]:
    """Return the times that a valley is looked at, from `begin` on."""
    valley, times = TangentSearch(early, late), [begin]
    while (time := valley.next(Tangent(times[-1], distance(times[-1]), slope(times[-1]), turn), CLOSE)) is not None:
        times.append(time)
    return times


@pytest.mark.parametrize("case", LOWS)
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_the_low_is_found_from_wherever_one_begins(case, share):
    distance, slope, (early, late), least = LOWS[case]
    times = looked_at(distance, slope, early + share * (late - early), early, late)
    assert min(map(distance, times)) <= least + CLOSE
    assert early <= min(times)
    assert max(times) <= late
    assert len(times) <= MOST_STEPS + 1
    assert len(set(times)) == len(times)


def test_tangents_on_both_sides_of_a_kink_tell_where_it_is():
    distance, slope, (early, late), _ = LOWS["a kink"]
    assert looked_at(distance, slope, early, early, late)[-1] == pytest.approx(3.1)
    assert looked_at(distance, slope, early, early, late, turn=3.3)[1:] == [3.3, pytest.approx(3.1)]


def test_where_the_middles_are_nearest_is_looked_at_next():
    distance, slope, (early, late), _ = LOWS["a parabola"]
    assert looked_at(distance, slope, 0.0, early, late, turn=1.3) == [0.0, 1.3]
    assert looked_at(distance, slope, 0.0, early, late, turn=-1.3)[1] != pytest.approx(1.3)


def test_what_neither_falls_nor_rises_is_looked_at_once():
    assert looked_at(lambda _: 1.0, lambda _: 0.0, 2.0, 0.0, 4.0) == [2.0]


@pytest.mark.parametrize("speed", [5e-324, 1e-200, 1e200])
@pytest.mark.parametrize("width", [1e-150, 1.0, 1e15])
def test_extreme_slopes_and_widths_do_no_harm(speed, width):
    middle = 0.5 * width
    times = looked_at(
        lambda t: 1.0 + speed * abs(t - middle), lambda t: speed if t > middle else -speed, 0.0, 0.0, width
    )
    assert all(0.0 <= time <= width for time in times)
    assert len(times) <= MOST_STEPS + 1


def test_random_lows_are_found():
    """The greatest of some random lines is convex: its low is that of a fine grid of times, refined once."""
    rng = np.random.default_rng(5)
    for _ in range(200):
        slopes, heights = rng.normal(size=6), rng.uniform(0.5, 2.0, 6)
        slopes[:2] = abs(slopes[0]) + 0.1, -abs(slopes[1]) - 0.1

        def distance(t, slopes=slopes, heights=heights):
            return float((slopes * t + heights).max())

        def slope(t, slopes=slopes, heights=heights):
            return float(slopes[(slopes * t + heights).argmax()])

        times = looked_at(distance, slope, float(rng.uniform(-20, 20)), -20.0, 20.0)
        grid = np.linspace(-20.0, 20.0, 20001)
        least = (slopes[:, None] * grid + heights[:, None]).max(axis=0).min()
        assert min(map(distance, times)) <= least + 2.0 * CLOSE


def test_the_middles_of_two_that_pass_are_nearest_when_they_do():
    place = np.eye(4)
    place[:3, 3] = -3.0, 2.0, 0.0
    still = Body("still", None, np.eye(4), Fixed(), (box(1.0, 1.0, 1.0),))
    passes = Body("passes", None, place, Constant((1.5, 0.0, 0.0), (0.0, 0.0, 0.3)), (box(0.5, 0.5, 0.5),))
    for bodies in ((still, passes), (passes, still)):
        (pair,) = pairs_that_might_collide(Scene(bodies, 0.0, 5.0, PairRules()), NarrowPhase(bodies), 0.0)
        for t in (0.5, 2.0, 4.5):
            assert Tangent.at(pair.measure_exactly(t)).turn == pytest.approx(2.0 - t)


def swinging(rng) -> tuple[Body, Body]:
    place = np.eye(4)
    place[:3, 3] = rng.uniform(2.0, 3.0, 3)
    swing = Harmonic((0.6, 0.0, 0.8), 0.3, 1.7, 0.4)
    turning = Constant(tuple(rng.normal(size=3) * 0.2), tuple(rng.normal(size=3)))
    return (
        Body("swings", None, np.eye(4), swing, (box(0.5, 0.6, 0.7),)),
        Body("turns", None, place, turning, (box(1.0, 0.3, 0.2), round_shape(0.3))),
    )


def test_the_slope_is_that_of_what_is_measured():
    rng = np.random.default_rng(6)
    step, agree = 1e-6, 0
    for _ in range(20):
        bodies = swinging(rng)
        (pair,) = pairs_that_might_collide(Scene(bodies, 0.0, 1.0, PairRules()), NarrowPhase(bodies), 0.0)
        for t in rng.uniform(0.1, 0.9, 5).tolist():
            before, here, after = (pair.measure_exactly(time) for time in (t - step, t, t + step))
            assert before.above > 0.1
            tangent = Tangent.at(here)
            agree += tangent.slope == pytest.approx((after.above - before.above) / (2.0 * step), abs=1e-4)
            assert (tangent.time, tangent.distance) == (t, here.above)
    assert agree >= 98  # at a kink there is no slope
