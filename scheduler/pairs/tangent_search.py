"""Search for the minimum of a distance between a time at which it falls and a time at which it rises."""

from __future__ import annotations

from typing import NamedTuple

from ..geometry.vector import dot, norm, subtract, unit
from .pair import Measurement

#: So many times are asked for at most,
MOST_STEPS = 12
#: and none nearer to a side of the valley than this share of its width.
LEAST_SHARE = 1.0 / 64.0
#: By so small a share of the width tangents may miss the time of a kink that was looked at.
TANGENT_ROUNDING = 1e-6


class Tangent(NamedTuple):
    """How a distance changes at one time.

    Attributes:
        time: s.
        distance: m.
        slope: m/s, of the distance; just after the time, where it has two.
        turn: s from then until the middles of the bodies are nearest, if they go on as they do; negative if they were.
    """

    time: float
    distance: float
    slope: float
    turn: float

    @staticmethod
    def at(measurement: Measurement) -> Tangent:
        """Return the tangent at an exact measurement of bodies apart: closest points move as their bodies do."""
        a, b, proximity = measurement.state.a, measurement.state.b, measurement.proximity
        assert proximity is not None
        across = unit(subtract(proximity.witness_b, proximity.witness_a))
        parting = subtract(b.twist.of(proximity.witness_b), a.twist.of(proximity.witness_a))
        way, going = subtract(b.centre, a.centre), subtract(b.twist.of(b.centre), a.twist.of(a.centre))
        speed = norm(going)
        turn = -dot(way, unit(going)) / speed if speed > 0.0 else 0.0
        return Tangent(measurement.time, measurement.above, dot(across, parting), turn)


class TangentSearch:
    """A low of a distance over time, closed in on from both sides.

    Nothing rests on there being one only, nor on finding it.
    """

    def __init__(self, early: float, late: float) -> None:
        """Look between two times, s."""
        self._early = early
        self._late = late
        self._falling: Tangent | None = None
        self._rising: Tangent | None = None
        self._steps = 0

    def next(self, here: Tangent, close: float) -> float | None:
        """Take in a tangent and return the time (s) to look at next.

        None where nothing seems to lie more than `close` m lower than what has been seen, or after many steps.
        """
        self._steps += 1
        if here.slope < 0.0:
            self._falling = here
        else:
            self._rising = here
        if here.slope == 0.0 or self._steps > MOST_STEPS:
            return None
        if self._falling is not None and self._rising is not None:
            return _between(self._falling, self._rising, close)
        away = here.turn if here.turn * here.slope < 0.0 else -here.distance / here.slope
        time = min(max(self._early, here.time + away), self._late)
        return time if time != here.time else None


def _between(falling: Tangent, rising: Tangent, close: float) -> float | None:
    """Return the time (s) at which two tangents meet, None where that is less than `close` m below both.

    It is where a distance with a kink is least; where they do not meet between, the distance has other lows, and the
    middle is taken.
    """
    width = rising.time - falling.time
    drop = falling.distance - rising.distance + rising.slope * width
    bend = (rising.slope - falling.slope) * width
    share = drop / bend if bend > 0.0 else 0.5
    if abs(share - 0.5) > 0.5 + TANGENT_ROUNDING:
        share = 0.5
    elif min(falling.distance, rising.distance) - (falling.distance + falling.slope * share * width) <= close:
        return None
    time = falling.time + min(max(LEAST_SHARE, share), 1.0 - LEAST_SHARE) * width
    return time if time not in (falling.time, rising.time) else None
