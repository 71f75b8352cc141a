"""Checks of the broad phase: boxes hold their bodies, follow one another, and part the pairs that have no spans."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import inf, nextafter
from typing import Any

import numpy as np

from .logs import Log
from .sampling import Effort
from .truth import Pair, Truth, point

Values = dict[str, Any]


def check_windows(truth: Truth, log: Log, effort: Effort) -> Iterable[str]:
    """Windows hold; without any, every pair to watch must have spans."""
    by_body: dict[str, list[Values]] = {name: [] for name in truth.names}
    for message in log.of("windows"):
        by_body[message["body"]].append(message)
    for windows in by_body.values():
        windows.sort(key=lambda window: window["start"])
    yield from check_boxes(truth, log, effort)
    if log.of("windows"):
        for name in truth.names:
            yield from check_succession(truth, name, by_body[name])
    listed = set(log.by_pair("spans"))
    for pair in truth.pairs():
        if "|".join(pair) not in listed:
            yield from check_unlisted(truth, pair, by_body[pair[0]], by_body[pair[1]])


def check_boxes(truth: Truth, log: Log, effort: Effort) -> Iterable[str]:
    """A body's corners, rounded, stay in its swept box throughout the window; of unknown path, on one of its paths."""
    rng = np.random.default_rng(effort.seed)
    messages = log.of("windows")
    for message in (messages[i] for i in rng.permutation(len(messages))[: effort.messages]):
        name = message["body"]
        surface = truth.surfaces[name]
        times = np.linspace(message["start"], message["end"], 25)
        poses = truth.kinematics.world_from_body(name, times)
        corners = surface.triangles.reshape(-1, 3) @ np.swapaxes(poses[:, :3, :3], 1, 2) + poses[:, None, :3, 3]
        rounding = np.repeat(surface.radii, 3)[:, None]
        low = np.array(point(message["box_min"])) - (corners - rounding)
        high = (corners + rounding) - np.array(point(message["box_max"]))
        outside = float(np.maximum(low, high).max(initial=-np.inf))
        if outside > truth.tolerance:
            yield f"/windows: {name} leaves its box [{message['start']}, {message['end']}] by {outside:.3g} m"


def check_succession(truth: Truth, name: str, windows: Sequence[Values]) -> Iterable[str]:
    """The windows of a body cover the time it exists; each begins at the last one's end, or a float later."""
    start, end = truth.interval(name, name)
    if not (truth.has_shapes(name) and start < end):
        if windows:
            yield f"/windows: {name} has windows, and is not there to have any"
        return
    if not windows:
        yield f"/windows: {name} has none"
        return
    if windows[0]["start"] != start or windows[-1]["end"] != end:
        yield f"/windows: {name} has them from {windows[0]['start']} to {windows[-1]['end']} s, exists {start} to {end}"
    for one, after in pairwise(windows):
        if after["start"] not in (one["end"], nextafter(one["end"], inf)):
            yield f"/windows: {name} has a gap or an overlap from {one['end']} to {after['start']} s"


def check_unlisted(truth: Truth, pair: Pair, one: Sequence[Values], other: Sequence[Values]) -> Iterable[str]:
    """Of a pair without spans the boxes are farther apart than its margin at each instant of its time."""
    start, end = truth.interval(*pair)
    first, second = (windows_of(windows) for windows in (one, other))
    if not (len(one) and len(other)):
        yield f"{'|'.join(pair)}: neither spans nor windows"
        return
    begins = np.maximum(first[:, None, 0], second[None, :, 0])
    ends = np.minimum(first[:, None, 1], second[None, :, 1])
    sides = np.maximum(first[:, None, 2:5] - second[None, :, 5:8], second[None, :, 2:5] - first[:, None, 5:8])
    gaps = np.linalg.norm(np.maximum(sides, 0.0), axis=2)
    # Windows that meet in one instant need not be apart where a box on either side of it is.
    near = (np.maximum(begins, start) < np.minimum(ends, end)) & ~(gaps > truth.margin(*pair))
    for i, j in np.argwhere(near)[:3].tolist():
        span = f"{begins[i, j]} to {ends[i, j]} s"
        yield f"{'|'.join(pair)}: no spans, and boxes {gaps[i, j]:.3g} m apart from {span}"


def windows_of(windows: Sequence[Values]) -> np.ndarray:
    """Return (n, 8): start, end, low corner, high corner."""
    rows = [(w["start"], w["end"], *point(w["box_min"]), *point(w["box_max"])) for w in windows]
    return np.array(rows).reshape(-1, 8)
