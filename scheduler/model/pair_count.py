"""How many pairs of bodies the rules allow, counted without listing the pairs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import IntArray
from .body_tree import anchors
from .scene import PairRules, Scene


class PairCounts(NamedTuple):
    """How many pairs might collide: those that are checked, and those that only the scene's rules keep from it."""

    checked: int
    ignored: int


def count_pairs(scene: Scene) -> PairCounts:
    """Count the pairs of bodies with shapes that exist together and can move relative to each other.

    Bodies of one anchor never part: their pairs are taken off again. Takes n log n for n bodies, times the number of
    kinds of bodies that the rules distinguish.
    """
    bodies = np.array([index for index, body in enumerate(scene.bodies) if body.shapes], dtype=np.int64)
    checked = ignored = 0
    for sign, together in [(1, bodies), *((-1, joined) for joined in _groups(bodies, anchors(scene.bodies)[bodies]))]:
        counts = _sharing_time(scene, together)
        checked += sign * counts.checked
        ignored += sign * counts.ignored
    return PairCounts(checked, ignored)


def _groups(bodies: IntArray, anchor_of: NDArray[np.int64]) -> Iterator[IntArray]:
    """Yield the bodies of each anchor that has several."""
    order = np.argsort(anchor_of, kind="stable")
    for group in np.split(bodies[order], np.flatnonzero(np.diff(anchor_of[order])) + 1):
        if len(group) > 1:
            yield group


def _sharing_time(scene: Scene, bodies: IntArray) -> PairCounts:
    """Count the pairs among some bodies that exist together, by what the rules say of them."""
    times = np.array([scene.shared_time(index, index) for index in bodies.tolist()]).reshape(-1, 2)
    there = times[:, 0] < times[:, 1]
    bodies, times = bodies[there], times[there]
    kinds, kind_of, allowed = kinds_of(scene.rules, bodies)
    members = [times[kind_of == kind] for kind in range(kinds)]
    counts = {True: 0, False: 0}
    for one in range(kinds):
        counts[bool(allowed[one, one])] += (_overlaps(members[one], members[one]) - len(members[one])) // 2
        for other in range(one + 1, kinds):
            counts[bool(allowed[one, other])] += _overlaps(members[one], members[other])
    return PairCounts(counts[True], counts[False])


def kinds_of(rules: PairRules, bodies: IntArray) -> tuple[int, IntArray, NDArray[np.bool_]]:
    """Return how many kinds of bodies the rules distinguish, each body's kind, and which kinds' pairs are checked."""
    sets = [*rules.checked, *rules.ignored]
    sides = [side for pairs in sets for side in (pairs.one, pairs.other)]
    named = np.array([[body in side for side in sides] for body in bodies.tolist()], dtype=bool)
    named = named.reshape(len(bodies), 2 * len(sets))
    kinds, kind_of = np.unique(named, axis=0, return_inverse=True) if sets else (named[:1], np.zeros(len(bodies), int))
    one, other = kinds[:, 0::2].astype(np.float64), kinds[:, 1::2].astype(np.float64)
    first = len(rules.checked)

    def either(part: slice) -> NDArray[np.bool_]:
        across = one[:, part] @ other[:, part].T
        fits: NDArray[np.bool_] = (across + across.T) > 0.0
        return fits

    allowed = either(slice(0, first))
    if rules.default:
        allowed |= ~either(slice(first, None))
    return len(kinds), kind_of.reshape(-1), allowed


def _overlaps(one: NDArray[np.float64], other: NDArray[np.float64]) -> int:
    """Return how many pairs of intervals longer than 0, one of (n, 2) and one of (m, 2), share more than an instant."""
    too_late = len(other) - np.searchsorted(np.sort(other[:, 0]), one[:, 1], side="left")
    too_early = np.searchsorted(np.sort(other[:, 1]), one[:, 0], side="right")
    return int(len(one) * len(other) - too_late.sum() - too_early.sum())
