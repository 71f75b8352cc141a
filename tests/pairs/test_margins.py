"""Breaches of a margin, and bodies that come and go: what the closed forms say of when."""

from __future__ import annotations

from itertools import pairwise
from math import pi, sqrt

import numpy as np
import pytest

from closecall.scheduler.model.events import Collision, Phase, Reason, Span, Verdict, Wakeup
from closecall.scheduler.model.scene import ALWAYS, Body, Mesh, PairRules, PairSet, Scene, Settings, Shape
from closecall.scheduler.motions import Constant, Fixed, Harmonic
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide
from closecall.scheduler.run import run

POINT = Mesh("point", np.zeros((1, 3)), np.zeros((1, 3), dtype=np.int64), solid=False)
HERE = np.eye(4)
O = (0.0, 0.0, 0.0)  # noqa: E741
BREACH_SLOP = 1e-9  # s: a crossing of the margin is known to 1/16384 of the contact tolerance


def ball(name, radius, x, y, motion, exists=ALWAYS) -> Body:
    pose = np.eye(4)
    pose[:2, 3] = x, y
    return Body(name, None, pose, motion, (Shape(POINT, radius, HERE),), exists)


def events_of(*bodies, end=4.0, margin=0.0, rules=None):
    scene = Scene(bodies, 0.0, end, rules or PairRules())
    return list(run(pairs_that_might_collide(scene, NarrowPhase(bodies), margin), Settings(margin=margin)))


def spans(events) -> list[Span]:
    return [event for event in events if isinstance(event, Span)]


def passing(y, **options):
    """A ball of radius 0.5 runs past one of 0.25 at 1 m/s; centres are nearest, y apart, at 2 s."""
    return events_of(
        ball("still", 0.25, 0, 0, Fixed()), ball("runs", 0.5, -2, y, Constant((1.0, 0.0, 0.0), O)), **options
    )


def test_a_breach_begins_and_ends_where_the_quadratic_says():
    told = spans(passing(1.0, margin=0.4))
    assert [span.verdict for span in told] == [Verdict.CLEAR, Verdict.BREACH, Verdict.CLEAR]
    half = sqrt(1.15**2 - 1.0)
    assert told[1].start == pytest.approx(2 - half, abs=BREACH_SLOP)
    assert told[1].end == pytest.approx(2 + half, abs=BREACH_SLOP)
    assert all(one.end == other.start for one, other in pairwise(told))
    assert told[0].clearance >= 0.4 - 1e-9
    assert told[2].clearance >= 0.4 - 1e-9
    assert 0.0 < told[1].clearance <= 0.25


def test_a_contact_lies_inside_its_breach():
    events = passing(0.3, margin=0.2)
    told = spans(events)
    assert [span.verdict.name for span in told] == ["CLEAR", "BREACH", "CONTACT", "BREACH", "CLEAR"]
    near, touch = sqrt(0.95**2 - 0.09), sqrt(0.75**2 - 0.09)
    assert [span.end for span in told[:-1]] == pytest.approx([2 - near, 2 - touch, 2 + touch, 2 + near], abs=1.1e-6)
    collisions = [event for event in events if isinstance(event, Collision)]
    assert [event.phase for event in collisions] == [Phase.BEGIN, Phase.END]


@pytest.mark.parametrize("short", [0.0, 1e-13, -1e-13])
def test_a_graze_of_the_margin_is_never_called_clear_nor_a_contact(short):
    told = spans(passing(1.0, margin=0.25 - short))
    at_nearest = [span for span in told if span.start <= 2.0 <= span.end]
    assert all(span.verdict in (Verdict.UNRESOLVED, Verdict.BREACH) for span in at_nearest)
    assert all(span.clearance > 0.2 for span in at_nearest)
    assert at_nearest[0].end - at_nearest[0].start < 0.1


def test_a_margin_kept_by_a_little_is_clear():
    told = spans(passing(1.0, margin=0.25 - 3e-4))
    assert [span.verdict for span in told] == [Verdict.CLEAR]
    assert told[0].clearance > 0.25 - 3e-4


def test_a_breach_that_lasts_is_slept_through():
    """0.1 apart, moving by 1 mm, with a margin of 0.5: no wakeup is needed but the first and the last."""
    events = events_of(
        ball("still", 0.5, 0, 0, Fixed()),
        ball("hums", 0.5, 1.1, 0, Harmonic((1.0, 0.0, 0.0), 1e-3, 0.1, 0.0)),
        margin=0.5,
    )
    assert [span.verdict for span in spans(events)] == [Verdict.BREACH]
    assert spans(events)[0].clearance == pytest.approx(0.099, abs=2e-3)
    woken = [event for event in events if isinstance(event, Wakeup) and event.reason is not Reason.MINIMUM]
    assert len(woken) <= 4


def test_the_last_rule_that_names_a_pair_sets_its_margin():
    everyone, first = frozenset(range(3)), frozenset({0})
    margins = ((PairSet(everyone, everyone), 0.1), (PairSet(first, frozenset({2})), 0.3))
    rules = PairRules(margins=margins)
    assert [rules.margin(0, 1, 9.0), rules.margin(2, 0, 9.0), rules.margin(3, 0, 9.0)] == [0.1, 0.3, 9.0]


def test_a_margin_of_its_own_is_used_for_the_pair():
    both = frozenset({0, 1})
    told = spans(passing(1.0, margin=0.0, rules=PairRules(margins=((PairSet(both, both), 0.4),))))
    assert [span.verdict for span in told] == [Verdict.CLEAR, Verdict.BREACH, Verdict.CLEAR]


def test_spans_tile_the_time_that_both_bodies_exist():
    events = events_of(
        ball("early", 0.25, 0, 0, Fixed(), exists=(-5.0, 2.5)),
        ball("late", 0.25, 3, 0, Harmonic((1.0, 0.0, 0.0), 0.5, 1.0, 0.0), exists=(1.0, 9.0)),
    )
    told = spans(events)
    assert (told[0].start, told[-1].end) == (1.0, 2.5)
    assert {span.verdict for span in told} == {Verdict.CLEAR}
    woken = [event for event in events if isinstance(event, Wakeup) and event.reason is not Reason.MINIMUM]
    assert (woken[0].time, woken[0].reason) == (1.0, Reason.START)
    assert (woken[-1].time, woken[-1].reason) == (2.5, Reason.END)


def test_a_body_that_appears_inside_another_touches_from_then_on():
    events = passing_with_existence((1.75, 2.25))
    (begin,) = [event for event in events if isinstance(event, Collision)]
    assert (begin.phase, begin.time_clear, begin.time_touching) == (Phase.BEGIN, 1.75, 1.75)
    assert [(span.verdict, span.start, span.end) for span in spans(events)] == [(Verdict.CONTACT, 1.75, 2.25)]


def test_a_body_that_is_gone_when_the_other_passes_touches_nothing():
    assert {span.verdict for span in spans(passing_with_existence((0.0, 1.0)))} == {Verdict.CLEAR}
    assert passing_with_existence((5.0, 6.0)) == []


def passing_with_existence(exists):
    return events_of(
        ball("guest", 0.25, 0, 0, Fixed(), exists=exists),
        ball("runs", 0.5, -2, 0.2, Constant((1.0, 0.0, 0.0), (0.0, 0.0, pi))),
    )
