"""The narrow phase: exact distances, touching and containment of two placed bodies. The only module that imports fcl.

Every shape is a triangle core plus a rounding radius, and only `fcl.distance` and `fcl.collide` on BVH models are used:
GJK distances over-estimate, continuous collision misses, mesh depths and normals mean nothing. Both bodies are measured
in a frame centred on the first, so that FCL's error follows their size and not their place.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Any, NamedTuple

import fcl
import numpy as np

from .events import Feature
from .extent import bounding_ball
from .nearby import NOTHING, NearTriangles, Triangles, near_pairs
from .rotation import FloatArray, mapped, translation_of
from .scene import Body, IntArray, Mesh, Shape
from .sliver import EPSILON, without_slivers
from .solid import Interior, component_points
from .triangle import Triangle, feature_at, meeting_point
from .vector import Vector, add, norm, scale, subtract, unit

#: FCL is given lengths times this power of two, which loses nothing. Unscaled it skips the face of every triangle whose
#: doubled area squared is below 1e-15 m^4, those of a 0.2 mm box among them, and then over- or underestimates
#: by up to 6% of their size (`python -m benchmarks.narrow_phase_error 3000 1 --unscaled`). Scaled it skips what
#: `without_slivers` has made segments of; the greatest coordinates, 1e30 m, are far from overflow in the fourth power.
SCALE = 2.0**60
#: m per m of size: a distance errs by less than this times the bodies' size about the centre of measurement, where no
#: triangle is thin (measured: at most 1.1e-16 over 6,000 near pairs, `python -m benchmarks.narrow_phase_error 6000`).
DISTANCE_ERROR = 64.0 * EPSILON

POINT = Mesh("point", np.zeros((1, 3)), np.zeros((1, 3), dtype=np.int64), solid=False)
"""The core of a ball."""

_PLAIN_REQUEST = fcl.DistanceRequest()
_DISTANCE_REQUEST = fcl.DistanceRequest(enable_nearest_points=True)
_COLLISION_REQUEST = fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)


class Rounded(NamedTuple):
    """A core's nearest point (m), what finds the feature that holds it, and the radius (m) that rounds it."""

    point: Vector
    feature: Callable[[], Feature]
    radius: float


@dataclass(frozen=True, slots=True)
class Proximity:
    """How near two bodies' surfaces are.

    Attributes:
        distance: m between the surfaces (rounding radii off), 0 where they meet.
        witness_a, witness_b: m, the nearest points, or twice one point where they meet; in the frame of the poses.
        feature_a, feature_b: find what holds them, which takes as long as finding the points.
    """

    distance: float
    witness_a: Vector
    witness_b: Vector
    feature_a: Callable[[], Feature]
    feature_b: Callable[[], Feature]

    @staticmethod
    def of_rounded(one: Rounded, other: Rounded) -> Proximity:
        """Return the proximity of two shapes whose cores' nearest points these are.

        Shapes that overlap meet half-way between their surfaces, in a point of the segment between the cores: it lies
        in both.
        """
        across = subtract(other.point, one.point)
        length = norm(across)
        direction = unit(across)
        gap = length - one.radius - other.radius
        if gap > 0.0:
            on_a = add(one.point, scale(one.radius, direction))
            on_b = subtract(other.point, scale(other.radius, direction))
            return Proximity(gap, on_a, on_b, one.feature, other.feature)
        middle = 0.5 * (length + one.radius - other.radius)
        met = add(one.point, scale(min(length, max(0.0, middle)), direction))
        return Proximity(0.0, met, met, one.feature, other.feature)

    def moved(self, offset: Vector) -> Proximity:
        """Return the same, seen from a frame whose origin lies at minus `offset` (m)."""
        return Proximity(
            self.distance,
            add(self.witness_a, offset),
            add(self.witness_b, offset),
            self.feature_a,
            self.feature_b,
        )


class Model:
    """A mesh as FCL wants it, shared by every shape that shows it."""

    def __init__(self, mesh: Mesh) -> None:
        """Build the bounding volume hierarchy."""
        self.mesh = mesh
        collapsed, self.error = without_slivers(mesh)
        self.bvh = _bvh(mesh.vertices, collapsed)
        self.ball = bounding_ball(mesh.vertices[np.unique(mesh.triangles)])
        self.points = component_points(mesh)
        self.triangles = Triangles.of(mesh.vertices[mesh.triangles])
        self.interior = Interior(mesh) if mesh.solid else None
        self.degenerate = bool(np.any(collapsed[:, 1] == collapsed[:, 2]))


class PlacedShape:
    """One shape of one body, with the FCL object that is moved for each measurement."""

    def __init__(self, index: int, shape: Shape, model: Model) -> None:
        """Take the shape's index in its body."""
        self.index = index
        self.shape = shape
        self.model = model
        self.reach = model.ball.radius + shape.radius
        self.extent = norm(model.ball.centre) + norm(translation_of(shape.pose)) + self.reach
        self.crisp = shape.radius == 0.0 and not model.degenerate
        self.object = fcl.CollisionObject(model.bvh, fcl.Transform())
        self.pose = shape.pose
        self.centre = model.ball.centre

    def place(self, body: FloatArray, origin: FloatArray) -> None:
        """Move the shape to where a body's pose puts it, as seen from `origin` (3,)."""
        self.pose = body @ self.shape.pose
        self.pose[:3, 3] -= origin
        self.object.setTransform(fcl.Transform(self.pose[:3, :3], self.pose[:3, 3] * SCALE))
        self.centre = mapped(self.pose, self.model.ball.centre)

    def local(self, points: FloatArray) -> FloatArray:
        """Return points (k, 3) of the measuring frame in the mesh's frame."""
        inverse: FloatArray = (points - self.pose[:3, 3]) @ self.pose[:3, :3]
        return inverse

    def world(self, points: FloatArray) -> FloatArray:
        """Return points (k, 3) of the mesh's frame in the measuring frame."""
        moved: FloatArray = points @ self.pose[:3, :3].T + self.pose[:3, 3]
        return moved

    def corners(self, triangle: int) -> Triangle:
        """Return a core triangle's corners in the measuring frame."""
        return self._corners(triangle, self.pose)

    def rounded(self, triangle: int, witness: Vector) -> Rounded:
        """Return the core's witness, and what finds what of its triangle holds it, also once the shape has moved on."""
        return Rounded(witness, partial(self._feature, triangle, witness, self.pose), self.shape.radius)

    def _corners(self, triangle: int, pose: FloatArray) -> Triangle:
        corners = self.model.mesh.vertices[self.model.mesh.triangles[triangle]]
        a, b, c = (corners @ pose[:3, :3].T + pose[:3, 3]).tolist()
        return tuple(a), tuple(b), tuple(c)

    def _feature(self, triangle: int, witness: Vector, pose: FloatArray) -> Feature:
        kind, index = feature_at(witness, self._corners(triangle, pose))
        return Feature(kind, self.index, triangle, index)


class NarrowPhase:
    """The exact measurements of a scene's bodies.

    Attributes:
        seconds: wall-clock time spent inside FCL so far.
    """

    def __init__(self, bodies: tuple[Body, ...]) -> None:
        """Build one model a mesh and one placed shape a shape."""
        self.seconds = 0.0
        meshes = {id(shape.mesh): shape.mesh for body in bodies for shape in body.shapes}
        models = {key: Model(mesh) for key, mesh in meshes.items()}
        self._bodies = [
            tuple(PlacedShape(i, shape, models[id(shape.mesh)]) for i, shape in enumerate(body.shapes))
            for body in bodies
        ]
        self._point = fcl.CollisionObject(_bvh(POINT.vertices, POINT.triangles), fcl.Transform())

    def add_ball(self, radius: float) -> int:
        """Return the index of a new body: the ball of this radius (m) about its frame's origin."""
        ball = Shape(POINT, radius, np.eye(4))
        self._bodies.append((PlacedShape(0, ball, Model(POINT)),))
        return len(self._bodies) - 1

    def is_ball(self, body: int) -> bool:
        """Tell whether a body is a single ball."""
        parts = self._bodies[body]
        return len(parts) == 1 and len(parts[0].model.mesh.vertices) == 1

    def nearest(self, a: int, b: int, pose_a: FloatArray, pose_b: FloatArray) -> Proximity:
        """Return how near the surfaces of the bodies a and b are, placed by poses (4x4) of one common frame."""
        self._place(a, b, pose_a, pose_b)
        best: Proximity | None = None
        for gap, one, other in self._by_gap(a, b):
            if best is not None and gap >= best.distance:
                break
            found = self._measure(one, other)
            if best is None or found.distance < best.distance:
                best = found
        assert best is not None
        return best.moved(translation_of(pose_a))

    def contained(self, a: int, b: int, pose_a: FloatArray, pose_b: FloatArray) -> Vector | None:
        """Return a point of one body that lies inside a solid of the other, None if there is none.

        Decides containment where the surfaces are disjoint: one point of each connected part, tested both ways.
        """
        self._place(a, b, pose_a, pose_b)
        for inner, outer in ((a, b), (b, a)):
            for part in self._bodies[inner]:
                for solid in self._bodies[outer]:
                    if solid.model.interior is None:
                        continue
                    point = solid.model.interior.contains(solid.local(part.world(part.model.points)))
                    if point is not None:
                        x, y, z = point.tolist()
                        return add(mapped(solid.pose, (x, y, z)), translation_of(pose_a))
        return None

    def triangles_within(
        self, a: int, b: int, pose_a: FloatArray, pose_b: FloatArray, reach: float
    ) -> NearTriangles | None:
        """Return all pairs of triangles of the bodies a and b that may be within `reach` (m), None for too many."""
        self._place(a, b, pose_a, pose_b)
        found: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        for gap, one, other in self._by_gap(a, b):
            if gap > reach:
                break
            rounding = one.shape.radius + other.shape.radius
            near = near_pairs(one.model.triangles, other.model.triangles, one.pose, other.pose, reach + rounding)
            if near is None:
                return None
            found.append((*near, np.full(len(near[0]), rounding)))
        if not found:
            return NOTHING
        ones, others, radii = zip(*found, strict=True)
        return NearTriangles(np.concatenate(ones), np.concatenate(others), np.concatenate(radii))

    def corners(
        self, a: int, b: int, pose_a: FloatArray, pose_b: FloatArray, features: tuple[Feature, Feature]
    ) -> tuple[FloatArray, FloatArray]:
        """Return the corners (3, 3) m of the triangles that hold two features, as seen from the first body's place."""
        self._place(a, b, pose_a, pose_b)
        one, other = self._bodies[a][features[0].shape], self._bodies[b][features[1].shape]
        return np.array(one.corners(features[0].triangle)), np.array(other.corners(features[1].triangle))

    def depth(self, a: int, b: int, pose_a: FloatArray, pose_b: FloatArray) -> float:
        """Return how far (m) two touching bodies may get relative to each other and touch; errs low, 0 if unknown.

        The deepest of: rounded shapes by what their radii exceed their cores' distance, a corner inside a solid by its
        distance to the surface. Errors of measurement are not taken off.
        """
        self._place(a, b, pose_a, pose_b)
        deepest = 0.0
        for gap, one, other in self._by_gap(a, b):
            if gap > 0.0:
                break
            rounding = one.shape.radius + other.shape.radius
            if rounding > 0.0:
                deepest = max(deepest, rounding - self._core_distance(one, other))
            else:
                deepest = max(deepest, self._depth(one, other), self._depth(other, one))
        return deepest

    def error(self, a: int, b: int) -> float:
        """Return how far (m) a measured distance of the two bodies may be from the true one.

        The terms of each placed point are counted apart: a mesh far from its own origin may be put back by its pose.
        """
        return sum(
            DISTANCE_ERROR * max(part.extent for part in parts) + max(part.model.error for part in parts)
            for parts in (self._bodies[a], self._bodies[b])
        )

    def _measure(self, one: PlacedShape, other: PlacedShape) -> Proximity:
        """Measure two placed shapes: first whether they meet, which is cheap, then how far apart they are."""
        if one.crisp and other.crisp:
            touch = fcl.CollisionResult()
            began = perf_counter()
            meets = fcl.collide(one.object, other.object, _COLLISION_REQUEST, touch)
            self.seconds += perf_counter() - began
            if meets:
                contact = touch.contacts[0]
                return _meeting(one, other, contact.b1, contact.b2)
        result = fcl.DistanceResult()
        began = perf_counter()
        core = fcl.distance(one.object, other.object, _DISTANCE_REQUEST, result)
        self.seconds += perf_counter() - began
        witnesses: Any = result.nearest_points
        (ax, ay, az), (bx, by, bz) = ((point / SCALE).tolist() for point in witnesses)
        if core <= 0.0:
            return _meeting(one, other, result.b1, result.b2)
        return Proximity.of_rounded(one.rounded(result.b1, (ax, ay, az)), other.rounded(result.b2, (bx, by, bz)))

    def _core_distance(self, one: PlacedShape, other: PlacedShape) -> float:
        """Return the distance (m) of two shapes' cores."""
        began = perf_counter()
        core = fcl.distance(one.object, other.object, _PLAIN_REQUEST, fcl.DistanceResult())
        self.seconds += perf_counter() - began
        return max(0.0, float(core) / SCALE)

    def _depth(self, guest: PlacedShape, host: PlacedShape) -> float:
        """Return how deep (m) the guest's corner nearest to the host's middle lies inside the host, 0 if outside."""
        if host.model.interior is None:
            return 0.0
        corners = guest.model.mesh.vertices
        away = corners - guest.local(np.array(host.centre))
        corner = guest.world(corners[(away * away).sum(axis=1).argmin()])
        if host.model.interior.contains(host.local(corner)[None]) is None:
            return 0.0
        self._point.setTransform(fcl.Transform(corner * SCALE))
        began = perf_counter()
        depth = fcl.distance(self._point, host.object, _PLAIN_REQUEST, fcl.DistanceResult())
        self.seconds += perf_counter() - began
        return max(0.0, float(depth) / SCALE)

    def _place(self, a: int, b: int, pose_a: FloatArray, pose_b: FloatArray) -> None:
        """Place both bodies as seen from the first one's origin."""
        origin = pose_a[:3, 3]
        for body, pose in ((a, pose_a), (b, pose_b)):
            for part in self._bodies[body]:
                part.place(pose, origin)

    def _by_gap(self, a: int, b: int) -> list[tuple[float, PlacedShape, PlacedShape]]:
        """Return the pairs of shapes with the gap (m) of their balls, nearest first."""
        pairs = [
            (norm(subtract(one.centre, other.centre)) - one.reach - other.reach, one, other)
            for one in self._bodies[a]
            for other in self._bodies[b]
        ]
        return sorted(pairs, key=lambda pair: (pair[0], pair[1].index, pair[2].index))


def _meeting(one: PlacedShape, other: PlacedShape, first: int, second: int) -> Proximity:
    """Return the touch of two triangles that meet."""
    point = meeting_point(one.corners(first), other.corners(second))
    feature_a, feature_b = one.rounded(first, point).feature, other.rounded(second, point).feature
    return Proximity(0.0, point, point, feature_a, feature_b)


def _bvh(vertices: FloatArray, triangles: IntArray) -> Any:
    """Return FCL's model of triangles (m, 3) over vertices (n, 3) m."""
    model = fcl.BVHModel()
    model.beginModel(len(vertices), len(triangles))
    model.addSubModel(vertices * SCALE, triangles)
    model.endModel()
    return model
