"""The data of a page's scripts as one block of text: compressed arrays of numbers."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scheduler.geometry.arrays import FloatArray
from ..log import messages_pb2 as pb
from ..log.severity import VERDICTS
from ..scene.quantities.units import metres
from ..scene.text.errors import printable
from .gathering import Gathered
from .replay import BOX_NUMBERS, POSE_NUMBERS, Drawn, Replay
from .tracks import Curve

# Browsers require arrays to begin at multiples of the size of their numbers.
_ALIGNMENT = 8

# Scale of the components of a quaternion in 16 bits.
_TURN = 32767

# The verdict where the log has no span.
_NOTHING = 0

_BEST_COMPRESSION = 9

# The replay marks and steps through this many begins of contacts; the first ones are kept.
_MOST_TOUCHES = 50_000


class _Block:
    """Named arrays, one after another, with a table of where each is."""

    def __init__(self) -> None:
        self._table: list[tuple[str, str, int, int]] = []
        self._data = bytearray()

    def add(self, name: str, values: NDArray[Any] | list[Any], kind: str) -> None:
        """Add an array under a name, as numbers of a little-endian numpy kind."""
        data = np.ascontiguousarray(values, dtype=kind)
        self._table.append((name, kind, len(self._data), data.size))
        self._data += data.tobytes()
        self._data += bytes(-len(self._data) % _ALIGNMENT)

    def text(self, facts: dict[str, Any]) -> str:
        """Return all, with some facts in JSON before it, in base64 of gzip of a length (4 bytes), JSON and arrays."""
        head = json.dumps(facts | {"arrays": self._table}, allow_nan=False, separators=(",", ":")).encode()
        head += b" " * (-(len(head) + 4) % _ALIGNMENT)
        data = len(head).to_bytes(4, "little") + head + self._data
        return base64.b64encode(gzip.compress(data, _BEST_COMPRESSION, mtime=0)).decode()


def packed(gathered: Gathered, near: float, opens: tuple[int, float]) -> str:
    """Return the data that the scripts draw.

    Args:
        gathered: from the log.
        near: m; below this distance a clear pair counts as near.
        opens: the index of the pair that the page shows at first, and the time, s.
    """
    summary, block = gathered.found.summary, _Block()
    start, end = summary["time"]
    origin = _origin(gathered.replay)
    bodies = list(dict.fromkeys(name for pair in gathered.pairs for name in (pair["body_a"], pair["body_b"])))
    _add_pairs(block, gathered, bodies, origin)
    _add_curves(block, gathered.curves, start)
    facts: dict[str, Any] = {
        "start": start,
        "end": end,
        "near": near,
        "unit": {"name": gathered.identity.length_unit, "metres": metres(1.0, gathered.identity.length_unit)},
        "opens": opens,
        "bodies": [printable(name) for name in bodies],
        "verdicts": VERDICTS,
        "spanVerdicts": {number: name.lower() for name, number in pb.Span.Verdict.items() if number},
        "reasons": list(pb.Wakeup.Reason.Value.keys()),
        "replay": None if gathered.replay is None else _add_replay(block, gathered.replay, origin),
    }
    return block.text(facts)


def below(values: FloatArray) -> NDArray[np.float32]:
    """Return the nearest single-precision numbers that are not above the values: bounds err low."""
    single = values.astype(np.float32)
    lower: NDArray[np.float32] = np.where(single > values, np.nextafter(single, np.float32(-np.inf)), single)
    return lower


def _add_pairs(block: _Block, gathered: Gathered, bodies: list[str], origin: FloatArray) -> None:
    pairs, place = gathered.pairs, {name: index for index, name in enumerate(bodies)}
    block.add("bodyA", [place[pair["body_a"]] for pair in pairs], "<u4")
    block.add("bodyB", [place[pair["body_b"]] for pair in pairs], "<u4")
    block.add("verdict", [VERDICTS.index(pair["verdict"]) for pair in pairs], "<u1")
    block.add("lower", [pair["distance"]["lower"] for pair in pairs], "<f8")
    block.add("upper", [_number(pair["distance"]["upper"]) for pair in pairs], "<f8")
    block.add("nearest", [_number(pair["distance"]["time"]) for pair in pairs], "<f8")
    block.add("margin", [pair["margin"] for pair in pairs], "<f8")
    kinds = len(pb.Wakeup.Reason.Value.keys())
    block.add("reasons", [[counts.get(kind, 0) for kind in range(kinds)] for counts in gathered.reasons], "<u4")
    nowhere = ((np.nan,) * 3,) * 2
    witnesses = [gathered.witnesses.get(row, nowhere) for row in range(len(pairs))]
    block.add("witnesses", np.array(witnesses, dtype=np.float64).reshape(-1, 3) - origin, "<f4")
    touches = [(touch.time, row, touch.point) for row, all_of in gathered.touches.items() for touch in all_of]
    touches = sorted(touches)[:_MOST_TOUCHES]
    block.add("touchPair", [row for _, row, _ in touches], "<u4")
    block.add("touchTime", [time for time, _, _ in touches], "<f8")
    points = np.array([point for _, _, point in touches], dtype=np.float64).reshape(-1, 3)
    block.add("touchPoint", points - origin, "<f4")


def _add_curves(block: _Block, curves: list[Curve], start: float) -> None:
    """Add the pairs' points and spans one after another, and where each pair's begin; times from the start on, s."""
    lines = [_line(curve) for curve in curves]
    points = _joined(lines, 3)
    block.add("pointFrom", _begins(lines), "<u4")
    block.add("pointTime", points[:, 0] - start, "<f4")
    block.add("pointDistance", below(points[:, 1]), "<f4")
    block.add("pointMeasured", points[:, 2], "<u1")
    all_spans = [_without_ends(curve.spans) for curve in curves]
    spans = _joined(all_spans, 3)
    block.add("spanFrom", _begins(all_spans), "<u4")
    block.add("spanStart", spans[:, 0], "<f8")
    block.add("spanVerdict", spans[:, 1], "<u1")
    block.add("spanClearance", below(spans[:, 2]), "<f4")


def _line(curve: Curve) -> FloatArray:
    """Return rows (n, 3) of s, m, and whether it was measured: what is known of a pair's distance at instants.

    Of bounds only those are left that lie above the line through the measured points: there, that line is wrong.
    """
    measured, bounds = curve.measured, curve.bounds
    if len(measured):
        bounds = bounds[bounds[:, 1] > np.interp(bounds[:, 0], measured[:, 0], measured[:, 1])]
    rows = np.concatenate((np.insert(measured, 2, 1.0, axis=1), np.insert(bounds, 2, 0.0, axis=1)))
    line: FloatArray = rows[np.argsort(rows[:, 0], kind="stable")]
    return line


def _without_ends(spans: FloatArray) -> FloatArray:
    """Return rows (n, 3) of start, verdict and clearance, each up to the next, of spans (m, 4)."""
    rows: list[tuple[float, float, float]] = []
    for index, (start, end, verdict, clearance) in enumerate(spans):
        rows.append((start, verdict, clearance))
        if index + 1 == len(spans) or spans[index + 1, 0] > end:
            rows.append((end, _NOTHING, 0.0))
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _add_replay(block: _Block, replay: Replay, origin: FloatArray) -> dict[str, Any]:
    """Add the bodies' surfaces and poses; return how they are put together."""
    models = replay.models.drawn()
    for number, model in enumerate(models):
        block.add(f"points{number}", model.points, "<f4")
        block.add(f"triangles{number}", model.triangles, "<u2" if len(model.points) < 1 << 16 else "<u4")
    tracks = list(replay.poses.items())
    poses = _joined([rows for _, rows in tracks], POSE_NUMBERS)
    block.add("poseFrom", _begins([rows for _, rows in tracks]), "<u4")
    block.add("poseTime", poses[:, 0], "<f8")
    block.add("posePlace", (poses[:, 1:4] - origin), "<f4")
    block.add("poseTurn", np.round(poses[:, 4:8] * _TURN), "<i2")
    block.add("lineTime", replay.lines[:, 0], "<f8")
    block.add("linePair", replay.lines[:, 1], "<i4")
    block.add("linePoints", replay.lines[:, 2:8].reshape(-1, 3) - origin, "<f4")
    boxes = [rows for _, rows in replay.boxes]
    crowd = _joined(boxes, BOX_NUMBERS)
    block.add("boxFrom", _begins(boxes), "<u4")
    block.add("boxTime", [time for time, _ in replay.boxes], "<f8")
    block.add("boxPlace", crowd[:, :3] - origin, "<f4")
    block.add("boxTurn", np.round(crowd[:, 3:7] * _TURN), "<i2")
    block.add("boxSize", crowd[:, 7:10], "<f4")
    return {
        "bodies": [_body(name, body, origin) for name, body in replay.bodies.items()],
        "tracks": [printable(name) for name, _ in tracks],
        "coarser": replay.models.coarser,
    }


def _body(name: str, body: Drawn, origin: FloatArray) -> dict[str, Any]:
    """Return a body as JSON; what stands in the world is seen from the origin."""
    shift = (0.0, 0.0, 0.0) if body.framed else tuple(origin)
    parts = [
        {
            "model": part.model,
            "place": [part.pose[axis] - shift[axis] for axis in range(3)],
            "turn": list(part.pose[3:]),
            "size": list(part.size),
        }
        for part in body.parts
    ]
    return {"name": printable(name), "parts": parts, "there": body.there}


def _origin(replay: Replay | None) -> FloatArray:
    """Return a point (3,) amid the scene, m: near it, single precision suffices."""
    if replay is None:
        return np.zeros(3)
    places = [rows[0, 1:4] for rows in replay.poses.values() if len(rows)]
    places += [np.array(part.pose[:3]) for body in replay.bodies.values() if not body.framed for part in body.parts]
    places += [rows[:, :3].mean(axis=0) for _, rows in replay.boxes[:1] if len(rows)]
    return np.median(places, axis=0) if places else np.zeros(3)


def _begins(parts: Iterable[FloatArray]) -> NDArray[np.int64]:
    """Return where each of some arrays begins among all of them, and where the last ends."""
    return np.cumsum([0, *(len(part) for part in parts)])


def _joined(parts: list[FloatArray], columns: int) -> FloatArray:
    return np.concatenate(parts) if parts else np.zeros((0, columns))


def _number(value: float | None) -> float:
    return np.nan if value is None else value
