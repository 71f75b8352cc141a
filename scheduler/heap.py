"""The lecture's queue: pairs by wakeup time, ties by pair id; and the ends of windows, before pairs of one time."""

from __future__ import annotations

import heapq
from math import inf

from .events import Reason
from .watch import Watch

#: The broad phase's place among the pairs of one time: the first.
_TICK = -1


class WakeupQueue:
    """A heap of sleeping pairs. A pair sleeps in it at most once, so that its id breaks every tie."""

    def __init__(self) -> None:
        """Start empty."""
        self._heap: list[tuple[float, int, Reason, Watch | None]] = []

    def __bool__(self) -> bool:
        """Tell whether any pair sleeps."""
        return bool(self._heap)

    def push(self, time: float, reason: Reason, watch: Watch) -> None:
        """Let a pair sleep until `time` (s)."""
        heapq.heappush(self._heap, (time, watch.pair.key.id, reason, watch))

    def push_tick(self, time: float) -> None:
        """Have windows end at `time` (s), unless that is never."""
        if time < inf:
            heapq.heappush(self._heap, (time, _TICK, Reason.WINDOW, None))

    def pop(self) -> tuple[float, Reason, Watch | None]:
        """Wake the pair with the earliest wakeup time, the one most likely to collide first; None: windows end."""
        time, _, reason, watch = heapq.heappop(self._heap)
        return time, reason, watch
