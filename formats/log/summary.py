"""The summary of a run: what `summary --json` prints and every log carries as `summary.json`."""

from __future__ import annotations

import json
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from itertools import zip_longest
from math import inf, isfinite
from operator import itemgetter
from typing import TypedDict

from closecall import __version__

from ...scheduler.model.events import (
    Collision,
    Distance,
    Event,
    Level,
    PairKey,
    Phase,
    Snapshot,
    Span,
    Verdict,
    Wakeup,
    Window,
)
from ...scheduler.model.pair_count import count_pairs
from ...scheduler.model.scene import Scene, Settings
from .bracket import DistanceRange, Least

# From worst to best; a pair's verdict is the worst of its spans'.
SEVERITY = (Verdict.CONTACT, Verdict.BREACH, Verdict.UNRESOLVED, Verdict.POSSIBLE, Verdict.CLEAR)
_RANKS = {verdict: rank for rank, verdict in enumerate(SEVERITY)}

# What answers a wakeup, from coarse to exact.
LEVELS = (Level.SPHERE, Level.MESH)
_LEVEL_RANKS = {level: rank for rank, level in enumerate(LEVELS)}


class Contact(TypedDict):
    """One contact in s: [clear, touching], and [touching, clear] or None where it stands at the end.

    `keys` names, by body, the named keys that its motion is between where the contact begins.
    """

    begin: list[float]
    end: list[float] | None
    keys: dict[str, list[str]]


class PairSummary(TypedDict):
    """What the run found of one pair.

    `margin`, m, is what the verdict was measured against. `queries` counts wakeups by the level that answered them.
    `error`, m, is by how much distances measured between the two may be wrong; it is off `lower` already.
    Round bodies are measured as polyhedra that enclose them: `chord_error`, m, is how much farther apart the bodies
    themselves are at most. `lower` is that of the polyhedra, `upper` of the bodies.
    """

    pair: str
    body_a: str
    body_b: str
    verdict: str
    margin: float
    distance: DistanceRange
    error: float
    chord_error: float
    contacts: list[Contact]
    breaches: list[list[float]]
    unresolved: list[list[float]]
    possible: list[list[float]]
    wakeups: int
    queries: dict[str, int]


class Totals(TypedDict):
    """Sums over all pairs; `pairs`, by verdict, sums to `pairs_total`."""

    pairs: dict[str, int]
    contacts: int
    wakeups: int
    queries: dict[str, int]


class Summary(TypedDict):
    """What the run found; pairs that the broad phase alone cleared are counted, not listed.

    `pairs_ignored` counts the pairs that only the scene's rules kept from being checked.
    """

    closecall: str
    time: list[float]
    settings: dict[str, float | None]
    pairs_total: int
    pairs_ignored: int
    pairs: list[PairSummary]
    totals: Totals


@dataclass(slots=True)
class _PairFindings:
    """What every pair has; inf stands for nothing found yet. Runs have millions of these: keep them small."""

    key: PairKey
    rank: int = len(SEVERITY)
    lower: float = inf
    upper: float = inf
    upper_time: float = inf
    measured: float = inf
    error: float = 0.0
    queries: list[int] = field(default_factory=lambda: [0] * len(LEVELS))

    def add_distance(self, distance: float, excess: float, time: float) -> None:
        upper = distance + excess
        if upper < self.upper or (upper == self.upper and time < self.upper_time):  # no for NaN
            self.upper, self.upper_time = upper, time
        self.measured = min(self.measured, distance)  # nor here

    def add_span(self, verdict: Verdict, clearance: float, error: float) -> None:
        self.rank = min(self.rank, _RANKS[verdict])
        certified = verdict is not Verdict.CONTACT and clearance > 0  # no for NaN
        self.lower = min(self.lower, clearance if certified else 0.0)
        self.error = max(self.error, error if isfinite(error) else 0.0)

    def verdict(self) -> str:
        """Return the worst verdict; nothing is proved of a pair without spans."""
        verdict = SEVERITY[self.rank] if self.rank < len(SEVERITY) else Verdict.UNRESOLVED
        return verdict.name.lower()

    def distance(self, share: float | None, verdicts: frozenset[str], chord_error: float) -> DistanceRange:
        """Return the least distance, its ends sought as near as `share` (None: not); `lower` is 0 if no span says more.

        Older logs state neither an error nor an excess: round bodies may be apart by all of their chord error more.
        """
        lower = self.lower if isfinite(self.lower) else 0.0
        upper = self.upper if self.error > 0.0 else self.upper + chord_error
        return Least(lower, upper, self.upper_time, self.measured, self.error).range(share, verdicts)


@dataclass(slots=True)
class _Brackets:
    """A pair's contacts so far: begins as (clear, touching), ends as (touching, clear)."""

    begins: list[tuple[float, float]] = field(default_factory=list)
    ends: list[tuple[float, float]] = field(default_factory=list)

    def add(self, phase: Phase, time_clear: float, time_touching: float) -> None:
        if phase is Phase.BEGIN:
            self.begins.append((time_clear, time_touching))
        else:
            self.ends.append((time_touching, time_clear))

    def pairs(self) -> list[tuple[list[float], list[float] | None]]:
        """Return each contact's begin and end in time order, in whatever order they were found.

        Both alternate; where a log lost some, a begin has the end that follows it before the next begin, if any.
        """
        ends = sorted(self.ends)
        begins = sorted(self.begins, key=itemgetter(1))
        found: list[tuple[list[float], list[float] | None]] = []
        for begin, following in zip_longest(begins, begins[1:], fillvalue=(inf, inf)):
            later = bisect_left(ends, (begin[1], -inf))
            end = ends[later] if later < len(ends) and ends[later][0] <= following[1] else None
            found.append((list(begin), None if end is None else list(end)))
        return found


@dataclass(frozen=True, slots=True)
class Subject:
    """What a summary says of its run that the facts do not.

    Attributes:
        name: of a body, by its index in document order.
        time: s, from and to.
        settings: in SI, under the scene file's keys.
        pairs_total: how many pairs the rules let be checked, with those that the broad phase clears.
        pairs_ignored: how many pairs only the rules keep from it.
        chord_error: m, of a body.
        margin: m, of a pair of bodies.
    """

    name: Callable[[int], str]
    time: tuple[float, float]
    settings: dict[str, float | None]
    pairs_total: int
    pairs_ignored: int
    chord_error: Callable[[int], float]
    margin: Callable[[int, int], float]


def subject_of(scene: Scene, settings: Settings, pairs_total: int) -> Subject:
    """Return what the summary of a scene's run says beside its facts."""
    names = tuple(body.name for body in scene.bodies)
    chord_errors = tuple(body.chord_error for body in scene.bodies)
    return Subject(
        name=names.__getitem__,
        time=(scene.start, scene.end),
        settings=asdict(settings),
        pairs_total=pairs_total,
        pairs_ignored=count_pairs(scene).ignored,
        chord_error=chord_errors.__getitem__,
        margin=lambda a, b: scene.rules.margin(a, b, settings.margin),
    )


class SummaryBuilder:
    """Folds a run's facts into its summary, in any order. Memory grows with pairs, contacts and unresolved spans alone.

    Args:
        subject: what the summary says beside the facts.
        keys_around: the named keys that a body is between at a time (s), empty for none.
    """

    def __init__(
        self, subject: Subject, keys_around: Callable[[int, float], tuple[str, str]] = lambda body, time: ("", "")
    ) -> None:
        self._subject = subject
        self._keys_around = keys_around
        self._findings: dict[int, _PairFindings] = {}
        self._brackets: defaultdict[int, _Brackets] = defaultdict(_Brackets)
        self._spans: dict[Verdict, defaultdict[int, list[tuple[float, float]]]] = {
            verdict: defaultdict(list) for verdict in (Verdict.BREACH, Verdict.UNRESOLVED, Verdict.POSSIBLE)
        }

    def add(self, event: Event) -> None:
        """Fold one more event; windows, and snapshots, which prove nothing, are passed over."""
        match event:
            case Wakeup():
                self.add_wakeup(event.pair, event.level)
            case Distance():
                self.add_distance(event.pair, event.distance, event.excess, event.time)
            case Collision():
                self.add_collision(event.pair, event.phase, event.time_clear, event.time_touching)
            case Span():
                self.add_span(event.pair, event.verdict, event.start, event.end, event.clearance, event.error)
            case Window() | Snapshot():
                pass

    def add_wakeup(self, pair: PairKey, level: Level) -> None:
        """Count a wakeup by what answered it."""
        self._findings_of(pair).queries[_LEVEL_RANKS[level]] += 1

    def add_distance(self, pair: PairKey, distance: float, excess: float, time: float) -> None:
        """Fold an exact distance, m, taken at a time, s; round bodies may be farther apart by the excess, m."""
        self._findings_of(pair).add_distance(distance, excess, time)

    def add_collision(self, pair: PairKey, phase: Phase, time_clear: float, time_touching: float) -> None:
        """Fold one end of a contact, bracketed in s."""
        self._findings_of(pair).rank = _RANKS[Verdict.CONTACT]
        self._brackets[pair.id].add(phase, time_clear, time_touching)

    def add_span(
        self, pair: PairKey, verdict: Verdict, start: float, end: float, clearance: float, error: float = 0.0
    ) -> None:
        """Fold what is proved from start to end, s, with the clearance and the error of distances, m."""
        self._findings_of(pair).add_span(verdict, clearance, error)
        if verdict in self._spans:
            self._spans[verdict][pair.id].append((start, end))

    def _findings_of(self, pair: PairKey) -> _PairFindings:
        findings = self._findings.get(pair.id)
        if findings is None:
            findings = self._findings[pair.id] = _PairFindings(pair)
        return findings

    def summary(self) -> Summary:
        """Return the summary of the events so far, its pairs by `pair_id`.

        A log of another writer may name more pairs than it says there are: then those that it names are all.
        """
        pairs = [self._pair_summary(findings) for _, findings in sorted(self._findings.items())]
        total = max(self._subject.pairs_total, len(pairs))
        return {
            "closecall": __version__,
            "time": list(self._subject.time),
            "settings": self._subject.settings,
            "pairs_total": total,
            "pairs_ignored": self._subject.pairs_ignored,
            "pairs": pairs,
            "totals": self._totals(pairs, total),
        }

    def _pair_summary(self, findings: _PairFindings) -> PairSummary:
        key = findings.key
        body_a, body_b = self._subject.name(key.a), self._subject.name(key.b)
        spans = {verdict: self._spans_of(key, verdict) for verdict in self._spans}
        verdicts = frozenset(verdict.name.lower() for verdict, times in spans.items() if times)
        chord_error = self._subject.chord_error(key.a) + self._subject.chord_error(key.b)
        return {
            "pair": f"{body_a}|{body_b}",
            "body_a": body_a,
            "body_b": body_b,
            "verdict": findings.verdict(),
            "margin": self._subject.margin(key.a, key.b),
            "distance": findings.distance(self._subject.settings.get("distance_tolerance"), verdicts, chord_error),
            "error": findings.error,
            "chord_error": chord_error,
            "contacts": self._contacts(key),
            "breaches": _as_one(spans[Verdict.BREACH], spans[Verdict.UNRESOLVED], self._subject.settings),
            "unresolved": spans[Verdict.UNRESOLVED],
            "possible": spans[Verdict.POSSIBLE],
            "wakeups": sum(findings.queries),
            "queries": {level.name.lower(): count for level, count in zip(LEVELS, findings.queries, strict=True)},
        }

    def _spans_of(self, key: PairKey, verdict: Verdict) -> list[list[float]]:
        return [list(span) for span in sorted(self._spans[verdict].get(key.id, ()))]

    def _contacts(self, key: PairKey) -> list[Contact]:
        brackets = self._brackets.get(key.id)
        if brackets is None:
            return []
        return [{"begin": begin, "end": end, "keys": self._keys(key, begin[1])} for begin, end in brackets.pairs()]

    def _keys(self, key: PairKey, time: float) -> dict[str, list[str]]:
        """Return the keys around a time (s), for those bodies of a pair that have any."""
        around = {self._subject.name(body): list(self._keys_around(body, time)) for body in (key.a, key.b)}
        return {name: keys for name, keys in around.items() if any(keys)}

    def _totals(self, pairs: list[PairSummary], total: int) -> Totals:
        verdicts = {verdict.name.lower(): 0 for verdict in SEVERITY}
        verdicts["clear"] = total - len(pairs)
        for pair in pairs:
            verdicts[pair["verdict"]] += 1
        levels = [level.name.lower() for level in LEVELS]
        return {
            "pairs": verdicts,
            "contacts": sum(len(pair["contacts"]) for pair in pairs),
            "wakeups": sum(pair["wakeups"] for pair in pairs),
            "queries": {level: sum(pair["queries"][level] for pair in pairs) for level in levels},
        }


def _as_one(
    breaches: list[list[float]], unresolved: list[list[float]], settings: Mapping[str, float | None]
) -> list[list[float]]:
    """Return the breaches, with those as one that nothing parts but an unresolved time within the time resolution."""
    resolution = settings.get("time_resolution") or 0.0
    slivers = {(low, high) for low, high in unresolved if high - low <= resolution}
    joined: list[list[float]] = []
    for low, high in breaches:
        if joined and (joined[-1][1], low) in slivers:
            joined[-1] = [joined[-1][0], high]
        else:
            joined.append([low, high])
    return joined


def to_json(summary: Summary) -> str:
    """Return the summary as one line of JSON; NaN and Infinity are refused."""
    return json.dumps(summary, ensure_ascii=False, allow_nan=False) + "\n"
