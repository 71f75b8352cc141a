"""What two logs may differ in, what is passed over, and how differences are ranked."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum
from fnmatch import fnmatchcase
from math import inf, isnan

from ..message_filter import is_pair_among
from ..reader import Loss

Value = float | str | None


class Cause(Enum):
    """Why two logs differ, from what matters most; the value names it, the topic is where it shows."""

    VERDICT = ("verdict changed", "/spans")
    CONTACT_APPEARED = ("contact appeared", "/collisions")
    CONTACT_VANISHED = ("contact vanished", "/collisions")
    PAIR_REMOVED = ("pair removed", "")
    PAIR_ADDED = ("pair added", "")
    PAIRS = ("pairs checked", "")
    MARGIN = ("margin changed", "")
    BEGIN = ("contact begin moved", "/collisions")
    END = ("contact end moved", "/collisions")
    MINIMUM_FELL = ("minimum fell", "/distances")
    MINIMUM_ROSE = ("minimum rose", "/distances")
    BREACH_APPEARED = ("breach appeared", "/spans")
    BREACH_VANISHED = ("breach vanished", "/spans")
    BREACH_MOVED = ("breach moved", "/spans")
    UNRESOLVED = ("unresolved time changed", "/spans")
    POSSIBLE = ("possible time changed", "/spans")
    MISSING = ("messages missing", "")
    EXTRA = ("messages added", "")
    FIELD = ("field changed", "")

    def __init__(self, label: str, topic: str) -> None:
        self.label = label
        self.topic = topic


_RANKS = {cause: rank for rank, cause in enumerate(Cause)}


@dataclass(frozen=True, slots=True)
class Difference:
    """One thing in which the new log differs from the golden one.

    Attributes:
        subject: the pair, "a|b"; or the topic, with the field; empty for the whole run.
        golden, new: what each log says; None where it says nothing.
        change: new less golden, or how much appeared or vanished, in `unit`; NaN where there is no number.
        unit: "s", "m", or empty.
        time: s, when it shows first; None where that is no question of time.
        proved: whether what the logs certify cannot both be true of one scene.
        keys: by body, the named keys that it is between then.
        count: how many messages differ so.
    """

    cause: Cause
    subject: str
    golden: Value
    new: Value
    change: float
    unit: str
    time: float | None
    proved: bool = True
    keys: dict[str, list[str]] = field(default_factory=dict)
    count: int = 1

    @property
    def size(self) -> float:
        """How large it is among others of its cause."""
        return 0.0 if isnan(self.change) else abs(self.change)


@dataclass(frozen=True, slots=True)
class Tolerances:
    """How far apart numbers may lie that are called equal: absolute (s, m), and a share of the golden number."""

    time: float = 1e-6
    distance: float = 1e-6
    time_share: float = 0.0
    distance_share: float = 0.0

    def times(self, golden: float) -> float:
        """Return by how much a time may differ from the golden one, s."""
        return self.time + self.time_share * abs(golden)

    def distances(self, golden: float) -> float:
        """Return by how much a distance may differ from the golden one, m."""
        return self.distance + self.distance_share * abs(golden)


@dataclass(frozen=True, slots=True)
class Ignored:
    """What is left out of a comparison.

    Attributes:
        patterns: globs of topics ("/viz/*"), of their fields ("/wakeups.sleep"), of pairs ("arm|*", either body first),
            or of bodies ("tool*": every pair with such a body).
    """

    patterns: tuple[str, ...] = ()

    def topic(self, topic: str) -> bool:
        """Tell whether a topic is left out."""
        return any(fnmatchcase(topic, pattern) for pattern in self.patterns if pattern.startswith("/"))

    def field(self, topic: str, name: str) -> bool:
        """Tell whether a topic's field is left out."""
        return self.topic(f"{topic}.{name}")

    def pair(self, pair: str) -> bool:
        """Tell whether a pair, "a|b", is left out."""
        return is_pair_among(pair, (pattern for pattern in self.patterns if not pattern.startswith("/")))


@dataclass(frozen=True, slots=True)
class Comparison:
    """What comparing two logs gave.

    Attributes:
        differences: in the order of the golden log's pairs.
        pairs: the pairs compared, "a|b".
        notes: what a reviewer should know, and is no difference.
        losses: what could not be read of either log.
        length_unit: of the golden log's scene, for texts that people read.
    """

    differences: tuple[Difference, ...]
    pairs: tuple[str, ...]
    notes: tuple[str, ...] = ()
    losses: tuple[Loss, ...] = ()
    length_unit: str = "m"

    @property
    def first(self) -> Difference | None:
        """The difference that shows first in time; None if there is none."""
        return min(
            self.differences,
            key=lambda one: (inf if one.time is None else one.time, _RANKS[one.cause]),
            default=None,
        )

    def by_cause(self) -> dict[Cause, int]:
        """Return how many differences have each cause, causes that matter most first."""
        counts = Counter(one.cause for one in self.differences)
        return {cause: counts[cause] for cause in Cause if counts[cause]}

    def largest(self, most: int) -> list[Difference]:
        """Return the largest differences, by cause: each cause has its turn before another has its second."""
        turns = Counter[Cause]()
        ranked: list[tuple[int, int, Difference]] = []
        for one in by_size(self.differences):
            ranked.append((turns[one.cause], _RANKS[one.cause], one))
            turns[one.cause] += 1
        chosen = sorted(ranked, key=lambda entry: entry[:2])[:most]
        return [one for _, _, one in sorted(chosen, key=lambda entry: (entry[1], entry[0]))]


def by_size(differences: Iterable[Difference]) -> list[Difference]:
    """Return differences with those that matter most first, of one cause the largest, of one size the earliest."""

    def rank(one: Difference) -> tuple[int, float, int, float, str]:
        time = inf if one.time is None else one.time
        return _RANKS[one.cause], -float(f"{one.size:.3g}"), -one.count, time, one.subject

    return sorted(differences, key=rank)
