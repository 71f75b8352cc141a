"""The narrow phase: exact distances, touching and containment of two placed bodies. The only module that imports fcl.

Every shape is a triangle core plus a rounding radius, and only `fcl.distance` and `fcl.collide` on BVH models are used:
GJK distances over-estimate, continuous collision misses, mesh depths and normals mean nothing. Both bodies are measured
in a frame centred on the first, so that FCL's error follows their size and not their place.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Any, NamedTuple

import fcl
import numpy as np

from .chain import Ball, Extent
from .events import Feature
from .rotation import FloatArray, mapped, translation_of
from .scene import Body, Mesh, Shape
from .sliver import EPSILON, without_slivers
from .solid import Interior, component_points
from .triangle import Triangle, feature_at, meeting_point
from .vector import Vector, add, norm, scale, subtract, unit

#: FCL is given lengths times this power of two, which loses nothing. Unscaled it skips the face of every triangle whose
#: doubled area squared is below 1e-15 m^4, those of a 0.2 mm box among them, and then over- or underestimates
#: by up to 6% of their size (`python -m benchmarks.narrow_phase_error 3000 1 --unscaled`).
SCALE = 2.0**30
#: m per m of size: a distance errs by less than this times the bodies' size about the centre of measurement, where no
#: triangle is thin (measured: at most 1.1e-16 over 6,000 near pairs, `python -m benchmarks.narrow_phase_error 6000`).
DISTANCE_ERROR = 64.0 * EPSILON

_DISTANCE_REQUEST = fcl.DistanceRequest(enable_nearest_points=True)
_COLLISION_REQUEST = fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)


class Rounded(NamedTuple):
    """A core's nearest point (m), the feature that holds it, and the radius (m) that rounds it."""

    point: Vector
    feature: Feature
    radius: float


@dataclass(frozen=True, slots=True)
class Proximity:
    """How near two bodies' surfaces are.

    Attributes:
        distance: m between the surfaces (rounding radii off), 0 where they meet.
        witness_a, witness_b: m, the nearest points, or twice one point where they meet; in the frame of the poses.
        feature_a, feature_b: what holds them.
    """

    distance: float
    witness_a: Vector
    witness_b: Vector
    feature_a: Feature
    feature_b: Feature

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
        self.bvh = fcl.BVHModel()
        self.bvh.beginModel(len(mesh.vertices), len(collapsed))
        self.bvh.addSubModel(mesh.vertices * SCALE, collapsed)
        self.bvh.endModel()
        self.ball = bounding_ball(mesh.vertices[np.unique(mesh.triangles)])
        self.points = component_points(mesh)
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
        a, b, c = self.world(self.model.mesh.vertices[self.model.mesh.triangles[triangle]]).tolist()
        return tuple(a), tuple(b), tuple(c)

    def rounded(self, triangle: int, witness: Vector) -> Rounded:
        """Return the core's witness, with what of its triangle holds it."""
        kind, index = feature_at(witness, self.corners(triangle))
        return Rounded(witness, Feature(kind, self.index, triangle, index), self.shape.radius)


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
        self._bodies = tuple(
            tuple(PlacedShape(i, shape, models[id(shape.mesh)]) for i, shape in enumerate(body.shapes))
            for body in bodies
        )

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

    def error(self, a: int, b: int) -> float:
        """Return how far (m) a measured distance of the two bodies may be from the true one."""
        return sum(
            DISTANCE_ERROR * max(norm(mapped(part.shape.pose, part.model.ball.centre)) + part.reach for part in parts)
            + max(part.model.error for part in parts)
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


def bounding_ball(points: FloatArray) -> Ball:
    """Return a ball about the middle of the points' bounding box, (n, 3) m."""
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    x, y, z = centre.tolist()
    return Ball((x, y, z), float(np.max(np.linalg.norm(points - centre, axis=1))))


def body_extent(body: Body) -> Extent:
    """Return the points that span a body (its cores' vertices, each rounded by its shape's radius) and a ball."""
    points, radii = [], []
    for shape in body.shapes:
        used = shape.mesh.vertices[np.unique(shape.mesh.triangles)]
        points.append(used @ shape.pose[:3, :3].T + shape.pose[:3, 3])
        radii.append(np.full(len(used), shape.radius))
    spanning, rounding = np.vstack(points), np.concatenate(radii)
    centre = 0.5 * ((spanning - rounding[:, None]).min(axis=0) + (spanning + rounding[:, None]).max(axis=0))
    x, y, z = centre.tolist()
    radius = float(np.max(np.linalg.norm(spanning - centre, axis=1) + rounding))
    return Extent(spanning, rounding, Ball((x, y, z), radius))
