"""Instants at which a pair's certificate is tried: everywhere a little, and again where it is nearest to breaking."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .rigid import FloatArray, IntArray
from .truth import Pair, Truth, seconds

Values = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Effort:
    """How hard to try.

    Attributes:
        uniform, scattered: instants of each pair, evenly spaced and at random.
        ends, knots: ends of spans and keys of motions that are tried on both sides, chosen at random if there are more.
        minima: local minima of a pair that are searched further.
        messages: messages of one topic and pair that are held against the truth.
        tight: instants where the log itself says that least is to spare.
        seed: of the random instants.
    """

    uniform: int = 500
    scattered: int = 125
    ends: int = 400
    knots: int = 100
    minima: int = 8
    messages: int = 60
    tight: int = 0
    seed: int = 0


TICK = 1.0 / 64.0
"""s: multiples of it are added and subtracted without rounding."""

OFFSETS = np.array([1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3])
"""s: how far inside its ends a span is tried too."""

SECTIONS, ROUNDS = 14, 6
"""A minimum's neighbourhood is cut in so many sections, so many times: to (2/15)^6 = 6e-6 of two steps."""

REACH = 3.0
"""Instants further from breaking than this many steps of motion are judged by a lower bound alone."""


@dataclass(frozen=True, slots=True)
class Samples:
    """Instants (n,) s, and at each the signed distance in m, or a lower bound above what the span promises."""

    times: FloatArray
    signed: FloatArray


def sample(
    truth: Truth, pair: Pair, spans: Sequence[Values], wakeups: Sequence[Values], effort: Effort, epoch: int
) -> Samples:
    """Try a pair over its whole time outside of contacts; `spans` are in order of time."""
    times = instants(truth, pair, spans, effort)
    if effort.tight:
        times = np.union1d(times, tightest(truth, pair, spans, wakeups, effort, epoch))
    times = outside_contacts(spans, times)
    if not len(times):
        return Samples(times, times)
    promised = clearances(spans, times)
    poses = truth.kinematics.relative(*pair, times)
    steps = truth.steps(*pair, poses)
    near = np.maximum(np.append(steps, 0.0), np.insert(steps, 0, 0.0))
    signed = truth.pair(*pair).lower_bounds(poses)
    exact = signed - promised < REACH * near + truth.tolerance
    signed[exact] = truth.pair(*pair).signed(poses[exact])
    held = ~exact & truth.pair(*pair).contained(poses)
    signed[held] = -np.abs(signed[held])
    lowest = minima(times, signed - promised, near, effort.minima)
    more = search(truth, pair, spans, times, lowest)
    return Samples(np.concatenate([times, more.times]), np.concatenate([signed, more.signed]))


def instants(truth: Truth, pair: Pair, spans: Sequence[Values], effort: Effort) -> FloatArray:
    """Return the first instants: a grid, random ones, both sides of spans' ends and of keys.

    Of keys that are no round numbers not the very instant: correct programs may differ in the last digit of when it is.
    """
    start, end = truth.interval(*pair)
    rng = np.random.default_rng([effort.seed, truth.pair_id(*pair)])
    ends = np.array([[span["start"], span["end"]] for span in spans]).reshape(-1)
    if len(ends) > effort.ends:
        ends = rng.choice(ends, effort.ends, replace=False)
    knots = truth.kinematics.knots(*pair, start=start, end=end)
    if len(knots) > effort.knots:
        knots = rng.choice(knots, effort.knots, replace=False)
    exact = knots[knots / TICK == np.round(knots / TICK)]
    exact = np.concatenate([np.nextafter(exact, -np.inf), exact])
    around = (np.concatenate([ends, knots])[:, None] + np.concatenate([-OFFSETS, OFFSETS])).reshape(-1)
    grid = np.linspace(start, end, effort.uniform)
    times = np.concatenate([grid, rng.uniform(start, end, effort.scattered), around, exact])
    return np.unique(times[(times >= start) & (times <= end)])


IN_STRETCH = 8
"""Instants in each stretch between neighbouring wakeups that is chosen for having little to spare."""


def tightest(
    truth: Truth, pair: Pair, spans: Sequence[Values], wakeups: Sequence[Values], effort: Effort, epoch: int
) -> FloatArray:
    """Return instants between the wakeups, outside of contacts, with the least clearance, in m and in m per s of sleep.

    A clearance here is the least that the log says at either end of a stretch or of the spans it lies in.
    """
    start, end = truth.interval(*pair)
    at = {seconds(message, epoch): np.nan_to_num(message["clearance"]) for message in wakeups}
    times = np.array([start, *sorted(time for time in at if start < time < end), end])
    said = np.array([at.get(time, np.inf) for time in times])
    middles, lengths = 0.5 * (times[1:] + times[:-1]), np.diff(times)
    outside = np.isin(middles, outside_contacts(spans, middles)) & (lengths > 0.0)
    if not outside.any():
        return times[:0]
    starts, lengths = times[:-1][outside], lengths[outside]
    clearance = np.minimum(np.minimum(said[:-1], said[1:])[outside], clearances(spans, middles[outside]))
    count = max(1, effort.tight // (2 * IN_STRETCH))
    orders = (np.argsort(clearance, kind="stable"), np.argsort(clearance / lengths, kind="stable"))
    chosen = np.unique(np.concatenate([order[:count] for order in orders]))
    rng = np.random.default_rng([effort.seed, truth.pair_id(*pair), effort.tight])
    return (starts[chosen, None] + lengths[chosen, None] * rng.random((len(chosen), IN_STRETCH))).reshape(-1)


def span_index(spans: Sequence[Values], times: FloatArray) -> IntArray:
    """Return for each time the index of the span that holds it, or -1.

    At an instant where two spans meet neither holds; the first span holds its start, the last one its end: a body
    may jump into another at the last instant.
    """
    if not spans:
        return np.full(len(times), -1)
    starts, ends = (np.array([span[key] for span in spans]) for key in ("start", "end"))
    index = np.maximum(np.searchsorted(starts, times, side="left") - 1, 0)
    inside = (times > starts[index]) & (times < ends[index])
    return np.where(inside | (times == starts[0]) | (times == ends[-1]), index, -1)


def outside_contacts(spans: Sequence[Values], times: FloatArray) -> FloatArray:
    """Return the times that are not inside a CONTACT span."""
    contact = np.array([span["verdict"] == "CONTACT" for span in spans] + [False])
    return times[~contact[span_index(spans, times)]]


def clearances(spans: Sequence[Values], times: FloatArray) -> FloatArray:
    """Return (n,) m: the clearance promised at each time, 0 where nothing is."""
    promised = np.array([span["clearance"] for span in spans] + [0.0])
    return np.nan_to_num(promised[span_index(spans, times)], nan=0.0)


def minima(times: FloatArray, slack: FloatArray, near: FloatArray, count: int) -> FloatArray:
    """Return (k, 2) s: the neighbourhoods of the lowest local minima of `slack` that motion could bring to 0."""
    if len(times) < 3:
        return np.zeros((0, 2))
    middle = slack[1:-1]
    lowest = (middle <= slack[:-2]) & (middle <= slack[2:]) & (middle < 2.0 * near[1:-1])
    found = np.flatnonzero(lowest) + 1
    found = found[np.argsort(slack[found], kind="stable")][:count]
    return np.stack([times[found - 1], times[found + 1]], axis=1)


def search(truth: Truth, pair: Pair, spans: Sequence[Values], times: FloatArray, around: FloatArray) -> Samples:
    """Narrow the neighbourhoods (k, 2) s of minima, all at once, and return every instant tried.

    One that motion between its instants cannot bring to breaking is left.
    """
    tried, found = [times[:0]], [times[:0]]
    for _ in range(ROUNDS if len(around) else 0):
        grid = np.linspace(around[:, 0], around[:, 1], SECTIONS + 2, axis=1)
        flat = grid.reshape(-1)
        poses = truth.kinematics.relative(*pair, flat)
        signed = truth.pair(*pair).signed(poses)
        inside = np.isin(flat, outside_contacts(spans, flat))
        slack = np.where(inside, signed - clearances(spans, flat), np.inf).reshape(grid.shape)
        best = np.clip(slack.argmin(axis=1), 1, SECTIONS)
        tried.append(flat[inside])
        found.append(signed[inside])
        step = np.append(truth.steps(*pair, poses), 0.0).reshape(grid.shape)[:, :-1].max(axis=1)
        rows = np.flatnonzero(slack.min(axis=1) < REACH * step + truth.tolerance)
        if not len(rows):
            break
        around = np.stack([grid[rows, best[rows] - 1], grid[rows, best[rows] + 1]], axis=1)
    return Samples(np.concatenate(tried), np.concatenate(found))
