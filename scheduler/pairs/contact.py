"""Lower bounds on how long a contact lasts, so that a pair in contact may sleep too."""

from __future__ import annotations

from functools import cached_property
from math import inf

from ..bounds import motion_bound
from ..bounds.inscribed_spheres import InscribedSpheres
from ..geometry.rounding import shortened
from ..model.events import Bound
from .pair import Measurement, Pair

#: After a contact that was too shallow to sleep on, this many steps are taken before its depth is asked again.
STEPS_BETWEEN = 8
#: So many steps that depth allows are not worth a look at the triangles that meet.
STEPS_ENOUGH = 16.0
#: Overlaps are first looked at this many steps ahead: farther, motions vary more.
STEPS_AHEAD = 64.0


class ContactSleep:
    """The certain duration of a pair's contacts; asked at each wakeup in contact, in order of time."""

    def __init__(self, pair: Pair, time_resolution: float) -> None:
        """Take a pair, and the least sleep (s) that is worth a measurement of depth."""
        self._pair = pair
        self._least = time_resolution
        self._steps_left = 0

    def sleep(self, touching: Measurement, horizon: float) -> tuple[float, Bound]:
        """Return how long (s, <= horizon) the bodies certainly go on touching, 0 where nothing is known."""
        if self._steps_left > 0:
            self._steps_left -= 1
            return 0.0, Bound.TIME_RESOLUTION
        enough = min(horizon, STEPS_ENOUGH * self._least)
        best = self._while_balls_meet(touching, horizon)
        if best[0] < enough:
            best = _longer(best, self._while_deep(self._pair.depth(touching), touching, horizon))
        sound = touching.inside is None and not (self._pair.path_unknown or self._pair.coarse)
        if best[0] < enough and sound:
            best = _longer(best, self._while_overlapping(touching, horizon))
        if best[0] <= self._least:
            self._steps_left = STEPS_BETWEEN
        return best

    def _while_balls_meet(self, touching: Measurement, horizon: float) -> tuple[float, Bound]:
        """Sleep while balls inside both bodies go on meeting."""
        if self._inner_balls is None:
            return 0.0, Bound.TIME_RESOLUTION
        sleep = self._inner_balls.sleep(touching.state, horizon, self._least)
        return (sleep if sleep >= horizon else shortened(touching.time, sleep)), Bound.INSCRIBED_SPHERES

    @cached_property
    def _inner_balls(self) -> InscribedSpheres | None:
        return None if self._pair.path_unknown else self._pair.inscribed_spheres()

    def _while_overlapping(self, touching: Measurement, horizon: float) -> tuple[float, Bound]:
        """Sleep while two triangles that meet go on meeting, by the way each corner goes or by how deep they meet."""
        best, depth = (0.0, Bound.TIME_RESOLUTION), 0.0
        for steps in (STEPS_AHEAD, inf):
            ahead = min(steps * self._least, horizon)
            overlaps = self._pair.overlaps(touching, ahead)
            if overlaps is None:
                break
            sleep, depth = shortened(touching.time, overlaps.sleep()), overlaps.depth
            best = _longer(best, (sleep, Bound.TRIANGLE_OVERLAP))
            if sleep < 0.9 * ahead:
                break
        return _longer(best, self._while_deep(depth, touching, horizon))

    def _while_deep(self, depth: float, touching: Measurement, horizon: float) -> tuple[float, Bound]:
        """Sleep while the bodies cannot have got by `depth` (m) relative to each other."""
        if depth <= 0.0:
            return 0.0, Bound.TIME_RESOLUTION
        return motion_bound.sleep(self._pair.motion, touching.state, touching.time, depth, horizon)


def _longer(one: tuple[float, Bound], other: tuple[float, Bound]) -> tuple[float, Bound]:
    return other if other[0] > one[0] else one
