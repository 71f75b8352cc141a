"""Checks of what is told of all pairs together: snapshots of the world, and the summary."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from .logs import Log
from .sampling import Effort
from .truth import NANOSECOND, Pair, Truth, seconds

Values = dict[str, Any]

WORST_FIRST = ("CONTACT", "BREACH", "UNRESOLVED", "POSSIBLE", "CLEAR")

SEARCHED = 500
"""Wakeups of a pair whose least distance may be given up."""

TIGHTEST = 2e-6
"""m: least distances are known no better than 1e-6 m, and than some errors of measurement."""


def summary_of(log: Log) -> Values | None:
    """Return the summary that the log carries, None if it has none."""
    text = log.attachments.get("summary.json")
    return None if text is None else json.loads(text)


def stated_chords(log: Log) -> dict[str, float]:
    """Return by pair how far (m) what was measured stands out from its round shapes, where the summary says so."""
    summary = summary_of(log) or {"pairs": []}
    return {pair["pair"]: pair["chord_error"] for pair in summary["pairs"]}


def check_summary(truth: Truth, log: Log) -> Iterable[str]:
    """The summary repeats the log's spans, states small chord errors, and ranges that hold the true least distance."""
    summary = summary_of(log)
    if summary is None:
        return
    spans, collisions = log.by_pair("spans"), log.by_pair("collisions")
    watched = {f"{a}|{b}": (a, b) for a, b in truth.pairs()}
    if summary["pairs_total"] != len(watched):
        yield f"summary: {summary['pairs_total']} pairs, truly {len(watched)}"
    for told in summary["pairs"]:
        name = told["pair"]
        if name not in watched:
            yield f"summary: no such pair to watch: {name}"
            continue
        verdicts = {span["verdict"] for span in spans.get(name, ())}
        worst = next((verdict for verdict in WORST_FIRST if verdict in verdicts), "UNRESOLVED")
        if any(event["phase"] == "BEGIN" for event in collisions.get(name, ())):
            worst = "CONTACT"
        if told["verdict"] != worst.lower():
            yield f"summary: {name} is {told['verdict']}, its spans say {worst}"
        yield from check_range(truth, watched[name], told)
        if verdicts <= {"CLEAR", "BREACH"}:
            yield from check_tightness(told, summary["settings"].get("distance_tolerance"))


def check_range(truth: Truth, pair: Pair, told: Values) -> Iterable[str]:
    """A pair's least distance: its lower end is not above the truth, its upper end not below it, at its time."""
    limit, chord = truth.chord_limit(*pair), told["chord_error"]
    if not 0.0 <= chord <= limit * (1.0 + 1e-9):
        yield f"summary: {told['pair']} has chord error {chord} m, at most {limit} can be"
    lower, upper, time = (told["distance"][key] for key in ("lower", "upper", "time"))
    if upper is None:
        return
    times = np.array([time])
    true = max(0.0, float(truth.signed(*pair, times)[0]))
    allowed = truth.tolerance + float(truth.creep(*pair, times)[0])
    if not lower <= true + allowed or not true - allowed <= upper <= true + chord + allowed:
        yield f"summary: {told['pair']} is {true} m apart at {time} s, told are {lower} to {upper}, chord {chord}"


def check_tightness(told: Values, share: float | None) -> Iterable[str]:
    """A least distance is called tight where it is certified to a share or 1e-6 m, and it is, or has a good excuse."""
    lower, upper, word, why = (told["distance"][key] for key in ("lower", "upper", "bracket", "why"))
    if upper is None:
        if word != "open":
            yield f"summary: {told['pair']} has no upper end and is called {word}"
        return
    tight = upper - lower <= max((share or 0.0) * upper, 0.5 * TIGHTEST) * (1.0 + 1e-9)
    if (word == "tight") != tight:
        yield f"summary: {told['pair']} is told to be {lower} to {upper} m apart at the least, which is called {word}"
    excuses = {
        "search": told["wakeups"] > SEARCHED,
        "not sought": share is None,
        "polyhedra": told["chord_error"] > 0.0,
        "error": 8.0 * told["error"] > 0.5 * TIGHTEST,
    }
    if not tight and not excuses.get(why, False):
        yield f"summary: {told['pair']} is told to be {lower} to {upper} m apart at the least, for {why}"


def check_world(truth: Truth, log: Log, effort: Effort, epoch: int, chords: Mapping[str, float]) -> Iterable[str]:
    """Snapshots tell the nearest pairs of those that exist, at their true distances."""
    messages = log.of("world")
    chosen = np.random.default_rng(effort.seed).permutation(len(messages))[: effort.messages // 5]
    messages = [messages[i] for i in np.sort(chosen)]
    times = np.array([seconds(message, epoch) for message in messages])
    least = np.full(len(times), np.inf)
    told = [{one["pair"]: one for one in message["pairs"]} for message in messages]
    for pair in truth.pairs():
        name = "|".join(pair)
        begin, end = truth.interval(*pair)
        for i in np.flatnonzero((times < begin - NANOSECOND) | (times > end + NANOSECOND)):
            if told[i].pop(name, None) is not None:
                yield f"/world at {times[i]} s: {name} exists from {begin} to {end} s"
        there = np.flatnonzero((times > begin) & (times < end))
        chord = min(chords.get(name, np.inf), truth.chord_limit(*pair))
        true = np.maximum(truth.signed(*pair, times[there]), 0.0)
        allowed = truth.tolerance + truth.pair_blur(*pair, times[there])
        least[there] = np.minimum(least[there], true + allowed)
        for i, distance, error in zip(there, true, allowed, strict=True):
            one = told[i].get(name, {"verdict": "CONTACT"})  # contacts read 0 up to the clear ends of their brackets
            least_told = 0.0 if truth.unknown(*pair) else distance - error - chord
            if one["verdict"] != "CONTACT" and not least_told <= one["distance"] <= distance + error:
                yield f"/world at {times[i]} s: {name} at {one['distance']} m is truly at {distance}"
    watched = {"|".join(pair) for pair in truth.pairs()}
    for time, message, pairs, bound in zip(times, messages, told, least, strict=True):
        for name in pairs.keys() - watched:
            yield f"/world at {time} s: no such pair to watch: {name}"
        if np.isfinite(bound) and not message["min_distance"] <= bound:
            yield f"/world at {time} s: least distance {message['min_distance']}, some pair has {bound}"
