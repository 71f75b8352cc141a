"""Which pair is worse."""

from __future__ import annotations

from .summary import SEVERITY, PairSummary

VERDICTS = tuple(verdict.name.lower() for verdict in SEVERITY)
"""From worst to best."""


def nearness(pair: PairSummary) -> float:
    """Return the least distance measured, else certified, m."""
    upper = pair["distance"]["upper"]
    return pair["distance"]["lower"] if upper is None else upper


def badness(pair: PairSummary) -> tuple[int, float, str]:
    """Return the sorting key of a pair: by verdict, then by the least distance."""
    return VERDICTS.index(pair["verdict"]), nearness(pair), pair["pair"]
