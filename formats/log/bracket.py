"""The bracket of a pair's minimum distance: whether it is tight, and why not."""

from __future__ import annotations

from math import inf
from typing import NamedTuple, TypedDict

from ...scheduler.pairs.least_distance import ERRORS, LEAST_TOLERANCE
from ..scene.quantities.lengths import length_text

#: Reasons for a minimum distance without an upper end.
OPEN = {
    "far": "the pair is cleared at a distance and never measured",
    "unknown path": "the path of a body is unknown",
}

#: Reasons for a wide bracket, and remedies.
WIDE = {
    "unresolved": ("the pair is unresolved", "try a finer --time-resolution"),
    "not sought": ("the run did not search for it", "give a fraction with --distance-tolerance"),
    "error": (
        "rounding errors limit the measured distances",
        "place the bodies closer to their common frame, or times closer to 0 (t0)",
    ),
    "polyhedra": ("round shapes are measured as polyhedra", "use spheres and capsules, which are exact"),
    "search": (
        "the search needs more measurements than a pair may take",
        "run a shorter time, or raise --distance-tolerance",
    ),
}

_ROUNDING = 1.0 + 1e-9


class DistanceRange(TypedDict):
    """A pair's least distance over the run, m: certified not below `lower`; `upper` measured at `time`, s.

    `bracket` is "tight" where the two are as near to each other as the run sought, else "wide"; "open" where nothing
    was measured. `why` says why it is not tight, `help` what would help where it is wide.
    """

    lower: float
    upper: float | None
    time: float | None
    bracket: str
    why: str | None
    help: str | None


class Least(NamedTuple):
    """A pair's least distance as a run found it, m.

    Attributes:
        lower: certified.
        upper: of the bodies, at a time, s; inf where nothing was measured.
        measured: the same of the polyhedra around their round shapes.
        error: by which what was measured may be wrong.
    """

    lower: float
    upper: float
    time: float
    measured: float
    error: float

    def range(self, share: float | None, verdicts: frozenset[str]) -> DistanceRange:
        """Return it as the summary has it.

        Args:
            share: of the least distance, how far its ends were to lie apart at most, None where it was not sought.
            verdicts: of the pair's spans.
        """
        known = self.upper < inf
        allowed = max((share or 0.0) * self.upper, LEAST_TOLERANCE) * _ROUNDING
        open_by_error = self.lower <= 0.0 and "unresolved" in verdicts and self.measured <= self.error > LEAST_TOLERANCE
        tight = known and self.upper - self.lower <= allowed and not open_by_error
        why: str | None = "unknown path" if "possible" in verdicts else "far"
        if known:
            why = None if tight else self._why(share, verdicts, allowed)
        return {
            "lower": self.lower,
            "upper": self.upper if known else None,
            "time": self.time if known else None,
            "bracket": "tight" if tight else "wide" if known else "open",
            "why": why,
            "help": WIDE[why][1] if known and why is not None else None,
        }

    def _why(self, share: float | None, verdicts: frozenset[str], allowed: float) -> str:
        """Return why the ends lie farther apart than allowed, m."""
        if self.lower <= 0.0 and "unresolved" in verdicts:
            return "error" if self.measured <= self.error > LEAST_TOLERANCE else "unresolved"
        if share is None:
            return "not sought"
        left = self.measured - self.lower
        if allowed < left <= ERRORS * self.error * _ROUNDING:
            return "error"
        return "polyhedra" if left <= allowed else "search"


def why_wide(distance: DistanceRange) -> str | None:
    """Return the reason for a wide bracket and a remedy; None for other brackets.

    Summaries of older logs do not say.
    """
    if distance.get("bracket") != "wide":
        return None
    words, remedy = WIDE.get(distance["why"] or "", ("the reason is unknown", "run the scene again"))
    return f"{words}; {remedy}"


def promised(share: float | None, unit: str) -> str:
    """Return the width of the bracket that a run seeks, with its length in `unit`."""
    least = length_text(LEAST_TOLERANCE, unit, 3)
    return least if share is None else f"{100.0 * share:g}% or {least}"
