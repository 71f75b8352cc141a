"""The lecture's queue: pairs by wakeup time, ties by pair id."""

from __future__ import annotations

import heapq

from .events import Reason
from .watch import Watch


class WakeupQueue:
    """A heap of sleeping pairs. A pair sleeps in it at most once, so that its id breaks every tie."""

    def __init__(self) -> None:
        """Start empty."""
        self._heap: list[tuple[float, int, Reason, Watch]] = []

    def __bool__(self) -> bool:
        """Tell whether any pair sleeps."""
        return bool(self._heap)

    def push(self, time: float, reason: Reason, watch: Watch) -> None:
        """Let a pair sleep until `time` (s)."""
        heapq.heappush(self._heap, (time, watch.pair.key.id, reason, watch))

    def pop(self) -> tuple[float, Reason, Watch]:
        """Wake the pair with the earliest wakeup time, the one most likely to collide first."""
        time, _, reason, watch = heapq.heappop(self._heap)
        return time, reason, watch
