"""Lower bounds on when two separated bodies can next touch.

Cheap bounds come first. Separating axes follow only where the cheap bounds give short sleeps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from typing import Generic, TypeVar

from ..bounds import motion_bound
from ..bounds.motion_bound import Proof
from ..geometry.rounding import shortened, spendable
from ..model.events import Bound
from .backoff import Backoff
from .pair import Measurement, Pair

#: Directional bounds are asked where the others allow fewer than this many steps of the floor; that between the whole
#: bodies otherwise too, as often as it pays.
STEPS_TOO_FEW = 16.0
#: A slab between the whole bodies looks this many times as far ahead as they do,
WHOLE_LOOKAHEAD = 64.0
#: pays where it lasts this many times as long, and then triangles are not looked at one by one.
WHOLE_SUFFICES = 2.0
#: Those look ahead so many times as far at first, then between so many: farther, more triangles are within reach.
FIRST_LOOKAHEAD, LEAST_LOOKAHEAD, MOST_LOOKAHEAD = 4.0, 2.0, 32.0

BoundT = TypeVar("BoundT")


class Ahead(Generic[BoundT]):
    """A bound from one measurement on, made when it is asked for, and anew when it is asked for farther ahead."""

    def __init__(self, make: Callable[[float], BoundT]) -> None:
        """Take what makes the bound for so many seconds ahead."""
        self._make = make
        self._looked = -inf
        self._bound: BoundT

    @property
    def asked(self) -> bool:
        """Whether the bound was ever asked for."""
        return self._looked > -inf

    @property
    def known(self) -> BoundT | None:
        """What was made last, None before anything was."""
        return self._bound if self.asked else None

    def until(self, duration: float) -> BoundT:
        """Return the bound for the next `duration` s, or longer."""
        if duration > self._looked:
            self._bound = self._make(duration)
            self._looked = duration
        return self._bound


@dataclass
class Tuning:
    """How far ahead the costly bounds of one pair look, and how often; learnt from what they gave.

    No proof rests on it.

    Attributes:
        lookahead: how many times as far ahead as the cheap bounds the triangles are looked at next.
        whole: when to try a slab between the whole bodies although the cheap bounds suffice.
    """

    lookahead: float = FIRST_LOOKAHEAD
    whole: Backoff = field(default_factory=Backoff)

    def lasted(self) -> None:
        """Look farther ahead: the slabs lasted as long as they looked."""
        self.lookahead = min(MOST_LOOKAHEAD, 2.0 * self.lookahead)

    def too_many(self) -> None:
        """Look less far ahead: too many triangles were within reach."""
        self.lookahead = max(LEAST_LOOKAHEAD, 0.5 * self.lookahead)


class SeparationSleep:
    """The bounds that hold from one measurement of a pair on."""

    def __init__(self, pair: Pair, measurement: Measurement, threshold: float, tuning: Tuning) -> None:
        """Look ahead from a measurement of bodies apart; sleeps are to keep them more than `threshold` m apart."""
        self._tuning = tuning
        self._pair = pair
        self._measurement = measurement
        self._threshold = threshold
        exact = measurement.proximity is not None
        self._balls = Ahead(lambda duration: pair.sphere_slabs(measurement, duration, threshold))
        self._slab = Ahead(lambda duration: pair.slab(measurement, duration, threshold) if exact else None)
        self._slabs = Ahead(lambda duration: pair.slabs(measurement, duration, threshold) if exact else None)

    def sleep(self, horizon: float, floor: float) -> tuple[float, Bound]:
        """Return the longest sleep (s, <= horizon) proved to keep the bodies apart, and the bound that allows it.

        Args:
            horizon: s, the longest sleep of interest, before the next stop.
            floor: s, the least step that will be taken.
        """
        here = self._measurement
        balls = self._balls.until(horizon).sleep(self._threshold)
        if balls >= horizon:
            return horizon, Bound.SPHERE_SLABS
        if here.proximity is None and balls >= min(horizon, STEPS_TOO_FEW * floor):
            return shortened(here.time, balls), Bound.SPHERE_SLABS
        spare = max(0.0, spendable(here.clearance) - self._threshold)  # as `proof` has it
        sleep, bound = motion_bound.sleep(self._pair.motion, here.state, here.time, spare, horizon)
        balls = shortened(here.time, balls)
        if balls > sleep:
            sleep, bound = balls, Bound.SPHERE_SLABS
        enough = sleep >= min(horizon, STEPS_TOO_FEW * floor)
        if sleep >= horizon or (enough and not self._tuning.whole.due()):
            return sleep, bound
        cheap = max(sleep, floor)
        whole = shortened(here.time, self._whole(min(horizon, WHOLE_LOOKAHEAD * cheap)))
        if whole > sleep:
            sleep, bound = whole, Bound.BODY_SLAB
        suffices = whole >= min(horizon, WHOLE_SUFFICES * cheap)
        if enough:
            self._tuning.whole.learn(suffices)
        elif not suffices:
            each = shortened(here.time, self._between_triangles(horizon, cheap))
            if each > sleep:
                sleep, bound = each, Bound.TRIANGLE_SLABS
        return sleep, bound

    def proof(self, after: Measurement) -> Proof:
        """Return what is certain of the time until a later measurement; no jump lies between."""
        here, motion = self._measurement, self._pair.motion
        duration = after.time - here.time
        parted = self._balls.until(duration).clearance(duration)
        if here.proximity is None and parted > self._threshold:
            return Proof(min(parted, here.clearance), 0.0)
        proof = motion_bound.proof(motion, here.state, here.clearance, duration, after.clearance)
        if not self._slab.asked and self._slabs.known is None and proof.clearance <= self._threshold:
            self._slab.until(duration)
            self._slabs.until(duration)
        if self._slab.known is not None:
            parted = max(parted, self._slab.known.clearance(duration))
        if self._slabs.known is not None:
            displaced = motion.displacement(here.state, duration)
            parted = max(parted, self._slabs.known.clearance(duration, displaced))
        return Proof(max(proof.clearance, min(parted, here.clearance)), proof.depth_limit)

    def _whole(self, duration: float) -> float:
        """Return how long (s) a slab between the whole bodies lasts, looking `duration` s ahead; 0 without one."""
        slab = self._slab.until(duration)
        return 0.0 if slab is None else min(duration, slab.sleep(self._threshold))

    def _between_triangles(self, horizon: float, cheap: float) -> float:
        """Return how long (s, <= horizon) slabs between the triangles last; `cheap` s are known to.

        They look farther ahead each time they lasted as long as they looked, and less far where there were too many.
        """
        ahead = min(horizon, self._tuning.lookahead * cheap)
        slabs = self._slabs.until(ahead)
        if slabs is None:
            self._tuning.too_many()
            return 0.0
        lasts = slabs.sleep(self._threshold)
        if lasts >= 0.9 * ahead:
            self._tuning.lasted()
        return lasts
