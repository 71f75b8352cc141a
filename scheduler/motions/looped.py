"""Keyframes that repeat before the first key, after the last, or both."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import floor, inf, nextafter, ulp

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.transform import chord
from ..geometry.vector import Vector
from .bernstein import EPSILON
from .key_interval import end_of
from .keyframes import Keyframes, stop_before
from .motion import Axis, Interval, LeverArms, Rates, farthest_from_zero

#: The ends of a loop are the same where they differ by less than this many eps, of a turn and of the coordinates.
SAME = 4.0
#: A loop shorter than this many spacings of floats has no time for its keys.
SPACINGS = 4.0
#: s, the period of a single key: it never ends.
FOREVER = 1e300


@dataclass(frozen=True, slots=True, eq=False)
class Looped:
    """Keyframes over and over; where they do not loop they hold the end's pose.

    Loop k takes the keys' place shifted by k periods; its first instant belongs to it, so that at the last key's time a
    loop shows the first key. The last key itself is never seen at such an end: where its pose is not the first key's,
    the end is a jump. Boundaries are floats by one formula, and every time is counted from its loop's: pose, knots and
    stops agree on each.

    Attributes:
        keys: of any number.
        before: repeat before the first key.
        after: repeat after the last key.
    """

    keys: Keyframes
    before: bool
    after: bool
    _own: Keyframes = field(init=False, repr=False)  # the keys with times from 0, in loop time
    _period: float = field(init=False, repr=False)  # s, > 0
    _jumps: bool = field(init=False, repr=False)  # whether the ends of a loop differ

    def __post_init__(self) -> None:
        """Move the keys to loop time and compare the ends."""
        keys = self.keys
        times = (keys.times - keys.times[0]).tolist()
        for key in range(1, len(times)):
            times[key] = max(times[key], nextafter(times[key - 1], inf))
        velocities = keys.key_velocities
        own = Keyframes(
            np.array(times), keys.translations, keys.quaternions, keys.translation, keys.step_rotation, velocities
        )
        gap = float(np.linalg.norm(own.path.limit - own.path.start))
        same = gap <= SAME * EPSILON * own.path.extent and own.turning.gap <= SAME * EPSILON
        object.__setattr__(self, "_own", own)
        object.__setattr__(self, "_period", times[-1] if len(times) > 1 else FOREVER)
        object.__setattr__(self, "_jumps", not same)

    @property
    def axis(self) -> Axis | None:
        """None: the axis changes from segment to segment."""
        return None

    def pose(self, t: float) -> FloatArray:
        """Return rest_from_moved, 4x4; at a jump the pose after it."""
        return self._own.pose(self._locate(t)[1])

    def displacement(self, t: float, duration: float, reach: LeverArms) -> float:
        """Return the keys' bound within a loop.

        From loop to loop the least of the way gone, the longer way to either end of the loop (every pose lies on one of
        them, since the ends are the same), and the farthest point of the loop.
        """
        loops, start, end = self._stretch(t, duration)
        own, period = self._own, self._period
        if loops == 0:
            span = own.span(start, end)
            return own.path.displacement(span) + chord(own.turning.angle(span), reach.radius)
        rest, before = own.span(start, period), own.span(0.0, start)
        again = own.span(0.0, end if loops == 1 else period)
        length, angle = self._travelled(loops, start, end)
        moved = min(length, max(own.path.length(rest), own.path.length(before)))
        place = own.path.position(*own.segment(start))
        moved = min(moved, max(own.path.departure(rest), own.path.farthest(place, again)))
        angle = min(angle, max(own.turning.angle(rest), own.turning.angle(before)))
        return moved + chord(angle, reach.radius)

    def path_length(self, t: float, duration: float, reach: LeverArms) -> float:
        """Return the path of the origin plus the arc about it."""
        length, angle = self._travelled(*self._stretch(t, duration))
        return length + angle * reach.radius

    def velocities(self, t: float) -> tuple[Vector, Vector]:
        """Return the velocities of the segment that starts at or holds t."""
        return self._own.velocities(self._locate(t)[1])

    def rates(self, t: float, duration: float) -> Rates:
        """Return the keys' rates."""
        return self._own.rates(self._locate(t)[1], duration)

    def knot_after(self, t: float) -> float:
        """Return the next key's time or the next loop's start (inf: none)."""
        loop, since = self._locate(t)
        return self._shown(loop, self._own.knot_after(since))

    def stop_after(self, t: float) -> float:
        """Return the next jump, or the last float before it (inf: none)."""
        loop, since = self._locate(t)
        jump = self._jump_within(loop, since)
        if jump == inf and self._ends(loop):
            jump = self._boundary(loop + 1) if self._jumps else self._jump_within(loop + 1, 0.0)
        return stop_before(jump, t)

    def extent(self, times: Interval) -> float:
        """Return the keys' extent."""
        return self._own.extent(times)

    def rounding_scale(self, times: Interval, radius: float) -> float:
        """The keys' own, and the way gone at top speed in the time that a loop's start is rounded by.

        That is half a spacing of floats there, and twice that of the time since the first key: the period is rounded
        too. A period that floats of the times cannot resolve raises ValueError: the scene's reader refuses it first.
        """
        latest = farthest_from_zero(times)
        if self._period < SPACINGS * ulp(latest):
            raise ValueError(f"keys that repeat every {self._period!r} s cannot be distinguished at {latest!r} s")
        speed = self._own.path.fastest + self._own.turning.fastest * radius
        first = float(self.keys.times[0])
        since = self._period + farthest_from_zero((times[0] - first, times[1] - first))
        late = 0.125 * (latest + 2.0 * since)
        return self._own.rounding_scale(times, radius) + speed * late

    def _boundary(self, loop: int) -> float:
        """Return the scene time at which a loop starts; the keys themselves are loop 0."""
        if loop <= 0:
            return float(self.keys.times[0]) + loop * self._period
        return float(self.keys.times[-1]) + (loop - 1) * self._period

    def _ends(self, loop: int) -> bool:
        """Return whether another loop follows."""
        return loop < 0 or self.after

    def _since(self, loop: int, t: float) -> float:
        """Return loop time: t counted from the loop's start, short of its end; unlimited where the pose is held."""
        since = elapsed(self._boundary(loop), t)
        return min(since, nextafter(self._period, 0.0)) if self._ends(loop) else since

    def _locate(self, t: float) -> tuple[int, float]:
        """Return the loop that t is in and its time there."""
        loop = floor((t - float(self.keys.times[0])) / self._period)
        loop = loop if self.before else max(loop, 0)
        loop = loop if self.after else min(loop, 0)
        while t < self._boundary(loop) and (self.before or loop > 0):
            loop -= 1
        while self._ends(loop) and t >= self._boundary(loop + 1):
            loop += 1
        return loop, self._since(loop, t)

    def _shown(self, loop: int, since: float) -> float:
        """Return the scene time at which a loop shows loop time `since`, at the latest where the next one starts."""
        if not self._ends(loop):
            return self._onset(loop, since) if since < inf else inf
        following = self._boundary(loop + 1)
        return min(self._onset(loop, since), following) if since < self._period else following

    def _onset(self, loop: int, since: float) -> float:
        """Return the first float t at which the loop shows loop time `since` or later (by bisection of floats)."""
        start = self._boundary(loop)
        guess = start + since
        step = 2.0 * ulp(max(abs(start), abs(guess), self._period))
        low, high = guess - step, guess + step
        while (middle := 0.5 * low + 0.5 * high) not in (low, high):
            if elapsed(start, middle) >= since:
                high = middle
            else:
                low = middle
        return high

    def _jump_within(self, loop: int, since: float) -> float:
        """Return the next jump of the keys after loop time `since`, as scene time; inf if the loop has none left."""
        jump = self._own.jump_after(since)
        return inf if self._ends(loop) and jump >= self._period else self._shown(loop, jump)

    def _stretch(self, t: float, duration: float) -> tuple[int, float, float]:
        """Return the loops entered within [t, t + duration], up to the float after its end, and both loop times.

        A jump at the end is left out, so no loop is entered where the ends differ.
        """
        first, start = self._locate(t)
        last, end = self._locate(end_of(t, duration))
        if last > first and self._jumps:
            return 0, start, self._period
        return last - first, start, end

    def _travelled(self, loops: int, start: float, end: float) -> tuple[float, float]:
        """Return path (m) and angle (rad) gone from loop time `start` to `end` of the loop that many later."""
        path, turning, span = self._own.path, self._own.turning, self._own.span
        if loops == 0:
            return path.length(span(start, end)), turning.angle(span(start, end))
        rest, whole, again = span(start, self._period), span(0.0, self._period), span(0.0, end)
        length = path.length(rest) + (loops - 1) * path.length(whole) + path.length(again)
        return length, turning.angle(rest) + (loops - 1) * turning.angle(whole) + turning.angle(again)


def elapsed(start: float, t: float) -> float:
    """Return t - start (s) rounded down, so that no float before a jump counts as the jump (Knuth's TwoSum)."""
    since = t - start
    taken = t - since
    rest = (t - (since + taken)) + (taken - start)
    return nextafter(since, -inf) if rest < 0.0 else since
