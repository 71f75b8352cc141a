"""Which pairs are in the queue: a pair enters when its swept boxes overlap, and leaves when they no longer do."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from math import inf

from ..model.events import Bound, Event, Reason, Window
from ..model.scene import Settings, pair_id
from ..model.share import WHOLE, Share
from ..pairs.monitor import Monitor, Plan
from ..pairs.pair_factory import PairFactory
from .broad_phase import Tick
from .window_history import WindowHistory


class ActivePairs:
    """Which pairs are in the queue, and what is known of those that have left it.

    Invariant: at every time each pair that might collide is covered by disjoint swept boxes over windows that contain
    that time, or is in the queue with a valid wakeup, or has been decided up to its end.
    """

    def __init__(self, factory: PairFactory, settings: Settings, ticks: Iterable[Tick], share: Share = WHOLE) -> None:
        """Take what makes the scene's pairs; none is made yet. Of a share, only its pairs ever enter the queue.

        `ticks` are the broad phase's.
        """
        self._factory = factory
        self._settings = settings
        self._share = share
        self._ticks = iter(ticks)
        self._tick = next(self._ticks, None)
        self._bodies = len(factory.scene.bodies)
        self._history = WindowHistory(self._bodies)
        self._inside: set[int] = set()
        self._never: set[int] = set()
        self._outside: dict[int, Monitor] = {}

    @property
    def next_tick(self) -> float:
        """When windows end, and others begin, s; inf for never."""
        return inf if self._tick is None else self._tick.time

    def meet(self) -> Generator[Event, None, list[tuple[float, Reason, Monitor]]]:
        """Begin the windows of the next tick: yield them, and return the pairs that enter with their wakeups.

        Every share has all windows; only the first one yields them.

        A pair that was cleared until now wakes now: the windows that end clear it up to this very time.
        """
        tick = self._tick
        assert tick is not None
        self._tick = next(self._ticks, None)
        time = tick.time
        self._history.add(tick.windows)
        if self._share.number == 0:
            yield from _told(tick)
        entering = []
        for a, b in tick.meeting.tolist():
            monitor = self._monitor_of(a, b)
            if monitor is None:
                continue
            begin = monitor.pair.start
            if monitor.decided < time:
                yield from monitor.clear(self._history.clearances(a, b, monitor.decided, time))
            first = time <= begin
            entering.append((begin if first else time, Reason.START if first else Reason.WINDOW, monitor))
        return entering

    def retire(self, monitor: Monitor, plan: Plan) -> Plan | None:
        """Return how long windows clear a pair that is to leave the queue; None where its own plan lasts longer.

        They have to clear it from when it is decided to: a last step that is to be tried finer is not.
        """
        key = monitor.pair.key
        if not monitor.parting or (until := self._history.cleared_until(key.a, key.b, monitor.decided)) < plan.time:
            return None
        self._inside.discard(key.id)
        self._outside[key.id] = monitor
        return Plan(until, Reason.WINDOW, Bound.WINDOWS)

    def finish(self) -> Iterator[Event]:
        """Yield the last events of the pairs that have left and whose boxes never overlapped again."""
        for _, monitor in sorted(self._outside.items()):
            key, end = monitor.pair.key, monitor.pair.end
            yield from monitor.clear(self._history.clearances(key.a, key.b, monitor.decided, end))
            yield from monitor.finish()

    def _monitor_of(self, a: int, b: int) -> Monitor | None:
        """Return the monitor of a pair that is to enter, a new one the first time; None for a pair that does not."""
        number = pair_id(a, b, self._bodies)
        if not self._share.has(number) or number in self._inside or number in self._never:
            return None
        monitor = self._outside.pop(number, None)
        if monitor is None:
            pair = self._factory.pair(a, b)
            if pair is None:
                self._never.add(number)
                return None
            monitor = Monitor(pair, self._settings)
        self._inside.add(number)
        return monitor


def _told(tick: Tick) -> Iterator[Window]:
    """Yield the windows of a tick as events."""
    columns = (tick.windows.bodies, tick.windows.starts, tick.windows.ends, tick.windows.low, tick.windows.high)
    for body, start, end, (x, y, z), (u, v, w) in zip(*(column.tolist() for column in columns), strict=True):
        yield Window(body, start, end, (x, y, z), (u, v, w))
