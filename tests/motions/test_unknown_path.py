"""Bodies whose path is unknown: when contact can be reached, against closed forms and paths drawn at random."""

from __future__ import annotations

from itertools import pairwise
from math import inf, pi, sin, sqrt

import numpy as np
import pytest
from scene_files import MOTION, fault
from scipy.integrate import quad
from scipy.optimize import brentq
from small_scenes import box, events_of
from small_scenes import round_shape as ball

from closecall.scheduler.model.events import Collision, Distance, Phase, Reason, Span, Verdict, Wakeup
from closecall.scheduler.model.scene import Body, PairRules, Scene, Settings
from closecall.scheduler.motions import Constant, Fixed, Harmonic, Limits
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide
from closecall.scheduler.snapshots.snapshot import Observer

O = (0.0, 0.0, 0.0)  # noqa: E741
TOLERANCE = Settings().contact_tolerance


def body(name, shape, x=0.0, motion=None, parent=None) -> Body:
    pose = np.eye(4)
    pose[0, 3] = x
    return Body(name, parent, pose, motion or Fixed(), () if shape is None else (shape,))


def spans(events) -> list[Span]:
    return [event for event in events if isinstance(event, Span)]


def verdicts(events) -> list[str]:
    return [span.verdict.name for span in spans(events)]


def changes(events) -> list[float]:
    return [before.end for before, _ in pairwise(spans(events))]


WALL = box(0.2, 20.0, 20.0)


@pytest.mark.parametrize(
    ("speed", "max_speed", "max_acceleration"),
    [(0.0, 1.6, 3.0), (0.5, 1.6, 3.0), (1.6, 1.6, 3.0), (0.2, inf, 0.7), (0.3, 2.0, inf), (0.3, 2.0, 0.0)],
)
def test_the_reach_is_the_integral_of_the_fastest_speed(speed, max_speed, max_acceleration):
    limits = Limits(0.7, speed, max_speed, max_acceleration)

    def fastest(since):
        gained = 0.0 if max_acceleration == 0.0 else max_acceleration * since
        return min(speed + gained, max_speed)

    bend = (max_speed - speed) / max_acceleration if 0.0 < max_acceleration < inf else 1.0
    for t in (-3.0, 0.7, 0.8, 1.4, 5.0):
        since = max(0.0, t - 0.7)
        expected = quad(fastest, 0.0, since, points=[bend] if 0.0 < bend < since else None)[0]
        assert limits.reach(t) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_contact_is_possible_from_when_the_reach_covers_the_gap():
    """A box in any attitude is held by the ball through its corners; 1.6 m/s is reached after 0.5333 s and 0.4267 m."""
    person = body("person", box(0.6, 0.4, 1.8), 0.0, Limits(0.0, 0.0, 1.6, 3.0))
    events = events_of(person, body("wall", WALL, 3.1))
    radius = sqrt(0.3**2 + 0.2**2 + 0.9**2)
    reached = 1.6 / 3.0 + (3.0 - radius - 0.5 * 1.6 * 1.6 / 3.0) / 1.6
    assert verdicts(events) == ["CLEAR", "POSSIBLE"]
    assert changes(events) == [pytest.approx(reached, abs=TOLERANCE)]
    assert changes(events)[0] <= reached
    assert not [event for event in events if isinstance(event, Collision | Distance)]


def test_a_margin_is_possibly_broken_before_contact_is_possible():
    person = body("person", ball(0.3), 0.0, Limits(0.0, 0.0, 1.6, inf))
    events = events_of(person, body("wall", WALL, 3.1), settings=Settings(margin=0.5))
    assert verdicts(events) == ["CLEAR", "POSSIBLE"]
    assert changes(events) == [pytest.approx((3.0 - 0.3 - 0.5) / 1.6, abs=TOLERANCE)]
    assert spans(events)[0].clearance > 0.5


def test_a_machine_that_withdraws_in_time_is_clear_again():
    """The gap at t is 1.5 + 1.2 sin(2 pi t / 4 + pi) - 0.3, the reach 0.3 t."""
    person = body("person", ball(0.3), 0.0, Limits(0.0, 0.3, 0.3, 0.0))
    wall = body("wall", WALL, 1.6, Harmonic((1.0, 0.0, 0.0), 1.2, 4.0, pi))
    events = events_of(person, wall, end=3.0)

    def left(t):
        return 1.5 + 1.2 * sin(2.0 * pi * t / 4.0 + pi) - 0.3 - 0.3 * t

    expected = [brentq(left, 0.0, 1.0), brentq(left, 1.0, 3.0)]
    assert verdicts(events) == ["CLEAR", "POSSIBLE", "CLEAR"]
    assert changes(events) == [pytest.approx(time, abs=TOLERANCE) for time in expected]


def test_two_unknown_paths_add_up():
    one = body("one", ball(0.5), 0.0, Limits(0.0, 1.0, 1.0, 0.0))
    other = body("other", ball(0.25), 4.0, Limits(1.0, 2.0, 2.0, 0.0))
    reached = (4.0 - 0.75 + 2.0) / 3.0
    events = events_of(one, other)
    assert verdicts(events) == ["CLEAR", "POSSIBLE"]
    assert changes(events) == [pytest.approx(reached, abs=TOLERANCE)]


def test_what_is_carried_on_an_unknown_path_is_held_by_the_ball():
    """A tool 0.5 m out that swings by 0.1 m along its arm: no farther than 0.5 + 0.1 + 0.05 from the carrier."""
    carrier = body("carrier", None, 0.0, Limits(0.0, 0.0, 1.0, inf))
    tool = body("tool", ball(0.05), 0.5, Harmonic((1.0, 0.0, 0.0), 0.1, 1.0, 0.0), parent=0)
    events = events_of(carrier, tool, body("wall", WALL, 2.1))
    assert verdicts(events) == ["CLEAR", "POSSIBLE"]
    assert changes(events) == [pytest.approx(2.0 - 0.65, abs=TOLERANCE)]


def test_two_bodies_on_one_unknown_path_are_seen_from_it():
    carrier = body("carrier", None, 0.0, Limits(0.0, 0.0, 1.0, inf))
    fixed = body("fixed", ball(0.1), 0.0, parent=0)
    moving = body("moving", ball(0.1), 0.5, Constant((-0.1, 0.0, 0.0), O), parent=0)
    events = events_of(carrier, fixed, moving)
    assert verdicts(events) == ["CLEAR", "CONTACT"]
    assert changes(events) == [pytest.approx(3.0, abs=TOLERANCE)]


@pytest.mark.parametrize("begin", [0.0, 2.0])
def test_contact_at_the_start_is_certain_for_that_instant(begin):
    events = events_of(body("person", box(1, 1, 1), 0.0, Limits(begin, 0.0, 1.0, inf)), body("box", box(1, 1, 1), 0.9))
    collisions = [event for event in events if isinstance(event, Collision)]
    assert [(event.phase, event.time) for event in collisions] == [(Phase.BEGIN, 0.0), (Phase.END, 0.0)]
    assert verdicts(events) == ["CONTACT", "POSSIBLE"]
    assert spans(events)[0].end == np.nextafter(0.0, 1.0)


def test_an_attitude_that_touches_is_only_possible_at_the_start():
    """The plate stands beside the wall; turned, it would reach it."""
    events = events_of(body("plate", box(0.1, 2, 2), 0.0, Limits(0.0, 0.0, 1.0, inf)), body("wall", WALL, 1.0))
    assert verdicts(events) == ["POSSIBLE"]
    assert not [event for event in events if isinstance(event, Collision)]


def test_few_wakeups_are_needed_while_contact_is_possible():
    person = body("person", ball(0.3), 0.0, Limits(0.0, 0.0, 1.6, inf))
    events = events_of(person, body("wall", WALL, 1.0), end=30.0)
    assert len([event for event in events if isinstance(event, Wakeup)]) < 200


@pytest.mark.parametrize("seed", range(5))
def test_no_path_within_the_limits_touches_while_clear(seed):
    """Paths of full acceleration in directions that change at random, and straight at the machine."""
    rng = np.random.default_rng(seed)
    speed, max_speed, acceleration = rng.uniform(0.0, 0.5), rng.uniform(0.5, 2.0), rng.uniform(0.5, 4.0)
    amplitude, period, place = rng.uniform(0.1, 1.0), rng.uniform(0.5, 3.0), rng.uniform(2.0, 3.5)
    person = body("person", ball(0.3), 0.0, Limits(0.0, speed, max_speed, acceleration))
    machine = body("machine", ball(0.4), place, Harmonic((1.0, 0.0, 0.0), amplitude, period, 0.0))
    told_spans = spans(events_of(person, machine))
    clear_until = told_spans[0].end if told_spans[0].verdict is Verdict.CLEAR else 0.0
    step = 1e-3
    times = np.arange(0.0, 4.0, step)
    machine_x = place + amplitude * np.sin(2.0 * np.pi * times / period)
    first_touch = inf
    for path in range(60):
        direction = np.array([1.0, 0.0, 0.0]) if path == 0 else rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        velocity, where = speed * direction, np.zeros(3)
        for t, x in zip(times, machine_x, strict=True):
            if np.linalg.norm(where - (x, 0.0, 0.0)) < 0.7:
                first_touch = min(first_touch, t)
                break
            where = where + velocity * step
            velocity = velocity + acceleration * step * direction
            velocity *= min(1.0, max_speed / max(np.linalg.norm(velocity), 1e-12))
            if path and rng.random() < 0.005:
                direction = np.array([x, 0.0, 0.0]) - where if rng.random() < 0.7 else rng.normal(size=3)
                direction /= np.linalg.norm(direction)
    assert first_touch >= clear_until - 2.0 * step
    assert first_touch < inf
    assert first_touch - clear_until < 0.1  # walking straight at it is nearly the worst


@pytest.mark.parametrize(
    ("motion", "problem"),
    [
        ("{type: limits}", "bodies.a.motion: nothing limits how far it gets"),
        (
            "{type: limits, velocity: [0, 3, 4], max_speed: 4}",
            "bodies.a.motion.velocity: expected a speed up to max_speed, 4, got 5",
        ),
        ("{type: limits, max_sped: 4}", "unknown key 'max_sped' (did you mean 'max_speed'?)"),
        ("{type: limits, max_speed: -1}", "bodies.a.motion.max_speed: "),
    ],
)
def test_limits_that_limit_nothing_are_refused(tmp_path, motion, problem):
    assert problem in fault(tmp_path, MOTION + motion)


def test_balls_that_part_again_are_clear_from_then_on():
    """The reach is 0.3 + 0.5 t, the wall's face at 3 + sin(2 pi t): nobody reaches it between the fifth and sixth s."""
    person = body("person", ball(0.3), 0.0, Limits(0.0, 0.5, 0.5, 0.0))
    wall = body("wall", WALL, 3.1, Harmonic((1.0, 0.0, 0.0), 1.0, 1.0, 0.0))
    events = events_of(person, wall, end=6.0)

    def left(t):
        return 3.0 + sin(2.0 * pi * t) - 0.3 - 0.5 * t

    times = np.linspace(0.0, 6.0, 6001)
    gaps = np.array([left(t) for t in times])
    crossed = np.flatnonzero((gaps[1:] > 0.0) != (gaps[:-1] > 0.0))
    expected = [brentq(left, times[i], times[i + 1]) for i in crossed]
    assert changes(events) == [pytest.approx(time, abs=2.0 * TOLERANCE) for time in expected]


def test_a_snapshot_of_somebody_inside_a_solid_says_that_contact_is_possible():
    bodies = (body("person", ball(0.3), 0.0, Limits(0.0, 0.0, 0.5, inf)), body("house", box(10, 10, 10)))
    scene, narrow_phase = Scene(bodies, 0.0, 1.0, PairRules()), NarrowPhase(bodies)
    pairs = list(pairs_that_might_collide(scene, narrow_phase, 0.0))
    observer = Observer(scene, pairs, 5, narrow_phase)
    for time in (0.1, 0.5, 1.0):
        (near,) = observer.at(time, frozenset()).nearest
        assert (near.verdict, near.distance) == (Verdict.POSSIBLE, 0.0)


def test_the_least_distance_of_an_unknown_path_is_not_searched():
    """It may come as near as 0.2 m, so that balls leave little of their gap: there is no path to measure it on."""
    free = body("free", box(1.0, 1.0, 1.0), 2.8, Limits(0.0, 0.1, 0.2, 1.0))
    events = events_of(body("still", box(1.0, 1.0, 1.0)), free)
    assert verdicts(events) == ["CLEAR"]
    assert spans(events)[0].clearance < 0.5
    assert not [event for event in events if isinstance(event, Distance)]
    assert Reason.MINIMUM not in [event.reason for event in events if isinstance(event, Wakeup)]
