"""A comparison of two logs as a table and as JSON."""

from __future__ import annotations

from itertools import groupby
from math import isfinite
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.padding import Padding
from rich.table import Table

from ..formats.log.diff.difference import Cause, Comparison, Difference, by_size
from ..formats.log.diff.wording import place, sentence, told
from ..formats.scene.text.errors import counted
from .show import console_for
from .terminal import cell

#: Causes in bold red.
_GRAVE = (Cause.VERDICT, Cause.CONTACT_APPEARED, Cause.PAIR_REMOVED)

#: Characters. A narrower terminal cannot hold the columns; there each difference is one sentence.
_TABLE_WIDTH = 100


def print_comparison(comparison: Comparison, most: int) -> None:
    """Print the largest differences by cause, the first difference in time, and the totals."""
    console = console_for()
    counts = comparison.by_cause()
    for cause, group in groupby(comparison.largest(most), key=lambda one: one.cause):
        shown = list(group)
        _print_cause(console, cause, shown, counts[cause], comparison.length_unit)
    for note in comparison.notes:
        console.print(cell(f"note: {note}", "dim"))
    first = comparison.first
    if first is None:
        same = "no differences in the readable parts" if comparison.losses else "no differences"
        console.print(f"{same}: {counted(len(comparison.pairs), 'pair')}")
        return
    console.print(cell(f"first: {sentence(first, comparison.length_unit)}"))
    differ = len({one.subject for one in comparison.differences} & set(comparison.pairs))
    pairs = counted(len(comparison.pairs), "pair")
    console.print(f"{counted(len(comparison.differences), 'difference')} in {differ} of {pairs}")


def _print_cause(console: Console, cause: Cause, shown: list[Difference], count: int, unit: str) -> None:
    """Print a heading and one row per difference, with lengths in `unit`; long rows are folded, never cut."""
    heading = f"{cause.label}: {count}"
    if len(shown) < count:
        heading += f", the largest {len(shown)}" if len(shown) > 1 else ", the largest"
    console.print(cell(heading, "bold red" if cause in _GRAVE else "bold"))
    if console.width < _TABLE_WIDTH:
        for one in shown:
            text = ", at ".join(part for part in (told(one, unit), place(one)) if part)
            subject = f"{one.subject.replace('|', ' | ')}: " if one.subject else ""
            console.print(Padding(cell(f"{subject}{text}"), (0, 0, 0, 2), expand=False))
        return
    table = Table(box=None, pad_edge=False, show_header=False)
    for _ in range(3):
        table.add_column(overflow="fold")
    for one in shown:
        table.add_row(cell(one.subject.replace("|", " | ")), cell(told(one, unit)), cell(place(one), "dim"))
    console.print(Padding(table, (0, 0, 0, 2), expand=False))


def as_values(comparison: Comparison, golden: Path, new: Path) -> dict[str, Any]:
    """Return all differences for JSON, in SI units and most important first; unknown numbers are null."""
    first = comparison.first
    return {
        "golden": str(golden),
        "new": str(new),
        "same": not (comparison.differences or comparison.losses),
        "pairs_compared": len(comparison.pairs),
        "by_cause": {cause.label: count for cause, count in comparison.by_cause().items()},
        "first": None if first is None else _values(first, comparison.length_unit),
        "differences": [_values(one, comparison.length_unit) for one in by_size(comparison.differences)],
        "notes": list(comparison.notes),
        "lost": [str(loss) for loss in comparison.losses],
    }


def _values(one: Difference, unit: str) -> dict[str, Any]:
    numbers = {name: _number(getattr(one, name)) for name in ("golden", "new", "change")}
    return {
        "cause": one.cause.label,
        "subject": one.subject,
        **numbers,
        "unit": one.unit,
        "time": one.time,
        "proved": one.proved,
        "keys": one.keys,
        "count": one.count,
        "text": sentence(one, unit),
    }


def _number(value: float | str | None) -> float | str | None:
    return None if isinstance(value, float) and not isfinite(value) else value
