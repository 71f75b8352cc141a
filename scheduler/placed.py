"""Shapes as FCL measures them: the only module that imports it.

Only `fcl.distance` and `fcl.collide` on BVH models are used: GJK distances over-estimate, continuous collision misses,
mesh depths and normals mean nothing.
"""

from __future__ import annotations

from functools import cached_property, partial
from math import frexp, ldexp
from typing import Any, NamedTuple

import fcl
import numpy as np

from .events import Feature
from .extent import bounding_ball
from .nearby import Triangles
from .proximity import Rounded
from .rotation import FloatArray, mapped, translation_of
from .scene import IntArray, Mesh, Shape, used_vertices
from .sliver import without_slivers
from .solid import Interior, component_points
from .triangle import Triangle, feature_at
from .vector import Vector, norm, subtract

#: FCL is given lengths times this power of two, which loses nothing. Unscaled it skips the face of every triangle whose
#: doubled area squared is below 1e-15 m^4, those of a 0.2 mm box among them, and then over- or underestimates
#: by up to 6% of their size (`python -m benchmarks.narrow_phase_error 3000 1 --unscaled`). Scaled it skips what
#: `without_slivers` has made segments of; the greatest coordinates, 1e30 m, are far from overflow in the fourth power.
SCALE = 2.0**60
#: Where FCL's answer looks wrong, it is asked again with lengths times the power of two that makes the pair's reach
#: about 2^24: 1 added to its square is not lost then, and triangles up to 1e-22 of its square have their faces.
FITTING = 24
#: Relative to their coordinates: by how much the nearest points may be farther apart than the distance says.
AGREEMENT = 1e-12

_PLAIN_REQUEST = fcl.DistanceRequest()
_DISTANCE_REQUEST = fcl.DistanceRequest(enable_nearest_points=True)
_COLLISION_REQUEST = fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)


class Cores(NamedTuple):
    """How far apart two shapes' cores are (m), the points and triangles of them that are nearest."""

    distance: float
    witness_a: Vector
    witness_b: Vector
    triangle_a: int
    triangle_b: int

    @property
    def agree(self) -> bool:
        """Whether they are apart, by the distance between the nearest points."""
        apart = norm(subtract(self.witness_b, self.witness_a))
        return self.distance > 0.0 and abs(apart - self.distance) <= AGREEMENT * (
            norm(self.witness_a) + norm(self.witness_b)
        )


class Model:
    """A mesh as measurements want it, shared by every shape that shows it. What takes long is made when asked for."""

    def __init__(self, mesh: Mesh) -> None:
        """Take the mesh without its slivers."""
        self.mesh = mesh
        collapsed, self.error = without_slivers(mesh)
        self._collapsed = collapsed
        self._bvhs: dict[float, Any] = {}
        self.ball = bounding_ball(used_vertices(mesh))
        self.degenerate = bool(np.any(collapsed[:, 1] == collapsed[:, 2]))

    @cached_property
    def points(self) -> FloatArray:
        """One point of each connected part, (k, 3) m."""
        return component_points(self.mesh)

    @cached_property
    def triangles(self) -> Triangles:
        """The triangles, to find those near another's."""
        return Triangles.of(self.mesh.vertices[self.mesh.triangles])

    @cached_property
    def interior(self) -> Interior | None:
        """The inside, None of a mesh that encloses nothing."""
        return Interior(self.mesh) if self.mesh.encloses else None

    def bvh(self, scale: float) -> Any:
        """Return the bounding volume hierarchy of lengths times `scale`, built when first asked for."""
        if scale not in self._bvhs:
            self._bvhs[scale] = _bvh(self.mesh.vertices, self._collapsed, scale)
        return self._bvhs[scale]


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
        self._object: Any = None
        self._moved = True
        self.pose = shape.pose
        self.centre = model.ball.centre

    def place(self, body: FloatArray, origin: FloatArray) -> None:
        """Move the shape to where a body's pose puts it, as seen from `origin` (3,)."""
        self.pose = body @ self.shape.pose
        self.pose[:3, 3] -= origin
        self._moved = True
        self.centre = mapped(self.pose, self.model.ball.centre)

    @property
    def object(self) -> Any:
        """The FCL object, at the shape's place."""
        if self._object is None:
            self._object = fcl.CollisionObject(self.model.bvh(SCALE), fcl.Transform())
        if self._moved:
            self._object.setTransform(fcl.Transform(self.pose[:3, :3], self.pose[:3, 3] * SCALE))
            self._moved = False
        return self._object

    def object_at(self, scale: float) -> Any:
        """Return a new FCL object at the shape's place, lengths times `scale`."""
        return fcl.CollisionObject(self.model.bvh(scale), fcl.Transform(self.pose[:3, :3], self.pose[:3, 3] * scale))

    def local(self, points: FloatArray) -> FloatArray:
        """Return points (k, 3) of the measuring frame in the mesh's frame."""
        inverse: FloatArray = (points - self.pose[:3, 3]) @ self.pose[:3, :3]
        return inverse

    def world(self, points: FloatArray) -> FloatArray:
        """Return points (k, 3) of the mesh's frame in the measuring frame."""
        moved: FloatArray = points @ self.pose[:3, :3].T + self.pose[:3, 3]
        return moved

    def held(self, point: Vector) -> Vector:
        """Return a point that the true shape holds, near one (m) of the polyhedron that is measured for it."""
        if self.shape.solid is None:
            return point
        x, y, z = self.local(np.array(point)).tolist()
        return mapped(self.pose, self.shape.solid.held((x, y, z)))

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


def meeting_triangles(one: PlacedShape, other: PlacedShape) -> tuple[int, int] | None:
    """Return two triangles of crisp shapes that meet, None if there are none."""
    touch = fcl.CollisionResult()
    if not fcl.collide(one.object, other.object, _COLLISION_REQUEST, touch):
        return None
    contact = touch.contacts[0]
    return contact.b1, contact.b2


def cores_between(one: PlacedShape, other: PlacedShape) -> Cores:
    """Measure the distance of two shapes' cores, again at a scale of their own where it looks wrong.

    Two triangles whose first corners are nearest to each other may be told as meeting, or with other nearest points
    than those whose distance it is: FCL first takes that distance squared plus 1, which is lost above 2^53.
    """
    cores = _cores_at(SCALE, one.object, other.object)
    if cores.agree:
        return cores
    reach = norm(subtract(one.centre, other.centre)) + one.reach + other.reach
    scale = ldexp(1.0, FITTING - frexp(reach)[1])
    return _cores_at(scale, one.object_at(scale), other.object_at(scale))


def distance_from_point(point: FloatArray, other: PlacedShape) -> float:
    """Return the distance (m) of a point (3,) m from a shape's core; 0 where it is unknown."""
    probe = fcl.CollisionObject(_bvh(np.zeros((1, 3)), np.zeros((1, 3), dtype=np.int64), SCALE), fcl.Transform())
    probe.setTransform(fcl.Transform(point * SCALE))
    return max(0.0, float(fcl.distance(probe, other.object, _PLAIN_REQUEST, fcl.DistanceResult())) / SCALE)


def _cores_at(scale: float, one: Any, other: Any) -> Cores:
    """Let FCL measure the distance of two objects that hold lengths times `scale`."""
    result = fcl.DistanceResult()
    core = fcl.distance(one, other, _DISTANCE_REQUEST, result)
    points: Any = result.nearest_points
    (ax, ay, az), (bx, by, bz) = ((point / scale).tolist() for point in points)
    return Cores(max(0.0, float(core) / scale), (ax, ay, az), (bx, by, bz), result.b1, result.b2)


def _bvh(vertices: FloatArray, triangles: IntArray, scale: float) -> Any:
    """Return FCL's model of triangles (m, 3) over vertices (n, 3) m, lengths times `scale`."""
    model = fcl.BVHModel()
    model.beginModel(len(vertices), len(triangles))
    model.addSubModel(vertices * scale, triangles)
    model.endModel()
    return model
