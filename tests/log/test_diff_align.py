"""Which contact is which: properties of every alignment, and the cases a reviewer would name."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from closecall.formats.log.diff.align import Interval, aligned, gap

THREE: list[Interval] = [(0.0, 1.0), (2.0, 3.0), (4.0, 5.0)]


@st.composite
def intervals(draw: st.DrawFn) -> list[Interval]:
    ends = sorted(draw(st.lists(st.integers(0, 60), max_size=12, unique=True)))
    return [(float(low), float(high)) for low, high in zip(ends[::2], ends[1::2], strict=False)]


def overlap(one: Interval, other: Interval) -> bool:
    return one[0] <= other[1] and other[0] <= one[1]


@given(intervals(), intervals())
def test_each_interval_stands_once_and_in_order(golden, new):
    pairs = aligned(golden, new)
    assert [i for i, _ in pairs if i is not None] == list(range(len(golden)))
    assert [j for _, j in pairs if j is not None] == list(range(len(new)))


@given(intervals(), intervals())
def test_what_overlaps_is_one_unless_its_like_is_taken(golden, new):
    pairs = aligned(golden, new)
    alone = {i for i, j in pairs if j is None}, {j for i, j in pairs if i is None}
    for i in alone[0]:
        for j in alone[1]:
            assert i is None or j is None or not overlap(golden[i], new[j])


@given(intervals())
def test_the_same_intervals_are_each_others_like(golden):
    assert aligned(golden, golden) == [(i, i) for i in range(len(golden))]


@pytest.mark.parametrize("gone", [0, 1, 2])
def test_one_that_is_gone_is_gone_alone(gone):
    left = [one for i, one in enumerate(THREE) if i != gone]
    pairs = aligned(THREE, left)
    assert [i for i, j in pairs if j is None] == [gone]
    assert [j for i, j in pairs if i is None] == []


def test_short_contacts_that_moved_past_their_own_length_are_still_the_same():
    moved = [(low + 1.4, high + 0.9) for low, high in THREE]
    assert not any(overlap(one, other) for one, other in zip(THREE, moved, strict=True))
    assert aligned(THREE, moved)[:1] == [(0, 0)]
    assert aligned([(1.0, 1.001)], [(1.0032, 1.0042)]) == [(0, 0)]


def test_a_contact_that_broke_in_two_keeps_its_begin():
    assert aligned([(0.0, 3.0)], [(0.0, 1.0), (2.0, 3.0)]) == [(0, 0), (None, 1)]


@pytest.mark.parametrize(
    ("one", "other", "apart"),
    [
        ((1.0, 2.0), (1.5, 3.0), 0.0),
        ((1.0, 2.0), (2.5, 3.0), 0.5),
        ((3.0, 2.5), (1.0, 2.0), 0.5),
        ((1.0, 1.0), (1.0, 1.0), 0.0),
    ],
)
def test_the_gap_between_brackets_does_not_depend_on_their_direction(one, other, apart):
    assert gap(one, other) == gap(other, one) == apart
