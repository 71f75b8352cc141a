"""Events of the scheduler as messages: every field set anew, for the messages are used again and again."""

from __future__ import annotations

from collections.abc import Mapping

from ...scheduler.model.events import (
    Collision,
    ContactKind,
    Distance,
    Feature,
    FeatureKind,
    Level,
    PairKey,
    Phase,
    Point,
    Reason,
    Span,
    Verdict,
    Wakeup,
    Window,
)
from ..scene.loaded import KeyNames
from . import messages_pb2 as pb

# By name, so that neither side's numbers bind the other's.
_REASONS = {reason: getattr(pb.Wakeup.Reason, reason.name) for reason in Reason}
_LEVELS = {level: getattr(pb.Wakeup.Level, level.name) for level in Level}
_FEATURES = {kind: getattr(pb.Feature, kind.name) for kind in FeatureKind}
_PHASES = {phase: getattr(pb.Collision.Phase, phase.name) for phase in Phase}
_CONTACTS = {kind: getattr(pb.Collision.Kind, kind.name) for kind in ContactKind}
_VERDICTS = {verdict: getattr(pb.Span, verdict.name) for verdict in Verdict}


class FactFiller:
    """Fills messages with facts, of bodies by these names (in document order). Timestamps are left alone.

    Args:
        names: of the bodies.
        keys: the named keys that bodies move by.
    """

    def __init__(self, names: tuple[str, ...], keys: Mapping[int, KeyNames]) -> None:
        self._names = names
        self._keys = keys

    def pair_name(self, pair: PairKey) -> str:
        """Return "a|b"."""
        return f"{self._names[pair.a]}|{self._names[pair.b]}"

    def fill_wakeup(self, message: pb.Wakeup, event: Wakeup) -> None:
        """Say that a pair woke."""
        self._fill_pair(message, event.pair)
        message.reason = _REASONS[event.reason]
        message.level = _LEVELS[event.level]
        message.bound = event.bound.value
        message.clearance = event.clearance
        message.sleep = event.sleep

    def fill_distance(self, message: pb.Distance, event: Distance) -> None:
        """Say what distance was measured, and where."""
        self._fill_pair(message, event.pair)
        message.distance = event.distance
        _fill_point(message.witness_a, event.witness_a)
        _fill_point(message.witness_b, event.witness_b)
        _fill_feature(message.feature_a, event.feature_a)
        _fill_feature(message.feature_b, event.feature_b)
        message.excess = event.excess

    def fill_collision(self, message: pb.Collision, event: Collision) -> None:
        """Say that a contact begins or ends."""
        self._fill_pair(message, event.pair)
        message.phase = _PHASES[event.phase]
        message.time_clear = event.time_clear
        message.time_touching = event.time_touching
        message.kind = _CONTACTS[event.kind]
        message.triangle_a = event.feature_a.triangle
        message.triangle_b = event.feature_b.triangle
        message.shape_a = event.feature_a.shape
        message.shape_b = event.feature_b.shape
        _fill_point(message.point, event.point)
        message.key_before_a, message.key_after_a = self.keys_around(event.pair.a, event.time)
        message.key_before_b, message.key_after_b = self.keys_around(event.pair.b, event.time)

    def keys_around(self, body: int, time: float) -> tuple[str, str]:
        """Return the named keys that a body is between at a time (s), empty for none."""
        names = self._keys.get(body)
        return ("", "") if names is None else names.around(time)

    def fill_span(self, message: pb.Span, event: Span) -> None:
        """Say what is proved of a pair over an interval."""
        self._fill_pair(message, event.pair)
        message.verdict = _VERDICTS[event.verdict]
        message.start = event.start
        message.end = event.end
        message.clearance = event.clearance
        message.depth_limit = event.depth_limit
        message.error = event.error

    def fill_window(self, message: pb.Window, event: Window) -> None:
        """Say what box a body does not leave over an interval."""
        message.body = self._names[event.body]
        message.start = event.start
        message.end = event.end
        _fill_point(message.box_min, event.low)
        _fill_point(message.box_max, event.high)

    def _fill_pair(self, message: pb.Wakeup | pb.Distance | pb.Collision | pb.Span, pair: PairKey) -> None:
        body_a, body_b = self._names[pair.a], self._names[pair.b]
        message.pair = f"{body_a}|{body_b}"
        message.pair_id = pair.id
        message.body_a = body_a
        message.body_b = body_b


def _fill_point(message: pb.Point, point: Point) -> None:
    message.x, message.y, message.z = point


def _fill_feature(message: pb.Feature, feature: Feature) -> None:
    message.kind = _FEATURES[feature.kind]
    message.shape = feature.shape
    message.triangle = feature.triangle
    message.index = feature.index
