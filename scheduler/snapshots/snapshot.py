"""Snapshots of the whole scene: every body's pose, and the nearest pairs."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import FloatArray
from ..geometry.vector import ZERO
from ..model.events import Collision, Nearness, Snapshot, Verdict
from ..model.extent import body_extents
from ..model.scene import Scene
from ..model.world_poses import WorldPoses
from ..narrow.narrow_phase import NarrowPhase
from ..pairs.pair import Pair

# Relative: what the sums of travels may lose to rounding.
_TRAVEL_ROUNDING = 1e-9


class Observer:
    """Takes snapshots: every body's pose, and the nearest pairs, exactly measured at that instant."""

    def __init__(self, scene: Scene, pairs: Sequence[Pair], most_pairs: int, narrow_phase: NarrowPhase) -> None:
        """Observe the scene's pairs; a snapshot names at most `most_pairs` >= 1 of them."""
        self._scene = scene
        self._poses = WorldPoses(scene.bodies)
        self._pairs = pairs
        self._most_pairs = most_pairs
        self._narrow_phase = narrow_phase
        self._travel = Travel(scene)
        self._first = np.array([pair.key.a for pair in pairs], dtype=np.int64)
        self._second = np.array([pair.key.b for pair in pairs], dtype=np.int64)
        self._path_unknown = np.array([pair.path_unknown for pair in pairs], dtype=bool)
        # What was measured last and the travel of both bodies by then: less their travel since, it bounds the distance.
        self._allowance = np.full(len(pairs), -inf)
        self._index = {pair.key.id: index for index, pair in enumerate(pairs)}

    def at(self, time: float, touching: frozenset[int], trigger: Collision | None = None) -> Snapshot:
        """Return the snapshot at `time` (s), while the pairs with ids in `touching` are in contact."""
        poses = self._poses.at(time)
        there = existing(self._scene, time)
        watched = there[self._first] & there[self._second]
        if trigger is not None:  # which may be the last that its pair does
            watched[self._index[trigger.pair.id]] = True
        nearest = tuple(self._nearest(time, poses, touching, watched))
        contacts = sum(1 for pair in touching if watched[self._index[pair]])
        return Snapshot(time, poses, there, nearest, contacts, trigger)

    def _nearest(
        self, time: float, poses: FloatArray, touching: frozenset[int], watched: NDArray[np.bool_]
    ) -> list[Nearness]:
        """Measure pairs in order of lower bounds on their distances until no other can be among the nearest."""
        self._travel.advance(poses)
        travelled = self._travel.so_far[self._first] + self._travel.so_far[self._second]
        bounds = np.maximum(self._travel.gaps(self._first, self._second), self._allowance - travelled)
        bounds[self._path_unknown] = -inf  # the ball that stands for an unknown place may be nearer than the body drawn
        bounds[~watched] = inf
        found: list[Nearness] = []
        for index in np.argsort(bounds, kind="stable"):
            if bounds[index] == inf:
                break
            if len(found) >= self._most_pairs and bounds[index] > found[-1].distance:
                break
            near = measured(self._pairs[index], time, poses, touching, self._narrow_phase)
            self._allowance[index] = near.distance + travelled[index]
            found.append(near)
            found.sort(key=lambda near: (near.distance, near.pair.id))
            del found[self._most_pairs :]
        return found


def measured(
    pair: Pair, time: float, poses: FloatArray, touching: frozenset[int], narrow_phase: NarrowPhase
) -> Nearness:
    """Measure a pair exactly; one known to be in contact reads 0 even where its surfaces are apart."""
    if pair.path_unknown:
        nearest = pair.distance(pair.look_inside(pair.measure_exactly(time)))
        assert nearest is not None
        verdict = Verdict.POSSIBLE if nearest.distance <= pair.margin else Verdict.CLEAR
        return Nearness(pair.key, nearest.distance, verdict, nearest.witness_a, nearest.witness_b)
    a, b = pair.key.a, pair.key.b
    found = narrow_phase.nearest(a, b, poses[a], poses[b])
    if pair.key.id in touching or found.distance <= (0.0 if pair.coarse else pair.error):
        return Nearness(pair.key, 0.0, Verdict.CONTACT, found.witness_a, found.witness_b)
    verdict = Verdict.BREACH if found.distance < pair.margin else Verdict.CLEAR
    return Nearness(pair.key, found.distance, verdict, found.witness_a, found.witness_b)


class Travel:
    """How far the points of bodies have got, from one set of poses to the next.

    Attributes:
        so_far: (n,) m, of each body, above the sum of what any of its points was displaced by.
    """

    def __init__(self, scene: Scene) -> None:
        """Start with nobody placed."""
        extents = body_extents(scene.bodies)
        balls = [extents[index].ball if index in extents else None for index in range(len(scene.bodies))]
        self._middles = np.array([ball.centre if ball else ZERO for ball in balls]).reshape(-1, 3)
        self._radii = np.array([ball.radius if ball else 0.0 for ball in balls])
        self._turns: FloatArray | None = None
        self._centres = np.zeros_like(self._middles)
        self.so_far = np.zeros(len(balls))

    def advance(self, poses: FloatArray) -> None:
        """Move all bodies to the poses (n, 4, 4).

        A point of a ball is displaced by no more than its centre is, and the radius times the norm of what the
        rotation changed by: that is its Frobenius norm over sqrt(2), as two of three singular values are equal and one
        is 0.
        """
        turns = poses[:, :3, :3]
        centres = np.einsum("nij,nj->ni", turns, self._middles) + poses[:, :3, 3]
        if self._turns is not None:
            turned = np.linalg.norm(turns - self._turns, axis=(1, 2)) / sqrt(2.0)
            moved = np.linalg.norm(centres - self._centres, axis=1) + self._radii * turned
            self.so_far += moved * (1.0 + _TRAVEL_ROUNDING)
        self._turns, self._centres = turns, centres

    def gaps(self, first: NDArray[np.int64], second: NDArray[np.int64]) -> FloatArray:
        """Return the gap (m) between the balls of pairs of bodies, negative where they overlap."""
        apart: FloatArray = np.linalg.norm(self._centres[first] - self._centres[second], axis=1)
        apart -= self._radii[first] + self._radii[second]
        return apart


def existing(scene: Scene, time: float) -> NDArray[np.bool_]:
    """Tell of each body whether it exists at `time` (s): up to its end, which only the scene's end belongs to."""
    return alive(lifetimes(scene), scene.end, time)


def alive(lifetimes: FloatArray, end: float, time: float) -> NDArray[np.bool_]:
    """Tell the same of the bodies' `lifetimes` in a scene that ends at `end` (s)."""
    from_, to = lifetimes
    there: NDArray[np.bool_] = (from_ <= time) & ((time < to) | (to >= end))
    return there


def lifetimes(scene: Scene) -> FloatArray:
    """Return when each body appears and vanishes, (2, n) s."""
    times: FloatArray = np.array([body.exists for body in scene.bodies]).reshape(-1, 2).T
    return times
