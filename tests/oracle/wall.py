"""A scene whose truth is known in closed form, its faultless log, and ways to spoil that log."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .logs import Log

WALL = """
closecall: 1
units: {length: m, angle: deg}
time: {start: 0, end: 2}
bodies:
  wall: {shapes: [{box: [0.5, 2, 2]}]}
  dart: {pose: {xyz: [-1, 0, 0]}, shapes: [{sphere: 0.1}], motion: {type: constant, velocity: [1, 0, 0]}}
  bird:
    pose: {xyz: [0, 0, 1.6000001]}
    shapes: [{sphere: 0.1}]
    motion: {type: harmonic, direction: [0, 0, 1], amplitude: 0.5, period: 0.7}
"""
"""A dart flies through a wall between 0.65 and 1.35 s; a bird comes within 1e-7 m of the wall's top, three times."""


def stamped(time: float, **fields: Any) -> dict[str, Any]:
    stamp = round(time * 1e9)
    return {"timestamp": stamp, "log_time": stamp, "publish_time": stamp, **fields}


def message(pair: str, rank: int, time: float, **fields: Any) -> dict[str, Any]:
    a, b = pair.split("|")
    return stamped(time, pair=pair, pair_id=rank, body_a=a, body_b=b, **fields)


def span(pair: str, rank: int, verdict: str, start: float, end: float, clearance: float = 0.0) -> dict[str, Any]:
    fields = {"verdict": verdict, "start": start, "end": end, "clearance": clearance, "depth_limit": np.nan}
    return message(pair, rank, end, **fields)


def collision(phase: str, clear: float, touching: float, x: float) -> dict[str, Any]:
    fields = {"phase": phase, "time_clear": clear, "time_touching": touching, "kind": "SURFACE"}
    return message("wall|dart", 0, touching, **fields, point={"x": x, "y": 0.0, "z": 0.0})


def wakeup(time: float, clearance: float, sleep: float, bound: str = "displacement") -> dict[str, Any]:
    fields = {"reason": "TIME_BOUND", "bound": bound, "clearance": clearance, "sleep": sleep}
    return message("wall|dart", 0, time, **fields)


def window(body: str, start: float, end: float, least: float, most: float, half: float) -> dict[str, Any]:
    """Return the box from `least` to `most` in x, and `half` to either side in y and z."""
    low, high = {"x": least, "y": -half, "z": -half}, {"x": most, "y": half, "z": half}
    return stamped(start, body=body, start=start, end=end, box_min=low, box_max=high)


def true_log() -> Log:
    """Return a log of WALL as a faultless tool would write it, from closed forms."""
    begin, end = 0.65 - 4e-7, 1.35 + 4e-7
    dart = [
        span("wall|dart", 0, "CLEAR", 0.0, begin, 3e-7),
        span("wall|dart", 0, "CONTACT", begin, end),
        span("wall|dart", 0, "CLEAR", end, 2.0, 3e-7),
    ]
    near = {"x": -0.25, "y": 0.0, "z": 0.0}
    distance = message("wall|dart", 0, 0.25, distance=0.4, witness_a=near, witness_b={"x": -0.65, "y": 0.0, "z": 0.0})
    turned = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    transform = {"parent_frame_id": "world", "child_frame_id": "dart", "rotation": turned}
    transform["translation"] = {"x": -0.5, "y": 0.0, "z": 0.0}
    windows = [window(name, 0.0, 2.0, -9.0, 9.0, 9.0) for name in ("wall", "bird")]
    windows.append(window("dart", 0.0, 0.5, -9.0, 9.0, 9.0))
    windows.append(window("dart", 0.5, 0.7, -0.6, -0.2, 0.1))
    windows.append(window("dart", 0.7, 2.0, -9.0, 9.0, 9.0))
    bird = [span("wall|bird", 1, "CLEAR", 0.0, 2.0, 5e-8), span("dart|bird", 2, "CLEAR", 0.0, 2.0, 0.1)]
    collisions = [
        collision("BEGIN", begin, 0.65 + 4e-7, -0.25),
        collision("END", end, 1.35 - 4e-7, 0.25),
    ]
    return Log(
        topics={
            "spans": sorted(dart + bird, key=lambda one: one["log_time"]),
            "collisions": collisions,
            "distances": [distance],
            "tf": [stamped(0.5, transforms=[transform])],
            "windows": windows,
            "wakeups": [wakeup(0.0, 0.65, 0.5), wakeup(0.5, 0.15, begin - 0.5), wakeup(end, 0.0, 2.0 - end)],
        }
    )


def spoil_verdict(log: Log) -> None:
    log.by_pair("spans")["wall|dart"][1]["verdict"] = "CLEAR"


def spoil_by_hiding_the_contact(log: Log) -> None:
    log.topics["spans"] = log.by_pair("spans")["wall|bird"]
    log.topics["collisions"] = []


def spoil_clearance(log: Log) -> None:
    log.by_pair("spans")["wall|bird"][0]["clearance"] = 2e-7


def spoil_gap(log: Log) -> None:
    log.by_pair("spans")["wall|dart"][2]["start"] += 1e-3


def spoil_end(log: Log) -> None:
    log.by_pair("spans")["wall|bird"][0]["end"] = 1.9


def spoil_bracket(log: Log) -> None:
    for key in ("time_clear", "time_touching"):
        log.topics["collisions"][0][key] -= 1e-4


def spoil_bracket_width(log: Log) -> None:
    log.topics["collisions"][1]["time_touching"] -= 1e-4


def spoil_phase(log: Log) -> None:
    log.topics["collisions"][1]["phase"] = "BEGIN"


def spoil_kind(log: Log) -> None:
    log.topics["collisions"][0]["time_touching"] = 1.0
    log.topics["collisions"][0]["point"] = {"x": 0.0, "y": 0.0, "z": 0.0}


def spoil_point(log: Log) -> None:
    log.topics["collisions"][0]["point"]["y"] = 0.2


def spoil_distance(log: Log) -> None:
    log.topics["distances"][0]["distance"] += 1e-7


def spoil_witness(log: Log) -> None:
    for key in ("witness_a", "witness_b"):
        log.topics["distances"][0][key]["x"] += 1e-7


def spoil_wakeup(log: Log) -> None:
    log.topics["wakeups"][1]["clearance"] += 1e-7


def spoil_rank(log: Log) -> None:
    log.topics["wakeups"][1]["pair_id"] = 1


def spoil_pair(log: Log) -> None:
    log.topics["spans"][0]["pair"] = "dart|wall"


def spoil_time(log: Log) -> None:
    log.topics["spans"][0]["log_time"] += 5


def spoil_by_standing_apart(log: Log) -> None:
    """Claim that the contact goes on for 0.2 s after its end."""
    last = log.by_pair("spans")["wall|dart"]
    last[1]["end"] = last[2]["start"] = log.topics["collisions"][1]["time_clear"] = 1.55
    log.topics["collisions"][1]["time_touching"] = 1.55 - 4e-7


def spoil_depth(log: Log) -> None:
    contact = log.by_pair("spans")["wall|dart"][1]
    contact["verdict"], contact["depth_limit"] = "UNRESOLVED", 0.2
    log.topics["collisions"] = []


def spoil_sleep(log: Log) -> None:
    spoil_depth(log)
    log.topics["wakeups"][1]["sleep"] = 0.6


def spoil_transform(log: Log) -> None:
    log.topics["tf"][0]["transforms"][0]["translation"]["x"] += 1e-7


def spoil_window(log: Log) -> None:
    log.topics["windows"][3]["box_max"]["x"] -= 1e-7


SPOILED: list[tuple[Callable[[Log], None], str]] = [
    (spoil_verdict, "touches at"),
    (spoil_by_hiding_the_contact, "no span: touches at"),
    (spoil_clearance, "nearer than its clearance"),
    (spoil_gap, "gap"),
    (spoil_end, "the pair's time ends"),
    (spoil_bracket, "apart at its touching end"),
    (spoil_bracket_width, "wider than"),
    (spoil_phase, "wrong way round"),
    (spoil_kind, "kind is SURFACE"),
    (spoil_point, "its point is"),
    (spoil_distance, "is truly"),
    (spoil_witness, "m off wall"),
    (spoil_wakeup, "clearance"),
    (spoil_rank, "rank 1"),
    (spoil_pair, "no such pair"),
    (spoil_time, "differs"),
    (spoil_by_standing_apart, "apart by"),
    (spoil_depth, "m deep at"),
    (spoil_sleep, "sleeps"),
    (spoil_transform, "dart is 1e-07 m off"),
    (spoil_window, "leaves its box"),
]
