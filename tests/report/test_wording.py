"""The sentences of a report's page say no more than is proved, and say all of that."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from report_pages import Parsed, made_up

from closecall.formats.log.reader import Loss
from closecall.formats.log.result import Found
from closecall.formats.report.page import opening
from closecall.formats.report.quantities import interval
from closecall.formats.report.wording import headline, nearest, proof, sentences


def test_of_several_verdicts_each_is_told_as_what_it_is() -> None:
    pairs = [
        made_up("a", "b", "clear", 0.9, 1.0, 2.0),
        made_up("a", "c", "unresolved", 0.0, 0.5, 3.0, unresolved=[[2.9, 3.1]]),
        made_up("b", "c", "breach", 0.7, 0.8, 1.0, margin=0.85, breaches=[[0.5, 1.5]]),
    ]
    summary = summary_of(*pairs)
    assert headline(summary) == "1 of 3 pairs comes closer than the margin."
    told = plain(" ".join(sentences(Found(summary), {})))
    assert "1 unresolved" in told
    assert "Closest pair: a | c, measured 0.5 m apart at 3 s (no lower bound above 0 is proved)." in told
    assert proof(pairs[1], [], "m").startswith("Unresolved: contact is neither found nor excluded in 2.9 to 3.1 s")
    assert proof(pairs[2], [], "mm").startswith("No contact: never closer than 700 mm; within the margin of 850 mm")


def test_a_pair_that_may_come_nearer_than_the_closest_is_told() -> None:
    pairs = [made_up("a", "b", "clear", 0.9, 1.0, 2.0), made_up("a", "c", "clear", 0.25, None, None)]
    told = plain(" ".join(sentences(Found(summary_of(*pairs)), {})))
    measured = "Closest pair: a | b, measured 1 m apart at 2 s (proved never closer than 0.9 m)."
    assert measured in told
    assert "a | c may come as close or closer (proved never closer than 0.25 m)." in told
    pairs[1]["distance"]["lower"] = 1.5
    assert "or closer" not in plain(" ".join(sentences(Found(summary_of(*pairs)), {})))


def test_that_no_other_pair_comes_nearer_is_told_where_it_is_proved_and_nowhere_else() -> None:
    pairs = [made_up("a", "b", "clear", 0.9, 1.0, 2.0), made_up("a", "c", "clear", 1.0, None, None)]
    assert told_of(*pairs).endswith(" No other pair comes closer: this is proved.")
    assert "this is proved" not in told_of(*pairs, total=3)  # of the third no distance is told
    assert "this is proved" not in told_of(pairs[0])
    pairs[1]["distance"]["lower"] = 0.999
    assert "this is proved" not in told_of(*pairs)
    pairs[1]["distance"]["lower"] = 1.0
    touching = made_up("b", "c", "contact", 0.0, 0.0, 1.0, contacts=[touch(0.999, 1.0)])
    told = told_of(*pairs, touching)
    assert "Closest other pair: a | b" in told
    assert told.endswith(" No other pair without contact comes closer: this is proved.")


def test_contacts_whose_brackets_overlap_are_told_together() -> None:
    """Which of them is first is not known; what is certainly later is not among them."""
    pairs = [
        made_up("a", "b", "contact", 0.0, 0.0, 1.0, contacts=[touch(0.999, 1.0 + 1e-12)]),
        made_up("a", "c", "contact", 0.0, 0.0, 1.0, contacts=[touch(0.999, 1.0)]),
        made_up("b", "c", "contact", 0.0, 0.0, 1.0, contacts=[touch(1.0, 1.001)]),
    ]
    told = told_of(*pairs)
    assert "First contact: a | c at 1 s, begins within" in told
    assert told.endswith("a | b may touch as early or earlier.")
    pairs[2]["contacts"] = [touch(0.9999, 1.001)]
    assert told_of(*pairs).endswith("2 other pairs, such as a | b, may touch as early or earlier.")
    assert "as early" not in told_of(pairs[1])
    for pair in pairs:
        pair["contacts"] = [touch(0.0, 0.0)]
    assert told_of(*pairs).endswith("2 other pairs, such as a | c, may touch as early or earlier.")


def test_a_measured_distance_is_told_as_measured_and_its_bound_as_a_bound() -> None:
    """A clearance of 8 mm, with what rounding adds to it."""
    pair = made_up("a", "b", "clear", 0.00792, 0.008000000000000063, 2.0)
    assert nearest(pair, "mm") == "8 mm"
    assert nearest(pair, "in") == "0.315 in"
    found = Found(summary_of(pair), length_unit="mm")
    assert "measured 8 mm apart at 2 s (proved never closer than 7.92 mm)." in plain(" ".join(sentences(found, {})))


def test_a_page_opens_at_the_first_contact_or_else_where_the_worst_pair_was_nearest() -> None:
    """Pairs are in the order of the page: worst first."""
    late = made_up("a", "b", "contact", 0.0, 0.0, 3.0, contacts=[touch(2.999, 3.0)])
    early = made_up("a", "c", "contact", 0.0, 0.0, 1.0, contacts=[touch(0.999, 1.0)])
    breach = made_up("a", "d", "breach", 0.7, 0.8, 2.0)
    unmeasured = made_up("a", "e", "clear", 0.1, None, None)
    assert opening([late, early, breach], 0.5) == (1, 1.0)
    as_early = made_up("a", "b2", "contact", 0.1, 0.2, 1.0, contacts=[touch(0.999, 1.0)])
    assert opening([early, as_early], 0.5) == (1, 1.0), "as early, and before it by name"
    assert opening([breach, unmeasured], 0.5) == (0, 2.0)
    assert opening([unmeasured, made_up("b", "c", "clear", 0.9, 1.0, 2.5)], 0.5) == (1, 2.5)
    assert opening([unmeasured], 0.5) == opening([], 0.5) == (0, 0.5)


def test_pairs_that_boxes_cleared_are_counted_and_no_distance_is_claimed() -> None:
    summary = summary_of(made_up("a", "b", "clear", 0.9, 1.0, 2.0), total=5)
    assert headline(summary).startswith("All 5 pairs stay clear. This is proved for every instant")
    told = (
        "The broad phase cleared 4 pairs: their swept boxes never overlap. The log does not give their distances; "
        "one of them may come closer than the pairs above."
    )
    assert told in sentences(Found(summary), {})
    loss = Loss(Path("o.mcap"), 100, "it ends", cut=True, places=1, read_to=None)
    assert told in sentences(Found(summary, loss), {})  # by a summary that is whole
    assert "Nothing could be read about 4 pairs." in sentences(Found(summary, loss, folded=True), {})


def summary_of(*pairs: Any, total: int | None = None) -> Any:
    counts = dict.fromkeys(("contact", "breach", "unresolved", "possible", "clear"), 0)
    total = len(pairs) if total is None else total
    for pair in pairs:
        counts[pair["verdict"]] += 1
    counts["clear"] += total - len(pairs)
    return {"pairs": list(pairs), "pairs_total": total, "time": [0.0, 4.0], "totals": {"pairs": counts}}


def told_of(*pairs: Any, total: int | None = None) -> str:
    return plain(" ".join(sentences(Found(summary_of(*pairs, total=total)), {})))


def touch(clear: float, touching: float) -> Any:
    return {"begin": [clear, touching], "end": None, "keys": {}}


def plain(html: str) -> str:
    return Parsed(html).text


@given(st.floats(-1e9, 1e9), st.floats(1e-9, 1e3), st.booleans())
def test_brackets_in_words_hold_the_bracket(start: float, length: float, forward: bool) -> None:
    end = start + length
    if end == start:
        return
    first, last = interval(*((start, end) if forward else (end, start))).removesuffix(" s").split(" to ")
    low, high = (Decimal(first), Decimal(last)) if forward else (Decimal(last), Decimal(first))
    assert low <= Decimal(repr(start)) < Decimal(repr(end)) <= high
    assert high - low <= Decimal("1.3") * (Decimal(end) - Decimal(start)) + Decimal("0.002")
