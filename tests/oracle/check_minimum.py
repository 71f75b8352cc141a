"""The least distance of a pair over its time against the least one found, and a count of what was looked at."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .sampling import Samples
from .truth import Pair, Truth

Values = dict[str, Any]

NEAR = 1e-3
"""Of the scene's spread: pairs that come nearer without touching are counted apart."""


def check_least(truth: Truth, pair: Pair, told: Values | None, samples: Samples) -> Iterable[str]:
    """No instant tried is nearer than the least distance certified, and a pair that touches has none."""
    if told is None or not len(samples.times):
        return
    lower = told["distance"]["lower"]
    if told["contacts"] and lower > truth.tolerance:
        yield f"least distance: {told['pair']} touches, told is at least {lower} m"
    nearest = int(samples.signed.argmin())
    if lower <= samples.signed[nearest] + truth.tolerance:
        return
    time = samples.times[[nearest]]  # where there may be but a lower bound
    least = max(0.0, float(truth.signed(*pair, time)[0]))
    if lower > least + truth.tolerance:
        yield f"least distance: {told['pair']} is {least} m apart at {time[0]} s, told is at least {lower} m"


@dataclass
class Tally:
    """What was looked at.

    Attributes:
        pairs, instants: held against the truth.
        verdicts: pairs by their worst verdict; those that the broad phase alone cleared are "never met".
        near: pairs without a contact that came nearer than NEAR.
        brackets: least distances with both ends.
        capped: those among them that the search gave up.
    """

    pairs: int = 0
    instants: int = 0
    verdicts: Counter[str] = field(default_factory=Counter)
    near: int = 0
    brackets: int = 0
    capped: int = 0

    def add(self, truth: Truth, spans: Sequence[Values], samples: Samples, told: Values | None) -> None:
        """Count one pair, given its spans, the instants tried and what the summary tells of it."""
        self.pairs += 1
        self.instants += len(samples.times)
        self.verdicts[told["verdict"] if told else "never met"] += 1
        if told is None or told["verdict"] == "contact":
            return
        least = float(samples.signed.min(initial=np.inf))
        self.near += 0.0 <= least < NEAR * truth.spread
        if told["distance"]["upper"] is not None:
            self.brackets += 1
            free = {span["verdict"] for span in spans} <= {"CLEAR", "BREACH"}
            self.capped += bool(free and told["distance"]["why"] == "search")

    def __str__(self) -> str:
        """Return one line."""
        verdicts = ", ".join(f"{count} {verdict}" for verdict, count in sorted(self.verdicts.items()))
        return (
            f"{self.pairs} pairs ({verdicts}; {self.near} near misses), {self.instants} instants, "
            f"{self.brackets} least distances, {self.capped} of them capped"
        )
