"""How long a contact is certain to last, so that a pair in contact may sleep too."""

from __future__ import annotations

from .events import Bound
from .pair import Measurement, Pair

#: After a contact that was too shallow to sleep on, this many steps are taken before its depth is asked again.
STEPS_BETWEEN = 8


class Hold:
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
        depth = self._pair.hold(touching)
        sleep, bound = 0.0, Bound.TIME_RESOLUTION
        if depth > 0.0:
            sleep, bound = self._pair.motion.sleep(touching.moments, touching.time, depth, horizon)
        if sleep <= self._least:
            self._steps_left = STEPS_BETWEEN
        return sleep, bound
