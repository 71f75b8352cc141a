"""The distance of triangles and meshes that lie as badly as can be: against exact rational arithmetic, brute force."""

import numpy as np
import pytest
from exact_triangles import root, squared_distance
from placed_meshes import SEGMENT, box_mesh, brute_force, phase_of, placed
from scipy.spatial.transform import Rotation

from closecall.scheduler.model.scene import Mesh
from closecall.scheduler.narrow.triangle_distance import nearest_of

UNIT = float(np.finfo(float).eps)


def coplanar(rng):
    corners = rng.integers(-2, 3, size=(2, 3, 3)).astype(float)
    corners[:, :, 2] = 0.0
    corners[1, :, 0] += rng.integers(0, 6)
    return corners


def face_to_face(rng):
    corners = coplanar(rng)
    corners[1, :, 2] = 10.0 ** rng.uniform(-13, -7)
    return corners


def parallel_edges(rng):
    """Translates of one triangle, so that every edge has one parallel to it."""
    corner = rng.integers(-2, 3, size=(3, 3)).astype(float)
    return np.stack((corner, corner[rng.permutation(3)] + rng.integers(-3, 4, size=3)))


def crossing_at_a_tiny_angle(rng):
    """Long segments or slivers that cross at 1e-14 to 1e-4 rad, nearly touching."""
    angle, gap = 10.0 ** rng.uniform(-14, -4), 10.0 ** rng.uniform(-14, -6)
    one = np.array([[-1.0, 0, 0], [1, 0, 0], [rng.uniform(-1, 1), 0, -gap * rng.integers(0, 2)]])
    turn = Rotation.from_rotvec([0, 0, angle]).as_matrix()
    two = np.array([[-1.0, 0, 0], [1, 0, 0], [1, 0, gap * rng.integers(0, 2)]]) @ turn.T
    place = np.array([rng.uniform(-0.5, 0.5), rng.choice([0.0, 1.0]) * gap, gap * rng.integers(0, 2)])
    return np.stack((one, two + place))


def slivers(rng):
    """Thin down to 1e-12 of their length, beside, above or through each other."""
    thin = 10.0 ** rng.uniform(-12, 0, size=2)
    corners = np.array([[[-1.0, 0, 0], [1, 0, 0], [rng.uniform(-1, 1), t, 0]] for t in thin])
    corners[1] = corners[1] @ Rotation.random(rng=rng).as_matrix().T
    corners[1] += rng.normal(size=3) * 10.0 ** rng.uniform(-12, 0)
    return corners


def shared_edges(rng):
    corners = rng.normal(size=(2, 3, 3))
    corners[1, :2] = corners[0, :2] + rng.choice([0.0, 1.0]) * 10.0 ** rng.uniform(-16, -8) * rng.normal(size=3)
    return corners


def a_corner_on_a_face(rng):
    corners = rng.normal(size=(2, 3, 3))
    corners[1] += rng.dirichlet(np.ones(3)) @ corners[0] - corners[1, 0] + rng.normal(size=3) * 1e-10
    return corners


def pierced(rng):
    corners = rng.normal(size=(2, 3, 3))
    corners[1] -= corners[1].mean(axis=0) - corners[0].mean(axis=0)
    return corners


FAMILIES = [
    coplanar,
    face_to_face,
    parallel_edges,
    crossing_at_a_tiny_angle,
    slivers,
    shared_edges,
    a_corner_on_a_face,
    pierced,
]


@pytest.mark.parametrize("family", FAMILIES)
def test_the_distance_of_badly_placed_triangles_errs_by_eight_units_at_most(family):
    rng = np.random.default_rng(11)
    for _ in range(40):
        corners = family(rng)
        if rng.random() < 0.2:
            corners[0, 2] = corners[0, 1]  # a segment
        if rng.random() < 0.3:
            corners = corners + rng.normal(size=corners.shape) * 10.0 ** rng.uniform(-17, -6)
        corners = corners @ Rotation.random(rng=rng).as_matrix().T * rng.choice([1e-22, 1.0, 1e15])
        true = root(squared_distance(*corners))
        found = nearest_of(corners[:1], corners[1:], (np.array([0]), np.array([0])))
        sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1).sum()
        assert abs(found.distance - true) <= 8.0 * UNIT * (sides + true)
        apart = np.linalg.norm(np.subtract(found.witness_b, found.witness_a))
        assert abs(apart - found.distance) <= 8.0 * UNIT * (sides + true + np.abs(corners).max())


def prism(sides: int) -> Mesh:
    """Return a closed prism of diameter and height 1 m, upright on z."""
    angles = 2.0 * np.pi * np.arange(sides) / sides
    ring = 0.5 * np.column_stack((np.cos(angles), np.sin(angles)))
    ends = [np.column_stack((ring, np.full(sides, z))) for z in (-0.5, 0.5)]
    low, high = 2 * sides, 2 * sides + 1
    pairs = [(i, (i + 1) % sides) for i in range(sides)]
    walls = [t for i, j in pairs for t in ((i, j, sides + j), (i, sides + j, sides + i))]
    caps = [t for i, j in pairs for t in ((low, j, i), (high, sides + i, sides + j))]
    vertices = np.vstack((*ends, [[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]))
    return Mesh("prism", vertices, np.array(walls + caps), True)


def turned(rng, pose):
    """Return two poses (4, 4), the second one `pose` from the first, which is turned in any way."""
    first = placed(rng, *rng.normal(size=3))
    return first, first @ pose


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_faces_a_trillionth_to_a_hundred_millionth_of_their_size_apart_do_not_meet(scale):
    """FCL says 0 of 5 to 30% of such faces; the truth is the gap that they were given, to the error stated."""
    rng = np.random.default_rng(12)
    for number in range(120):
        gap = 10.0 ** rng.uniform(-12, -8)
        shape = box_mesh(1, 1, 1) if number % 2 else prism(int(rng.integers(3, 20)))
        mesh = Mesh("scaled", shape.vertices * scale, shape.triangles, True)
        poses = turned(rng, placed(None, z=1.0 + gap))
        for pose in poses:
            pose[:3, 3] *= scale
        phase = phase_of(mesh, mesh)
        found = phase.nearest(0, 1, *poses)
        placing = 8.0 * UNIT * float(np.linalg.norm(poses[1][:3, 3]))
        assert abs(found.distance - gap * scale) <= phase.error(0, 1) + placing
        assert np.linalg.norm(np.subtract(found.witness_a, found.witness_b)) == pytest.approx(
            found.distance, abs=phase.error(0, 1) + placing
        )


def test_faces_of_many_triangles_that_nearly_meet_are_measured_piece_by_piece():
    """Plates of 2 x 1,800 triangles 1e-10 m apart: more pairs are near than are looked at together."""
    line = np.linspace(-0.5, 0.5, 31)
    points = np.array([(x, y, 0.0) for y in line for x in line])
    index = np.arange(961).reshape(31, 31)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    plate = Mesh("plate", points, np.vstack((np.column_stack((a, b, c)), np.column_stack((a, c, d)))), False)
    poses = turned(np.random.default_rng(13), placed(None, z=1e-10))
    phase = phase_of(plate, plate)
    assert phase.nearest(0, 1, *poses).distance == pytest.approx(1e-10, abs=phase.error(0, 1))


def nearly_parallel(rng, shapes) -> tuple[Mesh, Mesh, np.ndarray]:
    """Return two cores and a pose that parts their edges by 1e-14 to 1e-4 rad; triangles' by rounding alone."""
    pose, gap = placed(None), 10.0 ** rng.uniform(-12, -8)
    pose[:3, :3] = Rotation.from_rotvec(rng.normal(size=3) * 10.0 ** rng.uniform(-14, -4)).as_matrix()
    if shapes == "segments":
        angle = rng.uniform(0.0, 2.0 * np.pi)
        pose[:3, 3] = gap * np.cos(angle), gap * np.sin(angle), 0.0
        return SEGMENT, SEGMENT, pose
    if shapes == "sheets":
        square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
        sheet = Mesh("sheet", square, np.array([[0, 1, 2], [0, 2, 3]]), False)
        aside = [rng.choice([0.0, 1.0, rng.uniform(-1, 1)]) for _ in range(2)]
        pose[:3, 3] = (*aside, gap) if rng.random() < 0.5 else (1.0 + gap, aside[1], 0.0)
        return sheet, sheet, pose
    corners = rng.integers(-2, 3, size=(3, 3)) + 0.0
    if np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) < 0.5:
        corners = np.eye(3)
    one, other = (Mesh("t", corners, np.array([rng.permutation(3)]), False) for _ in range(2))
    return one, other, placed(None, *rng.integers(-3, 4, size=3))


@pytest.mark.parametrize(("shapes", "tries"), [("segments", 100), ("sheets", 200), ("triangles", 130)])
def test_nearly_parallel_edges_of_open_cores_do_not_read_too_far_apart(shapes, tries):
    """FCL tells up to 1e-8 of the size too much of segments and sheets, and of triangles now and then half the size."""
    rng = np.random.default_rng(26)
    for _ in range(tries):
        one, other, pose = nearly_parallel(rng, shapes)
        first = placed(rng)
        phase = phase_of(one, other)
        found = phase.nearest(0, 1, first, first @ pose).distance
        assert found <= brute_force(one, other, first, first @ pose) + phase.error(0, 1)
