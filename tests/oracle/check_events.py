"""Checks of single facts: collisions' brackets, measured distances and their witnesses, wakeups."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from .rigid import FloatArray
from .sampling import Effort, Samples
from .truth import NANOSECOND, Pair, Truth, point, seconds

Values = dict[str, Any]

POINT_TOLERANCE = 1e-6
"""Share of (1 m + the scene's size) by which a contact point may lie off the bodies: narrow phases place it so."""


def check_collisions(truth: Truth, pair: Pair, collisions: Sequence[Values], chord: float) -> Iterable[str]:
    """Every bracket is clear at one end, touching at the other, narrow, and the right way round.

    Touching is what is nearer than the chord error (m). Of an unknown path nothing is known after the start, where a
    contact ends for that reason alone.
    """
    if not collisions:
        return
    clear, touching = (np.array([event[key] for event in collisions]) for key in ("time_clear", "time_touching"))
    at_clear, at_touching = truth.signed(*pair, clear), truth.signed(*pair, touching)
    surfaces = truth.surface_distance(*pair, touching)
    start, _ = truth.interval(*pair)
    for i, event in enumerate(collisions):
        name = f"{'|'.join(pair)}: {event['phase']} [{clear[i]} clear, {touching[i]} touching]"
        standing = event["phase"] == "BEGIN" and clear[i] == touching[i] == start
        right = clear[i] < touching[i] if event["phase"] == "BEGIN" else touching[i] < clear[i]
        if not (right or standing):
            yield f"{name}: the wrong way round"
        if abs(clear[i] - touching[i]) > truth.contact_tolerance:
            yield f"{name}: wider than {truth.contact_tolerance} s"
        if at_clear[i] < -truth.sure_depth and not (standing or truth.unknown(*pair)):
            yield f"{name}: touches at its clear end, {-at_clear[i]:.3g} m deep"
        if at_touching[i] > truth.tolerance + chord:
            yield f"{name}: {at_touching[i]:.3g} m apart at its touching end"
        contained = surfaces[i] > 0.0
        doubtful = truth.tolerance + (chord + truth.slack(*pair) if chord > 0.0 else 0.0)
        if (event["kind"] == "CONTAINED") != contained and abs(surfaces[i]) > doubtful:
            yield f"{name}: kind is {event['kind']}, the surfaces' distance {surfaces[i]:.3g} m"
        yield from check_keys(truth, pair, event, name)
    yield from check_points(truth, pair, collisions, chord)


def check_keys(truth: Truth, pair: Pair, event: Values, name: str) -> Iterable[str]:
    """A collision names the keys that both bodies are between, by the keys' times, or within 1 ns of it."""
    for body, side in zip(pair, "ab", strict=True):
        said = (event.get(f"key_before_{side}", ""), event.get(f"key_after_{side}", ""))
        times = event["time_touching"] + NANOSECOND * np.array([-1.0, 0.0, 1.0])
        allowed = [truth.kinematics.named_around(body, time) for time in times.tolist()]
        if said not in allowed:
            yield f"{name}: {body} is said to be between keys {said}, not {allowed[1]}"


def check_points(truth: Truth, pair: Pair, collisions: Sequence[Values], chord: float) -> Iterable[str]:
    """A collision's point belongs to both bodies when they touch, to the chord error (m)."""
    places = np.array([point(event["point"]) for event in collisions])
    known = np.isfinite(places).all(axis=1)
    times = np.array([event["time_touching"] for event in collisions])[known]
    allowed = POINT_TOLERANCE * (1.0 + truth.spread) + truth.tolerance + chord
    for body in pair:
        if truth.unplaced(body):
            continue
        off = truth.from_points(body, times, places[known])
        for i in np.flatnonzero(off > allowed):
            yield f"{'|'.join(pair)}: collision at {times[i]} s: its point is {off[i]:.3g} m off {body}"


def chosen(messages: Sequence[Values], key: str, effort: Effort) -> list[Values]:
    """Return messages to check: those with the least `key`, and others at random."""
    if len(messages) <= effort.messages:
        return list(messages)
    order = np.argsort([message[key] for message in messages], kind="stable")
    third = effort.messages // 3
    others = np.random.default_rng(effort.seed).permutation(order[third:])[: effort.messages - third]
    return [messages[i] for i in np.concatenate([order[:third], others])]


def check_distances(
    truth: Truth, pair: Pair, distances: Sequence[Values], effort: Effort, epoch: int, chord: float
) -> Iterable[str]:
    """Measured distances are the true ones, and the witness points lie on both bodies that far apart.

    Beside the tolerance they may be off by what the bodies move in the nanosecond to which times are rounded. Of round
    shapes they may be too near by the chord error (m), the witness points as far out.
    """
    picked = chosen(distances, "distance", effort)
    if not picked:
        return
    times = np.array([seconds(message, epoch) for message in picked])
    blurs = [truth.blur(body, times) for body in pair]
    allowed = truth.tolerance + truth.pair_blur(*pair, times)
    measured = np.array([message["distance"] for message in picked])
    true = np.maximum(truth.signed(*pair, times), 0.0)
    for i in np.flatnonzero(~((measured <= true + allowed) & (measured >= true - allowed - chord))):
        yield f"{'|'.join(pair)}: distance {measured[i]} at {times[i]} s is truly {true[i]}"
    apart = measured > 0.0
    ends = [np.array([point(message[key]) for message in picked]) for key in ("witness_a", "witness_b")]
    span = np.linalg.norm(ends[0] - ends[1], axis=1)
    for i in np.flatnonzero(apart & ~(np.abs(span - measured) <= truth.tolerance)):
        yield f"{'|'.join(pair)}: witnesses {span[i]} m apart at {times[i]} s for distance {measured[i]}"
    for body, points, blur in zip(pair, ends, blurs, strict=True):
        known = truth.tolerance + blur[apart] + chord
        yield from check_witnesses(truth, pair, body, times[apart], points[apart], known)


def check_witnesses(
    truth: Truth, pair: Pair, body: str, times: FloatArray, points: FloatArray, allowed: FloatArray
) -> Iterable[str]:
    """Witness points (n, 3) lie on the body's surface at their times, if its place is known."""
    if truth.unplaced(body):
        return
    known = np.isfinite(points).all(axis=1)
    off = np.full(len(points), np.inf)
    off[known] = np.abs(truth.from_points(body, times[known], points[known]))
    for i in np.flatnonzero(~(off <= allowed)):
        yield f"{'|'.join(pair)}: witness {points[i].tolist()} at {times[i]} s is {off[i]:.3g} m off {body}"


def check_wakeups(
    truth: Truth, pair: Pair, wakeups: Sequence[Values], samples: Samples, effort: Effort, epoch: int
) -> Iterable[str]:
    """Clearances are no more than the distance; no certified sleep holds a touching instant outside of contacts."""
    if not wakeups:
        return
    times = np.array([seconds(message, epoch) for message in wakeups])
    if not truth.unknown(*pair):  # else a sleep may lead on through what is but possible
        yield from check_sleeps(pair, wakeups, times, samples.times[samples.signed < -truth.sure_depth])
    picked = chosen(wakeups, "sleep", effort)
    times = np.array([seconds(message, epoch) for message in picked])
    said = np.nan_to_num([message["clearance"] for message in picked], nan=0.0)
    allowed = truth.tolerance + truth.pair_blur(*pair, times)
    true = np.maximum(truth.signed(*pair, times), 0.0)
    for i in np.flatnonzero(said > true + allowed):
        yield f"{'|'.join(pair)}: wakeup at {times[i]} s: clearance {said[i]}, truly {true[i]}"


def check_sleeps(pair: Pair, wakeups: Sequence[Values], times: FloatArray, touching: FloatArray) -> Iterable[str]:
    """No sleep but a floor step holds one of the `touching` instants (s), which lie outside of contacts."""
    touching = np.sort(touching)
    sleeps = np.array([message["sleep"] for message in wakeups])
    first = np.searchsorted(touching, times + NANOSECOND, side="right")
    after = np.searchsorted(touching, times + sleeps - NANOSECOND, side="left")
    for i in np.flatnonzero(after > first).tolist():
        if wakeups[i]["bound"] != "time_resolution" and wakeups[i]["reason"] != "CONTACT":
            yield f"{'|'.join(pair)}: sleeps {sleeps[i]} s from {times[i]} s, touches at {touching[first[i]]} s"
