"""The relative motion of a pair, seen from its lowest common ancestor, where motion that both share cancels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import NamedTuple

from ..geometry.rounding import RELATIVE_ROUNDING, shortened
from ..geometry.vector import Vector, norm, subtract
from ..motions import Interval, Limits
from ..motions.acceleration_set import AccelerationSet, across, ball
from .chain import Chain, ChainState, Part

#: Relative to the two speeds, what their difference may lose to rounding.
CANCELLATION = 1e-13
#: Relative error granted to how far balls have grown.
REACHABLE_BALL_ROUNDING = 1e-14


@dataclass(frozen=True, slots=True, eq=False)
class PairState:
    """Both chains of a pair at one time, s."""

    time: float
    a: ChainState
    b: ChainState


class RelativeRates(NamedTuple):
    """The lecture's v and a of a pair: over ALL pairs of points, v (m/s) now and a (m/s^2) until the horizon (s).

    Attributes:
        steady: m/s^2, what stays the same of the first body's acceleration less that of the second.
        varying: m/s^2, where the rest of it is.
    """

    speed: float
    acceleration: float
    horizon: float
    steady: Vector
    varying: AccelerationSet

    def distance(self, duration: float) -> float:
        """Return the farthest (m) any point gets relative to any other within `duration`; inf past the horizon."""
        if duration > self.horizon:
            return inf
        return self.speed * duration + 0.5 * self.acceleration * duration**2


class RelativeMotion:
    """How the two bodies of a pair move relative to each other.

    Where the path of a body is unknown, its chain is that of a ball at its rest place, which grows.

    Attributes:
        unknown: what limits how fast such balls grow.
        radii: m, of both bounding balls together.
    """

    def __init__(self, a: Chain, b: Chain, unknown: tuple[Limits, ...] = ()) -> None:
        """Take both chains, seen from the same ancestor."""
        self.a = a
        self.b = b
        self.unknown = unknown
        self.radii = a.ball.radius + b.ball.radius

    @property
    def rigid(self) -> bool:
        """Whether the two can never move relative to each other, so that they are never paired."""
        return not (self.a.joints or self.b.joints or self.unknown)

    @cached_property
    def middles(self) -> RelativeMotion:
        """The motion of the middles of both balls, whose displacement does not count how bodies turn about them."""
        return RelativeMotion(self.a.middle, self.b.middle, self.unknown)

    def at(self, t: float) -> PairState:
        """Return both chains at t."""
        return PairState(t, self.a.at(t), self.b.at(t))

    def spread(self, t: float) -> float:
        """Return by how much (m) balls have grown at t; 0 where both paths are known."""
        return sum(limits.reach(t) for limits in self.unknown)

    def stop_after(self, t: float) -> float:
        """Return the first time > t that must not be slept past: a jump, or the last float before it."""
        return min(self.a.stop_after(t), self.b.stop_after(t))

    def rounding(self, times: Interval) -> float:
        """Return how far (m) floating point may falsify a distance at any of the times."""
        grown = REACHABLE_BALL_ROUNDING * self.spread(times[1])
        return self.a.rounding(times) + self.b.rounding(times) + grown

    def displacement(self, state: PairState, duration: float) -> float:
        """Return D_A + D_B (m), non-decreasing in `duration`."""
        moved = self.a.displacement(state.a, duration) + self.b.displacement(state.b, duration)
        return moved + self._growth(state.time, duration)

    def path_length(self, state: PairState, duration: float) -> float:
        """Return L_A + L_B (m), above the relative arc length of any two points over [t, t + duration]."""
        moved = self.a.path_length(state.a, duration) + self.b.path_length(state.b, duration)
        return moved + self._growth(state.time, duration)

    def approach(self, state: PairState, duration: float, part: Part = Part.WHOLE) -> RelativeRates:
        """Return the lecture's v and a for a sleep of up to `duration`, no farther than the next knot.

        For the points of a part of each body.
        v = |v_oA - v_oB| + w_A r_A + w_B r_B and a = |a_oA - a_oB| + (al_A + w_A^2) r_A + (al_B + w_B^2) r_B,
        each body's radius about its own frame origin o; v holds at the start, a is the supremum until the horizon.
        """
        t = state.time
        horizon = self._horizon(t, duration)
        rates_a, rates_b = self.a.rates(state.a, horizon), self.b.rates(state.b, horizon)
        (_, v_a, w_a), (_, v_b, w_b) = state.a.twist, state.b.twist
        radius_a, radius_b = self.a.radius(part), self.b.radius(part)
        speed = norm(subtract(v_a, v_b)) + norm(w_a) * radius_a + norm(w_b) * radius_b
        steady = subtract(rates_a.steady, rates_b.steady)
        varying = rates_a.varying.plus(rates_b.varying)
        for rates, radius in ((rates_a, radius_a), (rates_b, radius_b)):
            turning = (rates.angular_acceleration + rates.angular_speed**2) * radius
            varying = varying.plus(across(rates.axis, turning))
        speed += CANCELLATION * (norm(v_a) + norm(v_b)) + self.growth_speed(t)
        lost = CANCELLATION * (norm(rates_a.steady) + norm(rates_b.steady) + varying.norm_bound)
        varying = varying.plus(ball(lost + sum(limits.acceleration_after(t) for limits in self.unknown)))
        return RelativeRates(speed, norm(steady) + varying.norm_bound, horizon, steady, varying)

    def slack(self, state: PairState) -> float:
        """Return by how much (m/s) velocities may be wrong; balls that grow are wrong by how fast they do."""
        slack = CANCELLATION * (self.a.fastest(state.a.twist) + self.b.fastest(state.b.twist))
        return slack + self.growth_speed(state.time)

    def knot_after(self, t: float) -> float:
        """Return the first time > t at which a rate may jump (inf: none)."""
        return min(self.a.knot_after(t), self.b.knot_after(t), *(limits.knot_after(t) for limits in self.unknown))

    def _horizon(self, t: float, duration: float) -> float:
        """Return until when (s) no rate jumps, at most `duration`."""
        knot = self.knot_after(t)
        return duration if knot - t > duration else min(duration, shortened(t, knot - t))

    def crossing(self, state: PairState, horizon: float, late: float) -> tuple[float, float]:
        """Return the next knot (s), and above how far (m) any point gets up to it from where a look ahead ends.

        Args:
            moments: the pair where the look ahead begins.
            horizon: s, how far it goes, just short of the knot.
            late: s, by how much less for certain.
        """
        before = state.time + max(0.0, horizon - late)
        knot = self.knot_after(state.time)
        return knot, self.displacement(self.at(before), knot - before) * (1.0 + RELATIVE_ROUNDING)

    def growth_speed(self, t: float) -> float:
        """Return how fast (m/s) balls grow at t, or just after."""
        return sum(limits.speed_at(t) for limits in self.unknown)

    def _growth(self, t: float, duration: float) -> float:
        return self.spread(t + duration) - self.spread(t) if self.unknown else 0.0
