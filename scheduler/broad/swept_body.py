"""The windows of one body: how long to keep a box around it, and how far the body gets within."""

from __future__ import annotations

from math import floor, inf, nextafter
from typing import NamedTuple

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.rounding import RELATIVE_ROUNDING
from ..geometry.vector import Vector
from ..kinematics.chain import Chain, ChainState
from ..kinematics.relative_motion import REACHABLE_BALL_ROUNDING
from ..model.extent import Extent
from ..motions import Interval
from ..pairs.pair_factory import Side

#: A window lasts while the body's middle gets this share of its radius away: shorter ones cost more than the pairs that
#: they clear, longer ones clear fewer (`python -m benchmarks.many_bodies 10000`).
WORTH = 0.3
#: The shortest windows are the run's time over two to this power.
FINEST_LEVEL = 12
#: A body is slender, and also boxed as it is turned, where the shortest side of its box is below this share of its
#: ball's diameter.
SLENDER = 0.5


class Turned(NamedTuple):
    """A body's own box: its middle (m) in the world, its half sides (3,) m along the columns of `axes` (3, 3)."""

    middle: Vector
    half: FloatArray
    axes: FloatArray


class Sweep(NamedTuple):
    """Where a body is over [start, end].

    Attributes:
        renewed: s, when the next window is due: `end`, or the next float where the body jumps there; inf for none.
        centre, reach: the body is within `reach` (m) of this point of the world.
        turned, moved: and its points are at most `moved` (m) from this box of its own; None where that says no more.
    """

    start: float
    end: float
    renewed: float
    centre: Vector
    reach: float
    turned: Turned | None
    moved: float


class SweptBody:
    """A body as its windows see it: a ball in the world, and its own box where that is much smaller.

    The ball of a body of unknown path is the one that stands for it in pairs: about a rest place, growing.

    Attributes:
        begin, end: s, between which it exists within the run's time.
        error: m, by which a pose may misplace its points.
    """

    def __init__(self, side: Side, extent: Extent, times: Interval, exists: Interval) -> None:
        """Take what stands for the body seen from the world, its own extent, the run's time and the body's (s)."""
        chain = side.chain
        self._start, self._span = times[0], times[1] - times[0]
        self.begin, self.end = exists
        self._unknown = side.unknown
        self._radius = chain.ball.radius
        self._centre = chain.middle
        self.error = chain.rounding(exists) + REACHABLE_BALL_ROUNDING * self._grown(self.end)
        self._level = 0
        self._chain: Chain | None = None
        if not side.unknown:
            self._half = extent.high - np.array(extent.ball.centre)
            if self._half.min() < SLENDER * self._radius:
                self._chain = chain

    def sweep(self, start: float) -> Sweep:
        """Return the body's window from `start` (s) on, within its existence and up to its next jump."""
        state = self._centre.at(start)
        end, moved = self._window(state, start)
        renewed = inf
        if end < self.end:
            after = nextafter(end, inf)
            renewed = after if self._centre.stop_after(end) == after else end
        reach = (self._radius + self._grown(start) + moved) * (1.0 + RELATIVE_ROUNDING) + self.error
        if self._chain is None:
            return Sweep(start, end, renewed, state.centre, reach, None, 0.0)
        whole = self._chain.at(start)
        turned = Turned(whole.centre, self._half, whole.pose[:3, :3])
        away = self._chain.displacement(whole, end - start) + RELATIVE_ROUNDING * self._radius
        return Sweep(start, end, renewed, state.centre, reach, turned, away * (1.0 + RELATIVE_ROUNDING) + self.error)

    def _window(self, state: ChainState, start: float) -> tuple[float, float]:
        """Return until when (s) to keep a box made at `start`, the moment, and how far (m) its middle gets until then.

        Windows end on rungs of a ladder, halves of halves of the run's time, so that many bodies' end together.
        """
        jump = self._centre.stop_after(start)
        if jump == nextafter(start, inf):
            return start, 0.0
        latest = min(jump, self.end)
        while True:
            end = min(self._rung_after(start), latest)
            moved = self._centre.displacement(state, end - start) + self._grown(end) - self._grown(start)
            if moved <= WORTH * self._radius or self._level >= FINEST_LEVEL:
                break
            self._level += 1
        if 4.0 * moved < WORTH * self._radius and self._level > 0:
            self._level -= 1
        return end, moved

    def _rung_after(self, time: float) -> float:
        """Return the first rung of the body's level after a time, s."""
        rungs = float(1 << self._level)
        number = floor((time - self._start) / self._span * rungs) + 1
        while (rung := self._start + self._span * (number / rungs)) <= time:
            number += 1
        return rung

    def _grown(self, time: float) -> float:
        """Return by how much (m) the ball has grown at a time (s); 0 where the path is known."""
        return sum(limits.reach(time) for limits in self._unknown)
