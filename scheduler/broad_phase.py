"""The broad phase in time: swept boxes over windows, which clear all pairs whose boxes do not meet.

I-COLLIDE's sweep and prune, but with the trajectories known ahead: a box holds its body for a window that each body
chooses by how far it moves. The end of a window is an event, at which a new one begins and is held against all others.
"""

from __future__ import annotations

import heapq
from array import array
from collections import defaultdict
from collections.abc import Iterator
from math import ceil, hypot, inf, nextafter

import numpy as np

from .bounds import spendable
from .events import Window
from .grid import BoxGrid
from .lineage import anchors
from .pair import Pair
from .pairing import Pairing
from .scene import FloatArray, IntArray, Scene
from .stretches import Cleared
from .swept import Sweep, SweptBody

#: A body that appears later is taken in up to this share of the run's time before, with all others of that time.
_EARLIEST = 1.0 / 64.0
_FIELDS = 8


class BroadPhase:
    """The current swept boxes of a scene's bodies, and all that were before.

    Invariant: at each instant two windows that hold it, of any two bodies, have been held against each other, at the
    tick of the later one: a window is current from before it begins until the next one of its body has begun.
    """

    def __init__(self, pairing: Pairing) -> None:
        """Take the scene's pairing; no window begins before the first tick."""
        scene = pairing.scene
        self._bodies = _swept_bodies(pairing)
        count = len(scene.bodies)
        self._anchors = anchors(scene.bodies)
        self._guards = _guards(pairing, self._bodies)
        self._grid = BoxGrid(count)
        self._begins, self._ends = np.full(count, inf), np.full(count, -inf)
        self._history = History(count)
        self._due: defaultdict[float, list[tuple[float, int]]] = defaultdict(list)
        self._ticks: list[float] = []
        for body, swept in self._bodies.items():
            self._call(_birth(swept.begin, scene), swept.begin, body)

    @property
    def next_tick(self) -> float:
        """When the next windows begin, s; inf for never."""
        return self._ticks[0] if self._ticks else inf

    def renew(self) -> tuple[list[Window], list[tuple[int, int]]]:
        """Begin the windows of the next tick; return them, and the pairs a < b of bodies whose boxes meet anew."""
        time = heapq.heappop(self._ticks)
        sweeps = [(body, self._bodies[body].sweep(start)) for start, body in sorted(self._due.pop(time))]
        bodies = np.array([body for body, _ in sweeps], dtype=np.int64)
        low, high = _boxes([sweep for _, sweep in sweeps])
        guards = self._guards[bodies, None]
        self._grid.put(bodies, low - guards, high + guards)
        self._begins[bodies] = [sweep.start for _, sweep in sweeps]
        self._ends[bodies] = [sweep.end for _, sweep in sweeps]
        windows = []
        for (body, sweep), (x, y, z), (u, v, w) in zip(sweeps, low.tolist(), high.tolist(), strict=True):
            windows.append(Window(body, sweep.start, sweep.end, (x, y, z), (u, v, w)))
            self._history.add(windows[-1])
            if sweep.renewed < inf:
                self._call(sweep.end, sweep.renewed, body)
        return windows, self._meeting(bodies)

    def cleared_until(self, a: int, b: int, time: float) -> float:
        """Return until when (s) the current windows clear a pair, from `time` (s) on; -inf where they do not."""
        if max(self._begins[a], self._begins[b]) > nextafter(time, inf):
            return -inf
        if self._grid.meet(np.array([a]), np.array([b]))[0]:
            return -inf
        return float(min(self._ends[a], self._ends[b]))

    def clearances(self, a: int, b: int, since: float, until: float) -> Iterator[Cleared]:
        """Yield what windows cleared a pair by from `since` to `until` (s), during which no two boxes met."""
        return self._history.clearances(a, b, since, until)

    def _meeting(self, bodies: IntArray) -> list[tuple[int, int]]:
        """Return the pairs of a body of these and another whose windows meet, in space and time, and who may part."""
        one, other = self._grid.meeting(bodies)
        together = (self._begins[one] <= self._ends[other]) & (self._begins[other] <= self._ends[one])
        together &= self._anchors[one] != self._anchors[other]
        one, other = one[together], other[together]
        first, second = np.minimum(one, other), np.maximum(one, other)
        order = np.lexsort((second, first))
        return list(zip(first[order].tolist(), second[order].tolist(), strict=True))

    def _call(self, tick: float, start: float, body: int) -> None:
        """Have a window of a body begin at `start`, told at `tick` (s)."""
        if tick not in self._due:
            heapq.heappush(self._ticks, tick)
        self._due[tick].append((start, body))


def near_at_start(pairing: Pairing) -> tuple[Pair, ...]:
    """Return the pairs that may touch when the first bodies are there."""
    _, meeting = BroadPhase(pairing).renew()
    return tuple(pair for a, b in meeting if (pair := pairing.pair(a, b)) is not None)


class History:
    """All windows that have begun, by body."""

    def __init__(self, bodies: int) -> None:
        """Start with none."""
        self._rows: list[list[int]] = [[] for _ in range(bodies)]
        self._values = array("d")

    def add(self, window: Window) -> None:
        """Keep a body's next window."""
        self._rows[window.body].append(len(self._values))
        self._values.extend((window.start, window.end, *window.low, *window.high))

    def clearances(self, a: int, b: int, since: float, until: float) -> Iterator[Cleared]:
        """Yield the clearances (m) of two bodies' windows from `since` to `until` (s), one after the other.

        A jump parts two that follow each other: then the second begins at the next float.
        """
        one, other = self._from(a, since), self._from(b, since)
        row_a, row_b = next(one), next(other)
        while True:
            end_a, end_b = row_a[1], row_b[1]
            end = min(end_a, end_b, until)
            if end > since:
                yield Cleared(end, spendable(_gap(row_a[2:], row_b[2:])))
            if end >= until:
                return
            row_a = next(one) if end_a == end else row_a
            row_b = next(other) if end_b == end else row_b

    def _from(self, body: int, since: float) -> Iterator[list[float]]:
        """Yield a body's windows in order, from the last that begins at `since` (s) or before."""
        rows = self._rows[body]
        low, high = 0, len(rows)
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self._values[rows[middle]] <= since else (low, middle)
        for row in rows[low:]:
            yield self._values[row : row + _FIELDS].tolist()


def _gap(one: list[float], other: list[float]) -> float:
    """Return the distance (m) of two boxes, each its low corner and its high one."""
    sides = (max(0.0, one[k] - other[k + 3], other[k] - one[k + 3]) for k in range(3))
    return hypot(*sides)


def _swept_bodies(pairing: Pairing) -> dict[int, SweptBody]:
    """Return the bodies with shapes that exist within the scene's time."""
    scene = pairing.scene
    bodies = {}
    for body, extent in pairing.sides.extents.items():
        exists = scene.shared_time(body, body)
        if exists[0] < exists[1]:
            bodies[body] = SweptBody(pairing.sides.of(body, None), extent, (scene.start, scene.end), exists)
    return bodies


def _guards(pairing: Pairing, bodies: dict[int, SweptBody]) -> FloatArray:
    """Return by how much (n,) m each body's boxes are widened where they are held against others.

    Two of them are no less than the pair's margin and twice its error: what they clear is measured to be clear.
    """
    margins = [pairing.margin] * len(pairing.scene.bodies)
    for pairs, margin in pairing.scene.rules.margins:
        for body in pairs.one | pairs.other:
            margins[body] = max(margins[body], margin)
    guards = np.zeros(len(margins))
    for body, swept in bodies.items():
        measured = pairing.sides.of(body, None).measured
        error = swept.error + pairing.narrow_phase.own_error(measured)
        guards[body] = 0.5 * margins[body] + 2.0 * error
    return guards


def _birth(begin: float, scene: Scene) -> float:
    """Return when (s) to take in a body that exists from `begin` (s) on: earlier, but for the scene's start."""
    share = (begin - scene.start) / (scene.end - scene.start)
    early = scene.start + (ceil(share / _EARLIEST) - 1) * _EARLIEST * (scene.end - scene.start)
    return max(scene.start, min(early, nextafter(begin, -inf)))


def _boxes(sweeps: list[Sweep]) -> tuple[FloatArray, FloatArray]:
    """Return the boxes (n, 3) m along the world's axes that the bodies do not leave, low and high corners."""
    centres = np.array([sweep.centre for sweep in sweeps])
    reaches = np.array([sweep.reach for sweep in sweeps])[:, None]
    low, high = centres - reaches, centres + reaches
    slender = [(index, sweep.turned, sweep.moved) for index, sweep in enumerate(sweeps) if sweep.turned is not None]
    if slender:
        index = np.array([index for index, _, _ in slender])
        middles = np.array([turned.middle for _, turned, _ in slender])
        axes = np.abs(np.array([turned.axes for _, turned, _ in slender]))
        halves = np.einsum("nij,nj->ni", axes, np.array([turned.half for _, turned, _ in slender]))
        halves += np.array([moved for _, _, moved in slender])[:, None]
        low[index] = np.maximum(low[index], middles - halves)
        high[index] = np.minimum(high[index], middles + halves)
    return np.nextafter(low, -inf), np.nextafter(high, inf)
