"""The warnings at the end of a run: distances with a large error."""

from __future__ import annotations

from collections.abc import Sequence

from ...scheduler.pairs.least_distance import LEAST_TOLERANCE
from ..scene.quantities.lengths import length_text
from ..scene.text.errors import counted
from .bracket import WIDE
from .summary import PairSummary


def doubts(pairs: Sequence[PairSummary], unit: str = "m") -> tuple[str, ...]:
    """Warn of pairs whose distances may be wrong by more than 1e-6 m, or by their whole distance; print in `unit`."""
    doubted = [pair for pair in pairs if pair["error"] > LEAST_TOLERANCE or _hides_its_gap(pair)]
    if not doubted:
        return ()
    worst = max(doubted, key=lambda pair: pair["error"])
    more = f"; {counted(len(doubted) - 1, 'more pair')} may have a smaller error" if len(doubted) > 1 else ""
    name = worst["pair"].replace("|", " | ")
    return (f"distances of {name} may be wrong by {length_text(worst['error'], unit, 2)}{more}; {WIDE['error'][1]}",)


def _hides_its_gap(pair: PairSummary) -> bool:
    """Tell whether a pair without a contact may touch for all that is known, by the error alone."""
    upper = pair["distance"]["upper"]
    return pair["verdict"] != "contact" and upper is not None and 0.0 < upper <= pair["error"]
