"""Snapshots of many bodies: the nearest pairs are sought where bodies are near, never among all pairs."""

from __future__ import annotations

from bisect import insort
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..broad.box_grid import BoxGrid
from ..geometry.arrays import FloatArray, IntArray
from ..model.body_tree import ancestors, rigid_group
from ..model.events import Collision, Nearness, Snapshot
from ..model.extent import Extent, body_extents
from ..model.pair_count import kinds_of
from ..model.scene import bodies_of_pair, pair_id
from ..model.world_poses import WorldPoses
from ..pairs.pair import Pair
from ..pairs.pair_factory import PairFactory
from .snapshot import alive, lifetimes, measured

#: A search that found too few pairs goes on this many times as far.
_FARTHER = 2.0
#: Of more moving bodies than this, a collision's snapshot places only those that it shows.
_MOST_PLACED = 64


class CrowdObserver:
    """Takes snapshots of a crowd.

    At a tick the nearest pairs are measured, as of a few bodies. At a collision only bodies in contact are, so that it
    costs no more where there are more of them: their distance, 0, is the least.
    """

    def __init__(self, factory: PairFactory, most_pairs: int) -> None:
        """Observe a scene's bodies; a snapshot names at most `most_pairs` >= 1 pairs."""
        self._factory = factory
        self._scene = factory.scene
        self._most_pairs = most_pairs
        self._poses = WorldPoses(self._scene.bodies)
        self._lifetimes = lifetimes(self._scene)
        bodies = self._scene.bodies
        self._anchors = np.array([-1 if (at := rigid_group(bodies, k)) is None else at for k in range(len(bodies))])
        extents = body_extents(bodies)
        self._solid = np.array(sorted(extents), dtype=np.int64)
        self._middles = np.array([(*extents[k].ball.centre, 1.0) for k in sorted(extents)])
        self._radii = np.array([extents[k].ball.radius for k in sorted(extents)])
        self._halves = np.array([_half_sides(extents[k]) for k in sorted(extents)])
        self._rounding = np.array([extents[k].radii.max() for k in sorted(extents)])
        sides = [(place, factory.sides.of(body, None)) for place, body in enumerate(self._solid.tolist())]
        self._unknown = [(place, side) for place, side in sides if side.unknown]
        _, self._kinds, self._allowed = kinds_of(self._scene.rules, self._solid)
        self._asking = _asking(self._kinds, self._allowed)
        self._usual = float(np.median(self._radii))
        self._reach = self._usual  # m: how far apart the balls of pairs are that are looked at
        self._pairs: dict[int, Pair | None] = {}

    def at(self, time: float, touching: frozenset[int], trigger: Collision | None = None) -> Snapshot:
        """Return the snapshot at `time` (s), while the pairs with ids in `touching` are in contact."""
        there = alive(self._lifetimes, self._scene.end, time)
        met = sorted(pair for pair in touching if all(there[list(self._bodies_of(pair))]))
        if trigger is None:
            search = _Search(time, self._poses.at(time), touching, self._most_pairs)
            nearest = self._nearest(search, met, np.flatnonzero(there[self._solid]))
        else:
            met = sorted({*met, trigger.pair.id})  # it may be the last that its pair does
            shown = met[: self._most_pairs]
            search = _Search(time, self._placed(time, [trigger.pair.id, *shown]), touching, self._most_pairs)
            nearest = [near for pair in shown if (near := self._measured(pair, search)) is not None]
        return Snapshot(time, search.poses, there, tuple(nearest), len(met), trigger)

    def _nearest(self, search: _Search, met: list[int], solid: IntArray) -> list[Nearness]:
        """Measure the pairs that are near, farther and farther out until no other can be among the nearest.

        Those in contact come first: where they are enough, none is nearer.
        """
        bounds = self._bounds(search)
        centres, radii = bounds.centres, bounds.radii
        for pair in met[: self._most_pairs]:
            self._measured(pair, search)
        whole = float(np.linalg.norm(np.ptp(centres, axis=0)) + 2.0 * radii.max())
        while True:
            for pair, gap in self._gaps(solid, bounds):
                if len(met) >= self._most_pairs or gap > search.farthest:
                    break
                self._measured(pair, search)
            if self._reach >= whole or search.farthest <= self._reach:
                break
            self._reach *= _FARTHER
        if search.farthest < inf:
            self._reach = max(search.farthest, self._usual)
        return search.nearest

    def _gaps(self, solid: IntArray, bounds: _Bounds) -> list[tuple[int, float]]:
        """Return the pairs of bodies that the rules allow, that may part and whose balls are in reach, by gap (m).

        A gap is that of the balls or of the boxes, whichever is larger: the bodies are no nearer.
        """
        centres, radii, halves, rounding = bounds
        grid = BoxGrid(len(radii))
        reach = (radii[solid] + 0.5 * self._reach)[:, None]
        grid.put(solid, centres[solid] - reach, centres[solid] + reach)
        one, other = grid.meeting(solid[self._asking[solid]])
        wanted = self._allowed[self._kinds[one], self._kinds[other]]
        one, other = one[wanted], other[wanted]
        between = np.abs(centres[one] - centres[other])
        boxes = np.linalg.norm(np.maximum(0.0, between - halves[one] - halves[other]), axis=1)
        boxes -= rounding[one] + rounding[other]
        gaps = np.maximum(np.linalg.norm(between, axis=1) - radii[one] - radii[other], boxes)
        first, second = self._solid[np.minimum(one, other)], self._solid[np.maximum(one, other)]
        part = self._anchors[first] != self._anchors[second]
        numbers = pair_id(first[part], second[part], len(self._anchors))
        order = np.lexsort((numbers, gaps[part]))
        return list(zip(numbers[order].tolist(), gaps[part][order].tolist(), strict=True))

    def _bounds(self, search: _Search) -> _Bounds:
        """Return the balls and boxes around the solid bodies, or around what may be."""
        poses = search.poses[self._solid]
        centres = np.einsum("nij,nj->ni", poses, self._middles)[:, :3]
        halves = np.einsum("nij,nj->ni", np.abs(poses[:, :3, :3]), self._halves)
        radii = self._radii.copy()
        for place, side in self._unknown:
            centres[place] = side.chain.at(search.time).centre
            radii[place] = side.chain.ball.radius + sum(limits.reach(search.time) for limits in side.unknown)
            halves[place] = radii[place]
        return _Bounds(centres, radii, halves, self._rounding)

    def _measured(self, number: int, search: _Search) -> Nearness | None:
        """Measure a pair, once in a search; None where it is not to be checked."""
        if number not in search.known:
            if number not in self._pairs:
                self._pairs[number] = self._factory.pair(*self._bodies_of(number))
            pair = self._pairs[number]
            near = None
            if pair is not None:
                near = measured(pair, search.time, search.poses, search.touching, self._factory.narrow_phase)
            search.add(number, near)
        return search.known[number]

    def _placed(self, time: float, pairs: list[int]) -> FloatArray:
        """Return the poses (n, 4, 4) of all bodies, where few move, or else of those in some pairs' chains alone."""
        if self._poses.moving <= _MOST_PLACED:
            return self._poses.at(time)
        bodies = self._scene.bodies
        poses = np.zeros((len(bodies), 4, 4))
        for body in {body for pair in pairs for body in self._bodies_of(pair)}:
            above = np.eye(4)
            for index in reversed(ancestors(bodies, body)):
                above = above @ (bodies[index].pose @ bodies[index].motion.pose(time))
                poses[index] = above
        return poses

    def _bodies_of(self, number: int) -> tuple[int, int]:
        return bodies_of_pair(number, len(self._anchors))


class _Bounds(NamedTuple):
    """Balls and boxes around bodies, about the same centres, all in m.

    Attributes:
        centres: (m, 3).
        radii: (m,) of the balls.
        halves: (m, 3), half the sides of the boxes, along the world's axes.
        rounding: (m,): a body lies within so much of its box.
    """

    centres: FloatArray
    radii: FloatArray
    halves: FloatArray
    rounding: FloatArray


def _half_sides(extent: Extent) -> FloatArray:
    """Return half the sides (3,) m of a box about the middle of a body, along its axes, that holds its points."""
    halves: FloatArray = np.abs(extent.points - extent.ball.centre).max(axis=0)
    return halves


class _Search:
    """The measurements of one instant.

    Attributes:
        known: by pair id; None of a pair that is not to be checked.
        nearest: the nearest of them, ties by pair id, so many at most.
    """

    def __init__(self, time: float, poses: FloatArray, touching: frozenset[int], most: int) -> None:
        self.time = time
        self.poses = poses
        self.touching = touching
        self.known: dict[int, Nearness | None] = {}
        self.nearest: list[Nearness] = []
        self._most = most

    @property
    def farthest(self) -> float:
        """The distance (m) beyond which no other pair is among the nearest; inf while they are too few."""
        return self.nearest[-1].distance if len(self.nearest) == self._most else inf

    def add(self, number: int, near: Nearness | None) -> None:
        """Take in what was measured of a pair."""
        self.known[number] = near
        if near is not None:
            insort(self.nearest, near, key=lambda near: (near.distance, near.pair.id))
            del self.nearest[self._most :]


def _asking(kinds: IntArray, allowed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which bodies (n,) ask for those near them: of every pair that is allowed, one at least.

    The others are of kinds that ignore each other, the largest first: those are never looked at among themselves.

    Args:
        kinds: (n,) of the bodies.
        allowed: (k, k) whose pairs are checked.
    """
    silent: list[int] = []
    for kind in np.argsort(-np.bincount(kinds, minlength=len(allowed)), kind="stable").tolist():
        if not allowed[kind, [*silent, kind]].any():
            silent.append(kind)
    asking: NDArray[np.bool_] = ~np.isin(kinds, silent)
    return asking
