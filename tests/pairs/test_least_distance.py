"""The least distance of a pair over its run: the certified bracket against closed forms."""

from __future__ import annotations

from math import hypot, inf, sqrt

import numpy as np
import pytest
from small_scenes import box, events_of, round_shape

from closecall.scheduler.model.events import Distance, Reason, Span, Verdict, Wakeup
from closecall.scheduler.model.scene import Body, Settings
from closecall.scheduler.motions import Constant, Fixed, Harmonic, Keyframes, Looped, Orbit, Translation
from closecall.scheduler.pairs import least_distance as minimum
from closecall.scheduler.pairs import span_record as stretches

O = (0.0, 0.0, 0.0)  # noqa: E741
ROUNDING = 1e-12


def body(name, shape, place, motion) -> Body:
    pose = np.eye(4)
    pose[:3, 3] = place
    return Body(name, None, pose, motion, (shape,))


def ball(name, radius, place, motion) -> Body:
    return body(name, round_shape(radius), place, motion)


def bracket(events) -> tuple[float, float, float]:
    """Return the certified and the least measured distance, and when that was."""
    lower = min((event.clearance for event in events if isinstance(event, Span)), default=inf)
    distances = [(event.distance, event.time) for event in events if isinstance(event, Distance)]
    return lower, *min(distances, default=(inf, inf))


def is_tight(events, least: float, share: float = 0.01) -> bool:
    lower, upper, _ = bracket(events)
    holds = lower <= least + ROUNDING and least <= upper + ROUNDING
    return holds and upper - lower <= max(share * upper, 1e-6) + ROUNDING


@pytest.mark.parametrize("gap", [0.5, 0.01, 1e-4])
def test_balls_that_pass_are_as_near_as_their_centres_say(gap):
    passing = ball("runs", 0.5, (-2.0, 0.75 + gap, 0.0), Constant((1.0, 0.0, 0.0), O))
    events = events_of(ball("still", 0.25, O, Fixed()), passing)
    assert is_tight(events, gap)
    assert abs(bracket(events)[2] - 2.0) <= sqrt((0.75 + 1.01 * gap) ** 2 - (0.75 + gap) ** 2) + 1e-3


@pytest.mark.parametrize("share", [0.1, 0.01, 0.001])
def test_a_turning_bar_comes_as_near_as_its_corner(share):
    """A bar 2 m long and 0.2 m thick turns beside a wall: its corner runs on a circle."""
    wall = body("wall", box(0.1, 6.0, 6.0), (1.1, 0.0, 0.0), Fixed())
    bar = body("bar", box(2.0, 0.2, 0.2), O, Constant(O, (0.0, 0.0, 2.0)))
    events = events_of(wall, bar, settings=Settings(distance_tolerance=share))
    assert is_tight(events, 1.05 - hypot(1.0, 0.1), share)


def test_a_search_without_measurements_for_the_whole_still_proves_what_they_allow(monkeypatch):
    """A bar passes a wall 25 times; what is left is not twice what it took to prove it clear."""
    monkeypatch.setattr(minimum, "MOST_MEASUREMENTS", 300)
    monkeypatch.setattr(minimum, "RESERVE", 250)
    wall = body("wall", box(0.1, 6.0, 6.0), (1.1, 0.0, 0.0), Fixed())
    bar = body("bar", box(2.0, 0.2, 0.2), O, Constant(O, (0.0, 0.0, 20.0)))
    events = events_of(wall, bar)
    lower, upper, _ = bracket(events)
    least = 1.05 - hypot(1.0, 0.1)
    assert 0.5 * least < lower < least <= upper < 1.01 * least
    assert sum(isinstance(event, Wakeup) and event.reason is Reason.MINIMUM for event in events) <= 300


def test_the_bracket_of_a_gap_that_swings_is_tight():
    """Along x the gap is 0.3 - 0.2 sin(2 pi t / 1.3), 0.1 at its least."""
    swings = body("swings", box(1.0, 1.0, 1.0), (1.3, 0.2, 0.1), Harmonic((-1.0, 0.0, 0.0), 0.2, 1.3, 0.0))
    events = events_of(body("still", box(1.0, 1.0, 1.0), O, Fixed()), swings)
    assert is_tight(events, 0.1)


def test_bodies_that_move_alike_are_measured_at_the_start_and_at_the_end_alone():
    alike = Constant((0.5, 0.0, 0.0), O)
    events = events_of(body("one", box(1, 1, 1), O, alike), body("other", box(1, 1, 1), (1.35, 0, 0), alike))
    assert is_tight(events, 0.35)
    assert len([event for event in events if isinstance(event, Wakeup)]) <= 4


def test_a_body_that_goes_along_a_wall_is_measured_a_few_times():
    """Motion along the wall costs nothing: not a step for every hundredth of the gap."""
    wall, goes = body("wall", box(8.0, 0.2, 8.0), O, Fixed()), Constant((1.0, 0.0, 0.5), O)
    events = events_of(wall, body("goes", box(0.4, 0.4, 0.4), (-2.0, 0.6, -1.0), goes))
    assert is_tight(events, 0.3)
    assert len([event for event in events if isinstance(event, Wakeup)]) <= 8


@pytest.mark.parametrize("final", [0.2, 0.0001])
def test_a_jump_at_the_very_end_to_a_nearer_place_counts(final):
    """From where bounding spheres suffice to a gap of `final` m, at the last instant."""
    places = np.array([[9.0, 0.0, 0.0], [1.0 + final, 0.0, 0.0]])
    jump = Keyframes(np.array([0.0, 4.0]), places, np.tile([1.0, 0, 0, 0], (2, 1)), Translation.STEP, True)
    events = events_of(body("still", box(1, 1, 1), O, Fixed()), body("jumps", box(1, 1, 1), O, jump))
    lower, upper, time = bracket(events)
    assert (upper, time) == (pytest.approx(final, abs=ROUNDING), 4.0)
    assert lower <= final + ROUNDING
    assert is_tight(events, final)


def test_a_breach_is_narrowed_as_well():
    runs = ball("runs", 0.5, (-2.0, 1.0, 0.0), Constant((1.0, 0.0, 0.0), O))
    events = events_of(ball("still", 0.25, O, Fixed()), runs, settings=Settings(margin=0.4))
    assert [event.verdict for event in events if isinstance(event, Span)] == [
        Verdict.CLEAR,
        Verdict.BREACH,
        Verdict.CLEAR,
    ]
    assert is_tight(events, 0.25)


def test_without_a_tolerance_nothing_more_is_measured():
    runs = ball("runs", 0.5, (-2.0, 1.0, 0.0), Constant((1.0, 0.0, 0.0), O))
    still = ball("still", 0.25, O, Fixed())
    loose = events_of(still, runs, settings=Settings(distance_tolerance=None))
    assert not is_tight(loose, 0.25)
    assert not [event for event in loose if isinstance(event, Wakeup) and event.reason is Reason.MINIMUM]
    assert bracket(loose)[0] <= 0.25


def test_a_pair_cleared_by_spheres_alone_keeps_the_bound_that_cleared_it():
    far = body("far", box(1, 1, 1), (30.0, 0.0, 0.0), Harmonic((0.0, 1.0, 0.0), 1.0, 1.0, 0.0))
    events = events_of(body("still", box(1, 1, 1), O, Fixed()), far)
    lower, upper, _ = bracket(events)
    assert upper == inf
    assert 0.0 < lower <= 29.0


def test_a_pair_that_touches_is_not_searched():
    runs = ball("runs", 0.5, (-2.0, 0.3, 0.0), Constant((1.0, 0.0, 0.0), O))
    events = events_of(ball("still", 0.25, O, Fixed()), runs)
    assert bracket(events)[:2] == (0.0, 0.0)
    assert Reason.MINIMUM not in [event.reason for event in events if isinstance(event, Wakeup)]


def path(times, places) -> Keyframes:
    return Keyframes(
        np.array(times), np.array(places), np.tile([1.0, 0, 0, 0], (len(times), 1)), Translation.LINEAR, True
    )


def test_a_jump_inside_joined_stretches_is_not_slept_across(monkeypatch):
    """A ball loops from x = 8 to 1.1 to 8.5 m and jumps back; another goes by on a V, nearest in the seventh loop."""
    monkeypatch.setattr(stretches, "MOST_STRETCHES", 8)
    loops, nearest = 12, 6.5
    loop = Looped(path([0.0, 0.5, 1.0], [[8.0, 0, 0], [1.1, 0, 0], [8.5, 0, 0]]), False, True)
    away = path([0.0, nearest, loops], [[-0.5 * nearest, 0, 0], [0.0, 0, 0], [-0.5 * (loops - nearest), 0, 0]])
    events = events_of(ball("away", 0.5, O, away), ball("loops", 0.5, O, loop), end=float(loops))
    lower, upper, _ = bracket(events)
    assert lower <= 0.1 + ROUNDING
    assert upper >= 0.1 - ROUNDING


def test_what_seemed_to_graze_its_margin_and_kept_it_is_clear():
    """A ball on an orbit of 0.02 m at 5000 rad/s comes as near as 0.0525 m, and the margin is 0.05 m."""
    orbit = Orbit((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), 0.02, 5000.0, 0.0, False)
    other = ball("other", 0.1, (0.02 + 0.2 + 0.0525, 0.0, 0.0), Harmonic((0.0, 1.0, 0.0), 1e-4, 1.0, 0.0))
    events = events_of(ball("orbits", 0.1, O, orbit), other, end=0.1, settings=Settings(margin=0.05))
    for event in events:
        if isinstance(event, Span) and event.clearance > 0.05:
            assert event.verdict is Verdict.CLEAR
    assert bracket(events)[0] <= 0.0525 + ROUNDING
