"""The summary: what a run's events fold into."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from closecall.formats.log.doubts import doubts
from closecall.formats.log.summary import SummaryBuilder, subject_of, to_json
from closecall.scheduler.model.events import (
    Bound,
    Collision,
    ContactKind,
    Distance,
    Feature,
    FeatureKind,
    Level,
    PairKey,
    Phase,
    Reason,
    Span,
    Verdict,
    Wakeup,
)
from closecall.scheduler.model.scene import Body, PairRules, Scene, Settings, Shape, pair_id
from closecall.scheduler.motions import Fixed

FACE = Feature(FeatureKind.FACE, 0, 0, 0)
ORIGIN = (0.0, 0.0, 0.0)
NAMES = ("gear", "hammer", "bench")


def key(a: int, b: int) -> PairKey:
    return PairKey(pair_id(a, b, len(NAMES)), a, b)


FIRST, SECOND, THIRD = key(0, 1), key(0, 2), key(1, 2)


def builder(
    pairs_total: int = 3,
    chord_errors: tuple[float, ...] = (0.0, 0.0, 0.0),
    keys_around: Callable[[int, float], tuple[str, str]] = lambda body, time: ("", ""),
) -> SummaryBuilder:
    bodies = tuple(
        Body(name, None, np.eye(4), Fixed(), (Shape(cast(Any, None), 0.0, np.eye(4), error),))
        for name, error in zip(NAMES, chord_errors, strict=True)
    )
    scene = Scene(bodies, 0.0, 10.0, PairRules())
    return SummaryBuilder(subject_of(scene, Settings(), pairs_total), keys_around)


def folded(*events, **options):
    summary = builder(**options)
    for event in events:
        summary.add(event)
    return summary.summary()


def span(pair: PairKey, verdict: Verdict, start: float, end: float, clearance: float = 0.0, error: float = 0.0) -> Span:
    return Span(pair, verdict, start, end, clearance, math.nan, error)


def wakeup(pair: PairKey, level: Level, time: float = 1.0) -> Wakeup:
    return Wakeup(time, pair, Reason.TIME_BOUND, level, Bound.SPEED_ACCELERATION, 0.5, 0.1)


def distance(pair: PairKey, time: float, value: float, excess: float = 0.0) -> Distance:
    return Distance(time, pair, value, ORIGIN, ORIGIN, FACE, FACE, excess)


def collision(pair: PairKey, phase: Phase, clear: float, touching: float) -> Collision:
    return Collision(pair, phase, clear, touching, ContactKind.SURFACE, FACE, FACE, ORIGIN)


def test_summary_has_the_contracts_keys_in_its_order():
    summary = folded(span(FIRST, Verdict.CLEAR, 0.0, 10.0, 0.25))
    assert list(summary) == ["closecall", "time", "settings", "pairs_total", "pairs_ignored", "pairs", "totals"]
    assert summary["time"] == [0.0, 10.0]
    assert summary["settings"]["time_resolution"] == 1e-3
    assert summary["pairs"] == [
        {
            "pair": "gear|hammer",
            "body_a": "gear",
            "body_b": "hammer",
            "verdict": "clear",
            "margin": 0.0,
            "distance": {
                "lower": 0.25,
                "upper": None,
                "time": None,
                "bracket": "open",
                "why": "far",
                "help": None,
            },
            "error": 0.0,
            "chord_error": 0.0,
            "contacts": [],
            "breaches": [],
            "unresolved": [],
            "possible": [],
            "wakeups": 0,
            "queries": {"sphere": 0, "mesh": 0},
        }
    ]


def test_verdict_is_the_worst_of_the_spans():
    order = [Verdict.CONTACT, Verdict.BREACH, Verdict.UNRESOLVED, Verdict.POSSIBLE, Verdict.CLEAR]
    for rank, worst in enumerate(order):
        spans = [span(FIRST, verdict, 0.0, 1.0) for verdict in reversed(order[rank:])]
        assert folded(*spans)["pairs"][0]["verdict"] == worst.name.lower()


def test_lower_is_the_least_certified_clearance_and_upper_the_least_measured_distance():
    (pair,) = folded(
        span(FIRST, Verdict.CLEAR, 0.0, 4.0, 0.2),
        distance(FIRST, 5.0, 0.15),
        distance(FIRST, 2.0, 0.15),
        distance(FIRST, 6.0, 0.4),
        span(FIRST, Verdict.CLEAR, 4.0, 10.0, 0.1),
    )["pairs"]
    told = pair["distance"]
    assert (told["lower"], told["upper"], told["time"]) == (0.1, 0.15, 2.0)


@pytest.mark.parametrize("verdict", [Verdict.CONTACT, Verdict.UNRESOLVED])
def test_lower_is_zero_where_contact_is_not_excluded(verdict):
    (pair,) = folded(span(FIRST, Verdict.CLEAR, 0.0, 4.0, 0.2), span(FIRST, verdict, 4.0, 10.0, math.nan))["pairs"]
    assert pair["distance"]["lower"] == 0.0


def test_lower_is_zero_where_one_spans_clearance_is_unknown():
    spans = [span(FIRST, Verdict.CLEAR, 0.0, 4.0, 0.2), span(FIRST, Verdict.POSSIBLE, 4.0, 10.0, math.nan)]
    assert folded(*spans)["pairs"][0]["distance"]["lower"] == 0.0


def test_contacts_are_brackets_in_time_order_whatever_the_order_found():
    events = [
        collision(FIRST, Phase.BEGIN, 0.0, 0.0),
        collision(FIRST, Phase.END, 1.1, 1.0),
        collision(FIRST, Phase.BEGIN, 2.0, 2.1),
        collision(FIRST, Phase.END, 3.1, 3.0),
        collision(FIRST, Phase.BEGIN, 9.0, 9.1),
    ]
    expected = [
        {"begin": [0.0, 0.0], "end": [1.0, 1.1], "keys": {}},
        {"begin": [2.0, 2.1], "end": [3.0, 3.1], "keys": {}},
        {"begin": [9.0, 9.1], "end": None, "keys": {}},
    ]
    for seed in range(20):
        random.Random(seed).shuffle(events)
        summary = folded(*events)
        assert summary["pairs"][0]["contacts"] == expected
        assert summary["pairs"][0]["verdict"] == "contact"
        assert summary["totals"]["contacts"] == 3


def test_a_begin_or_an_end_that_is_lost_shifts_no_other():
    begins = [collision(FIRST, Phase.BEGIN, time - 0.1, time) for time in (2.0, 4.0)]
    ends = [collision(FIRST, Phase.END, time + 0.1, time) for time in (1.0, 5.0)]
    contacts = folded(*begins, *ends)["pairs"][0]["contacts"]
    assert [(one["begin"][1], one["end"]) for one in contacts] == [(2.0, None), (4.0, [5.0, 5.1])]


def test_a_contact_of_one_instant_has_its_own_end():
    events = [collision(FIRST, phase, 2.0, 2.0) for phase in (Phase.BEGIN, Phase.END)]
    (contact,) = folded(*events)["pairs"][0]["contacts"]
    assert (contact["begin"], contact["end"]) == ([2.0, 2.0], [2.0, 2.0])


def test_contacts_name_the_keys_that_each_body_is_between_where_they_begin():
    asked = []

    def keys_around(body: int, time: float) -> tuple[str, str]:
        asked.append((body, time))
        return {0: ("home", "reach"), 1: ("", ""), 2: ("", "grip")}[body]

    events = [collision(FIRST, Phase.BEGIN, 2.0, 2.1), collision(THIRD, Phase.BEGIN, 3.0, 3.1)]
    first, third = folded(*events, keys_around=keys_around)["pairs"]
    assert first["contacts"][0]["keys"] == {"gear": ["home", "reach"]}
    assert third["contacts"][0]["keys"] == {"bench": ["", "grip"]}
    assert asked == [(0, 2.1), (1, 2.1), (1, 3.1), (2, 3.1)]


def test_the_upper_distance_of_round_bodies_is_what_was_measured_of_them_and_not_of_their_polyhedra():
    facts = (distance(FIRST, 5.0, 0.3, 0.02), distance(FIRST, 6.0, 0.305))
    clear = span(FIRST, Verdict.CLEAR, 0.0, 10.0, 0.25, 1e-15)
    (pair,) = folded(clear, *facts, chord_errors=(0.01, 0.02, 0.04))["pairs"]
    assert pair["chord_error"] == pytest.approx(0.03)
    told = pair["distance"]
    assert (told["lower"], told["upper"], told["time"]) == (0.25, 0.305, 6.0)


@pytest.mark.parametrize(
    ("told", "word", "why"),
    [
        ([span(FIRST, Verdict.CLEAR, 0.0, 10.0, 0.297), distance(FIRST, 5.0, 0.3)], "tight", None),
        ([span(FIRST, Verdict.CLEAR, 0.0, 10.0, 0.2969), distance(FIRST, 5.0, 0.3)], "wide", "search"),
        ([span(FIRST, Verdict.CLEAR, 0.0, 10.0, 1e-6), distance(FIRST, 5.0, 2e-6)], "tight", None),
        ([span(FIRST, Verdict.CLEAR, 0.0, 10.0, 4e-17), distance(FIRST, 5.0, 4.4e-5)], "wide", "search"),
        ([span(FIRST, Verdict.CLEAR, 0.0, 10.0, 0.299), distance(FIRST, 5.0, 0.3, 0.003)], "wide", "polyhedra"),
        ([span(FIRST, Verdict.CLEAR, 0.0, 10.0, 0.29, 2e-3), distance(FIRST, 5.0, 0.3)], "wide", "error"),
        ([span(FIRST, Verdict.CLEAR, 0.0, 10.0, 0.2, 2e-3), distance(FIRST, 5.0, 0.3)], "wide", "search"),
        ([span(FIRST, Verdict.UNRESOLVED, 0.0, 10.0), distance(FIRST, 5.0, 0.3)], "wide", "unresolved"),
        ([span(FIRST, Verdict.UNRESOLVED, 0.0, 10.0, 0.299), distance(FIRST, 5.0, 0.3)], "tight", None),
        ([span(FIRST, Verdict.CONTACT, 0.0, 10.0), distance(FIRST, 5.0, 0.0)], "tight", None),
        ([span(FIRST, Verdict.CONTACT, 0.0, 10.0), distance(FIRST, 5.0, 0.0, 1e-4)], "wide", "polyhedra"),
        ([span(FIRST, Verdict.POSSIBLE, 0.0, 10.0)], "open", "unknown path"),
        ([span(FIRST, Verdict.CLEAR, 0.0, 10.0, 3.0)], "open", "far"),
    ],
)
def test_a_least_distance_says_whether_it_is_known_to_one_hundredth_or_a_micrometre_and_why_not(told, word, why):
    (pair,) = folded(*told)["pairs"]
    assert (pair["distance"]["bracket"], pair["distance"]["why"]) == (word, why)
    assert (pair["distance"]["help"] is not None) == (word == "wide")


def test_a_least_distance_that_was_not_sought_says_so():
    subject = subject_of(Scene((), 0.0, 10.0, PairRules()), Settings(distance_tolerance=None), 1)
    summary = SummaryBuilder(replace(subject, name=NAMES.__getitem__, chord_error=lambda body: 0.0))
    for event in (span(FIRST, Verdict.CLEAR, 0.0, 10.0, 0.29999), distance(FIRST, 5.0, 0.3)):
        summary.add(event)
    told = summary.summary()["pairs"][0]["distance"]
    assert (told["bracket"], told["why"]) == ("wide", "not sought")


def test_a_pair_tells_the_error_of_its_distances_and_a_large_one_is_warned_of():
    (pair,) = folded(span(FIRST, Verdict.CLEAR, 0.0, 10.0, 0.2, 1e-9), distance(FIRST, 5.0, 0.3))["pairs"]
    assert pair["error"] == 1e-9
    assert doubts([pair]) == ()
    small = {**pair, "error": 1e-9, "distance": {**pair["distance"], "upper": 0.5e-9}}
    large = {**pair, "error": 1.5e-3}
    for doubted, error in ((small, "1e-9"), (large, "0.0015")):
        (warning,) = doubts([cast(Any, doubted)])
        assert warning.startswith(f"distances of gear | hammer may be wrong by {error} m; ")
    (warning,) = doubts([cast(Any, small), cast(Any, large)])
    assert "0.0015 m; 1 more pair may have a smaller error; " in warning


def test_breaches_are_listed_in_time_order():
    spans = [span(FIRST, Verdict.BREACH, 5.0, 6.0, 0.01), span(FIRST, Verdict.BREACH, 1.0, 2.0, 0.02)]
    summary = folded(*spans)
    assert summary["pairs"][0]["breaches"] == [[1.0, 2.0], [5.0, 6.0]]
    assert summary["pairs"][0]["unresolved"] == []
    assert summary["totals"]["pairs"]["breach"] == 1


def test_unresolved_spans_are_listed_in_time_order():
    (pair,) = folded(span(FIRST, Verdict.UNRESOLVED, 5.0, 6.0), span(FIRST, Verdict.UNRESOLVED, 1.0, 2.0))["pairs"]
    assert pair["unresolved"] == [[1.0, 2.0], [5.0, 6.0]]


def test_queries_count_wakeups_by_the_level_that_answered():
    summary = folded(*(wakeup(FIRST, level) for level in (Level.SPHERE, Level.MESH, Level.MESH)))
    assert summary["pairs"][0]["wakeups"] == 3
    assert summary["pairs"][0]["queries"] == {"sphere": 1, "mesh": 2}
    assert summary["totals"]["queries"] == {"sphere": 1, "mesh": 2}


def test_pairs_stand_by_pair_id_and_those_never_seen_count_as_clear():
    summary = folded(
        span(THIRD, Verdict.CLEAR, 0.0, 10.0),
        span(FIRST, Verdict.CONTACT, 0.0, 10.0),
        span(SECOND, Verdict.POSSIBLE, 0.0, 10.0),
        pairs_total=1000,
    )
    assert [pair["pair"] for pair in summary["pairs"]] == ["gear|hammer", "gear|bench", "hammer|bench"]
    assert summary["totals"]["pairs"] == {"contact": 1, "breach": 0, "unresolved": 0, "possible": 1, "clear": 998}
    assert sum(summary["totals"]["pairs"].values()) == summary["pairs_total"]


def test_a_log_that_names_more_pairs_than_it_counts_has_those_that_it_names():
    summary = folded(*(span(pair, Verdict.CONTACT, 0.0, 10.0) for pair in (FIRST, SECOND, THIRD)), pairs_total=1)
    assert summary["pairs_total"] == 3
    assert summary["totals"]["pairs"] == {"contact": 3, "breach": 0, "unresolved": 0, "possible": 0, "clear": 0}


def test_json_has_null_for_the_unknown_and_never_nan():
    text = to_json(
        folded(
            span(FIRST, Verdict.CONTACT, 0.0, 10.0, math.nan),
            span(SECOND, Verdict.CLEAR, 0.0, 10.0, math.inf),
            span(THIRD, Verdict.POSSIBLE, 0.0, 10.0, math.nan),
            distance(FIRST, 1.0, math.nan),
        )
    )
    summary = json.loads(text, parse_constant=pytest.fail)
    ends = [[pair["distance"][key] for key in ("lower", "upper", "time")] for pair in summary["pairs"]]
    assert ends == [[0.0, None, None]] * 3


def test_a_nan_distance_does_not_hide_a_measured_one():
    for values in ([math.nan, 0.3], [0.3, math.nan]):
        (pair,) = folded(*(distance(FIRST, float(time), value) for time, value in enumerate(values)))["pairs"]
        assert pair["distance"]["upper"] == 0.3


def test_a_pair_without_spans_is_proved_nothing():
    assert folded(wakeup(FIRST, Level.MESH))["pairs"][0]["verdict"] == "unresolved"
