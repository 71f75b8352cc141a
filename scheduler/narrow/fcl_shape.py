"""Shapes as FCL measures them: the only module that imports FCL.

Only `fcl.distance` and `fcl.collide` on BVH models are used. FCL's GJK distances can be too large, its continuous
collision detection misses contacts, and its depths and normals between meshes mean nothing.
"""

from __future__ import annotations

from functools import cached_property, partial
from typing import Any

import fcl
import numpy as np

from ..geometry.arrays import FloatArray, IntArray
from ..geometry.transform import mapped, translation_of
from ..geometry.vector import Vector, norm, subtract, unit
from ..model.events import Feature
from ..model.extent import bounding_ball
from ..model.scene import Mesh, Shape, used_vertices
from ..solids.containment import Interior, component_points
from .closest_points import Rounded
from .slivers import EPSILON, without_slivers
from .triangle import Triangle, feature_at
from .triangle_distance import Cores, cores_within, nearest_of
from .triangle_pairs import Triangles

#: FCL is given lengths times this power of two, which loses nothing. Unscaled it skips the face of every triangle whose
#: doubled area squared is below 1e-15 m^4, those of a 0.2 mm box among them, and then over- or underestimates
#: by up to 6% of their size (`python -m benchmarks.narrow_phase_error 3000 1 --unscaled`). Scaled it skips what
#: `without_slivers` has made segments of; the greatest coordinates, 1e30 m, are far from overflow in the fourth power.
SCALE = 2.0**60
#: Relative to their coordinates: by how much the nearest points may be farther apart than the distance says.
AGREEMENT = 1e-12
#: m per m of size: what placing two cores may be wrong by, which decides whether they meet.
PLACING = 16.0 * EPSILON
#: m per m of size: where FCL contradicts itself, triangles so near are looked at first, and then so many times as far.
FIRST_REACH = 1e-9
FARTHER = 64.0

_PLAIN_REQUEST = fcl.DistanceRequest()
_DISTANCE_REQUEST = fcl.DistanceRequest(enable_nearest_points=True)
_COLLISION_REQUEST = fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)


class Model:
    """A mesh as measurements want it, shared by every shape that shows it. What takes long is made when asked for."""

    def __init__(self, mesh: Mesh) -> None:
        """Take the mesh without its slivers."""
        self.mesh = mesh
        collapsed, self.error = without_slivers(mesh)
        self._collapsed = collapsed
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

    @cached_property
    def bvh(self) -> Any:
        """FCL's hierarchy of bounding volumes, of lengths times `SCALE`."""
        return _bvh(self.mesh.vertices, self._collapsed)


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
        self.is_point = len(model.mesh.vertices) == 1
        self.closed = model.mesh.solid
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
            self._object = fcl.CollisionObject(self.model.bvh, fcl.Transform())
        if self._moved:
            self._object.setTransform(fcl.Transform(self.pose[:3, :3], self.pose[:3, 3] * SCALE))
            self._moved = False
        return self._object

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

    def heights(self, direction: FloatArray) -> FloatArray:
        """Return how far (n,) m the core's vertices lie along a unit direction (3,)."""
        found: FloatArray = self.model.mesh.vertices @ (direction @ self.pose[:3, :3]) + direction @ self.pose[:3, 3]
        return found

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
    """Measure the distance of two shapes' cores: by FCL, and by the near triangles one by one where it may be wrong.

    Nearly parallel edges mislead FCL. It may call two triangles face to face meeting, which its own nearest points
    contradict. And it may take a distance between such edges for the triangles' least; then it is misled by all that
    hold the nearest points. Of closed surfaces these are several, and it was never seen; nor does it concern points.
    Between others a slab proves that nothing is nearer, or the triangles are measured.
    """
    found = _fcl_cores(one, other)
    if not _agrees(found):
        return _nearest_cores(one, other, found)
    if one.is_point or other.is_point or (one.closed and other.closed) or _parted(one, other, found):
        return found
    return _cores_within(one, other, found.distance) or found


def _agrees(cores: Cores) -> bool:
    """Return whether cores are apart, by the distance between the nearest points."""
    apart = norm(subtract(cores.witness_b, cores.witness_a))
    coordinates = norm(cores.witness_a) + norm(cores.witness_b)
    return cores.distance > 0.0 and abs(apart - cores.distance) <= AGREEMENT * coordinates


def _parted(one: PlacedShape, other: PlacedShape, cores: Cores) -> bool:
    """Return whether a slab between the cores is as wide as their distance, to what placing them may be wrong by."""
    along = np.array(unit(subtract(cores.witness_b, cores.witness_a)))
    width = other.heights(along).min() - one.heights(along).max()
    return bool(width >= cores.distance - PLACING * (one.extent + other.extent))


def _nearest_cores(one: PlacedShape, other: PlacedShape, found: Cores) -> Cores:
    """Return the distance of cores for which FCL contradicts itself; 0 where the triangles that it names do meet.

    It mostly does where they nearly touch, so that what is near is looked for farther and farther away.
    """
    indices = np.array([found.triangle_a]), np.array([found.triangle_b])
    named = nearest_of(np.array([one.corners(found.triangle_a)]), np.array([other.corners(found.triangle_b)]), indices)
    if named.distance <= PLACING * (one.extent + other.extent):
        return found._replace(distance=0.0)
    reach = FIRST_REACH * (one.reach + other.reach)
    while reach < named.distance:
        if (near := _cores_within(one, other, reach)) is not None:
            return near
        reach *= FARTHER
    return _cores_within(one, other, named.distance) or named


def _cores_within(one: PlacedShape, other: PlacedShape, reach: float) -> Cores | None:
    """Return how far apart the cores are by their triangles, None if farther than `reach` (m)."""
    return cores_within(one.model.triangles, other.model.triangles, one.pose, other.pose, reach)


def distance_from_point(point: FloatArray, other: PlacedShape) -> float:
    """Return the distance (m) of a point (3,) m from a shape's core; 0 where it is unknown."""
    probe = fcl.CollisionObject(_bvh(np.zeros((1, 3)), np.zeros((1, 3), dtype=np.int64)), fcl.Transform())
    probe.setTransform(fcl.Transform(point * SCALE))
    return max(0.0, float(fcl.distance(probe, other.object, _PLAIN_REQUEST, fcl.DistanceResult())) / SCALE)


def _fcl_cores(one: PlacedShape, other: PlacedShape) -> Cores:
    """Let FCL measure the distance of two shapes' cores."""
    result = fcl.DistanceResult()
    core = fcl.distance(one.object, other.object, _DISTANCE_REQUEST, result)
    points: Any = result.nearest_points
    (ax, ay, az), (bx, by, bz) = ((point / SCALE).tolist() for point in points)
    return Cores(max(0.0, float(core) / SCALE), (ax, ay, az), (bx, by, bz), result.b1, result.b2)


def _bvh(vertices: FloatArray, triangles: IntArray) -> Any:
    """Return FCL's model of triangles (m, 3) over vertices (n, 3) m, lengths times `SCALE`."""
    model = fcl.BVHModel()
    model.beginModel(len(vertices), len(triangles))
    model.addSubModel(vertices * SCALE, triangles)
    model.endModel()
    return model
