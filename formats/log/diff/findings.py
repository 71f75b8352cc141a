"""What two logs found, compared pair by pair: verdicts, contacts, minima, breaches."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import inf, nan
from pathlib import Path

from ..container.clock import seconds_told
from ..errors import LogError
from ..result import Found
from ..summary import Contact, PairSummary
from .align import aligned, gap
from .difference import Cause, Difference, Ignored, Tolerances


@dataclass(frozen=True, slots=True)
class Rules:
    """How a comparison is done.

    Attributes:
        tolerances: of times and distances.
        ignored: what is left out.
        within_brackets: whether minima agree wherever what both logs certify may be true of one scene, and unresolved
            time is passed over; else the distances measured must agree too.
    """

    tolerances: Tolerances = field(default_factory=Tolerances)
    ignored: Ignored = field(default_factory=Ignored)
    within_brackets: bool = False


def require_comparable(golden: Found, new: Found, new_path: Path, rules: Rules) -> None:
    """Check that two logs are of one time, and share a pair.

    Raises:
        LogError: where they are not.
    """
    (start, end), (new_start, new_end) = golden.summary["time"], new.summary["time"]
    times = rules.tolerances.times
    if abs(new_start - start) > times(start) or abs(new_end - end) > times(end):
        covered, whole = (
            f"[{seconds_told(low, 7)}, {seconds_told(high, 7)}] s" for low, high in ((new_start, new_end), (start, end))
        )
        problem = f"covers {covered}, but the golden log covers {whole}"
        raise LogError(new_path, f"cannot be compared: it {problem}", "compare runs over the same time")
    before, after = _by_bodies(golden), _by_bodies(new)
    lossy = golden.loss is not None or new.loss is not None
    if before and after and not before.keys() & after.keys() and not lossy:
        raise LogError(
            new_path, "cannot be compared: the two logs have no pair in common", "compare runs of the same scene"
        )


def differences(golden: Found, new: Found, rules: Rules) -> Iterator[Difference]:
    """Yield what differs, in the order of the golden log's pairs."""
    before, after = _by_bodies(golden), _by_bodies(new)
    unlisted = len(after) < new.summary["pairs_total"], len(before) < golden.summary["pairs_total"]
    appeared = vanished = 0
    for bodies, pair in before.items():
        if rules.ignored.pair(pair["pair"]):
            continue
        if bodies in after:
            yield from _PairDiff(pair, after[bodies], golden, new, rules).differences()
        elif new.loss is None:
            vanished += not unlisted[0]
            yield from _only(Cause.PAIR_REMOVED, pair, unlisted[0], rules)
    for bodies, pair in after.items():
        if bodies not in before and golden.loss is None and not rules.ignored.pair(pair["pair"]):
            appeared += not unlisted[1]
            yield from _only(Cause.PAIR_ADDED, pair, unlisted[1], rules)
    total, new_total = golden.summary["pairs_total"], new.summary["pairs_total"]
    if new_total - total != appeared - vanished and not rules.ignored.patterns:
        yield Difference(Cause.PAIRS, "", str(total), str(new_total), float(new_total - total), "", None)


def notes(golden: Found, new: Found) -> Iterator[str]:
    """Yield what a reviewer should know of two runs, and is no difference of what they found."""
    before, after = golden.summary, new.summary
    for name in sorted(before["settings"].keys() | after["settings"].keys()):
        old, now = before["settings"].get(name), after["settings"].get(name)
        if old != now:
            yield f"setting {name}: {'none' if old is None else old} -> {'none' if now is None else now}"
    names, new_names = _bodies(golden), _bodies(new)
    gone, come = names - new_names, new_names - names
    if len(gone) == len(come) == 1:
        yield f"body {gone.pop()} is missing and {come.pop()} is new: was it renamed?"


def _only(cause: Cause, pair: PairSummary, unlisted: bool, rules: Rules) -> Iterator[Difference]:
    """Yield what it means that one log alone lists a pair.

    Args:
        unlisted: whether the other log has pairs that it does not list, for its broad phase cleared them.
    """
    removed = cause is Cause.PAIR_REMOVED
    verdict, other = pair["verdict"], "clear, by the broad phase" if unlisted else None
    if unlisted:
        if verdict == "clear" or rules.ignored.topic(Cause.VERDICT.topic):
            return
        cause = Cause.VERDICT
    golden, new = (verdict, other) if removed else (other, verdict)
    yield Difference(cause, pair["pair"], golden, new, nan, "", _time_of(pair) if unlisted else None)


class _PairDiff:
    """One pair as two logs have it."""

    def __init__(self, pair: PairSummary, now: PairSummary, golden: Found, new: Found, rules: Rules) -> None:
        self._pair, self._now = pair, now
        self._rules = rules
        self._end = golden.summary["time"][1]
        self._lost = [*golden.lost.get(pair["pair"], ()), *new.lost.get(now["pair"], ())]
        settings = (found.summary["settings"].get("contact_tolerance") for found in (golden, new))
        self._bracket = max(value or 0.0 for value in settings)

    def differences(self) -> Iterator[Difference]:
        """Yield what differs; of a pair that is not all there, what contacts say in the time that is."""
        ignored = self._rules.ignored.topic
        if self._lost:
            if not ignored("/collisions"):
                yield from self._contacts()
            return
        if not ignored("/spans"):
            yield from self._verdict()
        if self._pair["margin"] != self._now["margin"]:
            yield self._found(Cause.MARGIN, self._pair["margin"], self._now["margin"], "m", None)
        if not ignored("/collisions"):
            yield from self._contacts()
        if not ignored("/distances"):
            yield from self._minimum()
        if not ignored("/spans"):
            yield from self._breaches()
            yield from self._unproved()

    def _found(
        self, cause: Cause, golden: float | None, new: float | None, unit: str, time: float | None, proved: bool = True
    ) -> Difference:
        change = nan if golden is None or new is None else new - golden
        return Difference(cause, self._pair["pair"], golden, new, change, unit, time, proved)

    def _verdict(self) -> Iterator[Difference]:
        old, now = self._pair["verdict"], self._now["verdict"]
        if old == now:
            return
        times = [time for time in (_time_of(self._pair), _time_of(self._now)) if time is not None]
        yield Difference(Cause.VERDICT, self._pair["pair"], old, now, nan, "", min(times, default=None))

    def _contacts(self) -> Iterator[Difference]:
        old, now = self._pair["contacts"], self._now["contacts"]
        for i, j in aligned([self._touching(one) for one in old], [self._touching(one) for one in now]):
            if i is None or j is None:
                contact = now[j] if j is not None else old[i or 0]
                if not self._is_lost(contact["begin"][1]):
                    yield self._contact(Cause.CONTACT_VANISHED if j is None else Cause.CONTACT_APPEARED, contact)
            else:
                yield from self._moved(old[i], now[j])

    def _contact(self, cause: Cause, contact: Contact) -> Difference:
        start, end = self._touching(contact)
        text = f"{seconds_told(start, 7)} .. {'the end' if contact['end'] is None else f'{seconds_told(end, 7)} s'}"
        golden, new = (text, None) if cause is Cause.CONTACT_VANISHED else (None, text)
        return Difference(cause, self._pair["pair"], golden, new, end - start, "s", start, keys=contact["keys"])

    def _moved(self, old: Contact, now: Contact) -> Iterator[Difference]:
        times = self._rules.tolerances.times
        pair = self._pair["pair"]
        before, after = old["begin"][1], now["begin"][1]
        if gap(old["begin"], now["begin"]) > times(before) and not self._is_lost(before) and not self._is_lost(after):
            earlier = min(before, after)
            yield Difference(Cause.BEGIN, pair, before, after, after - before, "s", earlier, keys=now["keys"])
        if self._lost or (old["end"] is None and now["end"] is None):
            return
        if old["end"] is None or now["end"] is None or gap(old["end"], now["end"]) > times(old["end"][0]):
            (_, before), (_, after) = self._touching(old), self._touching(now)
            told, new_told = (None if one["end"] is None else one["end"][0] for one in (old, now))
            earlier = min(before, after)
            yield Difference(Cause.END, pair, told, new_told, after - before, "s", earlier, keys=now["keys"])

    def _minimum(self) -> Iterator[Difference]:
        """Yield whether the least distance fell or rose; a contact says that already."""
        if "contact" in (self._pair["verdict"], self._now["verdict"]):
            return
        old, now = self._pair["distance"], self._now["distance"]
        upper, new_upper = (inf if one["upper"] is None else one["upper"] for one in (old, now))
        before = old["lower"] if old["upper"] is None else old["upper"]
        after = now["lower"] if now["upper"] is None else now["upper"]
        allowed = self._rules.tolerances.distances(before)
        apart = now["lower"] > upper + allowed or old["lower"] > new_upper + allowed
        measured = old["upper"] is not None and now["upper"] is not None and abs(after - before) > allowed
        if apart or (measured and not self._rules.within_brackets):
            cause = Cause.MINIMUM_FELL if after < before else Cause.MINIMUM_ROSE
            yield self._found(cause, before, after, "m", old["time"] if now["time"] is None else now["time"], apart)

    def _breaches(self) -> Iterator[Difference]:
        old, now = self._pair["breaches"], self._now["breaches"]
        times, pair = self._rules.tolerances.times, self._pair["pair"]
        for i, j in aligned([(low, high) for low, high in old], [(low, high) for low, high in now]):
            if i is None or j is None:
                low, high = now[j] if j is not None else old[i or 0]
                text = f"{seconds_told(low, 7)} .. {seconds_told(high, 7)} s"
                if j is None:
                    yield Difference(Cause.BREACH_VANISHED, pair, text, None, high - low, "s", low)
                else:
                    yield Difference(Cause.BREACH_APPEARED, pair, None, text, high - low, "s", low)
                continue
            for before, after in zip(old[i], now[j], strict=True):
                if abs(after - before) > times(before) + self._bracket:
                    yield self._found(Cause.BREACH_MOVED, before, after, "s", min(before, after))

    def _unproved(self) -> Iterator[Difference]:
        """Yield whether the time changed that nothing is proved of; where it lies is the scheduler's affair."""
        old, now = self._pair, self._now
        kinds = [(Cause.POSSIBLE, old["possible"], now["possible"])]
        if not self._rules.within_brackets:
            kinds.append((Cause.UNRESOLVED, old["unresolved"], now["unresolved"]))
        for cause, spans, new_spans in kinds:
            before, after = (sum(high - low for low, high in one) for one in (spans, new_spans))
            allowed = self._rules.tolerances.times(before) + self._bracket * (len(spans) + len(new_spans))
            if abs(after - before) > allowed:
                yield self._found(cause, before, after, "s", min(low for low, _ in (*spans, *new_spans)))

    def _touching(self, contact: Contact) -> tuple[float, float]:
        return contact["begin"][1], self._end if contact["end"] is None else contact["end"][0]

    def _is_lost(self, time: float) -> bool:
        return any(low <= time <= high for low, high in self._lost)


def _time_of(pair: PairSummary) -> float | None:
    """Return when, s, a pair's verdict shows first; None for a clear pair."""
    if pair["contacts"]:
        return pair["contacts"][0]["begin"][1]
    spans = {"breach": pair["breaches"], "unresolved": pair["unresolved"], "possible": pair["possible"]}
    return next((one[0][0] for kind, one in spans.items() if kind == pair["verdict"] and one), None)


def _by_bodies(found: Found) -> dict[frozenset[str], PairSummary]:
    return {frozenset((pair["body_a"], pair["body_b"])): pair for pair in found.summary["pairs"]}


def _bodies(found: Found) -> set[str]:
    return {body for bodies in _by_bodies(found) for body in bodies}
