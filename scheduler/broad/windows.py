"""The windows of many bodies as arrays that travel between processes, and the sources of windows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import inf
from typing import NamedTuple, Protocol

import numpy as np

from ..geometry.arrays import FloatArray, IntArray
from ..model.share import WHOLE, Share
from ..pairs.pair_factory import PairFactory
from .swept_body import Sweep, SweptBody

Due = list[tuple[float, int]]
"""When (s) windows begin, and of which bodies."""


class Windows(NamedTuple):
    """Windows of k bodies.

    Attributes:
        bodies: (k,) whose they are.
        starts, ends: (k,) s.
        renewed: (k,) s, when the body's next window is due; inf for none.
        guards: (k,) m, by how much boxes are widened where they are held against others.
        low, high: (k, 3) m, the corners of the boxes along the world's axes that the bodies do not leave.
    """

    bodies: IntArray
    starts: FloatArray
    ends: FloatArray
    renewed: FloatArray
    guards: FloatArray
    low: FloatArray
    high: FloatArray

    @staticmethod
    def joined(parts: Iterable[Windows]) -> Windows:
        """Return the windows of all parts."""
        return Windows(*map(np.concatenate, zip(*parts, strict=True)))

    def taken(self, rows: IntArray) -> Windows:
        """Return some of them, by their rows."""
        bodies, *columns = self
        return Windows(bodies[rows], *(column[rows] for column in columns))


class WindowSource(Protocol):
    """A source of the windows of a scene's bodies."""

    def begins(self) -> Iterable[tuple[int, float]]:
        """Return the bodies that have windows, and when (s) the first one of each begins."""
        ...

    def windows(self, due: Due) -> Windows:
        """Return the windows that begin."""
        ...


class Sweeps:
    """Makes windows as they are asked for."""

    def __init__(self, factory: PairFactory, share: Share = WHOLE) -> None:
        """Take the bodies of a scene with shapes that exist within its time, or a share of them."""
        scene, self._bodies = factory.scene, dict[int, SweptBody]()
        for body, extent in factory.sides.extents.items():
            exists = scene.shared_time(body, body)
            if share.has(body) and exists[0] < exists[1]:
                side = factory.sides.of(body, None)
                self._bodies[body] = SweptBody(side, extent, (scene.start, scene.end), exists)
        self._guards = _guards(factory, self._bodies)

    def begins(self) -> Iterator[tuple[int, float]]:
        """Yield the bodies, and when (s) each exists from."""
        return ((body, swept.begin) for body, swept in self._bodies.items())

    def windows(self, due: Due) -> Windows:
        """Return the windows that begin."""
        return self._told([body for _, body in due], [self._bodies[body].sweep(start) for start, body in due])

    def all(self) -> Windows:
        """Return all windows of all bodies, those of each in order."""
        bodies: list[int] = []
        sweeps: list[Sweep] = []
        for body, swept in self._bodies.items():
            start = swept.begin
            while start < inf:
                bodies.append(body)
                sweeps.append(swept.sweep(start))
                start = sweeps[-1].renewed
        return self._told(bodies, sweeps)

    def _told(self, bodies: list[int], sweeps: list[Sweep]) -> Windows:
        whose: IntArray = np.array(bodies, dtype=np.int64)
        starts, ends, renewed = np.array([sweep[:3] for sweep in sweeps]).reshape(-1, 3).T
        return Windows(whose, starts, ends, renewed, self._guards[whose], *_boxes(sweeps))


class ToldWindows:
    """Windows that were made before."""

    def __init__(self, windows: Windows) -> None:
        """Take all windows of all bodies, those of each in order."""
        order = np.argsort(windows.bodies, kind="stable")
        self._windows = windows.taken(order)
        bodies, self._first = np.unique(self._windows.bodies, return_index=True)
        self._bodies: list[int] = bodies.tolist()
        self._next = dict(zip(self._bodies, self._first.tolist(), strict=True))

    def begins(self) -> Iterator[tuple[int, float]]:
        """Yield the bodies, and when (s) the first window of each begins."""
        return zip(self._bodies, self._windows.starts[self._first].tolist(), strict=True)

    def windows(self, due: Due) -> Windows:
        """Return the next window of each body."""
        rows = [self._next[body] for _, body in due]
        for _, body in due:
            self._next[body] += 1
        return self._windows.taken(np.array(rows))


def _guards(factory: PairFactory, bodies: dict[int, SweptBody]) -> FloatArray:
    """Return by how much (n,) m each body's boxes are widened where they are held against others.

    Two of them are no less than the pair's margin and twice its error: what they clear is measured to be clear.
    """
    margins = [factory.margin] * len(factory.scene.bodies)
    for pairs, margin in factory.scene.rules.margins:
        for body in pairs.one | pairs.other:
            margins[body] = max(margins[body], margin)
    guards = np.zeros(len(margins))
    for body, swept in bodies.items():
        narrow_index = factory.sides.of(body, None).narrow_index
        error = swept.error + factory.narrow_phase.own_error(narrow_index)
        guards[body] = 0.5 * margins[body] + 2.0 * error
    return guards


def _boxes(sweeps: list[Sweep]) -> tuple[FloatArray, FloatArray]:
    """Return the boxes (n, 3) m along the world's axes that the bodies do not leave, low and high corners.

    A box does not depend on what others it is made with.
    """
    centres = np.array([sweep.centre for sweep in sweeps]).reshape(-1, 3)
    reaches = np.array([sweep.reach for sweep in sweeps])[:, None]
    low, high = centres - reaches, centres + reaches
    slender = [(index, sweep.turned, sweep.moved) for index, sweep in enumerate(sweeps) if sweep.turned is not None]
    if slender:
        index = np.array([index for index, _, _ in slender])
        middles = np.array([turned.middle for _, turned, _ in slender])
        x, y, z = np.moveaxis(np.abs(np.array([turned.axes for _, turned, _ in slender])), 2, 0)
        half = np.array([turned.half for _, turned, _ in slender])
        halves = x * half[:, :1] + y * half[:, 1:2] + z * half[:, 2:]
        halves += np.array([moved for _, _, moved in slender])[:, None]
        low[index] = np.maximum(low[index], middles - halves)
        high[index] = np.minimum(high[index], middles + halves)
    return np.nextafter(low, -inf), np.nextafter(high, inf)
