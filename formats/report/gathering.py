"""A log read once into what its page shows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import Any

from foxglove_schemas_protobuf.Log_pb2 import Log

from ..log import messages_pb2 as pb
from ..log.container.identity import Identity
from ..log.reader import LogReader, Loss
from ..log.result import Found, read_found
from ..log.severity import badness
from ..log.summary import PairSummary
from .replay import Replay, ReplayBuilder
from .tracks import Curve, Tracks

# Pairs in a page; the worst are kept.
MOST_PAIRS = 20_000

_TOPICS = (
    "/wakeups",
    "/distances",
    "/collisions",
    "/spans",
    "/tf",
    "/scene/meshes",
    "/scene/boxes",
    "/viz/clearance",
    "/log",
)

# Warnings in a page.
_MOST_WARNINGS = 20

_Point = tuple[float, float, float]


@dataclass(slots=True)
class Awakening:
    """How often pairs woke: by reason, with what measured them then; by the bound that sent them to sleep again."""

    reasons: Counter[tuple[str, str]] = field(default_factory=Counter)
    bounds: Counter[str] = field(default_factory=Counter)


@dataclass(frozen=True, slots=True)
class Touch:
    """One end of a contact: s, its kind, and a point of both bodies, m."""

    time: float
    kind: str
    point: _Point


@dataclass(frozen=True, slots=True)
class Gathered:
    """What a page shows.

    Attributes:
        name: of the log's file.
        identity: what the log says of its run.
        found: the summary, and what is lost.
        loss: what could not be read.
        pairs: of the summary, worst first, as many as a page shows.
        curves: of the same pairs.
        reasons: of each pair, how often it woke for each reason, by the reason's number.
        witnesses: by pair, the two witness points where it was measured nearest, m.
        touches: by pair, the begins of its contacts.
        awakening: of all pairs.
        messages: how many were read, by topic.
        warnings: of the run.
        replay: the bodies and how they move; None where the log shows none.
    """

    name: str
    identity: Identity
    found: Found
    loss: Loss | None
    pairs: list[PairSummary]
    curves: list[Curve]
    reasons: list[dict[int, int]]
    witnesses: Mapping[int, tuple[_Point, _Point]]
    touches: Mapping[int, list[Touch]]
    awakening: Awakening
    messages: Counter[str]
    warnings: list[str]
    replay: Replay | None


def gather(path: Path) -> Gathered:
    """Read a log as far as it can be read.

    Raises:
        LogError: for a file that is missing, or not a log of closecall.
        DamagedLogError: where nothing can be read.
    """
    found = read_found(path)
    pairs = sorted(found.summary["pairs"], key=badness)[:MOST_PAIRS]
    with LogReader(path) as log:
        gathering = _Gathering(log.identity, pairs)
        for source, log_time, message in log.facts(*_TOPICS):
            gathering.add(source.topic, message, log.identity.seconds(log_time))
        return Gathered(
            name=path.name,
            identity=log.identity,
            found=found,
            loss=log.loss,
            pairs=pairs,
            curves=list(gathering.tracks.curves()),
            reasons=[dict(counts) for counts in gathering.reasons],
            witnesses=gathering.witnesses,
            touches=gathering.touches,
            awakening=gathering.awakening,
            messages=gathering.messages,
            warnings=gathering.warnings,
            replay=gathering.replay.finish(),
        )


class _Gathering:
    """Messages on their way into a page."""

    def __init__(self, identity: Identity, pairs: list[PairSummary]) -> None:
        self.tracks = Tracks(len(pairs), identity.start, identity.end)
        self.reasons: list[Counter[int]] = [Counter() for _ in pairs]
        self.witnesses: dict[int, tuple[_Point, _Point]] = {}
        self.touches: dict[int, list[Touch]] = {}
        self.awakening = Awakening()
        self.messages: Counter[str] = Counter()
        self.warnings: list[str] = []
        index = {pair["pair"]: row for row, pair in enumerate(pairs)}
        self.replay = ReplayBuilder(index, identity.end)
        self._index = index
        self._rows: dict[int, int | None] = {}
        self._least: dict[int, float] = {}

    def add(self, topic: str, message: Any, time: float) -> None:
        """Take in one message of a time, s."""
        self.messages[topic] += 1
        match message:
            case pb.Wakeup():
                self._add_wakeup(message, time)
            case pb.Distance():
                self._add_distance(message, time)
            case pb.Span():
                self._add_span(message)
            case pb.Collision():
                self._add_collision(message)
            case Log():
                if message.level == Log.WARNING and len(self.warnings) < _MOST_WARNINGS:
                    self.warnings.append(message.message)
            case _:
                self.replay.add(topic, message, time)

    def _add_wakeup(self, message: pb.Wakeup, time: float) -> None:
        reason = pb.Wakeup.Reason.Value.Name(message.reason)
        level = pb.Wakeup.Level.Value.Name(message.level)
        self.awakening.reasons[reason, level] += 1
        self.awakening.bounds[message.bound] += 1
        row = self._row(message)
        if row is None:
            return
        self.reasons[row][message.reason] += 1
        if message.level != pb.Wakeup.Level.MESH and message.clearance > 0.0:
            self.tracks.add_bound(row, time, message.clearance)

    def _add_distance(self, message: pb.Distance, time: float) -> None:
        row = self._row(message)
        if row is None or not isfinite(message.distance):
            return
        self.tracks.add_measured(row, time, message.distance)
        if message.distance < self._least.get(row, float("inf")):
            self._least[row] = message.distance
            self.witnesses[row] = _point(message.witness_a), _point(message.witness_b)

    def _add_span(self, message: pb.Span) -> None:
        row = self._row(message)
        if row is not None:
            self.tracks.add_span(row, (message.start, message.end, message.verdict, _bound(message.clearance)))

    def _add_collision(self, message: pb.Collision) -> None:
        row = self._row(message)
        if row is not None and message.phase == pb.Collision.Phase.BEGIN:
            kind = pb.Collision.Kind.Value.Name(message.kind).lower()
            touch = Touch(message.time_touching, kind, _point(message.point))
            self.touches.setdefault(row, []).append(touch)

    def _row(self, message: pb.Wakeup | pb.Distance | pb.Span | pb.Collision) -> int | None:
        """Return a message's pair as its place in the page, None where it has none."""
        pair: int = message.pair_id
        if pair not in self._rows:
            self._rows[pair] = self._index.get(message.pair)
        return self._rows[pair]


def _bound(clearance: float) -> float:
    """Return a certified clearance, 0 where there is none."""
    return clearance if clearance > 0.0 else 0.0  # no for NaN


def _point(point: pb.Point) -> _Point:
    return point.x, point.y, point.z
