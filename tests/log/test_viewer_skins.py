"""The red skins of bodies in contact: where they are drawn, from whatever side, and what room they take."""

from __future__ import annotations

import zlib

import numpy as np
import pytest
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from google.protobuf.timestamp_pb2 import Timestamp
from scipy.spatial.transform import Rotation
from small_scenes import box

from closecall.formats.log.viewer.drawings import Drawings
from closecall.formats.log.viewer.entities import BodyEntities, Look
from closecall.scheduler.model.scene import Body, PairRules, Scene, Shape
from closecall.scheduler.motions import Constant

TILTED = np.eye(4)
TILTED[:3, :3] = Rotation.from_euler("xyz", [0.4, 0.9, -1.3]).as_matrix()
TILTED[:3, 3] = (0.3, 0.1, -0.2)
CORNERS = box(0.5, 0.7, 0.9).mesh.vertices
SIZE = np.linalg.norm(np.ptp(CORNERS @ TILTED[:3, :3].T, axis=0))  # of the bounds in the body's own frame


def entities(framed: bool, count: int = 1) -> BodyEntities:
    shape = Shape(box(0.5, 0.7, 0.9).mesh, 0.0, TILTED)
    spinning = Constant((0.0, 0.0, 0.0), (1.0, 2.0, 3.0))
    bodies = tuple(Body(f"body {index}", None, np.eye(4), spinning, (shape,)) for index in range(count))
    scene = Scene(bodies, 0.0, 1.0, PairRules())
    look = Look([framed] * count, 1_000_000, 10.0, 2.0)
    return BodyEntities(scene, [True] * count, np.tile(np.eye(4), (count, 1, 1)), Drawings(bodies), look)


def random_pose(rng) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(rng=rng).as_matrix()
    pose[:3, 3] = rng.uniform(-5.0, 5.0, 3)
    return pose


def drawn(skin: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Return a skin's points (n, 3) and its origin (3,), m, in its entity's frame."""
    (triangles,) = SceneEntity.FromString(skin).triangles
    place, turn = triangles.pose.position, triangles.pose.orientation
    origin = np.array((place.x, place.y, place.z))
    points = np.array([(point.x, point.y, point.z) for point in triangles.points])
    return Rotation.from_quat((turn.x, turn.y, turn.z, turn.w)).apply(points) + origin, origin


@pytest.mark.parametrize("framed", [True, False])
def test_a_skin_lies_about_its_body_with_its_origin_over_it(framed):
    """A skin's corners are the box's, 0.004 of its size farther out, to a 50th of that; its origin is over it."""
    rng, shown = np.random.default_rng(1), entities(framed)
    for _ in range(300):
        pose = random_pose(rng)
        for _ in range(2):  # what is told again is told the same
            points, origin = drawn(b"".join(shown.in_red(0, Timestamp(), pose)))
            if not framed:
                points, origin = ((v - pose[:3, 3]) @ pose[:3, :3] for v in (points, origin))
            local = (points - TILTED[:3, 3]) @ TILTED[:3, :3]
            off = local - CORNERS
            assert np.linalg.norm(off, axis=1) == pytest.approx(0.004 * SIZE, rel=0.02)
            assert (np.sign(off) == np.sign(CORNERS)).all()
            assert (origin - TILTED[:3, 3]) @ pose[2, :3] > 0.039 * SIZE


def test_no_more_skins_are_kept_than_may_be_and_all_are_right(monkeypatch):
    monkeypatch.setattr("closecall.formats.log.viewer.entities._MOST_SKINS", 3)
    rng, shown = np.random.default_rng(2), entities(True, 5)
    poses = [random_pose(rng) for _ in range(5)]
    alone = [entities(True, 5).in_red(index, Timestamp(), pose) for index, pose in enumerate(poses)]
    for _ in range(3):
        assert [shown.in_red(index, Timestamp(), pose) for index, pose in enumerate(poses)] == alone
        assert len(shown._skins) <= 3


def test_skins_of_a_body_that_turns_take_little_room():
    shown, turn = entities(True), np.eye(4)
    skins = []
    for angle in np.linspace(0.0, 0.3, 50):
        turn[:3, :3] = Rotation.from_rotvec((0.0, angle, 0.0)).as_matrix()
        skins.append(b"".join(shown.in_red(0, Timestamp(), turn)))
    assert len(set(skins)) <= 3
    assert len(zlib.compress(skins[0])) < 0.6 * len(skins[0])
