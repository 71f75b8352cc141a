"""A pair of bodies that might collide, and its measurement at one time: spheres first, exact meshes where they fail."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .chain import Extent, chain_to, common_ancestor, lineage
from .events import Distance, Feature, FeatureKind, Level, PairKey
from .narrow_phase import NarrowPhase, Proximity, Rounded, body_extent
from .relative import Moments, RelativeMotion
from .rotation import FloatArray, mapped
from .scene import Body, Scene, all_pairs, pair_id
from .vector import Vector, norm, subtract

#: Bounding spheres settle a wakeup while their gap exceeds this share of the sum of their radii. Nearer, the exact
#: distance buys a sleep that is worth its cost.
SPHERES_SUFFICE = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """A pair at one time.

    Attributes:
        moments: both chains then.
        level: what measured it.
        clearance: m, certified lower bound on the distance of the surfaces, 0 where they touch within the error of
            measurement.
        proximity: the exact measurement in the ancestor's frame, None where spheres sufficed.
        inside: a point of one body inside a solid of the other (the ancestor's frame), None where there is none or
            nobody looked.
    """

    time: float
    moments: Moments
    level: Level
    clearance: float
    proximity: Proximity | None
    inside: Vector | None = None

    @property
    def touching(self) -> bool:
        """Whether the solids share a point, to within the error of measurement."""
        return self.clearance <= 0.0 or self.inside is not None


class Pair:
    """Two bodies that might collide, seen from their lowest common ancestor."""

    def __init__(
        self, key: PairKey, bodies: tuple[Body, ...], motion: RelativeMotion, phase: NarrowPhase, error: float
    ):
        """Take the pair's relative motion and `error`, m, by which a measured distance may be too large."""
        self.key = key
        self.motion = motion
        self.error = error
        self._bodies = bodies
        self._narrow_phase = phase

    def measure(self, t: float) -> Measurement:
        """Measure how far apart the surfaces are at t; whether one is inside the other is asked separately."""
        moments = self.motion.at(t)
        radii = self.motion.a.ball.radius + self.motion.b.ball.radius
        clearance = norm(subtract(moments.a.centre, moments.b.centre)) - radii - self.error
        if clearance > SPHERES_SUFFICE * radii and not self._round:
            return Measurement(t, moments, Level.SPHERE, clearance, None)
        return self._measured_exactly(t, moments)

    def measure_exactly(self, t: float) -> Measurement:
        """Measure the same, but never by bounding spheres alone."""
        return self._measured_exactly(t, self.motion.at(t))

    def _measured_exactly(self, t: float, moments: Moments) -> Measurement:
        if self._round:
            level, proximity = Level.SPHERE, self._between_spheres(moments)
        else:
            level = Level.MESH
            proximity = self._narrow_phase.nearest(self.key.a, self.key.b, moments.a.pose, moments.b.pose)
        return Measurement(t, moments, level, max(0.0, proximity.distance - self.error), proximity)

    def look_inside(self, measurement: Measurement) -> Measurement:
        """Return the measurement with containment decided; needed wherever disjoint surfaces do not prove it."""
        if measurement.touching or measurement.level is not Level.MESH:
            return measurement
        moments = measurement.moments
        inside = self._narrow_phase.contained(self.key.a, self.key.b, moments.a.pose, moments.b.pose)
        return Measurement(
            measurement.time, moments, measurement.level, measurement.clearance, measurement.proximity, inside
        )

    def distance(self, measurement: Measurement) -> Distance | None:
        """Return the measurement as it is reported, in the world's frame; None where nothing exact was measured."""
        proximity = measurement.proximity
        if proximity is None:
            return None
        a, b, gap = proximity.witness_a, proximity.witness_b, proximity.distance
        if measurement.inside is not None:
            a = b = measurement.inside
        if measurement.touching:
            gap = 0.0
        world = self._world_from_ancestor(measurement.time)
        return Distance(
            measurement.time,
            self.key,
            gap,
            mapped(world, a),
            mapped(world, b),
            proximity.feature_a,
            proximity.feature_b,
        )

    @cached_property
    def _round(self) -> bool:
        """Whether both bodies are single spheres, whose balls are themselves."""
        return all(
            len(body.shapes) == 1 and len(body.shapes[0].mesh.vertices) == 1
            for body in (self._bodies[self.key.a], self._bodies[self.key.b])
        )

    def _between_spheres(self, moments: Moments) -> Proximity:
        """Return the exact proximity of two spheres, whose balls are themselves."""
        core = Feature(FeatureKind.VERTEX, 0, 0, 0)
        return Proximity.of_rounded(
            Rounded(moments.a.centre, core, self.motion.a.ball.radius),
            Rounded(moments.b.centre, core, self.motion.b.ball.radius),
        )

    def _world_from_ancestor(self, t: float) -> FloatArray:
        """Return the 4x4 pose of the frame that measurements are taken in."""
        pose = np.eye(4)
        ancestor = common_ancestor(self._bodies, self.key.a, self.key.b)
        if ancestor is not None:
            for body in lineage(self._bodies, ancestor):
                pose = self._bodies[body].pose @ self._bodies[body].motion.pose(t) @ pose
        return pose


def pairs_that_might_collide(scene: Scene, narrow_phase: NarrowPhase) -> Iterator[Pair]:
    """Yield the allowed pairs of bodies with shapes that can move relative to each other, by pair id."""
    extents = {i: body_extent(body) for i, body in enumerate(scene.bodies) if body.shapes}
    latest = max(abs(scene.start), abs(scene.end))
    for a, b in all_pairs(len(scene.bodies)):
        if a not in extents or b not in extents or not scene.allows(a, b):
            continue
        motion = _relative_motion(scene.bodies, a, b, extents[a], extents[b])
        if motion.rigid:
            continue
        error = motion.rounding(latest) + narrow_phase.error(a, b)
        yield Pair(PairKey(pair_id(a, b, len(scene.bodies)), a, b), scene.bodies, motion, narrow_phase, error)


def _relative_motion(bodies: tuple[Body, ...], a: int, b: int, extent_a: Extent, extent_b: Extent) -> RelativeMotion:
    """Return the motion of both bodies below their lowest common ancestor."""
    ancestor = common_ancestor(bodies, a, b)
    return RelativeMotion(chain_to(bodies, a, ancestor, extent_a), chain_to(bodies, b, ancestor, extent_b))
