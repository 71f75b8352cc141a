"""The progress of a run, on a terminal: the step, its share done, and its time left. Nothing in a pipe."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from math import ceil, inf
from time import monotonic
from typing import NamedTuple

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Column

from ..formats.log.viewer.pictures import Picture
from ..formats.scene.text.errors import printable
from ..scheduler.model.events import Bound, Collision, Phase, Reason, Snapshot, Span, Wakeup
from ..scheduler.model.scene import Scene
from .application.watcher import Events, SharesDone, Watcher
from .faults import raise_interrupts

#: s, at least, between two updates of the bar: its CPU time is too short to measure.
BETWEEN_UPDATES = 0.1
#: The time left shows once so many seconds, and so large a share, of a step are done.
LEAST_SECONDS, LEAST_SHARE = 1.0, 0.02
#: On a terminal of fewer columns than this the bar, the scene's name and the counts are left out.
NARROW = 60
#: Characters of a scene's name that are shown.
NAME = 20


class TimeLeft:
    """The time left of a step, from its share done and the time that took; it never rises."""

    def __init__(self, now: float) -> None:
        """Begin at `now`, s."""
        self._began = now
        self._least = inf

    def told(self, now: float, share: float) -> str:
        """Return the time left, in words, once a share of the step is done; nothing while too little is."""
        spent = now - self._began
        if spent >= LEAST_SECONDS and LEAST_SHARE <= share <= 1.0:
            self._least = min(self._least, spent * (1.0 - share) / share)
        if self._least == inf:
            return ""
        minutes, seconds = divmod(max(1, ceil(self._least)), 60)
        hours, minutes = divmod(minutes, 60)
        return f"{hours}:{minutes:02}:{seconds:02} left" if hours else f"{minutes}:{seconds:02} left"


class Names(NamedTuple):
    """The names of a run's steps."""

    certifying: str
    seeking: str
    picturing: str


HERE = Names("certifying", "searching minimum distances", "taking snapshots")
"""Of a run in this process."""
TOLD = Names("writing wakeups", "writing minimum distances", "writing snapshots")
"""Of what workers told of it."""


class Steps:
    """The steps of a run, as its events tell them.

    All pairs are certified up to the end; then those that are left are searched for their least distances; then the
    pictures that are left are taken.

    Attributes:
        step: its name.
        share: of the step that is done, 0 to 1.
    """

    def __init__(self, start: float, end: float, names: Names) -> None:
        """Take the run's time (s), and what its steps are called."""
        self._start, self._end, self._names = start, end, names
        self.step, self.share = names.certifying, 0.0
        self._latest = start
        self._wakeups = self._contacts = 0
        self._open: set[int] = set()  # pairs that woke, and whose last span is not told
        self._searched = 0  # how many of them there were when the first was decided up to the end

    @property
    def counts(self) -> str:
        """The counts of the step, in words."""
        if self.step == self._names.seeking:
            return f"{self._searched - len(self._open)} of {self._searched} pairs"
        counts = f"{self._latest:.3f} of {self._end:g} s"
        if self.step == self._names.certifying:
            counts += f", {self._wakeups} wakeups" + (f", {self._contacts} contacts" if self._contacts else "")
        return counts

    def tell(self, event: object) -> None:
        """Take in the next event of the run."""
        if isinstance(event, Wakeup):
            self._wakeups += 1
            if event.reason is not Reason.MINIMUM:
                self._certified(event)
        elif isinstance(event, Span):
            if event.end >= self._end:
                self._open.discard(event.pair.id)
            if self._searched:
                self.share = 1.0 - len(self._open) / self._searched
        elif isinstance(event, Collision):
            self._contacts += event.phase is Phase.BEGIN
        elif isinstance(event, Snapshot | Picture) and self._searched and not self._open:
            self.step, self._latest = self._names.picturing, event.time
            self.share = self._way(event.time)

    def _certified(self, event: Wakeup) -> None:
        """Take in a wakeup that is no search's; without a sleep after it, the pair is decided up to its end."""
        decided = event.bound is Bound.NONE
        if decided and event.time < self._end:
            self._open.discard(event.pair.id)
        else:
            self._open.add(event.pair.id)
        if decided and event.time >= self._end and not self._searched:
            self.step, self.share, self._searched = self._names.seeking, 0.0, len(self._open)
        if not self._searched:
            self._latest = max(self._latest, event.time)
            self.share = self._way(self._latest)

    def _way(self, time: float) -> float:
        """Return what share of the run's time has passed at a time, s."""
        return (time - self._start) / (self._end - self._start)


class _Bar:
    """A line on stderr: what is done, a bar, counts, and the time left of the step."""

    def __init__(self, bar: Progress, title: str) -> None:
        self._bar = bar
        self._task = bar.add_task(printable(title), total=1.0, step="", counts="", left="")
        self._step = ""
        self._left = TimeLeft(monotonic())

    def show(self, step: str, share: float, counts: str) -> None:
        """Show how much of a step is done."""
        now = monotonic()
        if step != self._step:
            self._step, self._left = step, TimeLeft(now)
        left = self._left.told(now, share)
        self._bar.update(self._task, completed=share, step=step, counts=counts, left=left)


@contextmanager
def _bar(title: str) -> Iterator[_Bar | None]:
    """Lend a bar on stderr, None where that is no terminal."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    step, left = TextColumn("{task.fields[step]}"), TextColumn("{task.fields[left]}")
    share = TextColumn("{task.percentage:>3.0f}%")
    name = TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=True, max_width=NAME))
    counts = TextColumn("{task.fields[counts]}")
    wide = (name, step, BarColumn(bar_width=None), share, counts, left)
    columns = wide if console.width >= NARROW else (step, share, left)
    with Progress(*columns, console=console, transient=True) as bar:
        yield _Bar(bar, title)


class ProgressBar(Watcher):
    """Shows the progress of a run on a terminal, and lets Ctrl-C leave its log in order.

    Args:
        title: the scene's name.
        quiet: whether to show nothing.
    """

    def __init__(self, title: str, quiet: bool) -> None:
        self._title = title
        self._quiet = quiet

    def ready(self) -> None:
        """Have Ctrl-C raise KeyboardInterrupt from now on."""
        raise_interrupts()

    def events(self, events: Events, scene: Scene, told: bool) -> Events:
        """Yield the events while a bar shows the step, its share done and its time left."""
        with self._bar() as bar:
            if bar is None:
                yield from events
                return
            steps, due = Steps(scene.start, scene.end, TOLD if told else HERE), 0.0
            bar.show(steps.step, steps.share, steps.counts)
            for event in events:
                yield event
                steps.tell(event)
                if monotonic() >= due:
                    bar.show(steps.step, steps.share, steps.counts)
                    due = monotonic() + BETWEEN_UPDATES

    @contextmanager
    def shares(self) -> Iterator[SharesDone]:
        """Lend a function that shows how many shares of a step are done."""
        with self._bar() as bar:
            yield lambda step, done, of: bar.show(step, done / of, f"{done} of {of} shares") if bar else None

    def _bar(self) -> AbstractContextManager[_Bar | None]:
        """Lend a bar; None if it is not shown."""
        return nullcontext() if self._quiet else _bar(self._title)
