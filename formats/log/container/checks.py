"""What a log's messages may say. The reader checks each of them once: all behind it may trust them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import inf, isnan
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.message import Message

from ....scheduler.model.scene import bodies_of_pair
from ...scene.text.errors import quoted
from .. import messages_pb2 as pb
from .clock import LATEST_LOG_TIME_NS, NANOSECONDS_PER_SECOND

MOST_METRES = 1e31
"""Of a coordinate or a distance: ten times what any scene may hold. Beyond it squares near the end of float64."""

MOST_SECONDS = LATEST_LOG_TIME_NS / NANOSECONDS_PER_SECOND
"""Of a time, before or after 0: what the 63 bits of a log time leave to scene seconds, with whatever epoch."""

_UNIT = 1e-3
"""How far the length of a quaternion may be from 1."""

TYPES: dict[str, type[Message]] = {
    "/wakeups": pb.Wakeup,
    "/distances": pb.Distance,
    "/collisions": pb.Collision,
    "/spans": pb.Span,
    "/windows": pb.Window,
    "/world": pb.World,
    "/tf": FrameTransforms,
    "/scene/meshes": SceneUpdate,
    "/scene/boxes": SceneUpdate,
    "/viz/clearance": SceneUpdate,
    "/viz/contacts": SceneUpdate,
    "/viz/names": SceneUpdate,
    "/log": Log,
}
"""Of the messages of each topic that closecall writes; distances may have one for each body, its name behind."""

_REASONS = frozenset(pb.Wakeup.Reason.Value.values()) - {pb.Wakeup.Reason.UNKNOWN}
_LEVELS = frozenset(pb.Wakeup.Level.Value.values()) - {pb.Wakeup.Level.UNKNOWN}
_PHASES = frozenset(pb.Collision.Phase.Value.values()) - {pb.Collision.Phase.UNKNOWN}
_KINDS = frozenset(pb.Collision.Kind.Value.values()) - {pb.Collision.Kind.UNKNOWN}
_VERDICTS = frozenset(pb.Span.Verdict.values()) - {pb.Span.UNKNOWN}

_Paired = pb.Wakeup | pb.Distance | pb.Collision | pb.Span


class FactError(ValueError):
    """A message that says what cannot be."""


class FactChecks:
    """The checks of one pass over a log: every number in its range, every pair the same throughout.

    Args:
        bodies: how many the log says there are.
    """

    def __init__(self, bodies: int) -> None:
        self._bodies = bodies
        self._pairs: dict[int, tuple[str, str, str]] = {}
        self._names: dict[int, str] = {}
        self._indices: dict[str, int] = {}

    def require(self, message: Any, log_time: int) -> None:
        """Check a message of one of `TYPES`.

        Raises:
            FactError: for one that says what cannot be.
        """
        if log_time > LATEST_LOG_TIME_NS:
            raise FactError(f"its log time is {log_time}")
        match message:
            case pb.Wakeup():
                self._pair(message)
                _length("clearance", message.clearance)
                _among("reason", message.reason, _REASONS)
                _among("level", message.level, _LEVELS)
                if not 0.0 <= message.sleep <= 2.0 * MOST_SECONDS:
                    raise FactError(f"sleep is {message.sleep!r}")
            case pb.Distance():
                self._pair(message)
                _length("distance", message.distance)
                _length("excess", message.excess)
                _place("witness_a", message.witness_a)
                _place("witness_b", message.witness_b)
            case pb.Collision():
                self._pair(message)
                self._collision(message)
            case pb.Span():
                self._pair(message)
                _among("verdict", message.verdict, _VERDICTS)
                _interval(message.start, message.end)
                _length("clearance", message.clearance)
                if not isnan(message.depth_limit):
                    _length("depth_limit", message.depth_limit)
                if message.error != inf:  # where a path is unknown
                    _length("error", message.error)
            case _:
                _SHOWN[type(message)](message)

    def _collision(self, message: pb.Collision) -> None:
        _among("phase", message.phase, _PHASES)
        _among("kind", message.kind, _KINDS)
        clear, touching = message.time_clear, message.time_touching
        _interval(*((clear, touching) if message.phase == pb.Collision.Phase.BEGIN else (touching, clear)))
        _place("point", message.point)

    def _pair(self, message: _Paired) -> None:
        """Check that a message names the pair of its rank, and always by the same names."""
        known = self._pairs.get(message.pair_id)
        told = message.pair, message.body_a, message.body_b
        if known is None:
            self._add_pair(message.pair_id, told)
        elif told != known:
            raise FactError(f"pair {message.pair_id} has two names, {quoted(told[0])} and {quoted(known[0])}")

    def _add_pair(self, pair_id: int, told: tuple[str, str, str]) -> None:
        pair, *names = told
        if pair_id >= self._bodies * (self._bodies - 1) // 2:
            raise FactError(f"pair {pair_id} does not exist among {self._bodies} bodies")
        if pair != "|".join(names) or not all(names) or names[0] == names[1]:
            raise FactError(f"pair {quoted(pair)} is not {quoted(names[0])} and {quoted(names[1])}")
        for body, name in zip(bodies_of_pair(pair_id, self._bodies), names, strict=True):
            if self._names.setdefault(body, name) != name or self._indices.setdefault(name, body) != body:
                raise FactError(f"body {body} has two names, one of them {quoted(name)}")
        self._pairs[pair_id] = told


def _length(name: str, value: float) -> None:
    if not 0.0 <= value <= MOST_METRES:  # as for all of these: no number is in any range if it is NaN
        raise FactError(f"{name} is {value!r}")


def _among(name: str, value: int, known: frozenset[int]) -> None:
    if value not in known:
        raise FactError(f"{name} is {value}")


def _interval(first: float, last: float) -> None:
    if not -MOST_SECONDS <= first <= last <= MOST_SECONDS:
        raise FactError(f"it is from {first!r} s to {last!r} s")


def _place(name: str, point: Any) -> None:
    x, y, z = point.x, point.y, point.z
    most = MOST_METRES
    if not (-most <= x <= most and -most <= y <= most and -most <= z <= most):
        raise FactError(f"{name} is ({x!r}, {y!r}, {z!r})")


def _places(name: str, points: Iterable[Any]) -> None:
    rows = np.array([(point.x, point.y, point.z) for point in points], dtype=np.float64)
    if rows.size and not np.abs(rows).max() <= MOST_METRES:
        raise FactError(f"{name} are beyond {MOST_METRES:g} m or not numbers")


def _turn(turn: Any) -> None:
    x, y, z, w = turn.x, turn.y, turn.z, turn.w
    if not abs(x * x + y * y + z * z + w * w - 1.0) <= 2.0 * _UNIT:
        raise FactError(f"its rotation is ({x!r}, {y!r}, {z!r}, {w!r})")


def _pose(pose: Any) -> None:
    _place("position", pose.position)
    _turn(pose.orientation)


def _window(message: pb.Window) -> None:
    _interval(message.start, message.end)
    _place("box_min", message.box_min)
    _place("box_max", message.box_max)


def _world(message: pb.World) -> None:
    if not isnan(message.min_distance):
        _length("min_distance", message.min_distance)
    for pair in message.pairs:
        _length("distance", pair.distance)


def _frames(message: Any) -> None:
    for one in message.transforms:
        _place("translation", one.translation)
        _turn(one.rotation)


def _update(message: Any) -> None:
    for entity in message.entities:
        for line in entity.lines:
            if len(line.points) < 2:
                raise FactError("a line has fewer than two points")
            _places("points", line.points)
        for mesh in entity.triangles:
            _pose(mesh.pose)
            _places("points", mesh.points)
        for part in (*entity.cubes, *entity.spheres):
            _pose(part.pose)
            _place("size", part.size)


_SHOWN: dict[type[Message], Callable[[Any], None]] = {
    pb.Window: _window,
    pb.World: _world,
    FrameTransforms: _frames,
    SceneUpdate: _update,
    Log: lambda message: None,
}
