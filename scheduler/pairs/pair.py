"""A pair of bodies that might collide, and its measurement at one time: spheres first, exact meshes where they fail."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

import numpy as np

from ..bounds.body_slab import BodySlab, Points, lasting_slab
from ..bounds.inscribed_spheres import InscribedSpheres
from ..bounds.sphere_slabs import SphereSlabs
from ..bounds.triangle_overlap import TriangleOverlap, proper
from ..bounds.triangle_slabs import TriangleSlabs
from ..geometry.arrays import FloatArray
from ..geometry.transform import mapped, translation_of
from ..geometry.vector import Vector, norm, subtract, unit
from ..kinematics.chain import Part, Twist
from ..kinematics.relative_motion import PairState, RelativeMotion
from ..model.body_tree import ancestors, common_ancestor
from ..model.events import Distance, Feature, FeatureKind, Level, PairKey, Verdict
from ..model.scene import Scene
from ..narrow.closest_points import ClosestPoints, Rounded
from ..narrow.narrow_phase import NarrowPhase
from ..narrow.triangle_pairs import NearTriangles

#: Bounding spheres settle a wakeup while their gap exceeds this share of the sum of their radii. Nearer, the exact
#: distance buys a sleep that is worth its cost.
FAR_IN_RADII = 0.5
#: An error of measurement above so many m leaves it open whether bodies touch that are nearer than that,
DOUBT = 1e-6
#: but not below this share of both radii: that is what any two bodies of their size have.
USUAL_SHARE = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """A pair at one time.

    Attributes:
        state: both chains then.
        level: what measured it.
        clearance: m, certified lower bound on the distance of the surfaces, 0 where they touch within the error of
            measurement.
        above: m, upper bound on that distance; inf where nothing exact was measured.
        margin: m, of the pair.
        proximity: the exact measurement in the ancestor's frame, None where spheres sufficed.
        inside: a point of one body inside a solid of the other (the ancestor's frame), None where there is none or
            nobody looked.
        hidden: m, where a large error of measurement leaves it open whether they touch: how deep the bodies may be in
            each other; inf where nobody knows. Else 0.
    """

    time: float
    state: PairState
    level: Level
    clearance: float
    above: float
    margin: float
    proximity: ClosestPoints | None
    inside: Vector | None = None
    hidden: float = 0.0

    @property
    def touching(self) -> bool:
        """Whether the solids share a point: to within the error of measurement, or certainly where that is large."""
        return (self.clearance <= 0.0 and self.hidden == 0.0) or self.inside is not None

    @property
    def status(self) -> Verdict:
        """CONTACT, BREACH (nearer than the margin, to within the error of measurement) or CLEAR, of the instant.

        A pair that may touch, but not certainly, stands as in breach: nearer than any margin.
        """
        if self.touching:
            return Verdict.CONTACT
        return Verdict.BREACH if self.clearance <= self.margin else Verdict.CLEAR

    @property
    def threshold(self) -> float:
        """The distance (m) above which the status is proved: the margin, or in breach that of contact."""
        return self.margin if self.status is Verdict.CLEAR else 0.0


class Pair:
    """Two bodies that might collide, seen from their lowest common ancestor.

    Attributes:
        start, end: s, between which both bodies exist.
        path_unknown: whether the path of one of them is unknown, so that growing balls stand for it; all
            measurements are then of those.
        at_start: the same two at their start, where that is known though the paths are not.
        margin: m, nearer than which the pair is in breach.
        error: m, by which a measured distance may be wrong.
        coarse: whether that is so large that bodies nearer than it only touch where they certainly overlap.
    """

    def __init__(
        self,
        key: PairKey,
        scene: Scene,
        motion: RelativeMotion,
        phase: NarrowPhase,
        margin: float,
        narrow_indices: tuple[int, int],
        at_start: Pair | None = None,
    ):
        """Take the pair's relative motion, its margin in m, and what stands for its bodies in the narrow phase.

        `at_start` is the pair at rest where paths are unknown, if its bodies' places are known at its start.
        """
        self.key = key
        self.motion = motion
        self.path_unknown = bool(motion.unknown)
        self.at_start = at_start
        self.margin = margin
        self.start, self.end = scene.shared_time(key.a, key.b)
        self._a, self._b = narrow_indices
        self.error = motion.rounding((self.start, self.end)) + phase.error(self._a, self._b)
        self.coarse = not self.path_unknown and self.error > max(DOUBT, USUAL_SHARE * motion.radii)
        self._bodies = scene.bodies
        self._narrow_phase = phase

    def measure(self, t: float) -> Measurement:
        """Measure how far apart the surfaces are at t; whether one is inside the other is asked separately."""
        return self.measure_beyond(t, self.margin + FAR_IN_RADII * self.motion.radii)

    def measure_beyond(self, t: float, far: float) -> Measurement:
        """Measure the same, by bounding spheres where they are farther apart than `far` m."""
        state = self.motion.at(t)
        centres = norm(subtract(state.a.centre, state.b.centre))
        clearance = centres - self.motion.radii - self.motion.spread(t) - self.error
        if clearance > far and not self._round:
            return Measurement(t, state, Level.SPHERE, clearance, inf, self.margin, None)
        return self._measured_exactly(t, state)

    def measure_exactly(self, t: float) -> Measurement:
        """Measure the same, but never by bounding spheres alone."""
        return self.measure_beyond(t, inf)

    def far(self, clearance: float) -> bool:
        """Return whether a clearance (m) by bounding spheres says enough of a pair."""
        return clearance - self.margin > FAR_IN_RADII * self.motion.radii

    def _measured_exactly(self, t: float, state: PairState) -> Measurement:
        if self._round:
            level, proximity = Level.SPHERE, self._between_spheres(state)
        else:
            level = Level.MESH
            proximity = self._narrow_phase.nearest(self._a, self._b, state.a.pose, state.b.pose)
        gap = proximity.distance - self.motion.spread(t)
        above = inf if self.path_unknown else gap + self.error
        hidden = 0.0
        if self.coarse and gap <= self.error and self._overlap(state) < self.error:
            hidden = self.error if gap > 0.0 else inf
        clearance = max(0.0, gap - self.error)
        return Measurement(t, state, level, clearance, above, self.margin, proximity, hidden=hidden)

    def _overlap(self, state: PairState) -> float:
        """Return how deep (m) the bodies are in each other as measured, errors not taken off; 0 if unknown."""
        deep = self._narrow_phase.depth(self._a, self._b, state.a.pose, state.b.pose)
        one, other = self._inner_radii
        apart = norm(subtract(state.a.centre, state.b.centre))
        return max(deep, one + other - apart) if one > 0.0 and other > 0.0 else deep

    def look_inside(self, measurement: Measurement) -> Measurement:
        """Return the measurement with containment decided; needed wherever disjoint surfaces do not prove it."""
        if measurement.touching or measurement.hidden or measurement.level is not Level.MESH:
            return measurement
        state = measurement.state
        inside = self._narrow_phase.contained(self._a, self._b, state.a.pose, state.b.pose)
        return replace(measurement, inside=inside)

    def depth(self, measurement: Measurement) -> float:
        """Return how far (m) touching bodies may get relative to each other and certainly still touch.

        What touches to within the error of measurement may get as far again: then it does to within three times that.
        Not so where the error is large.
        """
        if measurement.inside is not None:
            return measurement.clearance
        state = measurement.state
        proximity = measurement.proximity
        if proximity is not None and proximity.distance > 0.0:  # only balls that have grown meet
            depth = -proximity.distance
        else:
            depth = self._narrow_phase.depth(self._a, self._b, state.a.pose, state.b.pose)
        least = 0.0 if self.coarse else self.error
        return max(depth + self.motion.spread(measurement.time) - self.error, least)

    def slabs(self, measurement: Measurement, duration: float, beyond: float) -> TriangleSlabs | None:
        """Return the slabs between the bodies' triangles at a measurement, None where there are too many.

        Args:
            measurement: exact, of bodies apart.
            duration: s, how far ahead they may be asked of.
            beyond: m, what the triangles that are left out keep as distance until then.
        """
        state = measurement.state
        near = self.motion.approach(state, duration, Part.CORE)
        reach = self.motion.displacement(state, near.horizon) * (1.0 + 1e-6) + beyond
        spread = self.motion.spread(measurement.time)
        found = self._triangles_within(state, reach + spread + 2.0 * self.error)
        if found is None:
            return None
        twists, slack = self._twists(state), self.motion.slack(state)
        proximity = measurement.proximity
        assert proximity is not None
        direction = unit(subtract(proximity.witness_b, proximity.witness_a))
        return TriangleSlabs(found, twists, direction, self.error + spread, reach, near, slack)

    def slab(self, measurement: Measurement, duration: float, beyond: float) -> BodySlab | None:
        """Return the slab between the whole bodies at a measurement that lasts longest, None where none is found.

        Args:
            measurement: exact, of bodies apart.
            duration: s, how far ahead it may be asked of.
            beyond: m, the width that it is chosen to keep.
        """
        state = measurement.state
        proximity = measurement.proximity
        assert proximity is not None
        near = self.motion.approach(state, duration, Part.CORE)
        twists, slack = self._twists(state), self.motion.slack(state)
        centre = state.a.pose[:3, 3]
        chains = zip((self.motion.a, self.motion.b), (state.a.pose, state.b.pose), twists, strict=True)
        one, other = (
            Points(chain.extent.points @ pose[:3, :3].T + (pose[:3, 3] - centre), chain.extent.radii, twist)
            for chain, pose, twist in chains
        )
        features = proximity.feature_a(), proximity.feature_b()
        nearest = self._narrow_phase.corners(self._a, self._b, state.a.pose, state.b.pose, features)
        error = self.error + self.motion.spread(measurement.time)
        return lasting_slab(one, other, nearest, error, beyond, near, slack)

    def sphere_slabs(self, measurement: Measurement, duration: float, beyond: float) -> SphereSlabs:
        """Return the slabs between the bodies' bounding balls from a measurement on.

        Args:
            measurement: of any level.
            duration: s, how far ahead they may be asked of.
            beyond: m, the width that they are chosen to keep.
        """
        return SphereSlabs(self.motion, self.error, measurement.state, duration, beyond)

    def inscribed_spheres(self) -> InscribedSpheres | None:
        """Return balls inside both bodies, of known path; None where the middle of a body's bounds is outside of it."""
        one, other = self._inner_radii
        return InscribedSpheres(self.motion, one + other - self.error) if one > 0.0 and other > 0.0 else None

    @cached_property
    def _inner_radii(self) -> tuple[float, float]:
        """The radii (m) of balls about the middles of both bodies' bounds that these hold, 0 without one."""
        inner = self._narrow_phase.inscribed_radius
        return inner(self._a, self.motion.a.ball.centre), inner(self._b, self.motion.b.ball.centre)

    def overlaps(self, measurement: Measurement, duration: float) -> TriangleOverlap | None:
        """Return the overlaps of touching bodies' triangles, of some where there are many; None of far too many.

        Args:
            measurement: of bodies of known path, whose surfaces touch.
            duration: s, how far ahead they may be asked of.
        """
        state = measurement.state
        found = self._triangles_within(state, 2.0 * self.error, some=True)
        if found is None:
            return None
        near = self.motion.approach(state, duration, Part.CORE)
        twists, slack = self._twists(state), self.motion.slack(state)
        return TriangleOverlap(proper(found), twists, self.error, near, slack)

    def _triangles_within(self, state: PairState, reach: float, some: bool = False) -> NearTriangles | None:
        """Return the pairs of triangles that may be within `reach` (m), as seen from the first body's place."""
        return self._narrow_phase.triangles_within(self._a, self._b, state.a.pose, state.b.pose, reach, some)

    def _twists(self, state: PairState) -> tuple[Twist, Twist]:
        """Return how both bodies move, as seen from the first one's place."""
        centre = translation_of(state.a.pose)
        a, b = state.a.twist, state.b.twist
        return a._replace(origin=subtract(a.origin, centre)), b._replace(origin=subtract(b.origin, centre))

    def distance(self, measurement: Measurement) -> Distance | None:
        """Return the measurement as it is reported, in the world's frame; None where nothing exact was measured.

        Where a path is unknown, the nearest points are those of the ball at the rest place, before it has grown.
        """
        proximity = measurement.proximity
        if proximity is None:
            return None
        a, b = proximity.witness_a, proximity.witness_b
        gap = max(0.0, proximity.distance - self.motion.spread(measurement.time))
        if measurement.inside is not None:
            a = b = measurement.inside
        if measurement.touching:
            gap = 0.0
        features, excess = (proximity.feature_a(), proximity.feature_b()), 0.0
        if not self.path_unknown:
            poses = measurement.state.a.pose, measurement.state.b.pose
            excess = self._narrow_phase.excess(self._a, self._b, *poses, proximity, features)
        if self._ancestry:
            world = self._world_from_ancestor(measurement.time)
            a, b = mapped(world, a), mapped(world, b)
        return Distance(measurement.time, self.key, gap, a, b, *features, excess)

    @cached_property
    def _round(self) -> bool:
        """Whether both bodies are single spheres, whose balls are themselves."""
        return self._narrow_phase.is_ball(self._a) and self._narrow_phase.is_ball(self._b)

    def _between_spheres(self, state: PairState) -> ClosestPoints:
        """Return the exact proximity of two spheres, whose balls are themselves."""
        core = Feature(FeatureKind.VERTEX, 0, 0, 0)
        return ClosestPoints.of_rounded(
            Rounded(state.a.centre, lambda: core, self.motion.a.ball.radius),
            Rounded(state.b.centre, lambda: core, self.motion.b.ball.radius),
        )

    def _world_from_ancestor(self, t: float) -> FloatArray:
        """Return the 4x4 pose of the frame that measurements are taken in."""
        pose = np.eye(4)
        for body in self._ancestry:
            pose = self._bodies[body].pose @ self._bodies[body].motion.pose(t) @ pose
        return pose

    @cached_property
    def _ancestry(self) -> tuple[int, ...]:
        """The bodies that carry the frame that measurements are taken in, nearest first."""
        ancestor = common_ancestor(self._bodies, self.key.a, self.key.b)
        return () if ancestor is None else ancestors(self._bodies, ancestor)
