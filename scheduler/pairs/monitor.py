"""The state of one pair: what is known of it, what a new measurement adds, and when it must wake next."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import inf, nan, nextafter, ulp
from typing import NamedTuple

from ..bounds import motion_bound
from ..bounds.motion_bound import Proof
from ..model.events import Bound, Collision, ContactKind, Event, Phase, Reason, Verdict
from ..model.scene import Settings
from .contact import ContactSleep
from .least_distance import LeastDistance
from .pair import Measurement, Pair
from .separation import SeparationSleep, Tuning
from .span_record import Cleared, SpanRecord
from .step_floor import StepFloor

#: The bounds that lose little of a separation: motion along them does not close the gap.
SLABS = frozenset({Bound.SPHERE_SLABS, Bound.BODY_SLAB, Bound.TRIANGLE_SLABS})
#: From its clear side a bracket is walked by the bounds, but in steps no smaller than this share of it.
BRACKET_SHARE = 1.0 / 8.0
#: A margin's crossing is known to this share of the contact tolerance: so near that a breach's ends measure at the
#: margin.
MARGIN_SHARE = 1.0 / 16384.0


class Plan(NamedTuple):
    """The next wakeup of a pair: when (s), why, and the bound that allows the sleep."""

    time: float
    reason: Reason
    bound: Bound


class Finding(NamedTuple):
    """The decision on the time between two measurements.

    Attributes:
        verdict: of the whole time.
        clearance: m, certified lower bound on the distance; 0 where nothing is certain.
        depth_limit: m, no point of one solid gets deeper than this into the other; NaN where nothing is known.
    """

    verdict: Verdict
    clearance: float = 0.0
    depth_limit: float = 0.0


class Monitor:
    """The state of one pair.

    Everything up to `known.time` is decided and yielded. `other`, if there is one, is a later measurement with another
    status (touching instead of clear, or clear instead of in breach): the change lies between the two, and the pair
    is woken inside until they are no further apart than the tolerance.

    Attributes:
        clearance: m, certified lower bound on the distance of the solids at the last measurement, 0 in contact.
    """

    def __init__(self, pair: Pair, settings: Settings) -> None:
        """Monitor a pair while both its bodies exist."""
        self.pair = pair
        self._settings = settings
        self._end = pair.end
        self.clearance = 0.0
        self._known: Measurement | None = None
        self._ahead_of_known: SeparationSleep | None = None
        self._tuning = Tuning()
        self._other: Measurement | None = None
        latest = max(abs(pair.start), abs(pair.end))
        self._margin_tolerance = max(MARGIN_SHARE * settings.contact_tolerance, 8.0 * ulp(latest))
        tolerance = self._margin_tolerance if pair.margin > 0.0 else settings.contact_tolerance
        self._floor = StepFloor(settings, tolerance, latest)
        self._contact_sleep = ContactSleep(pair, settings.time_resolution)
        resolution = settings.time_resolution
        self._spans = SpanRecord(pair.key, pair.start, pair.error, resolution, self._margin_tolerance)
        self._near = False  # whether bounding spheres have not cleared it so far that its least distance may stay loose

    def learn(self, measurement: Measurement) -> Iterator[Event]:
        """Take in a measurement and yield what it settles: distances, spans, the begin or end of a contact."""
        known = self._known
        if known is None:
            measurement = self.pair.look_inside(measurement)
            self._stand_at(measurement)
            if self.pair.at_start is not None and measurement.time == self.pair.start:
                yield from self._touch_at_start(self.pair.at_start)
            if measurement.touching:
                yield from self._change(measurement, measurement)
        else:
            measurement, finding = self._judge(known, measurement)
            if measurement.status is not known.status:
                self._other = measurement
            elif known.hidden or measurement.hidden or not self._takes_back(measurement.time - known.time, finding):
                yield from self._extend(known, measurement, finding)
                self._stand_at(measurement)
        self.clearance = 0.0 if measurement.touching else measurement.clearance
        if not self.pair.path_unknown and (distance := self.pair.distance(measurement)) is not None:
            yield distance
        yield from self._close_bracket()

    def finish(self) -> Iterator[Event]:
        """Yield the last events of a pair that is decided up to its end: its least distance and its spans."""
        share = self._settings.distance_tolerance
        if share is not None and self._near and not self._spans.touched:
            search = LeastDistance(self.pair, self._spans.waiting, share, self._settings.time_resolution, self._tuning)
            self._spans.replace((yield from search.narrowed()))
        yield from self._spans.finish()

    @property
    def decided(self) -> float:
        """Up to when (s) all is decided of the pair."""
        return self._spans.end

    @property
    def parting(self) -> bool:
        """Whether the pair was clear when it was last decided, and no later change waits for its bracket."""
        known = self._known
        return self._other is None and known is not None and known.status is Verdict.CLEAR

    def clear(self, stretches: Iterable[Cleared]) -> Iterator[Event]:
        """Take in what windows cleared since all was decided; the pair is then looked at anew."""
        for end, clearance in stretches:
            yield from self._spans.extend(end, Verdict.CLEAR, clearance, 0.0, inf)
        self._known = self._ahead_of_known = None

    def plan(self) -> Plan | None:
        """Return the next wakeup, None when the pair is decided up to the end."""
        known, other = self._known, self._other
        assert known is not None
        if other is None:
            return self._plan_ahead(known) if known.time < self._end else None
        tolerance = self._tolerance(known, other)
        gap = other.time - known.time
        latest = gap - 0.5 * tolerance
        if known.touching:
            return Plan(known.time + 0.5 * gap, Reason.REFINE, Bound.CONTACT_TOLERANCE)
        floor = min(self._floor.seconds, max(tolerance, BRACKET_SHARE * gap))
        sleep, bound = self._ahead.sleep(latest, floor)
        if bound in SLABS:  # nearly exact: what little it leaves is the bracket
            floor = min(floor, tolerance)
        if sleep < floor:
            sleep, bound = floor, Bound.CONTACT_TOLERANCE
        if _leaves(known, other):
            latest = 0.5 * gap
        return Plan(known.time + min(sleep, latest), Reason.REFINE, bound)

    def _plan_ahead(self, known: Measurement) -> Plan:
        """Sleep for the best sound bound, at least the time resolution, and past no stop."""
        jump = self.pair.motion.stop_after(known.time)
        stop = min(jump, self._end)
        sleep, bound = self._proved_sleep(known, stop - known.time)
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

    def _proved_sleep(self, known: Measurement, horizon: float) -> tuple[float, Bound]:
        """Return how long (s) the pair's status is certain to last.

        In breach it is certain that no contact begins; that the breach lasts, only as far as the time resolution.
        """
        if known.touching:
            return self._contact_sleep.sleep(known, horizon)
        sleep, bound = self._ahead.sleep(horizon, self._floor.seconds)
        least = self._settings.time_resolution
        if known.status is not Verdict.BREACH or sleep <= least:
            return sleep, bound
        left = known.margin - known.above
        lasting = 0.0, bound
        if left > 0.0:
            lasting = motion_bound.sleep(self.pair.motion, known.state, known.time, left, sleep)
        return lasting if lasting[0] > least else (least, Bound.TIME_RESOLUTION)

    def _stand_at(self, measurement: Measurement) -> None:
        """Take a measurement as the last one known."""
        self._known = measurement
        seen = replace(measurement, proximity=None) if measurement.hidden else measurement  # no direction parts them
        self._ahead_of_known = None
        if not measurement.touching:
            self._ahead_of_known = SeparationSleep(self.pair, seen, measurement.threshold, self._tuning)

    @property
    def _ahead(self) -> SeparationSleep:
        assert self._ahead_of_known is not None
        return self._ahead_of_known

    def _jumps_between(self, known: Measurement, measurement: Measurement) -> bool:
        """Return whether a jump parts two measurements: the last float before it and the jump itself are both stops."""
        adjacent = measurement.time <= nextafter(known.time, inf)
        return adjacent and self.pair.motion.stop_after(known.time) == measurement.time

    def _takes_back(self, step: float, finding: Finding) -> bool:
        """Return whether a step (s) that proved nothing is to be taken back and tried finer."""
        beside_margin = finding.clearance > 0.0 and step <= self._margin_tolerance
        if finding.verdict is Verdict.UNRESOLVED and not beside_margin:
            return self._floor.failed(step)
        if finding.verdict is not Verdict.CONTACT:
            self._floor.proved(step)
        return False

    def _judge(self, known: Measurement, measurement: Measurement) -> tuple[Measurement, Finding]:
        """Return the measurement, containment decided where it must be, and what is decided of the time since.

        Disjoint surfaces prove that neither body is inside the other only where both were apart before and the time
        between is proved clear.
        """
        if known.touching:
            return self.pair.look_inside(measurement), Finding(Verdict.CONTACT, depth_limit=nan)
        if measurement.touching:
            return measurement, Finding(Verdict.CONTACT, depth_limit=nan)
        duration = measurement.time - known.time
        if self._jumps_between(known, measurement):  # each side speaks for itself
            left = motion_bound.left(self.pair.motion, known.state, known.clearance, duration)
            proof = Proof(min(left, measurement.clearance), 0.0)
            measurement = self.pair.look_inside(measurement)
        else:
            proof = self._ahead.proof(measurement)
            if proof.clearance <= 0.0 or known.hidden:
                measurement = self.pair.look_inside(measurement)
        return measurement, self._finding(known, measurement, proof)

    def _finding(self, known: Measurement, measurement: Measurement, proof: Proof) -> Finding:
        """Return what is proved between two measurements that do not touch.

        CLEAR holds the margin everywhere. Where a margin is crossed, and between two measurements in breach, it is
        proved that nothing touches. Unresolved with a clearance is what grazes the margin, certainly without contact.
        """
        clear = known.status is measurement.status is Verdict.CLEAR
        hidden = max(known.hidden, measurement.hidden)
        if (clear or hidden) and proof.clearance > known.margin:
            return Finding(Verdict.CLEAR, proof.clearance)
        if proof.clearance > 0.0:
            return Finding(Verdict.UNRESOLVED if clear else Verdict.BREACH, proof.clearance)
        return Finding(Verdict.UNRESOLVED, depth_limit=proof.depth_limit + hidden)

    def _close_bracket(self) -> Iterator[Event]:
        """Tell the change of status once its time is known to the tolerance."""
        known, other = self._known, self._other
        if known is None or other is None or other.time - known.time > self._tolerance(known, other):
            return
        if not (known.touching or other.touching):
            _, finding = self._judge(known, other)
            yield from self._extend(known, other, finding)
        self._stand_at(other)
        self._other = None
        self._floor.restore()
        if known.touching or other.touching:
            yield from self._change(known, other)

    def _extend(self, known: Measurement, until: Measurement, finding: Finding) -> Iterator[Event]:
        """Tell what is decided between two measurements; of what may be, only that it cannot be is certain."""
        nearest = min(known.above, until.above)
        self._near |= not (self.pair.path_unknown or self.pair.far(finding.clearance)) or nearest < inf
        if self.pair.path_unknown and finding.verdict is not Verdict.CLEAR:
            finding = finding._replace(verdict=Verdict.POSSIBLE, depth_limit=nan)
        yield from self._spans.extend(until.time, *finding, nearest)

    def _tolerance(self, known: Measurement, other: Measurement) -> float:
        """Return the widest bracket (s) that a change between two standings may keep."""
        crosses_margin = not (known.touching or other.touching)
        return self._margin_tolerance if crosses_margin else self._settings.contact_tolerance

    def _change(self, before: Measurement, after: Measurement) -> Iterator[Event]:
        """Tell a contact's begin (also one that stands at the start, where both are the same) or end."""
        begins = after.touching
        touching, clear = (after, before) if begins else (before, after)
        # A contact's span runs from the clear side of its begin to the clear side of its end.
        yield from self._extend(before, after, Finding(Verdict.CONTACT, depth_limit=nan))
        if not begins:  # the next contact may begin at the very instant that was clear
            yield from self._spans.finish()
        if not self.pair.path_unknown:
            yield _collision(self.pair, Phase.BEGIN if begins else Phase.END, clear.time, touching)

    def _touch_at_start(self, pair: Pair) -> Iterator[Event]:
        """Return whether bodies of unknown path touch while their places are still known, which is at one instant."""
        first = pair.look_inside(pair.measure(pair.start))
        if not first.touching:
            return
        instant = nextafter(pair.start, inf)
        yield _collision(pair, Phase.BEGIN, pair.start, first)
        yield from self._spans.extend(instant, Verdict.CONTACT, 0.0, nan, 0.0)
        yield _collision(pair, Phase.END, instant, first)


def _collision(pair: Pair, phase: Phase, clear: float, touching: Measurement) -> Collision:
    """Return the end of a contact between `clear` (s) and a measurement that touches."""
    distance = pair.distance(touching)
    assert distance is not None
    return Collision(
        pair.key,
        phase,
        clear,
        touching.time,
        ContactKind.SURFACE if touching.inside is None else ContactKind.CONTAINED,
        distance.feature_a,
        distance.feature_b,
        distance.witness_a,
    )


def _leaves(known: Measurement, other: Measurement) -> bool:
    """Return whether the change between two standings is a breach's end."""
    return known.status is Verdict.BREACH and other.status is Verdict.CLEAR
