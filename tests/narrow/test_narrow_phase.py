"""Exact distances, touching, features and containment against closed forms and brute force."""

from fractions import Fraction
from math import sqrt

import numpy as np
import pytest
from placed_meshes import EYE, POINT, SEGMENT, TRIANGLE, box_mesh, brute_force, phase_of, placed, soup
from scipy.spatial.transform import Rotation

from closecall.scheduler.model.events import FeatureKind
from closecall.scheduler.model.scene import Body, Mesh, Shape
from closecall.scheduler.motions import Fixed
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.narrow.triangle import Triangle, feature_at, meeting_point
from closecall.scheduler.narrow.triangle_pairs import MOST_TRIANGLE_PAIRS, Triangles, near_pairs
from closecall.scheduler.solids.containment import component_points
from closecall.scheduler.solids.winding import winding_numbers
from oracle.triangles import separation


def test_unit_boxes_four_apart_read_three():
    assert phase_of(box_mesh(1, 1, 1), box_mesh(1, 1, 1)).nearest(0, 1, EYE, placed(None, 0, 4, 0)).distance == 3.0


@pytest.mark.parametrize("offset", [0.0, 1e3, 1e6])
def test_random_soups_agree_with_brute_force_wherever_they_are(offset):
    rng = np.random.default_rng(1)
    for _ in range(100):
        one, other = soup(rng, 6), soup(rng, 6)
        phase = phase_of(one, other)
        pose_a = placed(rng, offset, offset, -offset)
        pose_b = placed(rng, *(pose_a[:3, 3] + rng.normal(size=3) * 4))
        near = pose_a.copy(), pose_b.copy()
        for pose in near:
            pose[:3, 3] -= pose_a[:3, 3]
        found = phase.nearest(0, 1, pose_a, pose_b)
        assert found.distance == pytest.approx(brute_force(one, other, *near), abs=1e-12)
        gap = np.linalg.norm(np.subtract(found.witness_a, found.witness_b))
        assert gap == pytest.approx(found.distance, abs=1e-14 * (1 + offset) * 10)


@pytest.mark.parametrize("size", [1e-22, 1e-18, 1e-13, 1e-9, 1e-6, 1e-4, 1.0, 1e3, 1e15])
def test_the_error_covers_near_pairs_of_slivers_of_any_size(size):
    """Unscaled, FCL skips the faces of triangles below a fixed area, and errs by percents of their size."""
    rng = np.random.default_rng(2)
    for _ in range(200):
        thin = 10.0 ** rng.uniform(-7, 0)
        turn = Rotation.random(rng=rng).as_matrix()
        corners = rng.normal(size=(3, 3)) * (size, thin * size, thin * size) @ turn
        one = Mesh("t", corners, np.array([[0, 1, 2]]), False)
        other = Mesh("t", rng.normal(size=(3, 3)) * size, np.array([[0, 1, 2]]), False)
        touched = rng.dirichlet(np.ones(3)) @ one.vertices - other.vertices[0]
        pose = placed(None, *(touched + rng.normal(size=3) * size * 10.0 ** rng.uniform(-8, 0)))
        phase = phase_of(one, other)
        truth = brute_force(one, other, EYE, pose)
        assert abs(phase.nearest(0, 1, EYE, pose).distance - truth) < phase.error(0, 1)


def test_the_error_covers_what_is_straight_above_a_thin_triangle():
    """There its normal counts, which is rounded by eps side / height."""
    rng = np.random.default_rng(7)
    above = []
    for _ in range(200):
        thin = 10.0 ** rng.uniform(-7, -3)
        turn = Rotation.random(rng=rng).as_matrix()
        corners = (np.array([[0, 0, 0], [1, 0, 0], [0.4, thin, 0]]) @ turn.T).astype(np.longdouble)
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        normal /= np.sqrt(normal @ normal)
        point = (rng.dirichlet(np.full(3, 4.0)) @ corners + normal * 10.0 ** rng.uniform(-4, 0)).astype(float)
        phase = phase_of(Mesh("t", corners.astype(float), TRIANGLE, False), Mesh("p", point[None], 0 * TRIANGLE, False))
        wrong = abs(phase.nearest(0, 1, EYE, EYE).distance - abs((point - corners[0]) @ normal))
        assert wrong < phase.error(0, 1)
        above.append(wrong > 1e-12)
    assert any(above)


def test_the_error_of_plump_triangles_is_tiny():
    assert phase_of(box_mesh(1, 1, 1), box_mesh(1, 1, 1)).error(0, 1) < 1e-13


def test_a_bead_over_a_tenth_of_a_millimetre_box_reads_its_true_distance():
    phase = phase_of(box_mesh(1e-4, 1e-4, 1e-4), Shape(POINT, 1e-5, EYE))
    for x, y in ((0.0, 0.0), (2e-5, -3e-5), (4.9e-5, 0.0)):
        found = phase.nearest(0, 1, EYE, placed(None, x, y, 8e-5)).distance
        assert found == pytest.approx(2e-5, abs=1e-18)


@pytest.mark.parametrize(("core", "truth"), [(POINT, sqrt(9 + 1) - 1.5), (SEGMENT, 3.0 - 1.5)])
def test_spheres_and_capsules_are_cores_less_their_radius(core, truth):
    phase = phase_of(Shape(core, 0.5, EYE), Shape(POINT, 1.0, EYE))
    found = phase.nearest(0, 1, EYE, placed(None, 3.0, 0.0, 1.0))
    assert found.distance == pytest.approx(truth, abs=1e-14)
    assert np.linalg.norm(np.subtract(found.witness_a, found.witness_b)) == pytest.approx(truth, abs=1e-14)


def test_capsules_agree_with_segment_to_segment_distance():
    rng = np.random.default_rng(3)
    phase = phase_of(Shape(SEGMENT, 0.25, EYE), Shape(SEGMENT, 0.125, EYE))
    share = np.linspace(-1, 1, 401)
    for _ in range(100):
        pose = placed(rng, *rng.normal(size=3) * 2)
        one = np.array([0, 0, 1.0]) * share[:, None]
        other = pose[:3, 2] * share[:, None] + pose[:3, 3]
        sampled = np.min(np.linalg.norm(one[:, None] - other[None], axis=2)) - 0.375
        found = phase.nearest(0, 1, EYE, pose).distance
        assert found == pytest.approx(max(0.0, sampled), abs=1e-2)
        assert found <= max(0.0, sampled) + 1e-12


def test_overlap_reads_zero_with_one_point_on_both_surfaces():
    rng = np.random.default_rng(4)
    one, other = box_mesh(1, 1, 1), box_mesh(1, 1, 1)
    phase = phase_of(one, other)
    met = 0
    for _ in range(200):
        pose = placed(rng, *rng.normal(size=3) * 0.6)
        found = phase.nearest(0, 1, EYE, pose)
        if found.distance == 0.0:
            met += 1
            assert found.witness_a == found.witness_b
            for witness, matrix in ((found.witness_a, EYE), (found.witness_b, pose)):
                local = (np.array(witness) - matrix[:3, 3]) @ matrix[:3, :3]
                assert np.max(np.abs(local)) == pytest.approx(0.5, abs=1e-9)
    assert met > 100


def test_degenerate_triangles_in_a_mesh_do_not_invent_contact():
    """fcl.collide calls collinear segments that lie apart a collision; such meshes are measured by distance alone."""
    line = Mesh("line", np.array([[0.0, 0, 0], [1, 0, 0]]), np.array([[0, 1, 1]]), False)
    found = phase_of(line, line).nearest(0, 1, EYE, placed(None, 3.0))
    assert found.distance == pytest.approx(2.0, abs=1e-15)


def test_several_shapes_of_one_body_read_as_their_nearest():
    shapes = tuple(Shape(box_mesh(1, 1, 1), 0.0, placed(None, x)) for x in (0.0, 5.0, 10.0))
    bodies = Body("many", None, EYE, Fixed(), shapes), Body("one", None, EYE, Fixed(), (Shape(POINT, 0.5, EYE),))
    found = NarrowPhase(bodies).nearest(0, 1, EYE, placed(None, 5.0, 3.0))
    assert found.distance == pytest.approx(2.0, abs=1e-15)
    assert found.feature_a().shape == 1


CORNERS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


@pytest.mark.parametrize(
    ("point", "kind", "index"),
    [
        ((0.0, 0.0, 0.0), FeatureKind.VERTEX, 0),
        ((0.0, 1.0, 0.0), FeatureKind.VERTEX, 2),
        ((0.5, 0.0, 0.0), FeatureKind.EDGE, 0),
        ((0.5, 0.5, 0.0), FeatureKind.EDGE, 1),
        ((0.0, 0.3, 0.0), FeatureKind.EDGE, 2),
        ((0.3, 0.3, 0.0), FeatureKind.FACE, 0),
    ],
)
def test_a_witness_is_on_the_corner_edge_or_face_that_holds_it(point, kind, index):
    assert feature_at(point, CORNERS) == (kind, index)


def test_two_crossing_triangles_meet_in_a_point_of_both():
    other = ((0.2, 0.2, -1.0), (0.3, 0.2, 1.0), (0.2, 0.3, 1.0))
    point = meeting_point(CORNERS, other)
    assert point[2] == pytest.approx(0.0)
    assert 0.2 <= point[0] <= 0.3


def test_coplanar_triangles_meet_in_a_point_of_both():
    rng = np.random.default_rng(6)
    met = 0
    for _ in range(300):
        one, other = (np.column_stack((rng.normal(size=(3, 2)), np.zeros(3))) for _ in range(2))
        if brute_force_overlap(one, other):
            met += 1
            point = meeting_point(triangle(one), triangle(other))
            assert all(inside_distance(np.array(point), corners) < 1e-12 for corners in (one, other))
    assert met > 50


def test_triangles_that_only_touch_meet_in_a_point_of_both():
    """A plane through one point of both, of a corner, an edge or a face, has each on a side of its own, to rounding."""
    rng = np.random.default_rng(7)
    for _ in range(600):
        turn, place = Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)
        below, above = (standing_on_zero(rng, side) @ turn.T + place for side in (-1.0, 1.0))
        point = np.array(meeting_point(triangle(below), triangle(above)))
        assert max(distance_to(point, below), distance_to(point, above)) < 1e-13


def standing_on_zero(rng, side) -> np.ndarray:
    """Return a triangle on one side (-1, 1) of z = 0, with a corner, an edge or all of it in that plane, at 0."""
    corners = rng.normal(size=(3, 3))
    corners[:, 2] = side * np.abs(corners[:, 2])
    flat = int(rng.integers(1, 4))
    corners[:flat, 2] = 0.0
    weights = rng.dirichlet(np.ones(flat)) if rng.random() < 0.7 else np.eye(flat)[0]
    return corners - weights @ corners[:flat]


def distance_to(point, corners) -> float:
    return float(separation(np.moveaxis(np.tile(point, (1, 3, 1)), 2, 0), np.moveaxis(corners[None], 2, 0))[0])


def triangle(corners) -> Triangle:
    (a, b, c), (d, e, f), (g, h, i) = corners.tolist()
    return (a, b, c), (d, e, f), (g, h, i)


def cross(a, b) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def inside_distance(point, corners) -> float:
    """Return how far outside a triangle of the plane a point lies, as a share of its area."""
    x, y, z = corners[:, :2]
    area = cross(y - x, z - x)
    return max(0.0, *(-cross(b - a, point[:2] - a) / area for a, b in ((x, y), (y, z), (z, x))))


def brute_force_overlap(one, other) -> bool:
    """Tell whether two triangles of the plane overlap, by the separating axes of their edges."""
    for corners in (one, other):
        for k in range(3):
            edge = corners[(k + 1) % 3] - corners[k]
            axis = np.array([-edge[1], edge[0], 0.0])
            p, q = one @ axis, other @ axis
            if p.max() < q.min() or q.max() < p.min():
                return False
    return True


def test_winding_number_is_one_inside_and_zero_outside_of_a_closed_mesh():
    mesh = box_mesh(2, 2, 2)
    corners = mesh.vertices[mesh.triangles]
    rng = np.random.default_rng(5)
    points = rng.uniform(-2, 2, size=(300, 3))
    expected = np.where(np.abs(points).max(axis=1) < 1.0, 1.0, 0.0)
    np.testing.assert_allclose(winding_numbers(points, corners), expected, atol=1e-9)


def test_every_connected_part_of_a_soup_gives_one_point():
    """An STL repeats every corner: two boxes are 24 triangles of 72 vertices, and two parts."""
    mesh = box_mesh(1, 1, 1)
    corners = mesh.vertices[mesh.triangles].reshape(-1, 3)
    both = np.vstack((corners, np.add(corners, 5.0)))
    assert len(component_points(Mesh("soup", both, np.arange(72).reshape(-1, 3), True))) == 2


def test_parts_that_share_a_corner_alone_give_a_point_each():
    corners = box_mesh(1, 1, 1).vertices
    triangles = box_mesh(1, 1, 1).triangles
    for shift, parts in (((1.0, 1.0, 1.0), 2), ((1.0, 1.0, 0.0), 1)):
        both = Mesh("both", np.vstack((corners, corners + shift)), np.vstack((triangles, triangles + 8)), True)
        assert len(component_points(both)) == parts


def tree_of(points) -> Triangles:
    """Return triangles that are points (n, 3)."""
    return Triangles.of(np.repeat(points[:, None], 3, axis=1))


def test_near_triangles_of_large_meshes_are_all_found():
    """Points along two lines that pass each other at 5 cm: more groups of them than are compared each with each."""
    along = np.linspace(-1.0, 1.0, 2000)[:, None]
    one, other = along * (1.0, 1.0, 0.0), along * (1.0, -1.0, 0.0)
    pose, reach = placed(None, z=0.05), 0.052
    found = near_pairs(tree_of(one), tree_of(other), EYE, pose, reach)
    assert found is not None
    near = np.argwhere(np.linalg.norm(one[:, None] - (other + pose[:3, 3]), axis=2) <= reach).tolist()
    expected = {(*one[i].tolist(), *(other[j] + pose[:3, 3]).tolist()) for i, j in near}
    assert len(expected) > 200
    assert expected <= set(map(tuple, np.hstack([corners[:, 0] for corners in found]).tolist()))


def test_of_too_many_near_triangles_some_are_found_where_they_will_do():
    points = np.random.default_rng(4).uniform(-1.0, 1.0, (1000, 3))
    tree = tree_of(points)
    assert near_pairs(tree, tree, EYE, EYE, 0.5) is None
    found = near_pairs(tree, tree, EYE, EYE, 0.5, some=True)
    assert found is not None
    assert 0 < len(found[0]) <= MOST_TRIANGLE_PAIRS
    known = {tuple(point) for point in points.tolist()}
    assert all(tuple(corner) in known for corners in found for corner in corners[:, 0].tolist())
    assert np.linalg.norm(found[0][:, 0] - found[1][:, 0], axis=1).max() <= 0.5 * np.sqrt(3.0)


def test_containment_is_seen_both_ways_and_for_every_part():
    big, small = box_mesh(10, 10, 10), box_mesh(1, 1, 1)
    assert phase_of(big, small).contained(0, 1, EYE, EYE) is not None
    assert phase_of(small, big).contained(0, 1, EYE, EYE) is not None
    assert phase_of(small, big).contained(0, 1, EYE, placed(None, 20.0)) is None
    parts = Mesh(
        "parts",
        np.vstack((small.vertices + 50.0, small.vertices)),
        np.vstack((small.triangles, small.triangles + 8)),
        True,
    )
    assert phase_of(parts, big).contained(0, 1, EYE, EYE) is not None
    open_sheet = Mesh("sheet", np.array(CORNERS), np.array([[0, 1, 2]]), False)
    assert phase_of(open_sheet, big).contained(0, 1, EYE, EYE) is not None


@pytest.mark.parametrize("offset", [0.0, 1e3, 1e6])
def test_the_error_covers_a_mesh_that_its_pose_brings_back_from_afar(offset):
    """A box of 1 m whose file has it far away, turned about itself; the truth by fractions."""
    rng = np.random.default_rng(int(offset))
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])
    for _ in range(30):
        angle = float(rng.uniform(0.0, 2.0 * np.pi))
        pose, there = np.eye(4), np.eye(4)
        pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        pose[:3, 3] = -pose[:3, :3] @ np.full(3, offset)
        there[0, 3] = float(rng.uniform(2.0, 3.0))
        far = Mesh("far", corners + offset, triangles, True)
        wall = Mesh("wall", corners * [1.0, 9.0, 9.0], triangles, True)
        phase = phase_of(Shape(far, 0.0, pose), wall)
        found = phase.nearest(0, 1, np.eye(4), there).distance
        places = [sum(Fraction(pose[0, k]) * Fraction(float(v[k])) for k in range(3)) for v in far.vertices]
        true = Fraction(float(there[0, 3])) - Fraction(1, 2) - max(places) - Fraction(float(pose[0, 3]))
        assert abs(found - float(true)) <= phase.error(0, 1)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_first_corners_that_are_nearest_are_not_told_as_meeting(size):
    """A capsule's end straight above a triangle's first corner: FCL says 0 there now and then."""
    rng = np.random.default_rng(5)
    for _ in range(600):
        gap = float(10.0 ** rng.uniform(-4, 2)) * size
        segment = np.array([[0.0, 0.0, 0.0], [*rng.normal(size=2), 0.0 if rng.random() < 0.5 else 0.5]]) * size
        away = [*rng.normal(size=2), 0.0 if rng.random() < 0.5 else -abs(rng.normal())]
        triangle = np.array([[0.0, 0.0, 0.0], [*rng.normal(size=2), 0.0], away]) * size - [0.0, 0.0, gap]
        poses = np.tile(np.eye(4), (2, 1, 1))
        poses[:, :3, :3] = Rotation.random(2, rng=rng).as_matrix()
        poses[:, :3, 3] = rng.normal(size=(2, 3)) * size
        own = [(c - pose[:3, 3]) @ pose[:3, :3] for c, pose in zip((segment, triangle), poses, strict=True)]
        one = Mesh("segment", own[0], np.array([[0, 1, 1]]), False)
        other = Mesh("triangle", own[1], np.array([[0, 1, 2]]), False)
        found = phase_of(one, other).nearest(0, 1, *poses)
        lengths = np.linalg.norm(segment, axis=1).max() + np.linalg.norm(triangle, axis=1).max()
        near = separation(np.moveaxis(segment[[0, 1, 1]][None], 2, 0), np.moveaxis(triangle[None], 2, 0))
        assert found.distance == pytest.approx(max(0.0, float(near[0])), abs=1e-12 * lengths)
        apart = np.linalg.norm(np.array(found.witness_a) - found.witness_b)
        assert apart == pytest.approx(found.distance, abs=1e-11 * lengths)
