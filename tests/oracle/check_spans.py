"""Checks of the certificate: spans tile the time, CLEAR is clear, CONTACT touches, UNRESOLVED is not too deep."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from .bodies import Surface
from .distance import PairDistance
from .rigid import FloatArray, inverse, rigid
from .sampling import Effort, Samples, clearances, span_index
from .truth import POINT, Pair, Truth

Values = dict[str, Any]

VERDICTS = ("CLEAR", "BREACH", "CONTACT", "UNRESOLVED", "POSSIBLE")

MARGIN_TIME = 1.0 / 16384.0
"""Of the contact tolerance: how well (s) it is known when a margin is crossed,"""
MARGIN_FLOATS = 8.0
"""or within so many floats of time, as in Unix time."""


def told(pair: Pair, span: Values | None) -> str:
    """Return how a fault names a pair and its span."""
    if span is None:
        return f"{'|'.join(pair)}: no span"
    return f"{'|'.join(pair)}: {span['verdict']} [{span['start']}, {span['end']}]"


def check_tiling(truth: Truth, pair: Pair, spans: Sequence[Values]) -> Iterable[str]:
    """The spans cover the time in which both bodies exist, without gap or overlap."""
    if not spans:
        return
    start, end = truth.interval(*pair)
    if spans[0]["start"] != start:
        yield f"{told(pair, spans[0])}: the pair's time begins at {start}"
    if spans[-1]["end"] != end:
        yield f"{told(pair, spans[-1])}: the pair's time ends at {end}"
    for before, after in pairwise(spans):
        if before["end"] != after["start"]:
            kind = "gap" if before["end"] < after["start"] else "overlap"
            yield f"{told(pair, after)}: {kind}, the span before ends at {before['end']}"
    for span in spans:
        if not span["start"] < span["end"] and start < end:
            yield f"{told(pair, span)}: has no length"
        if span["verdict"] not in VERDICTS:
            yield f"{told(pair, span)}: no such verdict"
        if not span["clearance"] >= 0.0:
            yield f"{told(pair, span)}: clearance {span['clearance']}"


def free(span: Values) -> bool:
    """Tell whether a span is certified free of contact: CLEAR, BREACH, or unresolved as to the margin alone."""
    return span["verdict"] in ("CLEAR", "BREACH") or (span["verdict"] == "UNRESOLVED" and span["clearance"] > 0.0)


def check_certificate(
    truth: Truth, pair: Pair, spans: Sequence[Values], samples: Samples, chord: float
) -> Iterable[str]:
    """No instant inside a span free of contact touches; none is nearer than the clearance, nor the margin if CLEAR.

    Without any span the pair counts as CLEAR over its whole time. One line a span: its worst instant.
    """
    index = span_index(spans, samples.times)
    promised = clearances(spans, samples.times)
    margin = truth.margin(*pair)
    for i, span in enumerate(spans or [None]):
        inside = index == i if span is not None else np.ones(len(index), dtype=bool)
        if not inside.any():
            continue
        times, signed = samples.times[inside], samples.signed[inside]
        certified = span is None or free(span)
        worst = int(signed.argmin())
        if certified and signed[worst] < -truth.sure_depth:
            yield f"{told(pair, span)}: touches at {times[worst]} s, {-signed[worst]:.3g} m deep"
        below = promised[inside] - np.maximum(signed, 0.0)
        worst = int(below.argmax())
        if below[worst] > truth.tolerance:
            yield f"{told(pair, span)}: {below[worst]:.3g} m nearer than its clearance at {times[worst]} s"
        if margin > 0.0:
            yield from check_margin(truth, pair, span, Samples(times, signed), chord)


def check_margin(truth: Truth, pair: Pair, span: Values | None, samples: Samples, chord: float) -> Iterable[str]:
    """A CLEAR span keeps the margin; a BREACH span is at it or below it at both ends, or just inside a jump."""
    margin = truth.margin(*pair)
    if span is None or span["verdict"] == "CLEAR":
        short = margin - samples.signed
        near = np.flatnonzero(short > truth.tolerance)
        short[near] -= truth.creep(*pair, samples.times[near])
        worst = int(short.argmax())
        if short[worst] > truth.tolerance:
            yield f"{told(pair, span)}: {short[worst]:.3g} m inside the margin at {samples.times[worst]} s"
    elif span["verdict"] == "BREACH":
        step = max(MARGIN_TIME * truth.contact_tolerance, MARGIN_FLOATS * np.spacing(abs(span["end"])))
        inner = (min(span["start"] + step, span["end"]), max(span["end"] - step, span["start"]))
        times = np.array([span["start"], span["end"], *inner])
        over = truth.signed(*pair, times) - truth.creep(*pair, times) - margin - chord
        for time, distance in zip(times, np.minimum(over[:2], over[2:]), strict=False):
            if distance > truth.tolerance:
                yield f"{told(pair, span)}: {distance:.3g} m outside the margin at its end {time} s"


def check_contacts(
    truth: Truth, pair: Pair, spans: Sequence[Values], collisions: Sequence[Values], effort: Effort, chord: float
) -> Iterable[str]:
    """CONTACT spans run from a BEGIN's clear time to an END's, or to the pair's end, and touch between."""
    _, end = truth.interval(*pair)
    begins = {event["time_clear"]: event for event in collisions if event["phase"] == "BEGIN"}
    ends = {event["time_clear"]: event for event in collisions if event["phase"] == "END"}
    contacts = [span for span in spans if span["verdict"] == "CONTACT"]
    for span in contacts:
        begin, finish = begins.pop(span["start"], None), ends.pop(span["end"], None)
        if begin is None:
            yield f"{told(pair, span)}: no BEGIN is clear at its start"
        if finish is None and span["end"] != end:
            yield f"{told(pair, span)}: no END is clear at its end"
        if begin is not None:
            until = end if finish is None else finish["time_touching"]
            yield from check_touching(truth, pair, span, (begin["time_touching"], until), effort, chord)
    for time in (*begins, *ends):
        yield f"{'|'.join(pair)}: a collision with time_clear {time} bounds no CONTACT span"


def check_touching(
    truth: Truth, pair: Pair, span: Values, between: tuple[float, float], effort: Effort, chord: float
) -> Iterable[str]:
    """Inside a contact no stretch longer than two time resolutions is clear, as touching is measured once in each.

    Two, since the measurements on both sides of a stretch may fall just outside of it. Apart is what is farther than
    the chord error (m).
    """
    reach = 1.05 * truth.time_resolution
    first, last = between[0] + reach, between[1] - reach
    if first > last:
        return
    allowed = truth.tolerance + chord
    times = np.linspace(first, last, max(5, effort.uniform // 10))
    apart = np.flatnonzero(truth.signed(*pair, times) > allowed)
    for i in apart[:20]:
        stretch = np.linspace(times[i] - reach, times[i] + reach, 43)
        gaps = truth.signed(*pair, stretch)
        if (gaps > allowed).all():
            yield f"{told(pair, span)}: apart by {gaps.min():.3g} m or more around {times[i]} s"
            return


def check_depths(truth: Truth, pair: Pair, spans: Sequence[Values], samples: Samples, effort: Effort) -> Iterable[str]:
    """In an UNRESOLVED span no corner of one solid lies deeper in the other than its depth limit."""
    index = span_index(spans, samples.times)
    unresolved = [i for i, span in enumerate(spans) if span["verdict"] == "UNRESOLVED"]
    touching = (samples.signed < -truth.sure_depth) & np.isin(index, unresolved)
    chosen = np.flatnonzero(touching)
    if not len(chosen):
        return
    chosen = chosen[np.argsort(samples.signed[chosen])][: max(1, effort.messages // 4)]
    poses = truth.kinematics.relative(*pair, samples.times[chosen])
    for i, pose in zip(chosen, poses, strict=True):
        span = spans[int(index[i])]
        depth = deepest(truth.surfaces[pair[0]], truth.surfaces[pair[1]], pose)
        if depth > span["depth_limit"] + truth.tolerance:
            time = samples.times[i]
            yield f"{told(pair, span)}: {depth:.3g} m deep at {time} s, limit {span['depth_limit']:.3g}"


def deepest(a: Surface, b: Surface, pose: FloatArray) -> float:
    """Return m: a depth that some point of one body has in the other, b at `pose` (4x4) in a: no more than the largest.

    Tried for each corner of one body's triangles against the whole other body.
    """
    return max(depth_in(a, b, pose), depth_in(b, a, inverse(pose[None])[0]))


def depth_in(host: Surface, guest: Surface, pose: FloatArray) -> float:
    """Return m: the largest depth in `host` of a corner of `guest` (its ball, if rounded), guest at `pose`.

    A corner with rounding radius r at core distance s outside of a core with rounding R: the ball's nearest point
    is R - (s - r) deep, but no deeper than R. Inside a closed core at distance s from its surface: s deep.
    """
    corners = guest.triangles.reshape(-1, 3) @ pose[:3, :3].T + pose[:3, 3]
    corners, first = np.unique(corners, axis=0, return_index=True)
    radii = np.repeat(guest.radii, 3)[first]
    bare = Surface(host.triangles, np.zeros_like(host.radii), host.probes, ())
    gaps = np.maximum(PairDistance(bare, POINT).surfaces(rigid(None, corners)), 0.0)
    held = np.zeros(len(corners), dtype=bool)
    for solid in host.solids:
        held |= solid.holds(corners)
    rounding = host.radii.min()
    outside = np.minimum(rounding, rounding - (gaps - radii))
    one_solid = len(host.solids) == 1 and len(host.triangles) == len(host.solids[0].surface)
    return float(np.where(held & one_solid, gaps, outside).max(initial=0.0))
