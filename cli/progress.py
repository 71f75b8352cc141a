"""A progress bar on a terminal: simulated time, wakeups, contacts, time left. Nothing in a pipe."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ..formats.scene.errors import printable
from ..scheduler.events import Collision, Phase, Wakeup

ToldT = TypeVar("ToldT")

#: Wakeups between two looks at the clock: the bar costs nothing measurable.
WAKEUPS_PER_UPDATE = 256


def shown(events: Iterable[ToldT], start: float, end: float, title: str) -> Generator[ToldT, None, None]:
    """Yield the events while a bar on stderr, if that is a terminal, shows how far they have come."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield from events
        return
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=None),
        TextColumn("{task.fields[now]:.3f} of {task.fields[end]:g} s"),
        TextColumn("{task.fields[wakeups]} wakeups, {task.fields[contacts]} contacts"),
        TimeRemainingColumn(compact=True),
    )
    wakeups = contacts = 0
    latest = start
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(printable(title), total=end - start, now=start, end=end, wakeups=0, contacts=0)
        for event in events:
            yield event
            if isinstance(event, Collision):
                contacts += event.phase is Phase.BEGIN
            elif isinstance(event, Wakeup):
                wakeups += 1
                latest = max(latest, event.time)
                if wakeups % WAKEUPS_PER_UPDATE == 0:
                    bar.update(task, completed=latest - start, now=latest, wakeups=wakeups, contacts=contacts)


@contextmanager
def shares_shown(title: str, quiet: bool) -> Iterator[Callable[[int, int], None]]:
    """Lend a function that is told how many shares of how many are done; a bar shows it, likewise on a terminal."""
    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield lambda done, of: None
        return
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=None),
        MofNCompleteColumn(),
        TextColumn("shares of the pairs"),
        TimeRemainingColumn(compact=True),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(printable(title), total=None)
        yield lambda done, of: bar.update(task, completed=done, total=of)
