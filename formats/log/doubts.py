"""The warnings of a run once it is done: distances that are hardly known."""

from __future__ import annotations

from collections.abc import Sequence

from ...scheduler.pairs.least_distance import LEAST_TOLERANCE
from .bracket import WIDE
from .summary import PairSummary


def doubts(pairs: Sequence[PairSummary]) -> tuple[str, ...]:
    """Return a warning of pairs whose distances may be wrong by more than 1e-6 m, or by all that they stay apart."""
    doubted = [pair for pair in pairs if pair["error"] > LEAST_TOLERANCE or _hides_its_gap(pair)]
    if not doubted:
        return ()
    worst = max(doubted, key=lambda pair: pair["error"])
    more = f", those of {len(doubted) - 1} more by less" if len(doubted) > 1 else ""
    name = worst["pair"].replace("|", " | ")
    return (f"distances of {name} may be wrong by {worst['error']:.2g} m{more}; {WIDE['error'][1]}",)


def _hides_its_gap(pair: PairSummary) -> bool:
    """Tell whether a pair without a contact may touch for all that is known, by the error alone."""
    upper = pair["distance"]["upper"]
    return pair["verdict"] != "contact" and upper is not None and 0.0 < upper <= pair["error"]
