"""Bodies as primitives of a foxglove.SceneEntity, in wire bytes: each model is packed once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.CubePrimitive_pb2 import CubePrimitive
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

from ....scheduler.geometry.arrays import FloatArray
from ....scheduler.model.scene import Body, Shape
from .surfaces import Surface, ball_centre, outermost, outline, surface, triangle_count
from .transforms import quaternions
from .wire import embedded, indices, points, power_of_two, rounded

# Of how far points are moved out: about what they are rounded to.
_INFLATION_STEP = 1.0 / 64.0


class Drawings:
    """How bodies are drawn, in any frame: `frame_from_body` (4x4) places them there.

    Viewers paint translucent triangles without regard to what lies in front, but for the depth of their origins.

    Attributes:
        triangles: of each body, how many are drawn; balls have none.
        outlines: (n, 26, 3) m, points of each body in its own frame that span it; zeros without shapes.
    """

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._bodies = bodies
        self._surfaces: dict[tuple[int, float, float], Surface] = {}
        self._packed: dict[tuple[int, float], tuple[FloatArray, bytes, bytes]] = {}
        counts = {_model(shape): triangle_count(shape) for shape in _distinct(bodies)}
        self.triangles = [sum(counts[_model(shape)] for shape in body.shapes) for body in bodies]
        self.outlines = _outlines(bodies)

    def exact(self, body: int, frame_from_body: FloatArray, colour: Color) -> bytes:
        """Return the body's shapes, each about its own middle, as fields of a SceneEntity."""
        return b"".join(self._shape(shape, frame_from_body @ shape.pose, colour) for shape in self._bodies[body].shapes)

    def triangulated(
        self, body: int, frame_from_body: FloatArray, colour: Color, origin: FloatArray, inflation: float = 0.0
    ) -> bytes:
        """Return the body's shapes as triangles, balls too, as fields of a SceneEntity.

        Args:
            body: its index.
            frame_from_body: where it is.
            colour: with opacity.
            origin: (3,) m in the body's frame, whose depth decides when it is painted.
            inflation: m, how far every point is moved out; what is moved is rounded too, by less than is seen, since
                what ends in zeros takes a third of the room.
        """
        return b"".join(
            self._about(origin, shape, frame_from_body, colour, inflation) for shape in self._bodies[body].shapes
        )

    def box(self, body: int, frame_from_body: FloatArray, colour: Color, inflation: float = 0.0) -> bytes:
        """Return the box that bounds the body, `inflation` (m) wider on every side, as fields of a SceneEntity."""
        low, high = self.outlines[body].min(axis=0), self.outlines[body].max(axis=0)
        x, y, z = (high - low + 2.0 * inflation).tolist()
        centre = frame_from_body @ _translation(0.5 * (low + high))
        cube = CubePrimitive(pose=pose(centre), size=Vector3(x=x, y=y, z=z), color=colour)
        return embedded(SceneEntity.CUBES_FIELD_NUMBER, cube.SerializeToString())

    def _shape(self, shape: Shape, frame_from_mesh: FloatArray, colour: Color) -> bytes:
        centre = ball_centre(shape)
        if centre is not None:
            return _ball(frame_from_mesh @ _translation(centre), 2.0 * shape.radius, colour)
        if _model(shape) not in self._packed:
            drawn = surface(shape)
            self._packed[_model(shape)] = (drawn.centre, *_packed(drawn, drawn.centre))
        middle, vertices, corners = self._packed[_model(shape)]
        return _triangles(frame_from_mesh @ _translation(middle), vertices, corners, colour)

    def _about(
        self, origin: FloatArray, shape: Shape, frame_from_body: FloatArray, colour: Color, inflation: float
    ) -> bytes:
        step = power_of_two(_INFLATION_STEP * inflation)
        key = (*_model(shape), inflation)
        if key not in self._surfaces:
            drawn = surface(shape, inflation)
            self._surfaces[key] = Surface(rounded(drawn.points, step), drawn.triangles)
        in_mesh = rounded((origin - shape.pose[:3, 3]) @ shape.pose[:3, :3], step)
        placement = frame_from_body @ shape.pose @ _translation(in_mesh)
        return _triangles(placement, *_packed(self._surfaces[key], in_mesh), colour)


def pose(frame_from_thing: FloatArray) -> Pose:
    """Return a 4x4 pose as a message."""
    x, y, z, w = quaternions(frame_from_thing[None, :3, :3])[0].tolist()
    px, py, pz = frame_from_thing[:3, 3].tolist()
    return Pose(position=Vector3(x=px, y=py, z=pz), orientation=Quaternion(x=x, y=y, z=z, w=w))


def _model(shape: Shape) -> tuple[int, float]:
    """Return what shapes that look the same have in common: the mesh and the radius about it."""
    return id(shape.mesh), shape.radius


def _distinct(bodies: Sequence[Body]) -> Iterable[Shape]:
    """Return one shape of each model."""
    return {_model(shape): shape for body in bodies for shape in body.shapes}.values()


def _packed(drawn: Surface, origin: FloatArray) -> tuple[bytes, bytes]:
    """Return the points, as seen from `origin` (3,), and the corners of a surface."""
    return (
        points(TriangleListPrimitive.POINTS_FIELD_NUMBER, drawn.points - origin),
        indices(TriangleListPrimitive.INDICES_FIELD_NUMBER, drawn.triangles),
    )


def _triangles(frame_from_points: FloatArray, vertices: bytes, corners: bytes, colour: Color) -> bytes:
    placed = TriangleListPrimitive(pose=pose(frame_from_points)).SerializeToString()
    painted = TriangleListPrimitive(color=colour).SerializeToString()
    return embedded(SceneEntity.TRIANGLES_FIELD_NUMBER, placed + vertices + painted + corners)


def _ball(frame_from_ball: FloatArray, diameter: float, colour: Color) -> bytes:
    size = Vector3(x=diameter, y=diameter, z=diameter)
    sphere = SpherePrimitive(pose=pose(frame_from_ball), size=size, color=colour)
    return embedded(SceneEntity.SPHERES_FIELD_NUMBER, sphere.SerializeToString())


def _translation(offset: FloatArray) -> FloatArray:
    matrix: FloatArray = np.eye(4)
    matrix[:3, 3] = offset
    return matrix


def _outlines(bodies: Sequence[Body]) -> FloatArray:
    """Return points that span each body, (n, 26, 3); equal shapes are looked at once."""
    known: dict[tuple[int, float, bytes], FloatArray] = {}
    outlines = np.zeros((len(bodies), 26, 3))
    for index, body in enumerate(bodies):
        keys = [(*_model(shape), shape.pose.tobytes()) for shape in body.shapes]
        for key, shape in zip(keys, body.shapes, strict=True):
            if key not in known:
                known[key] = outline(shape)
        if len(keys) == 1:
            outlines[index] = known[keys[0]]
        elif keys:
            outlines[index] = outermost(np.vstack([known[key] for key in keys]))
    return outlines
