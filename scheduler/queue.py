"""The lecture's queue: pairs by wakeup time, ties by pair id. Ends of windows come before pairs of the same time."""

from __future__ import annotations

import heapq
from itertools import count
from math import inf

from .model.events import Reason
from .pairs.monitor import Monitor

#: The ends of windows are numbered from here on, below all pairs: of one time they come first, in order.
_FIRST_TICK = -(1 << 62)


class WakeupQueue:
    """A heap of sleeping pairs. A pair sleeps in it at most once, so that its id breaks every tie.

    Attributes:
        turn: whose events come now: the wakeup time (s) and pair id that were pulled off last, a negative number for
            ends of windows; a time of inf once the queue has run empty.
    """

    def __init__(self) -> None:
        """Start empty."""
        self._heap: list[tuple[float, int, Reason, Monitor | None]] = []
        self._ticks = count(_FIRST_TICK)
        self.turn: tuple[float, int] = (-inf, 0)

    def push(self, time: float, reason: Reason, monitor: Monitor) -> None:
        """Let a pair sleep until `time` (s)."""
        heapq.heappush(self._heap, (time, monitor.pair.key.id, reason, monitor))

    def push_tick(self, time: float) -> None:
        """Have windows end at `time` (s), unless that is never."""
        if time < inf:
            heapq.heappush(self._heap, (time, next(self._ticks), Reason.WINDOW, None))

    def pop(self) -> tuple[float, Reason, Monitor | None] | None:
        """Wake the pair with the earliest wakeup time, the one most likely to collide first.

        Instead of a pair there is None where windows end; instead of anything, once no pair sleeps.
        """
        if not self._heap:
            self.turn = (inf, 0)
            return None
        time, number, reason, monitor = heapq.heappop(self._heap)
        self.turn = (time, number)
        return time, reason, monitor
