"""The narrow phase: exact distance, touching and containment of two placed bodies.

Every shape is a core of triangles plus a rounding radius. Both bodies are measured in a frame centred on the first, so
the error of measurement depends on their size and not on their place.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import perf_counter
from typing import TypeVar

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.transform import mapped, translation_of
from ..geometry.vector import Vector, add, norm, scale, subtract
from ..model.events import Feature
from ..model.scene import Body, Mesh, Shape
from .closest_points import ClosestPoints
from .fcl_shape import Model, PlacedShape, cores_between, distance_from_point, meeting_triangles
from .slivers import EPSILON
from .triangle import meeting_point
from .triangle_distance import Cores
from .triangle_pairs import NOTHING, NearTriangles, near_pairs

Found = TypeVar("Found")

#: m per m of size: a distance errs by less than this times the bodies' size about the centre of measurement, where no
#: triangle is thin (measured: at most 1.5e-16 over 6,000 near pairs, `python -m benchmarks.narrow_phase_error 6000`).
DISTANCE_ERROR = 64.0 * EPSILON

POINT = Mesh("point", np.zeros((1, 3)), np.zeros((1, 3), dtype=np.int64), solid=False)
"""The core of a ball."""


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

    def add_ball(self, radius: float) -> int:
        """Return the index of a new body: the ball of this radius (m) about its frame's origin."""
        ball = Shape(POINT, radius, np.eye(4))
        self._bodies.append((PlacedShape(0, ball, Model(POINT)),))
        return len(self._bodies) - 1

    def is_ball(self, body: int) -> bool:
        """Return whether a body is a single ball."""
        parts = self._bodies[body]
        return len(parts) == 1 and parts[0].is_point

    def nearest(self, a: int, b: int, pose_a: FloatArray, pose_b: FloatArray) -> ClosestPoints:
        """Return how near the surfaces of the bodies a and b are, placed by poses (4x4) of one common frame."""
        self._place(a, b, pose_a, pose_b)
        best: ClosestPoints | None = None
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
                    apart = norm(subtract(part.centre, solid.centre)) > part.reach + solid.reach
                    if apart or solid.model.interior is None:
                        continue
                    point = solid.model.interior.contains(solid.local(part.world(part.model.points)))
                    if point is not None:
                        x, y, z = point.tolist()
                        return add(mapped(solid.pose, (x, y, z)), translation_of(pose_a))
        return None

    def triangles_within(
        self, a: int, b: int, pose_a: FloatArray, pose_b: FloatArray, reach: float, some: bool = False
    ) -> NearTriangles | None:
        """Return all pairs of triangles of the bodies a and b that may be within `reach` (m), None for too many.

        Of too many `some` takes some, where that will do.
        """
        self._place(a, b, pose_a, pose_b)
        found: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        for gap, one, other in self._by_gap(a, b):
            if gap > reach:
                break
            rounding = one.shape.radius + other.shape.radius
            near = near_pairs(one.model.triangles, other.model.triangles, one.pose, other.pose, reach + rounding, some)
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

    def excess(
        self,
        a: int,
        b: int,
        pose_a: FloatArray,
        pose_b: FloatArray,
        near: ClosestPoints,
        features: tuple[Feature, Feature],
    ) -> float:
        """Return how much farther apart (m) two bodies are at most than what was measured of them at these poses.

        Only round shapes are farther, for they are measured as polyhedra around them: two of their points give how far.
        """
        one, other = self._bodies[a][features[0].shape], self._bodies[b][features[1].shape]
        stands_out = one.shape.chord_error + other.shape.chord_error
        if stands_out == 0.0:
            return 0.0
        self._place(a, b, pose_a, pose_b)
        back = scale(-1.0, translation_of(pose_a))
        ends = one.held(add(near.witness_a, back)), other.held(add(near.witness_b, back))
        return min(stands_out, max(0.0, norm(subtract(*ends)) - near.distance))

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
                deepest = max(deepest, rounding - self._cores(one, other).distance)
            else:
                deepest = max(deepest, self._depth(one, other), self._depth(other, one))
        return deepest

    def inscribed_radius(self, body: int, middle: Vector) -> float:
        """Return the radius (m) of a ball about a point (m) of a body's frame that one of its shapes holds.

        The greatest of a solid; of rounded shapes, by corners and middles of edges. Errs low, 0 if none.
        """
        held = 0.0
        for part in self._bodies[body]:
            part.place(np.eye(4), np.array(middle))
            here, interior = part.local(np.zeros((1, 3))), part.model.interior
            if interior is not None and interior.contains(here) is not None:
                held = max(held, self._timed(partial(distance_from_point, np.zeros(3), part)) + part.shape.radius)
            elif part.shape.radius > 0.0:
                corners = part.model.mesh.vertices[part.model.mesh.triangles]
                points = np.concatenate((corners, 0.5 * (corners + np.roll(corners, 1, axis=1)))).reshape(-1, 3)
                held = max(held, part.shape.radius - float(np.linalg.norm(points - here, axis=1).min()))
        return max(0.0, held - self.own_error(body))

    def error(self, a: int, b: int) -> float:
        """Return how far (m) a measured distance of the two bodies may be from the true one."""
        return self.own_error(a) + self.own_error(b)

    def own_error(self, body: int) -> float:
        """Return a body's part (m) of that; its pose may bring a mesh back from afar, so that each term counts."""
        parts = self._bodies[body]
        return DISTANCE_ERROR * max(part.extent for part in parts) + max(part.model.error for part in parts)

    def _measure(self, one: PlacedShape, other: PlacedShape) -> ClosestPoints:
        """Measure two placed shapes: first whether they meet, which is cheap, then how far apart they are."""
        if one.crisp and other.crisp:
            meeting = self._timed(lambda: meeting_triangles(one, other))
            if meeting is not None:
                return _meeting(one, other, *meeting)
        cores = self._cores(one, other)
        if cores.distance <= 0.0:
            return _meeting(one, other, cores.triangle_a, cores.triangle_b)
        return ClosestPoints.of_rounded(
            one.rounded(cores.triangle_a, cores.witness_a), other.rounded(cores.triangle_b, cores.witness_b)
        )

    def _cores(self, one: PlacedShape, other: PlacedShape) -> Cores:
        """Return how far apart two shapes' cores are."""
        return self._timed(lambda: cores_between(one, other))

    def _depth(self, guest: PlacedShape, host: PlacedShape) -> float:
        """Return how deep (m) the guest's corner nearest to the host's middle lies inside the host, 0 if outside."""
        if host.model.interior is None:
            return 0.0
        corners = guest.model.mesh.vertices
        away = corners - guest.local(np.array(host.centre))
        corner = guest.world(corners[(away * away).sum(axis=1).argmin()])
        if host.model.interior.contains(host.local(corner)[None]) is None:
            return 0.0
        return self._timed(lambda: distance_from_point(corner, host))

    def _timed(self, measure: Callable[[], Found]) -> Found:
        """Return what FCL measures, and count the time it takes."""
        began = perf_counter()
        found = measure()
        self.seconds += perf_counter() - began
        return found

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


def _meeting(one: PlacedShape, other: PlacedShape, first: int, second: int) -> ClosestPoints:
    """Return the touch of two triangles that meet."""
    point = meeting_point(one.corners(first), other.corners(second))
    feature_a, feature_b = one.rounded(first, point).feature, other.rounded(second, point).feature
    return ClosestPoints(0.0, point, point, feature_a, feature_b)
