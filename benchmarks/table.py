"""One row of the table that `python -m benchmarks` prints."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Row:
    """A case, what was measured, what was to be reached, and whether it is; None where there is nothing to reach."""

    case: str
    measured: str
    target: str = ""
    met: bool | None = None

    @property
    def verdict(self) -> str:
        """Met, missed, or nothing."""
        return "" if self.met is None else "met" if self.met else "missed"

    def markdown(self) -> str:
        """Return the row of a Markdown table."""
        return f"| {self.case} | {self.measured} | {self.target} | {self.verdict} |"


HEAD = "| case | measured | target | |\n|---|---|---|---|"
