"""Makes the pairs of bodies that might collide."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..geometry.transform import translation_of
from ..geometry.vector import ZERO, norm
from ..kinematics.chain import Chain, chain_to
from ..kinematics.relative_motion import RelativeMotion
from ..model.body_tree import ancestors, common_ancestor, rigid_group
from ..model.events import PairKey
from ..model.extent import Ball, Extent, body_extents
from ..model.scene import Scene, all_pairs, pair_id
from ..model.share import WHOLE, Share
from ..motions import Limits
from ..narrow.narrow_phase import NarrowPhase
from .pair import Pair


class Side(NamedTuple):
    """One body of a pair: its chain, its index in the narrow phase, and the limits of a path that is unknown."""

    chain: Chain
    narrow_index: int
    unknown: tuple[Limits, ...]


def pairs_that_might_collide(scene: Scene, narrow_phase: NarrowPhase, margin: float) -> Iterator[Pair]:
    """Return the allowed pairs of bodies with shapes that exist together and can move relative to each other, by id.

    Args:
        scene: whose rules say which pairs are allowed.
        narrow_phase: of its bodies; gets a ball for each whose path is unknown.
        margin: m, of pairs that no rule gives one of their own.
    """
    return PairFactory(scene, narrow_phase, margin).all()


class PairFactory:
    """Makes the pairs of a scene, one at a time; bodies' chains are shared between them.

    Attributes:
        scene: whose rules say which pairs are allowed.
        sides: what stands for its bodies.
        narrow_phase: of its bodies; gets a ball for each whose path is unknown.
        margin: m, of pairs that no rule gives one of their own.
    """

    def __init__(self, scene: Scene, narrow_phase: NarrowPhase, margin: float) -> None:
        """Take the scene; no pair is made yet."""
        self.scene = scene
        self.sides = Sides(scene, narrow_phase)
        self.narrow_phase = narrow_phase
        self.margin = margin

    def all(self, share: Share = WHOLE) -> Iterator[Pair]:
        """Yield every pair that might collide, or those of a share, by id."""
        for number, (a, b) in enumerate(all_pairs(len(self.scene.bodies))):
            if share.has(number) and (pair := self.pair(a, b)) is not None:
                yield pair

    def pair(self, a: int, b: int) -> Pair | None:
        """Return the pair of the bodies a < b; None where they have no shapes or cannot meet, or may not be checked."""
        scene, sides = self.scene, self.sides
        if a not in sides.extents or b not in sides.extents or not scene.rules.allow(a, b):
            return None
        begin, end = scene.shared_time(a, b)
        ancestor = common_ancestor(scene.bodies, a, b)
        one, other = sides.of(a, ancestor), sides.of(b, ancestor)
        motion = RelativeMotion(one.chain, other.chain, one.unknown + other.unknown)
        if motion.rigid or begin >= end:
            return None
        key = PairKey(pair_id(a, b, len(scene.bodies)), a, b)
        own = scene.rules.margin(a, b, self.margin)
        at_start = None
        if motion.unknown and sides.known_at(begin, a, ancestor) and sides.known_at(begin, b, ancestor):
            still = RelativeMotion(sides.at_rest(a, ancestor), sides.at_rest(b, ancestor))
            at_start = Pair(key, scene, still, self.narrow_phase, own, (a, b))
        return Pair(key, scene, motion, self.narrow_phase, own, (one.narrow_index, other.narrow_index), at_start)


def ignored_pairs(scene: Scene) -> Iterator[tuple[int, int]]:
    """Yield the pairs that only the scene's rules keep from being checked, by id; the first ones come at once."""
    rules = scene.rules
    anchors = {index: rigid_group(scene.bodies, index) for index, body in enumerate(scene.bodies) if body.shapes}
    for a, above in anchors.items():
        others = frozenset[int]().union(*(rule.partners(a) for rule in rules.ignored)) if rules.default else anchors
        for b in sorted(b for b in others if b > a and b in anchors and anchors[b] != above):
            begin, end = scene.shared_time(a, b)
            if begin < end and not rules.allow(a, b):
                yield a, b


class Sides:
    """What stands for the bodies of a scene in their pairs.

    A body is itself, seen from an ancestor. Where a path between the two is unknown, a ball stands for it that holds it
    however the frames below are turned, and grows about the rest place of the uppermost frame of such a path.

    Attributes:
        extents: by body, of those that have shapes.
    """

    def __init__(self, scene: Scene, narrow_phase: NarrowPhase) -> None:
        """Take the scene, and the narrow phase of its bodies."""
        self.extents = body_extents(scene.bodies)
        self._bodies = scene.bodies
        self._times = (scene.start, scene.end)
        self._narrow_phase = narrow_phase
        self._balls: dict[tuple[int, int], tuple[int, Extent]] = {}
        self._made: dict[tuple[int, int | None], Side] = {}

    def of(self, body: int, ancestor: int | None) -> Side:
        """Return what stands for a body seen from an ancestor, made once."""
        if (body, ancestor) not in self._made:
            self._made[body, ancestor] = self._side(body, ancestor)
        return self._made[body, ancestor]

    def _side(self, body: int, ancestor: int | None) -> Side:
        unknown = self._unknown(body, ancestor)
        if not unknown:
            return Side(self.at_rest(body, ancestor), body, ())
        top = unknown[-1]
        narrow_index, extent = self._ball(body, top)
        motion = self._bodies[top].motion
        assert isinstance(motion, Limits)
        return Side(chain_to(self._bodies, top, ancestor, extent), narrow_index, (motion,))

    def at_rest(self, body: int, ancestor: int | None) -> Chain:
        """Return a body's chain, as if all of unknown path stood at rest."""
        return chain_to(self._bodies, body, ancestor, self.extents[body])

    def known_at(self, time: float, body: int, ancestor: int | None) -> bool:
        """Return whether the body is at a known place at a time (s), seen from an ancestor."""
        motions = (self._bodies[index].motion for index in self._unknown(body, ancestor))
        return all(isinstance(motion, Limits) and time <= motion.begin for motion in motions)

    def _unknown(self, body: int, ancestor: int | None) -> list[int]:
        """Return the frames of unknown path from a body up to below an ancestor, the body's own first."""
        line = ancestors(self._bodies, body)
        below = line if ancestor is None else line[: line.index(ancestor)]
        return [index for index in below if isinstance(self._bodies[index].motion, Limits)]

    def _ball(self, body: int, top: int) -> tuple[int, Extent]:
        """Return a ball about the frame `top` that holds a body below it at all times, and its index."""
        if (body, top) not in self._balls:
            line = ancestors(self._bodies, body)
            own = self.extents[body]
            radius = float(np.max(np.linalg.norm(own.points, axis=1) + own.radii))
            for index in line[: line.index(top)]:
                radius += self._bodies[index].motion.extent(self._times) + norm(
                    translation_of(self._bodies[index].pose)
                )
            extent = Extent(np.zeros((1, 3)), np.array([radius]), Ball(ZERO, radius))
            self._balls[body, top] = self._narrow_phase.add_ball(radius), extent
        return self._balls[body, top]
