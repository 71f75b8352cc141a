"""How bodies and poses are packed and drawn: against the message classes, trimesh and scipy."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive
from google.protobuf.timestamp_pb2 import Timestamp
from scipy.spatial.transform import Rotation

from closecall.formats.log.viewer.colours import AMBER, FIXED, GREEN, MOVING, RED, ClearanceScale
from closecall.formats.log.viewer.drawings import Drawings
from closecall.formats.log.viewer.markers import figure
from closecall.formats.log.viewer.surfaces import outline, surface, triangle_count
from closecall.formats.log.viewer.transforms import TransformPacker, quaternions
from closecall.formats.log.viewer.wire import embedded, indices, points, varint
from closecall.formats.scene.build.primitive_meshes import box_mesh, point_mesh, segment_mesh
from closecall.scheduler.model.scene import Body, Mesh, Shape
from closecall.scheduler.motions import Fixed

PLACE = np.eye(4)
PLACE[:3, :3] = Rotation.from_euler("xyz", [0.3, -1.1, 2.0]).as_matrix()
PLACE[:3, 3] = (1.0, -2.0, 3.0)


@pytest.mark.parametrize("value", [0, 1, 127, 128, 300, 16383, 16384, 2**31])
def test_varints_are_those_of_protobuf(value):
    assert Timestamp(seconds=value).SerializeToString() == (b"\x08" + varint(value) if value else b"")


def test_points_and_indices_are_what_the_message_class_reads():
    vertices = np.random.default_rng(0).normal(size=(50, 3))
    triangles = np.random.default_rng(1).integers(0, 50, size=(70, 3))
    read = TriangleListPrimitive.FromString(points(2, vertices) + indices(5, triangles))
    assert [(point.x, point.y, point.z) for point in read.points] == [tuple(row) for row in vertices]
    assert list(read.indices) == triangles.ravel().tolist()


def test_quaternions_are_the_rotations_even_half_a_turn_round():
    rng = np.random.default_rng(2)
    turns = Rotation.random(2000, rng=rng).as_matrix()
    axes = rng.normal(size=(500, 3))
    axes[:3] = np.eye(3)
    half = Rotation.from_rotvec(np.pi * axes / np.linalg.norm(axes, axis=1, keepdims=True)).as_matrix()
    rotations = np.concatenate((turns, half, np.eye(3)[None]))
    found = quaternions(rotations)
    assert np.allclose(np.linalg.norm(found, axis=1), 1.0, atol=1e-15)
    assert (found[:, 3] >= 0.0).all()
    assert np.abs(Rotation.from_quat(found).as_matrix() - rotations).max() < 1e-14
    assert np.array_equal(found[-1], (0.0, 0.0, 0.0, 1.0))


@pytest.mark.parametrize("time", [Timestamp(), Timestamp(seconds=3), Timestamp(seconds=2**40, nanos=999_999_999)])
def test_packed_transforms_are_what_the_message_class_reads(time):
    names = ["a", "a longer name", "ä" * 70]
    poses = np.array([np.eye(4), PLACE, PLACE @ PLACE])
    packer = TransformPacker(names)
    for _ in range(2):
        read = FrameTransforms.FromString(packer.pack(time, poses))
        assert [transform.child_frame_id for transform in read.transforms] == names
        for transform, pose in zip(read.transforms, poses, strict=True):
            assert transform.timestamp == time
            assert transform.parent_frame_id == "world"
            turn, place = transform.rotation, transform.translation
            assert np.array_equal((place.x, place.y, place.z), pose[:3, 3])
            assert np.allclose(Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix(), pose[:3, :3])


def test_a_capsule_is_closed_outward_and_round():
    shape = Shape(segment_mesh(2.0), 0.5, np.eye(4))
    drawn = surface(shape)
    mesh = trimesh.Trimesh(drawn.points, drawn.triangles)
    assert len(drawn.triangles) == triangle_count(shape)
    mesh.update_faces(mesh.nondegenerate_faces())
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(np.pi * 0.25 * 2.0 + 4.0 / 3.0 * np.pi * 0.125, rel=0.04)
    from_axis = drawn.points - np.array([(0.0, 0.0, z) for z in np.clip(drawn.points[:, 2], -1.0, 1.0)])
    assert np.allclose(np.linalg.norm(from_axis, axis=1), 0.5)


def test_inflated_triangles_stay_closed_though_their_corners_were_apart():
    box = box_mesh(1.0, 2.0, 3.0)
    loose = Mesh("loose", box.vertices[box.triangles].reshape(-1, 3), np.arange(36).reshape(-1, 3), True)
    drawn = surface(Shape(loose, 0.0, np.eye(4)), 0.1)
    mesh = trimesh.Trimesh(drawn.points, drawn.triangles)
    assert mesh.is_watertight
    assert mesh.volume > 6.0
    assert np.linalg.norm(drawn.points, axis=1).max() == pytest.approx(np.sqrt(14.0) / 2.0 + 0.1, rel=0.02)


@pytest.mark.parametrize("mesh", [box_mesh(1.0, 2.0, 3.0), segment_mesh(2.0), point_mesh()])
def test_outlines_reach_the_bounds(mesh):
    radius = 0.0 if len(mesh.vertices) == 8 else 0.25
    shape = Shape(mesh, radius, PLACE)
    found = outline(shape)
    placed = mesh.vertices @ PLACE[:3, :3].T + PLACE[:3, 3]
    assert np.allclose(found.min(axis=0), placed.min(axis=0) - radius)
    assert np.allclose(found.max(axis=0), placed.max(axis=0) + radius)


def test_a_body_of_several_shapes_is_drawn_shape_by_shape():
    shapes = (Shape(box_mesh(1.0, 1.0, 1.0), 0.0, PLACE), Shape(point_mesh(), 0.5, np.eye(4)))
    drawings = Drawings((Body("both", None, np.eye(4), Fixed(), shapes), Body("frame", None, np.eye(4), Fixed(), ())))
    assert drawings.triangles == [12, 0]
    assert not drawings.outlines[1].any()
    entity = SceneEntity.FromString(drawings.exact(0, PLACE, Color(r=1.0, a=0.5)))
    assert (len(entity.triangles), len(entity.spheres)) == (1, 1)
    place = entity.spheres[0].pose.position
    assert np.allclose((place.x, place.y, place.z), PLACE[:3, 3])
    assert entity.triangles[0].color == entity.spheres[0].color == Color(r=1.0, a=0.5)
    box = SceneEntity.FromString(drawings.box(0, np.eye(4), Color())).cubes[0]
    low, high = drawings.outlines[0].min(axis=0), drawings.outlines[0].max(axis=0)
    centre, size = box.pose.position, box.size
    assert np.allclose((centre.x, centre.y, centre.z), 0.5 * (low + high))
    assert np.allclose((size.x, size.y, size.z), high - low)


def test_where_a_drawing_has_its_origin_moves_none_of_its_points():
    shapes = (Shape(segment_mesh(2.0), 0.5, PLACE), Shape(point_mesh(), 0.5, np.eye(4)))
    drawings = Drawings((Body("both", None, np.eye(4), Fixed(), shapes),))
    found = []
    for origin in (np.zeros(3), np.array((3.0, -4.0, 5.0))):
        entity = SceneEntity.FromString(drawings.triangulated(0, PLACE, Color(), origin))
        for drawn in entity.triangles:
            place, turn = drawn.pose.position, drawn.pose.orientation
            assert np.allclose((place.x, place.y, place.z), PLACE[:3, :3] @ origin + PLACE[:3, 3])
            rotation = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
            local = np.array([(point.x, point.y, point.z) for point in drawn.points])
            found.append(local @ rotation.T + (place.x, place.y, place.z))
    assert np.allclose(found[0], found[2])
    assert np.allclose(found[1], found[3])


def test_embedded_fields_hold_their_data():
    assert SceneEntity.FromString(embedded(SceneEntity.ID_FIELD_NUMBER, "ä|b".encode())).id == "ä|b"


@pytest.mark.parametrize(
    ("distance", "text"),
    [
        (0.0, "0.000 µm"),
        (4.2e-6, "4.20 µm"),
        (9.999e-5, "100 µm"),
        (1.2781e-4, "0.128 mm"),
        (0.0149456, "14.9 mm"),
        (0.0999, "99.9 mm"),
        (0.1, "0.100 m"),
        (32.512, "32.5 m"),
        (999.4, "999 m"),
        (12345.0, "12.3 km"),
    ],
)
def test_figures_come_in_the_unit_that_fits(distance, text):
    assert figure(distance) == text


def test_colours_run_from_red_over_amber_to_green():
    scale = ClearanceScale(0.001, 0.1)
    assert scale.rgb(0.0) == scale.rgb(0.001) == RED
    assert scale.rgb(0.01) == pytest.approx(AMBER)
    assert scale.rgb(0.1) == scale.rgb(9.0) == pytest.approx(GREEN)


def test_bodies_are_neither_too_dark_nor_too_bright_for_any_background():
    for red, green, blue in MOVING + FIXED:
        assert 0.4 < 0.2126 * red + 0.7152 * green + 0.0722 * blue < 0.8
    assert len(set(MOVING)) == len(MOVING)
