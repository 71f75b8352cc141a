"""The summary of a run: what `summary --json` prints and every log carries as `summary.json`."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from itertools import zip_longest
from math import inf, isfinite
from typing import TypedDict

from closecall import __version__

from ...scheduler.counting import count_pairs
from ...scheduler.events import (
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
from ...scheduler.scene import Scene, Settings

# From worst to best; a pair's verdict is the worst of its spans'.
SEVERITY = (Verdict.CONTACT, Verdict.BREACH, Verdict.UNRESOLVED, Verdict.POSSIBLE, Verdict.CLEAR)
_RANKS = {verdict: rank for rank, verdict in enumerate(SEVERITY)}

# What answers a wakeup, from coarse to exact.
LEVELS = (Level.SPHERE, Level.HULL, Level.MESH)
_LEVEL_RANKS = {level: rank for rank, level in enumerate(LEVELS)}


class DistanceRange(TypedDict):
    """A pair's least distance over the run, m: certified not below `lower`; `upper` measured at `time`, s."""

    lower: float
    upper: float | None
    time: float | None


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
    Round bodies are measured as polyhedra that enclose them:
    `chord_error`, m, is how much farther apart the bodies themselves may be; `upper` includes it.
    """

    pair: str
    body_a: str
    body_b: str
    verdict: str
    margin: float
    distance: DistanceRange
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
    queries: list[int] = field(default_factory=lambda: [0] * len(LEVELS))

    def add_distance(self, event: Distance) -> None:
        self.upper, self.upper_time = min((self.upper, self.upper_time), (event.distance, event.time))

    def add_span(self, event: Span) -> None:
        self.rank = min(self.rank, _RANKS[event.verdict])
        certified = event.verdict is not Verdict.CONTACT and event.clearance > 0  # no for NaN
        self.lower = min(self.lower, event.clearance if certified else 0.0)

    def verdict(self) -> str:
        """Return the worst verdict; nothing is proved of a pair without spans."""
        verdict = SEVERITY[self.rank] if self.rank < len(SEVERITY) else Verdict.UNRESOLVED
        return verdict.name.lower()

    def distance(self, chord_error: float) -> DistanceRange:
        """Return the least distance; 0, which errs low, is the bound where no span gives a better."""
        lower = self.lower if isfinite(self.lower) else 0.0
        if not isfinite(self.upper):
            return {"lower": lower, "upper": None, "time": None}
        return {"lower": lower, "upper": self.upper + chord_error, "time": self.upper_time}


@dataclass(slots=True)
class _Brackets:
    """A pair's contacts so far: begins as (clear, touching), ends as (touching, clear)."""

    begins: list[tuple[float, float]] = field(default_factory=list)
    ends: list[tuple[float, float]] = field(default_factory=list)

    def add(self, event: Collision) -> None:
        if event.phase is Phase.BEGIN:
            self.begins.append((event.time_clear, event.time_touching))
        else:
            self.ends.append((event.time_touching, event.time_clear))

    def pairs(self) -> list[tuple[list[float], list[float] | None]]:
        """Return each contact's begin and end in time order, in whatever order they were found: both alternate."""
        ends = (list(end) for end in sorted(self.ends))
        begins = (list(begin) for begin in sorted(self.begins, key=lambda bracket: bracket[1]))
        return [(begin, end) for begin, end in zip_longest(begins, ends) if begin is not None]


class SummaryBuilder:
    """Folds a run's events into its summary. Memory grows with pairs, contacts and unresolved spans alone.

    Args:
        scene: for the names of the bodies and the time range.
        settings: as resolved for this run.
        pairs_total: how many pairs the rules let be checked, with those that the broad phase clears.
        keys_around: the named keys that a body is between at a time (s), empty for none.
    """

    def __init__(
        self,
        scene: Scene,
        settings: Settings,
        pairs_total: int,
        keys_around: Callable[[int, float], tuple[str, str]] = lambda body, time: ("", ""),
    ) -> None:
        self._scene = scene
        self._names = tuple(body.name for body in scene.bodies)
        self._chord_errors = tuple(body.chord_error for body in scene.bodies)
        self._keys_around = keys_around
        self._time = (scene.start, scene.end)
        self._settings = settings
        self._pairs_total = pairs_total
        self._pairs_ignored = count_pairs(scene).ignored
        self._findings: dict[int, _PairFindings] = {}
        self._brackets: defaultdict[int, _Brackets] = defaultdict(_Brackets)
        self._breaches: defaultdict[int, list[tuple[float, float]]] = defaultdict(list)
        self._unresolved: defaultdict[int, list[tuple[float, float]]] = defaultdict(list)
        self._possible: defaultdict[int, list[tuple[float, float]]] = defaultdict(list)

    def add(self, event: Event) -> None:
        """Fold one more event, in any order; windows, and snapshots, which prove nothing, are passed over."""
        if isinstance(event, Window | Snapshot):
            return
        pair = event.pair
        findings = self._findings.get(pair.id)
        if findings is None:
            findings = self._findings[pair.id] = _PairFindings(pair)
        match event:
            case Wakeup():
                findings.queries[_LEVEL_RANKS[event.level]] += 1
            case Distance():
                findings.add_distance(event)
            case Collision():
                findings.rank = _RANKS[Verdict.CONTACT]
                self._brackets[pair.id].add(event)
            case Span():
                findings.add_span(event)
                if event.verdict is Verdict.UNRESOLVED:
                    self._unresolved[pair.id].append((event.start, event.end))
                elif event.verdict is Verdict.BREACH:
                    self._breaches[pair.id].append((event.start, event.end))
                elif event.verdict is Verdict.POSSIBLE:
                    self._possible[pair.id].append((event.start, event.end))

    def summary(self) -> Summary:
        """Return the summary of the events so far, its pairs by `pair_id`."""
        pairs = [self._pair_summary(findings) for _, findings in sorted(self._findings.items())]
        return {
            "closecall": __version__,
            "time": list(self._time),
            "settings": asdict(self._settings),
            "pairs_total": self._pairs_total,
            "pairs_ignored": self._pairs_ignored,
            "pairs": pairs,
            "totals": self._totals(pairs),
        }

    def _pair_summary(self, findings: _PairFindings) -> PairSummary:
        key = findings.key
        body_a, body_b = self._names[key.a], self._names[key.b]
        chord_error = self._chord_errors[key.a] + self._chord_errors[key.b]
        return {
            "pair": f"{body_a}|{body_b}",
            "body_a": body_a,
            "body_b": body_b,
            "verdict": findings.verdict(),
            "margin": self._scene.rules.margin(key.a, key.b, self._settings.margin),
            "distance": findings.distance(chord_error),
            "chord_error": chord_error,
            "contacts": self._contacts(key),
            "breaches": [list(span) for span in sorted(self._breaches.get(key.id, ()))],
            "unresolved": [list(span) for span in sorted(self._unresolved.get(key.id, ()))],
            "possible": [list(span) for span in sorted(self._possible.get(key.id, ()))],
            "wakeups": sum(findings.queries),
            "queries": {level.name.lower(): count for level, count in zip(LEVELS, findings.queries, strict=True)},
        }

    def _contacts(self, key: PairKey) -> list[Contact]:
        brackets = self._brackets.get(key.id)
        if brackets is None:
            return []
        return [{"begin": begin, "end": end, "keys": self._keys(key, begin[1])} for begin, end in brackets.pairs()]

    def _keys(self, key: PairKey, time: float) -> dict[str, list[str]]:
        """Return the keys around a time (s), for those bodies of a pair that have any."""
        around = {self._names[body]: list(self._keys_around(body, time)) for body in (key.a, key.b)}
        return {name: keys for name, keys in around.items() if any(keys)}

    def _totals(self, pairs: list[PairSummary]) -> Totals:
        verdicts = {verdict.name.lower(): 0 for verdict in SEVERITY}
        verdicts["clear"] = self._pairs_total - len(pairs)
        for pair in pairs:
            verdicts[pair["verdict"]] += 1
        levels = [level.name.lower() for level in LEVELS]
        return {
            "pairs": verdicts,
            "contacts": sum(len(pair["contacts"]) for pair in pairs),
            "wakeups": sum(pair["wakeups"] for pair in pairs),
            "queries": {level: sum(pair["queries"][level] for pair in pairs) for level in levels},
        }


def to_json(summary: Summary) -> str:
    """Return the summary as one line of JSON; NaN and Infinity are refused."""
    return json.dumps(summary, ensure_ascii=False, allow_nan=False) + "\n"
