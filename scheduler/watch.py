"""What is known of one pair so far, what a new measurement adds to it, and when the pair must wake next."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, nan, nextafter
from typing import NamedTuple

from .events import Bound, Collision, ContactKind, Event, PairKey, Phase, Reason, Span, Verdict
from .floor import Floor
from .pair import Measurement, Pair
from .scene import Settings

#: From its clear side a bracket is walked by the bounds, but in steps no smaller than this share of it.
BRACKET_SHARE = 1.0 / 8.0


class Plan(NamedTuple):
    """The next wakeup of a pair: when (s), why, and the bound that allows the sleep."""

    time: float
    reason: Reason
    bound: Bound


class Watch:
    """The state of one pair.

    Everything up to `known.time` is decided and told. `other`, if there is one, is a later measurement with the
    opposite answer (touching instead of clear, or clear instead of touching): the change lies between the two, and the
    pair is woken inside until they are no further apart than the contact tolerance.

    Attributes:
        clearance: m, certified lower bound on the distance of the solids at the last measurement, 0 in contact.
    """

    def __init__(self, pair: Pair, settings: Settings, start: float, end: float) -> None:
        """Watch a pair over [start, end], s."""
        self.pair = pair
        self._settings = settings
        self._end = end
        self.clearance = 0.0
        self._known: Measurement | None = None
        self._other: Measurement | None = None
        self._floor = Floor(settings, max(abs(start), abs(end)))
        self._spans = SpanRecord(pair.key, start)

    def learn(self, measurement: Measurement) -> Iterator[Event]:
        """Take in a measurement and yield what it settles: distances, spans, the begin or end of a contact."""
        known = self._known
        if known is None:
            measurement = self.pair.look_inside(measurement)
            self._known = measurement
            if measurement.touching:
                yield from self._change(measurement, measurement)
        else:
            measurement, verdict, clearance, depth_limit = self._judge(known, measurement)
            if self._takes_back(measurement.time - known.time, verdict):
                pass
            elif measurement.touching is known.touching:
                yield from self._spans.extend(measurement.time, verdict, clearance, depth_limit)
                self._known = measurement
            else:
                self._other = measurement
        self.clearance = 0.0 if measurement.touching else measurement.clearance
        if (distance := self.pair.distance(measurement)) is not None:
            yield distance
        yield from self._close_bracket()
        if self._known is not None and self._known.time >= self._end and self._other is None:
            yield from self._spans.finish()

    def plan(self) -> Plan | None:
        """Return the next wakeup, None when the pair is decided up to the end."""
        known, other = self._known, self._other
        assert known is not None
        if other is None:
            return self._plan_ahead(known) if known.time < self._end else None
        if known.touching:
            return Plan(0.5 * (known.time + other.time), Reason.REFINE, Bound.CONTACT_TOLERANCE)
        tolerance = self._settings.contact_tolerance
        latest = other.time - 0.5 * tolerance
        sleep, bound = self.pair.motion.sleep(known.moments, known.time, known.clearance, latest - known.time)
        floor = min(self._floor.seconds, max(tolerance, BRACKET_SHARE * (other.time - known.time)))
        if sleep < floor:
            sleep, bound = floor, Bound.CONTACT_TOLERANCE
        return Plan(min(known.time + sleep, latest), Reason.REFINE, bound)

    def _plan_ahead(self, known: Measurement) -> Plan:
        """Sleep for the best sound bound, at least the time resolution, and past no stop."""
        jump = self.pair.motion.stop_after(known.time)
        stop = min(jump, self._end)
        sleep, bound = 0.0, Bound.TIME_RESOLUTION
        if known.clearance > 0.0:
            sleep, bound = self.pair.motion.sleep(known.moments, known.time, known.clearance, stop - known.time)
        reason = Reason.TIME_BOUND
        floor = self._settings.time_resolution if known.touching else self._floor.seconds
        if sleep < min(floor, stop - known.time):
            sleep, bound = floor, Bound.TIME_RESOLUTION
            reason = Reason.REFINE if self._floor.finer else Reason.TIME_RESOLUTION
        if known.touching:
            reason = Reason.CONTACT
        if known.time + sleep < stop and sleep < stop - known.time:
            return Plan(known.time + sleep, reason, bound)
        return Plan(stop, Reason.KNOT if jump < self._end else Reason.END, bound)

    def _jumps_between(self, known: Measurement, measurement: Measurement) -> bool:
        """Tell whether a jump parts two measurements: the last float before it and the jump itself are both stops."""
        adjacent = measurement.time <= nextafter(known.time, inf)
        return adjacent and self.pair.motion.stop_after(known.time) == measurement.time

    def _takes_back(self, step: float, verdict: Verdict) -> bool:
        """Tell whether a step (s) that proved nothing is to be taken back and tried finer."""
        if verdict is Verdict.UNRESOLVED:
            return self._floor.failed(step)
        if verdict is Verdict.CLEAR:
            self._floor.proved(step)
        return False

    def _judge(self, known: Measurement, measurement: Measurement) -> tuple[Measurement, Verdict, float, float]:
        """Return the measurement, containment decided where it must be; and the verdict, clearance, depth limit since.

        Disjoint surfaces prove that neither body is inside the other only where both were apart before and the time
        between is proved clear.
        """
        if known.touching:
            return self.pair.look_inside(measurement), Verdict.CONTACT, 0.0, nan
        if self._jumps_between(known, measurement):  # each side speaks for itself
            left = self.pair.motion.left(known.moments, known.clearance, measurement.time - known.time)
            verdict = Verdict.CLEAR if left > 0.0 else Verdict.UNRESOLVED
            return self.pair.look_inside(measurement), verdict, max(0.0, min(left, measurement.clearance)), 0.0
        if measurement.touching:
            return measurement, Verdict.CONTACT, 0.0, nan
        duration = measurement.time - known.time
        proof = self.pair.motion.proof(known.moments, known.clearance, duration, measurement.clearance)
        if proof.clearance > 0.0:
            return measurement, Verdict.CLEAR, proof.clearance, 0.0
        return self.pair.look_inside(measurement), Verdict.UNRESOLVED, 0.0, proof.depth_limit

    def _close_bracket(self) -> Iterator[Event]:
        """Tell the contact's begin or end once it is known to the contact tolerance."""
        known, other = self._known, self._other
        if known is None or other is None or other.time - known.time > self._settings.contact_tolerance:
            return
        self._known, self._other = other, None
        self._floor.restore()
        yield from self._change(known, other)

    def _change(self, before: Measurement, after: Measurement) -> Iterator[Event]:
        """Tell a contact's begin (also one that stands at the start, where both are the same) or end."""
        begins = after.touching
        touching, clear = (after, before) if begins else (before, after)
        # A contact's span runs from the clear side of its begin to the clear side of its end.
        yield from self._spans.extend(clear.time, Verdict.CLEAR if begins else Verdict.CONTACT, clear.clearance, 0.0)
        yield from self._spans.extend(after.time, Verdict.CONTACT, 0.0, nan)
        distance = self.pair.distance(touching)
        assert distance is not None
        yield Collision(
            self.pair.key,
            Phase.BEGIN if begins else Phase.END,
            clear.time,
            touching.time,
            ContactKind.SURFACE if touching.inside is None else ContactKind.CONTAINED,
            distance.feature_a,
            distance.feature_b,
            distance.witness_a,
        )


class SpanRecord:
    """The growing last span of a pair: neighbours of one verdict become one span."""

    def __init__(self, key: PairKey, start: float) -> None:
        """Begin at `start`, s."""
        self._key = key
        self._start = self._end = start
        self._verdict: Verdict | None = None
        self._clearance = inf
        self._depth_limit = 0.0

    def extend(self, until: float, verdict: Verdict, clearance: float, depth_limit: float) -> Iterator[Span]:
        """Add the stretch up to `until`; yield the span before it where the verdict changes."""
        if until <= self._end:
            return
        if verdict is not self._verdict:
            yield from self.finish()
            self._verdict, self._clearance, self._depth_limit = verdict, clearance, depth_limit
        self._end = until
        self._clearance = min(self._clearance, clearance)
        self._depth_limit = max(self._depth_limit, depth_limit)

    def finish(self) -> Iterator[Span]:
        """Yield the last span, if it has any length, and start the next where it ends."""
        if self._verdict is not None and self._end > self._start:
            yield Span(self._key, self._verdict, self._start, self._end, self._clearance, self._depth_limit)
        self._start = self._end
