"""The broad phase in time: swept boxes over windows clear all pairs whose boxes do not overlap.

This is the sweep and prune of I-COLLIDE with the trajectories known ahead. A box holds its body for a window of time.
Each body chooses the window's length by how far it moves. The end of a window is an event: a new window begins, and its
box is compared with all others. In the words of kinetic data structures a window is a certificate, its end a failure
time.
"""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Iterator
from math import ceil, inf, nextafter
from typing import NamedTuple

import numpy as np

from ..geometry.arrays import IntArray
from ..model.body_tree import anchors
from ..model.scene import Scene
from ..pairs.pair import Pair
from ..pairs.pair_factory import PairFactory
from .box_grid import BoxGrid
from .windows import Due, Sweeps, Windows, WindowSource

#: A body that appears later is taken in up to this share of the run's time before, with all others of that time.
_EARLIEST = 1.0 / 64.0


class Tick(NamedTuple):
    """The begin of windows.

    Attributes:
        time: s, at which they are taken in.
        windows: that begin.
        meeting: (m, 2) the pairs a < b of bodies whose boxes meet anew, in order.
    """

    time: float
    windows: Windows
    meeting: IntArray


class BroadPhase(Iterator[Tick]):
    """The ticks of a scene, in order of time.

    Invariant: at each instant two windows that hold it, of any two bodies, have been held against each other, at the
    tick of the later one: a window is current from before it begins until the next one of its body has begun.
    """

    def __init__(self, scene: Scene, source: WindowSource) -> None:
        """Take the scene and the source of its bodies' windows."""
        count = len(scene.bodies)
        self._source = source
        self._anchors = anchors(scene.bodies)
        self._grid = BoxGrid(count)
        self._begins, self._ends = np.full(count, inf), np.full(count, -inf)
        self._due: defaultdict[float, Due] = defaultdict(list)
        self._ticks: list[float] = []
        for body, begin in source.begins():
            self._call(_birth(begin, scene), begin, body)

    def __next__(self) -> Tick:
        """Begin the windows of the next tick."""
        if not self._ticks:
            raise StopIteration
        time = heapq.heappop(self._ticks)
        windows = self._source.windows(sorted(self._due.pop(time)))
        bodies, guards = windows.bodies, windows.guards[:, None]
        self._grid.put(bodies, windows.low - guards, windows.high + guards)
        self._begins[bodies], self._ends[bodies] = windows.starts, windows.ends
        for body, end, renewed in zip(bodies.tolist(), windows.ends.tolist(), windows.renewed.tolist(), strict=True):
            if renewed < inf:
                self._call(end, renewed, body)
        return Tick(time, windows, self._meeting(bodies))

    def _meeting(self, bodies: IntArray) -> IntArray:
        """Return the pairs of a body of these and another whose windows meet, in space and time, and who may part."""
        one, other = self._grid.meeting(bodies)
        together = (self._begins[one] <= self._ends[other]) & (self._begins[other] <= self._ends[one])
        together &= self._anchors[one] != self._anchors[other]
        one, other = one[together], other[together]
        first, second = np.minimum(one, other), np.maximum(one, other)
        order = np.lexsort((second, first))
        return np.column_stack((first[order], second[order]))

    def _call(self, tick: float, start: float, body: int) -> None:
        """Have a window of a body begin at `start` (s), yielded at `tick` (s)."""
        if tick not in self._due:
            heapq.heappush(self._ticks, tick)
        self._due[tick].append((start, body))


def near_at_start(factory: PairFactory) -> tuple[Pair, ...]:
    """Return the pairs that may touch when the first bodies are there."""
    first = next(BroadPhase(factory.scene, Sweeps(factory)))
    return tuple(pair for a, b in first.meeting.tolist() if (pair := factory.pair(a, b)) is not None)


def _birth(begin: float, scene: Scene) -> float:
    """Return when (s) to take in a body that exists from `begin` (s) on: earlier, but for the scene's start."""
    share = (begin - scene.start) / (scene.end - scene.start)
    early = scene.start + (ceil(share / _EARLIEST) - 1) * _EARLIEST * (scene.end - scene.start)
    return max(scene.start, min(early, nextafter(begin, -inf)))
