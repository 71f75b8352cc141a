"""What people and programs read: tables, JSON, warnings. Results on stdout, everything else on stderr."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from decimal import ROUND_FLOOR
from math import inf
from typing import Any

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from ..formats.log.bracket import promised, why_wide
from ..formats.log.container.clock import coarseness_told, seconds_told
from ..formats.log.diff.wording import between
from ..formats.log.severity import VERDICTS, badness, nearness
from ..formats.log.summary import PairSummary, Summary
from ..formats.log.tables.escapes import json_text
from ..formats.scene.quantities.lengths import at_least_text, length_number, length_text
from ..formats.scene.text.errors import counted, printable
from .terminal import cell, say

#: Rows of the table for people.
MOST_ROWS = 20

#: Characters.
WIDTH_OF_A_PIPE = 1000

#: Characters: on a terminal narrower than this, columns would be folded into ribbons.
NARROW = 60

#: How verdicts are printed.
STYLES = {"contact": "bold red", "breach": "red", "unresolved": "yellow", "possible": "yellow", "clear": "green"}


class _Console(Console):
    """A console that prints words as they are, and lets its caller know that the reader of its pipe went away."""

    def render_str(self, text: str, **options: Any) -> Text:
        """Return words as text, whatever they hold."""
        return super().render_str(printable(text), **options)

    def on_broken_pipe(self) -> None:
        """Raise what rich would turn into a failure."""
        raise BrokenPipeError


def console_for(to_stderr: bool = False) -> Console:
    """Return a console as wide as the terminal; down a pipe, wide enough to keep a row in one line for grep."""
    console = _Console(highlight=False, markup=False, emoji=False, stderr=to_stderr)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = WIDTH_OF_A_PIPE
    return console


def print_rows(console: Console, columns: Sequence[str], rows: Sequence[Sequence[Text]]) -> None:
    """Print rows under their columns; on a terminal too narrow for them each row is a list, folded and never cut."""
    if console.width < NARROW:
        for name, *others in rows:
            console.print(cell(name.plain, "bold"), overflow="fold")
            for column, told in zip(columns[1:], others, strict=True):
                if told.plain:
                    console.print(Padding(Text.assemble(f"{column}: ", told), (0, 0, 0, 2)), overflow="fold")
        return
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in columns:
        table.add_column(column, overflow="fold")
    for row in rows:
        table.add_row(*row)
    console.print(table)


def print_warnings(warnings: Iterable[str], note: str | None = None) -> None:
    """Print a line each on stderr, and a note after them."""
    for warning in warnings:
        say(f"warning: {warning}", to_stderr=True)
    if note is not None:
        say(f"note: {note}", to_stderr=True)


def print_json(value: Mapping[str, Any]) -> None:
    """Print a JSON object on stdout."""
    say(json_text(value))


def print_seconds(seconds: Mapping[str, float]) -> None:
    """Print what the run's parts took, on stderr."""
    say("seconds: " + ", ".join(f"{name} {value:.3f}" for name, value in seconds.items()), to_stderr=True)


def print_summary(
    summary: Summary,
    unit: str,
    shown: list[PairSummary] | None = None,
    chosen: int | None = None,
    to_stderr: bool = False,
) -> None:
    """Print a table of pairs, and the totals of all pairs.

    Args:
        summary: of the run.
        unit: of lengths in the table.
        shown: the pairs to print; by default the worst.
        chosen: how many pairs the user selected; by default all.
        to_stderr: whether to print on stderr.
    """
    if shown is None:
        shown = sorted(summary["pairs"], key=badness)[:MOST_ROWS]
    more = (len(summary["pairs"]) if chosen is None else chosen) - len(shown)
    console = console_for(to_stderr)
    rows = [
        (
            cell(pair["pair"].replace("|", " | ")),
            cell(pair["verdict"], STYLES[pair["verdict"]]),
            cell(_distance(pair, unit)),
            cell(_contacts(pair)),
        )
        for pair in shown
    ]
    if shown or not summary["pairs"]:
        print_rows(console, ("pair", "verdict", "minimum distance", "time"), rows)
    else:
        console.print("no listed pair matches")
    for note in _notes(summary, shown, unit):
        console.print(note)
    if more:
        console.print(f"... and {counted(more, 'more pair')}")
    counts = summary["totals"]["pairs"]
    found = ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts.get(verdict))
    start, end = summary["time"]
    ignored = f"; {summary['pairs_ignored']} ignored by the scene" if summary.get("pairs_ignored") else ""
    pairs_told = counted(summary["pairs_total"], "pair")
    console.print(
        f"{pairs_told} over [{seconds_told(start)}, {seconds_told(end)}] s: {found or 'nothing to check'}{ignored}"
    )


def _earliness(pair: PairSummary) -> float:
    """Return when, s, the verdict of a pair shows first, else its least distance."""
    firsts = [one["begin"][1] for one in pair["contacts"][:1]]
    firsts += [low for kind in ("breaches", "unresolved", "possible") for low, _ in pair[kind][:1]]
    time = pair["distance"]["time"]
    return min(firsts, default=inf if time is None else time)


#: How pairs may be sorted; by wakeups, the most first.
ORDERS: dict[str, Callable[[PairSummary], Any]] = {
    "severity": badness,
    "distance": lambda pair: (nearness(pair), pair["pair"]),
    "time": lambda pair: (_earliness(pair), pair["pair"]),
    "name": lambda pair: pair["pair"],
    "wakeups": lambda pair: (-pair["wakeups"], pair["pair"]),
}


def _distance(pair: PairSummary, unit: str) -> str:
    """Return the bracket of the pair's minimum distance in `unit`, and the time of its upper end."""
    lower, upper, time = pair["distance"]["lower"], pair["distance"]["upper"], pair["distance"]["time"]
    if upper is None or time is None:
        return f"above {at_least_text(lower, unit)}" if lower > 0.0 else "unknown"
    if upper == 0.0:
        return "0"
    wide = "" if why_wide(pair["distance"]) is None else ", wide"
    least = length_number(lower, unit, 4, ROUND_FLOOR)
    return f"{least} .. {length_text(upper, unit)} at {seconds_told(time)} s{wide}"


def _notes(summary: Summary, shown: Iterable[PairSummary], unit: str) -> list[str]:
    """Return why brackets of minimum distances or of contact times are wider than usual, and what would help."""
    found = dict.fromkeys(why for pair in shown if (why := why_wide(pair["distance"])) is not None)
    limit = promised(summary["settings"].get("distance_tolerance"), unit)
    coarse = coarseness_told(summary["settings"].get("contact_tolerance") or 0.0, *summary["time"])
    return [f"wide: the bracket is wider than {limit}: {why}" for why in found] + [f"note: {coarse}"] * bool(coarse)


def _contacts(pair: PairSummary) -> str:
    """Return the first contact's begin with the keys it lies between, its end, and how many more there are."""
    contacts = pair["contacts"]
    if not contacts:
        return _spans(pair)
    first = contacts[0]
    lost = any(start > first["begin"][1] for start, _ in pair["unresolved"])
    unended = "an unknown end" if lost else "the end"
    end = unended if first["end"] is None else f"{seconds_told(first['end'][0], 7)} s"
    keys = ", ".join(f"{body} {between(*around)}" for body, around in first["keys"].items())
    more = f" and {len(contacts) - 1} more" if len(contacts) > 1 else ""
    return f"{seconds_told(first['begin'][1], 7)}{f' ({keys})' if keys else ''} .. {end}{more}"


def _spans(pair: PairSummary) -> str:
    """Return when a pair that never touches is not clear, or is not known to be; of the worst such kind."""
    kinds = {"breach": pair.get("breaches"), "unresolved": pair.get("unresolved"), "possible": pair.get("possible")}
    for kind, spans in kinds.items():
        if spans:
            return f"{kind} " + ", ".join(f"{seconds_told(a)}..{seconds_told(b)} s" for a, b in spans[:2])
    return ""
