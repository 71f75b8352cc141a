"""What floating point takes off what is not a motion's: frames, cancelling speeds, growing balls, slabs, margins.

Held against extended precision and fractions. Each test also sees errors that a far smaller constant would miss.
"""

from fractions import Fraction
from math import inf, nextafter

import numpy as np
import pytest
from drawn_motions import EPSILON, random_unit, vector
from scipy.spatial.transform import Rotation
from small_scenes import events_of, round_shape

from closecall.scheduler.bounds.triangle_overlap import TriangleOverlap
from closecall.scheduler.bounds.triangle_slabs import TriangleSlabs
from closecall.scheduler.geometry.transform import rotation_of_quaternion
from closecall.scheduler.geometry.vector import ZERO
from closecall.scheduler.kinematics.chain import Chain, Twist, chain_to
from closecall.scheduler.kinematics.relative_motion import RelativeMotion, RelativeRates
from closecall.scheduler.model.events import Distance, Span, Verdict
from closecall.scheduler.model.extent import Ball, Extent, body_extent
from closecall.scheduler.model.scene import Body, Mesh, PairRules, Scene, Shape
from closecall.scheduler.motions import Constant, Fixed, Keyframes, Limits, Translation
from closecall.scheduler.motions.acceleration_set import STILL as CONSTANT
from closecall.scheduler.motions.key_interval import Span as Stretch
from closecall.scheduler.narrow.narrow_phase import DISTANCE_ERROR, NarrowPhase
from closecall.scheduler.narrow.narrow_phase import POINT as POINT_MESH
from closecall.scheduler.narrow.triangle_pairs import NearTriangles, Triangles, near_pairs
from closecall.scheduler.pairs.least_distance import ERRORS, LEAST_TOLERANCE
from closecall.scheduler.pairs.pair import Pair
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide
from closecall.scheduler.solids.containment import Interior

WIDE = np.longdouble
EYE = np.eye(4)
POINT = Extent(np.zeros((1, 3)), np.zeros(1), Ball(ZERO, 0.0))
STILL = Twist(ZERO, ZERO, ZERO)
CASES = 300


def wide(array) -> np.ndarray:
    return np.asarray(array, dtype=WIDE)


def length(vectors) -> np.ndarray:
    return np.sqrt(np.sum(wide(vectors) ** 2, axis=-1))


def exact_rotation(quaternion) -> np.ndarray:
    """Return the rotation of a quaternion of any length, in extended precision."""
    w, x, y, z = wide(quaternion)
    n = 2 / (w * w + x * x + y * y + z * z)
    return np.array(
        [
            [1 - n * (y * y + z * z), n * (x * y - z * w), n * (x * z + y * w)],
            [n * (x * y + z * w), 1 - n * (x * x + z * z), n * (y * z - x * w)],
            [n * (x * z - y * w), n * (y * z + x * w), 1 - n * (x * x + y * y)],
        ]
    )


def posed(rng, far) -> tuple[np.ndarray, np.ndarray]:
    """Return a random pose in float64 and the same in extended precision."""
    quaternion, place = rng.normal(size=4), rng.normal(size=3) * far
    pose, exact = np.eye(4), np.eye(4, dtype=WIDE)
    pose[:3, :3] = rotation_of_quaternion(*map(float, quaternion / np.linalg.norm(quaternion)))
    exact[:3, :3], pose[:3, 3], exact[:3, 3] = exact_rotation(quaternion), place, place
    return pose, exact


def test_the_account_covers_up_to_thirty_frames_within_each_other():
    rng = np.random.default_rng(1)
    shares = []
    for _ in range(CASES):
        mesh = Mesh("t", rng.normal(size=(3, 3)) * 10.0 ** rng.uniform(-3, 3), np.array([[0, 1, 2]]), False)
        bodies, exact = [], np.eye(4, dtype=WIDE)
        for frame in range(int(rng.integers(1, 30))):
            pose, step = posed(rng, rng.choice([0.0, 1.0, 5e6]))
            exact = exact @ step
            bodies.append(Body(str(frame), frame - 1 if frame else None, pose, Fixed(), (Shape(mesh, 0.0, EYE),)))
        chain = chain_to(tuple(bodies), len(bodies) - 1, None, body_extent(bodies[-1]))
        found = wide(chain.at(0.0).pose)
        wrong = wide(mesh.vertices) @ (found - exact)[:3, :3].T + (found - exact)[:3, 3]
        shares.append(float(length(wrong).max()) / chain.rounding((0.0, 1.0)))
    assert 0.01 < max(shares) < 1.0


def test_the_speed_of_bodies_that_move_alike_is_not_less_than_what_rounding_hides():
    """One drives in the world, the other in a turned frame: what is left of 10 km/s is the rounding of its parts."""
    rng = np.random.default_rng(2)
    seen = 0
    for _ in range(CASES):
        pose, _ = posed(rng, 0.0)
        inner = np.array(random_unit(rng)) * 1e4
        turned = wide(pose[:3, :3]) @ wide(inner)
        bodies = (
            Body("a", None, EYE, Constant(vector(turned.astype(float)), ZERO), ()),
            Body("b", None, pose, Constant(vector(inner), ZERO), ()),
        )
        motion = RelativeMotion(chain_to(bodies, 0, None, POINT), chain_to(bodies, 1, None, POINT))
        speed = motion.approach(motion.at(0.0), 1.0).speed
        truth = float(length(turned - wide(turned.astype(float))))
        seen += truth > 1e-13
        assert truth <= speed
    assert seen > CASES // 2


def exact_reach(limits: Limits, t: float) -> Fraction:
    since, top = Fraction(t) - Fraction(limits.begin), Fraction(limits.max_speed)
    speed, steepness = Fraction(limits.speed), Fraction(limits.max_acceleration)
    rising = min(since, (top - speed) / steepness)
    return speed * rising + steepness * rising**2 / 2 + top * (since - rising)


def test_the_account_covers_how_far_an_unknown_path_may_have_led():
    rng = np.random.default_rng(3)
    still, shares = Chain((), EYE, POINT), []
    for _ in range(3 * CASES):
        speed, more, steepness = map(float, 10.0 ** rng.uniform(-3, 3, 3))
        limits = Limits(float(rng.normal() * 1e9), speed, speed + more, steepness)
        end = limits.begin + float(10.0 ** rng.uniform(-2, 4))
        motion = RelativeMotion(still, still, (limits,))
        wrong = abs(Fraction(motion.spread(end)) - exact_reach(limits, end))
        shares.append(float(wrong) / motion.rounding((limits.begin, end)))
    assert 0.01 < max(shares) < 1.0


def test_the_lengths_of_whole_segments_err_high_to_the_last_bit():
    """Of a cubic path that runs straight, at the slopes as its keys' velocities."""
    rng = np.random.default_rng(10)
    for _ in range(CASES):
        times, way = np.arange(6.0) * rng.uniform(0.1, 10), rng.normal(size=3)
        places = np.arange(6.0)[:, None] * way
        slopes = np.broadcast_to(way / times[1], (6, 3))
        keys = Keyframes(times, places, np.array([[1.0, 0, 0, 0]] * 6), Translation.CUBIC, False, slopes)
        assert keys.path.length(Stretch(0, float(times[1]), 5, 0.0)) >= 4 * length(way)


def test_no_triangle_within_reach_is_left_out_by_rounding():
    """Points, whose distance is that of their boxes, at just the reach."""
    rng = np.random.default_rng(4)
    for _ in range(3 * CASES):
        one, other = (Triangles.of(np.repeat(rng.normal(size=(1, 1, 3)), 3, axis=1)) for _ in range(2))
        poses = [posed(rng, 1.0)[0] for _ in range(2)]
        places = [
            wide(pose[:3, :3]) @ wide(part.corners[0, 0]) + wide(pose[:3, 3])
            for pose, part in zip(poses, (one, other), strict=True)
        ]
        reach = nextafter(float(length(places[1] - places[0])), inf)
        found = near_pairs(one, other, poses[0], poses[1], reach)
        assert found is not None
        assert len(found[0]) == 1


def test_slabs_spend_no_more_than_their_gap_to_the_last_bit():
    rng = np.random.default_rng(5)
    square = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    for _ in range(CASES):
        gap, speed, acceleration = map(float, 10.0 ** rng.uniform(-3, 3, 3))
        moving = Twist(ZERO, (0.0, 0.0, speed), ZERO)
        near = NearTriangles(square, square + np.array([0.0, 0.0, gap]), np.zeros(1))
        ahead = RelativeRates(speed, acceleration, 1e3, (0.0, 0.0, acceleration), CONSTANT)
        slabs = TriangleSlabs(near, (moving, STILL), (0.0, 0.0, 1.0), 0.0, inf, ahead, 0.0)

        def left(s, gap=gap, speed=speed, acceleration=acceleration) -> Fraction:
            return Fraction(gap) - Fraction(speed) * s - Fraction(acceleration) * s**2 / 2

        spare = gap * float(rng.choice([0.0, 0.5, 0.99]))
        s = slabs.sleep(spare)
        assert Fraction(spare) < left(Fraction(s)) < Fraction(spare) + Fraction(gap) / 10**11
        assert 0 < left(Fraction(s)) - Fraction(slabs.clearance(s, 0.0)) < Fraction(gap) / 10**11


def segment_distance(p, d, q, e) -> float:
    """Return the distance of two segments in extended precision."""
    p, d, q, e = map(wide, (p, d, q, e))

    def from_segment(x, a, u):
        return length(x - a - np.clip((x - a) @ u / (u @ u), 0, 1) * u)

    found = [from_segment(p, q, e), from_segment(p + d, q, e), from_segment(q, p, d), from_segment(q + e, p, d)]
    n, r = np.cross(d, e), q - p
    if all(0 <= np.cross(r, other) @ n / (n @ n) <= 1 for other in (d, e)):
        found.append(abs(r @ n) / length(n))
    return float(min(found))


def depth_of(edge, face) -> float:
    """Return how far (m) an edge (2, 3) and a face (3, 3) may get relative to each other and meet."""
    near = NearTriangles(edge[[0, 1, 1]][None], face[None], np.zeros(1))
    return TriangleOverlap(near, (STILL, STILL), 0.0, RelativeRates(0.0, 0.0, 1.0, ZERO, CONSTANT), 0.0).depth


def test_an_edge_nearly_along_a_border_is_no_farther_from_it_than_it_is():
    """Conditioned by the angle between them, the nearest points once made 3e-10 m of 2e-13 m."""
    rng = np.random.default_rng(6)
    face = np.array([[0.0, 0, 0], [1, 0, 0], [0.3, 1, 0]])
    pierced = 0
    for _ in range(3 * CASES):
        gap, angle = 10.0 ** rng.uniform(-13, -6), 10.0 ** rng.uniform(-6, -1)
        along = np.array([1.0, 0.3 * angle * rng.normal(), angle])
        through = np.array([rng.uniform(0.2, 0.8), gap, 0.0])
        begin, end = through - rng.uniform(0.1, 1) * along, through + rng.uniform(0.1, 1) * along
        turn = Rotation.random(rng=rng).as_matrix()
        begin, end, *corners = np.vstack((begin, end, face)) @ turn.T
        margin = depth_of(np.array([begin, end]), np.array(corners))
        border = min(
            segment_distance(begin, end - begin, corner, after - corner)
            for corner, after in zip(corners, np.roll(corners, -1, axis=0), strict=True)
        )
        assert margin <= border + 100.0 * DISTANCE_ERROR
        pierced += margin > 0.0
    assert pierced > CASES // 2


def test_the_depth_of_an_edge_is_its_distance_to_the_nearest_border():
    """Of an edge straight through a face, to what is allowed for the planes around both."""
    rng = np.random.default_rng(7)
    for _ in range(CASES):
        x = float(rng.uniform(0.05, 0.2))
        turn = Rotation.random(rng=rng).as_matrix()
        edge = np.array([[x, 0.4, -1.0], [x, 0.4, 1.0]]) @ turn.T
        face = np.array([[0.0, 0, 0], [0, 1, 0], [1, 0, 0]]) @ turn.T
        truth = segment_distance(edge[0], edge[1] - edge[0], face[0], face[1] - face[0])
        assert depth_of(edge, face) == pytest.approx(truth, abs=100.0 * DISTANCE_ERROR)


@pytest.mark.parametrize("size", [1e-12, 1e-6, 1.0, 1e6])
def test_a_point_beside_a_face_is_inside_or_outside_as_soon_as_it_is_off_by_the_error(size):
    rng = np.random.default_rng(8)
    error = DISTANCE_ERROR * size
    for _ in range(CASES):
        corners = rng.normal(size=(4, 3)) * size
        faces = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
        normals = np.cross(*(corners[faces[:, i]] - corners[faces[:, 0]] for i in (1, 2)))
        heights = np.einsum("fc,fc->f", normals, corners[faces[:, 0]] - corners[:4]) / np.linalg.norm(normals, axis=1)
        if np.abs(heights).min() < 0.1 * size:
            continue
        face = int(rng.integers(4))
        outward = normals[face] / np.linalg.norm(normals[face]) * np.sign(heights[face])
        beside = rng.dirichlet(np.full(3, 5.0)) @ corners[faces[face]]
        interior = Interior(Mesh("t", corners, faces, True))
        assert interior.contains((beside + error * outward)[None]) is None
        assert interior.contains((beside - error * outward)[None]) is not None


def test_a_least_distance_is_found_to_eight_errors_where_those_are_large():
    """A gap of 1 cm, 1e10 m away, is known to 7e-5 m."""
    far = 1e10
    bodies = tuple(
        Body(name, None, np.block([[np.eye(3), np.array([[far], [y], [0.0]])], [np.zeros((1, 3)), 1.0]]), motion, shape)
        for name, y, motion, shape in (
            ("a", 0.0, Constant((1e-3, 0.0, 0.0), ZERO), (round_shape(1.0),)),
            ("b", 2.01, Fixed(), (round_shape(1.0),)),
        )
    )
    scene = Scene(bodies, 0.0, 4.0, PairRules())
    (pair,) = pairs_that_might_collide(scene, NarrowPhase(bodies), 0.0)
    events = events_of(*bodies)
    (span,) = [event for event in events if isinstance(event, Span)]
    upper = min(event.distance for event in events if isinstance(event, Distance))
    assert span.verdict is Verdict.CLEAR
    assert ERRORS * pair.error > 10 * LEAST_TOLERANCE
    assert upper - span.clearance <= ERRORS * pair.error
    assert span.clearance <= 0.01 <= upper + pair.error
    assert EPSILON * far < pair.error < 1e3 * EPSILON * far


def pair_far_away(rng) -> tuple[Pair, float]:
    """Return a triangle in two frames and a point just above it, all 5e6 m away, and their true distance (m)."""
    (outer, exact_outer), (inner, exact_inner) = posed(rng, 5e6), posed(rng, 1e3)
    exact = exact_outer @ exact_inner
    corners = rng.normal(size=(3, 3))
    placed = wide(corners) @ exact[:3, :3].T + exact[:3, 3]
    normal = np.cross(placed[1] - placed[0], placed[2] - placed[0])
    normal /= length(normal)
    here = EYE.copy()
    here[:3, 3] = (rng.dirichlet(np.full(3, 5.0)) @ placed + normal * 10.0 ** rng.uniform(-6, -3)).astype(float)
    mesh = Mesh("t", corners, np.array([[0, 1, 2]]), False)
    bodies = (
        Body("frame", None, outer, Fixed(), ()),
        Body("triangle", 0, inner, Fixed(), (Shape(mesh, 0.0, EYE),)),
        Body("point", None, here, Constant((1e-9, 0.0, 0.0), ZERO), (Shape(POINT_MESH, 0.0, EYE),)),
    )
    (pair,) = pairs_that_might_collide(Scene(bodies, 0.0, 1.0, PairRules()), NarrowPhase(bodies), 0.0)
    return pair, float(abs((wide(here[:3, 3]) - placed[0]) @ normal))


def test_what_is_certified_of_a_distance_far_away_is_never_above_it():
    rng = np.random.default_rng(9)
    shares = []
    for _ in range(CASES):
        pair, truth = pair_far_away(rng)
        measurement = pair.measure(0.0)
        slabs = pair.slabs(measurement, 1e-9, 1.0)
        assert measurement.proximity is not None
        assert slabs is not None
        assert 1e-9 < pair.error < 2e-7
        assert measurement.clearance <= truth <= measurement.above
        assert truth - 3.0 * pair.error < slabs.clearance(0.0, 0.0) <= truth
        shares.append(abs(measurement.proximity.distance - truth) / pair.error)
    assert 0.01 < max(shares) < 1.0
