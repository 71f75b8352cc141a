"""Which stretches make up a span, and to whom a sliver beside a margin's crossing belongs."""

from itertools import pairwise

import pytest

from closecall.formats.log.summary import Subject, SummaryBuilder
from closecall.scheduler.model.events import PairKey, Span, Verdict
from closecall.scheduler.pairs.span_record import SpanRecord

KEY = PairKey(0, 0, 1)
RESOLUTION, CROSSING = 1e-3, 1e-10
CLEAR, BREACH, UNRESOLVED, CONTACT = Verdict.CLEAR, Verdict.BREACH, Verdict.UNRESOLVED, Verdict.CONTACT


def spans(*stretches: tuple[Verdict, float, float]) -> list[Span]:
    """Return the spans of stretches (verdict, duration in s, clearance in m), one after the other."""
    record, told, end = SpanRecord(KEY, 0.0, 1e-12, RESOLUTION, CROSSING), [], 0.0
    for verdict, duration, clearance in stretches:
        end += duration
        told += record.extend(end, verdict, clearance, 0.0, 1.0)
    return [*told, *record.finish()]


def verdicts(*stretches: tuple[Verdict, float, float]) -> list[Verdict]:
    told = spans(*stretches)
    assert all(one.end == other.start for one, other in pairwise(told))
    assert (told[0].start, told[-1].end) == (0.0, pytest.approx(sum(duration for _, duration, _ in stretches)))
    return [span.verdict for span in told]


def test_breaches_that_a_sliver_parts_are_one_with_the_least_clearance_of_all():
    for length in (1e-12, 1e-9, 9e-4):
        (told,) = spans((BREACH, 1.0, 0.5), (UNRESOLVED, length, 0.3), (BREACH, 1.0, 0.4))
        assert (told.verdict, told.clearance, told.end) == (BREACH, 0.3, pytest.approx(2.0 + length))


def test_ten_breaches_in_a_row_are_one():
    told = verdicts(*[(BREACH, 1e-9, 0.4), (UNRESOLVED, 1e-10, 0.4)] * 10, (BREACH, 1.0, 0.4), (CLEAR, 1.0, 0.5))
    assert told == [BREACH, CLEAR]


def test_a_sliver_that_could_touch_or_is_long_is_told_by_itself():
    assert verdicts((BREACH, 1.0, 0.5), (UNRESOLVED, 1e-10, 0.0), (BREACH, 1.0, 0.4)) == [BREACH, UNRESOLVED, BREACH]
    assert verdicts((BREACH, 1.0, 0.5), (UNRESOLVED, 2e-3, 0.3), (BREACH, 1.0, 0.4)) == [BREACH, UNRESOLVED, BREACH]


def test_beside_one_breach_a_sliver_belongs_to_it_within_the_tolerance_of_a_crossing():
    for other, kept in ((CLEAR, 0.5), (CONTACT, 0.0)):
        assert verdicts((other, 1.0, kept), (UNRESOLVED, 9e-11, 0.4), (BREACH, 1.0, 0.4)) == [other, BREACH]
        assert verdicts((BREACH, 1.0, 0.4), (UNRESOLVED, 9e-11, 0.4), (other, 1.0, kept)) == [BREACH, other]
        long = verdicts((other, 1.0, kept), (UNRESOLVED, 3e-10, 0.4), (BREACH, 1.0, 0.4))
        assert long == [other, UNRESOLVED, BREACH]
    assert verdicts((BREACH, 1.0, 0.4), (UNRESOLVED, 9e-11, 0.4)) == [BREACH]


def test_what_grazes_the_margin_without_a_breach_is_unresolved():
    told = verdicts((CLEAR, 1.0, 0.5), (UNRESOLVED, 1e-11, 0.4), (CLEAR, 1.0, 0.5))
    assert told == [CLEAR, UNRESOLVED, CLEAR]


def test_a_sliver_that_could_touch_does_not_add_to_the_breaches_counted():
    subject = Subject("ab".__getitem__, (0.0, 5.0), {"time_resolution": 1e-3}, 1, 0, lambda body: 0.0, lambda a, b: 1.0)
    builder = SummaryBuilder(subject)
    for verdict, start, end in (
        (BREACH, 0.0, 1.0),
        (UNRESOLVED, 1.0, 1.0001),
        (BREACH, 1.0001, 2.0),
        (UNRESOLVED, 2.0, 2.5),
        (BREACH, 2.5, 5.0),
    ):
        builder.add(Span(KEY, verdict, start, end, 0.0, 0.0, 1e-12))
    (pair,) = builder.summary()["pairs"]
    assert pair["breaches"] == [[0.0, 2.0], [2.5, 5.0]]
    assert pair["unresolved"] == [[1.0, 1.0001], [2.0, 2.5]]
