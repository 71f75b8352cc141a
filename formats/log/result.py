"""What a log found: by the summary that it carries, or, where that is lost, by folding its facts again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import nan
from pathlib import Path

from ...scheduler.model.events import Level, PairKey, Phase, Verdict
from ...scheduler.model.scene import bodies_of_pair
from . import messages_pb2 as pb
from .carried import OlderSummaryError, SummaryError, as_summary, require_same_run
from .container.attachments import NAME_A_LOG, read_attachment
from .container.contents import SUMMARY
from .container.identity import Identity
from .errors import LogError
from .reader import LogReader, Loss
from .summary import Subject, Summary, SummaryBuilder

FINDINGS = ("/distances", "/collisions", "/spans")
FACTS = ("/wakeups", *FINDINGS)

# By name, so that neither side's numbers bind the other's.
_LEVELS = {getattr(pb.Wakeup.Level, level.name): level for level in Level}
_PHASES = {getattr(pb.Collision.Phase, phase.name): phase for phase in Phase}
_VERDICTS = {getattr(pb.Span, verdict.name): verdict for verdict in Verdict}

_Fact = pb.Wakeup | pb.Distance | pb.Collision | pb.Span

Stretches = list[tuple[float, float]]
"""Intervals of time, s."""


@dataclass(frozen=True, slots=True)
class Found:
    """What a log found.

    Attributes:
        summary: of what could be read. Where a pair's spans are lost, nothing is proved: the pair is unresolved there.
        loss: what could not be read.
        lost: by the pair's name, when (s) its spans are lost; pairs of which nothing was read are counted as
            unresolved, not listed.
        length_unit: of the scene, for texts that people read.
        folded: whether the summary was made of the facts that could be read, and is not the one that the log carries.
    """

    summary: Summary
    loss: Loss | None = None
    lost: dict[str, Stretches] = field(default_factory=dict)
    length_unit: str = "m"
    folded: bool = False


def read_summary(path: Path) -> Summary:
    """Return the summary that a finished log carries, found by the log's index.

    Raises:
        LogError: for a file that is missing, unfinished, damaged, or not a log of closecall.
    """
    try:
        return as_summary(read_attachment(path, SUMMARY))
    except SummaryError as error:
        raise LogError(path, f"is an MCAP file, but its {SUMMARY} is not closecall's: {error}", NAME_A_LOG) from error


def read_found(path: Path) -> Found:
    """Return what a log found, however much of it there is.

    Raises:
        LogError: for a file that is missing, or not a log of closecall.
        DamagedLogError: where nothing can be read.
    """
    with LogReader(path) as log:
        try:
            summary = read_summary(path)
            require_same_run(summary, log.identity)
            return Found(summary, length_unit=log.identity.length_unit)
        except (LogError, SummaryError):
            found = fold(path)
        try:
            for carried in log.attachments(SUMMARY):
                summary = as_summary(carried.data)
                require_same_run(summary, log.identity)
                return Found(summary, found.loss, length_unit=found.length_unit)
        except OlderSummaryError:
            return found
        except SummaryError as error:
            log.doubt(f"its {SUMMARY} is not closecall's: {error}")
        return replace(found, loss=found.loss or log.loss)


def fold(path: Path, topics: Sequence[str] = FACTS) -> Found:
    """Return what a log found by its facts alone, without the summary that it carries.

    Args:
        topics: of the facts; without `/wakeups` none are counted.

    Raises:
        LogError: as `read_found`.
    """
    with LogReader(path) as log:
        folding = Folding(log.identity)
        for _, log_time, message in log.facts(*topics):
            folding.add(message, log.identity.seconds(log_time))
        return folding.found(log.loss)


class Folding:
    """A log's messages on their way into a summary."""

    def __init__(self, identity: Identity) -> None:
        self._identity = identity
        self._names: dict[int, str] = {}
        self._pairs: dict[int, PairKey] = {}
        self._keys: dict[tuple[int, float], tuple[str, str]] = {}
        self._covered: dict[int, Stretches] = {}
        subject = Subject(
            name=self._names.__getitem__,
            time=(identity.start, identity.end),
            settings=identity.settings,
            pairs_total=identity.pairs_total,
            pairs_ignored=identity.pairs_ignored,
            chord_error=lambda body: identity.chord_errors.get(self._names[body], 0.0),
            margin=lambda a, b: identity.margin(self._names[a], self._names[b]),
        )
        self._builder = SummaryBuilder(subject, lambda body, time: self._keys.get((body, time), ("", "")))

    def add(self, message: _Fact, time: float) -> None:
        """Fold one message of a time, s."""
        pair = self._pairs.get(message.pair_id) or self._new_pair(message)
        match message:
            case pb.Wakeup():
                self._builder.add_wakeup(pair, _LEVELS[message.level])
            case pb.Distance():
                self._builder.add_distance(pair, message.distance, message.excess, time)
            case pb.Collision():
                self._builder.add_collision(pair, _PHASES[message.phase], message.time_clear, message.time_touching)
                self._keys[pair.a, message.time_touching] = message.key_before_a, message.key_after_a
                self._keys[pair.b, message.time_touching] = message.key_before_b, message.key_after_b
            case pb.Span():
                verdict = _VERDICTS[message.verdict]
                self._builder.add_span(pair, verdict, message.start, message.end, message.clearance, message.error)
                _cover(self._covered.setdefault(pair.id, []), message.start, message.end)

    def found(self, loss: Loss | None) -> Found:
        """Return what was folded, with the time without spans as unresolved."""
        lost: dict[str, Stretches] = {}
        for pair in self._pairs.values():
            body_a, body_b = self._names[pair.a], self._names[pair.b]
            gaps = _gaps(self._covered.get(pair.id, []), *self._identity.shared_time(body_a, body_b))
            for start, end in gaps:
                self._builder.add_span(pair, Verdict.UNRESOLVED, start, end, nan)
            if gaps and loss is not None:
                lost[f"{body_a}|{body_b}"] = gaps
        summary = self._builder.summary()
        if loss is not None:
            verdicts = summary["totals"]["pairs"]
            unseen = max(0, summary["pairs_total"] - len(summary["pairs"]))
            verdicts["clear"] -= unseen
            verdicts["unresolved"] += unseen
        return Found(summary, loss, lost, self._identity.length_unit, folded=True)

    def _new_pair(self, message: _Fact) -> PairKey:
        a, b = bodies_of_pair(message.pair_id, self._identity.bodies)
        self._names[a], self._names[b] = message.body_a, message.body_b
        pair = self._pairs[message.pair_id] = PairKey(message.pair_id, a, b)
        return pair


def _cover(covered: Stretches, start: float, end: float) -> None:
    """Add a span to those of its pair, joined with the last where it follows that."""
    if covered and covered[-1][1] == start:
        covered[-1] = (covered[-1][0], end)
    else:
        covered.append((start, end))


def _gaps(covered: Stretches, start: float, end: float) -> Stretches:
    """Return what spans leave open of an interval."""
    gaps: Stretches = []
    for low, high in sorted(covered):
        if low > start:
            gaps.append((start, low))
        start = max(start, high)
    return [*gaps, (start, end)] if start < end else gaps
