"""The speed-acceleration bound of the lecture and the displacement bound: sleeps, and proofs between measurements."""

from __future__ import annotations

from typing import NamedTuple

from ..geometry.rounding import shortened, spendable
from ..kinematics.relative_motion import PairState, RelativeMotion, RelativeRates
from ..model.events import Bound
from .closed_form import longest_sleep, time_bound, two_sided_clearance

#: The lecture's bound looks this many times as far ahead as the displacement bound sleeps: farther only loosens it.
LOOKAHEAD = 4.0


class Proof(NamedTuple):
    """Bounds on the time between two measurements.

    Attributes:
        clearance: m, lower bound on the distance; touching is excluded where it is > 0.
        depth_limit: m, no point of one solid gets deeper than this into the other.
    """

    clearance: float
    depth_limit: float


def sleep(
    motion: RelativeMotion, state: PairState, now: float, clearance: float, horizon: float
) -> tuple[float, Bound]:
    """Return the longest sleep (s, <= horizon) that the sound bounds allow, and the name of the bound that set it.

    Args:
        motion: of the pair.
        moments: the pair at `now`.
        now: s.
        clearance: m, certified lower bound on the distance now, > 0.
        horizon: s, the longest sleep of interest, before the next stop.
    """
    spend = spendable(clearance)
    near = motion.approach(state, horizon)
    lecture = _lecture_sleep(near, now, spend)
    if lecture >= horizon:
        return horizon, Bound.SPEED_ACCELERATION
    displaced = longest_sleep(lambda s: motion.displacement(state, s), spend, horizon, 2.0 * lecture)
    if displaced >= horizon:
        return horizon, Bound.DISPLACEMENT
    if lecture < near.horizon:
        near = motion.approach(state, min(horizon, LOOKAHEAD * max(displaced, lecture)))
        lecture = max(lecture, _lecture_sleep(near, now, spend))
    displaced = shortened(now, displaced)
    return (displaced, Bound.DISPLACEMENT) if displaced > lecture else (lecture, Bound.SPEED_ACCELERATION)


def proof(motion: RelativeMotion, state: PairState, before: float, duration: float, after: float) -> Proof:
    """Return what two measurements `duration` s apart prove of the time between.

    The clearance is the better of what the displacement leaves of the first one, and the two-sided bound.

    Args:
        motion: of the pair.
        moments: the pair at the first measurement; no jump lies between it and the second.
        before: m, certified lower bound on the distance at the first.
        duration: s.
        after: m, the same at the second.
    """
    straight = motion.approach(state, duration).distance(duration)
    left = spendable(before) - min(motion.displacement(state, duration), straight)
    path = min(motion.path_length(state, duration), straight)
    two_sided = two_sided_clearance(spendable(before), spendable(after), path)
    return Proof(max(left, two_sided), max(0.0, -two_sided))


def left(motion: RelativeMotion, state: PairState, clearance: float, duration: float) -> float:
    """Return what `duration` s of displacement leave of a clearance (m); negative where it is spent.

    A jump at the end of the duration is left out.
    """
    return spendable(clearance) - motion.displacement(state, duration)


def _lecture_sleep(near: RelativeRates, now: float, spend: float) -> float:
    """Return min(H, t_c), s."""
    return min(near.horizon, shortened(now, time_bound(spend, near.speed, near.acceleration)))
