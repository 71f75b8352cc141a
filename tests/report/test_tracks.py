"""What is drawn of a pair is thinned, and stays true: bounds err low, extremes and contacts are kept."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from closecall.formats.log import messages_pb2 as pb
from closecall.formats.report import tracks as tracks_module
from closecall.formats.report.packing import below
from closecall.formats.report.tracks import Curve, Tracks

END = 10.0
DRAWN = 60
"""Points and spans of a pair after thinning, at most: in 8 parts of the run at the least."""

FloatArray = NDArray[np.float64]


def thinned(measured: FloatArray, bounds: FloatArray, spans: FloatArray, monkeypatch: pytest.MonkeyPatch) -> Curve:
    """Return what is drawn of one pair where the page has room for few points; while reading, too."""
    monkeypatch.setattr(tracks_module, "_MOST_KEPT", 3 * DRAWN)
    monkeypatch.setattr(tracks_module, "_MOST_DRAWN", DRAWN)
    tracks = Tracks(1, 0.0, END)
    for time, distance in measured.tolist():
        tracks.add_measured(0, time, distance)
    for time, clearance in bounds.tolist():
        tracks.add_bound(0, time, clearance)
    for start, end, verdict, clearance in spans.tolist():
        tracks.add_span(0, (start, end, int(verdict), clearance))
    (curve,) = tracks.curves()
    return curve


def drawn_spans(seed: int, count: int) -> FloatArray:
    """Return spans (n, 4) that follow each other over the run, many of them short, of random verdicts."""
    rng = np.random.default_rng(seed)
    cuts = np.concatenate(([0.0], np.sort(rng.uniform(0.0, END, count - 1) ** 2 / END), [END]))
    verdicts = rng.choice([pb.Span.CLEAR, pb.Span.CONTACT, pb.Span.BREACH, pb.Span.UNRESOLVED], count)
    return np.column_stack((cuts[:-1], cuts[1:], verdicts, rng.uniform(0.0, 3.0, count)))


@pytest.mark.parametrize("seed", range(5))
def test_where_a_contact_is_told_a_contact_is_drawn(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    spans = drawn_spans(seed, 400)
    drawn = thinned(np.zeros((0, 2)), np.zeros((0, 2)), spans, monkeypatch).spans
    assert len(drawn) <= DRAWN
    contacts = spans[spans[:, 2] == pb.Span.CONTACT]
    shown = drawn[drawn[:, 2] == pb.Span.CONTACT]
    assert len(contacts) > 50
    for start, end in contacts[:, :2]:
        inside = (shown[:, 0] <= end) & (shown[:, 1] >= start)
        covered = np.minimum(shown[inside, 1], end) - np.maximum(shown[inside, 0], start)
        assert covered.sum() == pytest.approx(end - start, abs=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_a_clearance_is_never_drawn_higher_than_it_was_certified(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    spans = drawn_spans(seed, 400)
    drawn = thinned(np.zeros((0, 2)), np.zeros((0, 2)), spans, monkeypatch).spans
    for start, end, _, clearance in spans:
        over = drawn[(drawn[:, 0] < end) & (drawn[:, 1] > start)]
        assert (over[:, 3] <= clearance).all()


def test_spans_that_are_drawn_follow_one_another(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = thinned(np.zeros((0, 2)), np.zeros((0, 2)), drawn_spans(7, 400), monkeypatch).spans
    assert (drawn[0, 0], drawn[-1, 1]) == (0.0, END)
    assert np.array_equal(drawn[1:, 0], drawn[:-1, 1])


@pytest.mark.parametrize("seed", range(5))
def test_points_that_are_drawn_were_measured_and_the_extremes_are_among_them(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(seed)
    measured = np.column_stack((rng.uniform(0.0, END, 1000), rng.exponential(1.0, 1000)))  # in any order
    bounds = np.column_stack((rng.uniform(0.0, END, 1000), rng.exponential(1.0, 1000)))
    curve = thinned(measured, bounds, np.zeros((0, 4)), monkeypatch)
    assert 20 < len(curve.measured) + len(curve.bounds) <= DRAWN
    for told, drawn in ((measured, curve.measured), (bounds, curve.bounds)):
        assert {tuple(point) for point in drawn.tolist()} <= {tuple(point) for point in told.tolist()}
        assert (np.diff(drawn[:, 0]) >= 0.0).all()
        assert drawn[:, 1].min() == told[:, 1].min()
    assert curve.measured[:, 1].max() == measured[:, 1].max()


def test_few_points_are_all_drawn() -> None:
    tracks = Tracks(2, 0.0, END)
    for time in (3.0, 1.0, 2.0):
        tracks.add_measured(1, time, 10.0 * time)
    empty, curve = tracks.curves()
    assert len(empty.measured) == len(empty.bounds) == len(empty.spans) == 0
    assert curve.measured.tolist() == [[1.0, 10.0], [2.0, 20.0], [3.0, 30.0]]


@given(st.lists(st.floats(0.0, 1e12), min_size=1))
def test_a_bound_in_single_precision_is_not_above_itself(values: list[float]) -> None:
    exact = np.array(values)
    single = below(exact)
    assert single.dtype == np.float32
    assert (single.astype(np.float64) <= exact).all()
    assert np.allclose(single, exact, rtol=2e-7, atol=1e-44)
