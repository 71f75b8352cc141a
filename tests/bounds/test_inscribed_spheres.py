"""Balls inside solids: how large they are, in closed form, and how long they go on meeting, by dense samples."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from drawn_motions import RandomCourse
from scipy.spatial.transform import Rotation
from small_scenes import box, events_of, round_shape

from closecall.formats.scene.build.primitive_meshes import segment_mesh
from closecall.scheduler.bounds.inscribed_spheres import MOST_LEGS, InscribedSpheres
from closecall.scheduler.kinematics.chain import Chain, Joint
from closecall.scheduler.kinematics.relative_motion import RelativeMotion
from closecall.scheduler.model.events import Bound, Collision, Reason, Wakeup
from closecall.scheduler.model.extent import Ball, Extent, body_extent
from closecall.scheduler.model.scene import Body, Mesh, PairRules, Scene, Shape
from closecall.scheduler.motions import Constant, Fixed, Keyframes, Translation
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide

O = (0.0, 0.0, 0.0)  # noqa: E741
PATHS = 100
SAMPLES = 60
ROUNDING = 1e-9

TILTED = np.eye(4)
TILTED[:3, :3] = Rotation.from_euler("xyz", [0.4, 0.9, -1.3]).as_matrix()
TILTED[:3, 3] = (0.3, 0.1, -0.2)


def mesh(corners, triangles, solid=True) -> Mesh:
    return Mesh("mesh", np.array(corners, dtype=float), np.array(triangles), solid)


TETRAHEDRON = mesh([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], [(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)])
CUBE = box(1.0, 1.0, 1.0).mesh
SHELL = mesh(
    np.concatenate((CUBE.vertices, 0.8 * CUBE.vertices)),
    np.concatenate((CUBE.triangles, CUBE.triangles[:, ::-1] + 8)),
)
HOLLOW = Shape(SHELL, 0.0, np.eye(4))
HALF = np.eye(4)
HALF[:3, 3] = (2.0, 0.0, 0.0)

# Shapes of a body, and the radius about the middle of its bounds.
HELD = {
    "a box": ([box(0.5, 0.7, 0.9)], 0.25),
    "a box, tilted": ([Shape(box(0.5, 0.7, 0.9).mesh, 0.0, TILTED)], 0.25),
    "a rounded box": ([Shape(box(0.5, 0.7, 0.9).mesh, 0.1, TILTED)], 0.35),
    "a tetrahedron": ([Shape(TETRAHEDRON, 0.0, np.eye(4))], 1.0 / sqrt(3.0)),
    "a sphere": ([round_shape(0.3)], 0.3),
    "a capsule": ([Shape(segment_mesh(2.0), 0.2, TILTED)], 0.2),
    "a shell, whose middle is hollow": ([HOLLOW], 0.0),
    "an open box": ([Shape(mesh(CUBE.vertices, CUBE.triangles[2:], False), 0.0, np.eye(4))], 0.0),
    "two boxes apart": ([box(1.0, 1.0, 1.0), Shape(CUBE, 0.0, HALF)], 0.0),
    "a box across a longer one": ([box(3.0, 0.4, 0.4), box(1.0, 1.0, 1.0)], 0.5),
    "a box along a shorter one": ([box(1.0, 1.0, 1.0), box(3.0, 0.4, 0.4)], 0.5),
}


@pytest.mark.parametrize("case", HELD)
def test_the_radius_about_the_middle_is_that_of_closed_forms(case):
    shapes, radius = HELD[case]
    body = Body("body", None, np.eye(4), Fixed(), tuple(shapes))
    middle = body_extent(body).ball.centre
    found = NarrowPhase((body,)).inscribed_radius(0, middle)
    assert found <= radius
    assert found == pytest.approx(radius, abs=1e-12)


class Path(RandomCourse):
    """Two balls on random chains of motions, most of which meet at first, and how long they are said to."""

    def __init__(self, rng) -> None:
        super().__init__(rng)
        self.radii = self.apart(self.state) * float(rng.uniform(0.9, 3.0))
        self.sleep = InscribedSpheres(self.motion, self.radii).sleep(self.state, self.duration)


def test_balls_on_random_motions_meet_as_long_as_is_said():
    rng = np.random.default_rng(1)
    slept = followed = whole = 0
    for _ in range(PATHS):
        path = Path(rng)
        assert 0.0 <= path.sleep <= path.duration
        slept += path.sleep > 0.0
        whole += path.sleep == path.duration
        followed += path.t + path.sleep > path.motion.knot_after(path.t)
        assert path.sleep == 0.0 or max(path.samples(path.sleep, SAMPLES)) <= path.radii + ROUNDING
    assert slept > PATHS // 2
    assert 0 < whole < slept
    assert followed > PATHS // 20


def extent(radius: float) -> Extent:
    return Extent(np.zeros((1, 3)), np.array([radius]), Ball(O, radius))


def test_balls_that_pass_meet_as_long_as_closed_forms_say():
    """One goes by at 2 m/s, 0.3 m aside, from 0.39 m before; together they are 0.5 m wide."""
    still, goes = Chain((), np.eye(4), extent(0.2)), Constant((2.0, 0.0, 0.0), (1.0, 2.0, 3.0))
    place = np.eye(4)
    place[:3, 3] = (-0.39, 0.3, 0.0)
    motion = RelativeMotion(still, Chain((Joint(place, goes),), np.eye(4), extent(0.3)))
    assert InscribedSpheres(motion, 0.5).sleep(motion.at(0.0), 9.0) == pytest.approx(0.395, rel=1e-8)
    assert InscribedSpheres(motion, 0.5).sleep(motion.at(0.0), 9.0) <= 0.395
    assert InscribedSpheres(motion, 0.5).sleep(motion.at(0.0), 0.3) == 0.3
    assert InscribedSpheres(motion, 0.49).sleep(motion.at(0.0), 9.0) == 0.0


def test_so_many_keys_are_followed_at_most():
    """To and fro between 0 and 0.1 m from another, 4 MOST_LEGS times in as many seconds."""
    count = 4 * MOST_LEGS
    places = np.array([(0.1 * (index % 2), 0.0, 0.0) for index in range(count + 1)])
    turns = np.tile((1.0, 0.0, 0.0, 0.0), (count + 1, 1))
    path = Keyframes(np.arange(count + 1.0), places, turns, Translation.LINEAR, step_rotation=False)
    still = Chain((), np.eye(4), extent(0.2))
    motion = RelativeMotion(still, Chain((Joint(np.eye(4), path),), np.eye(4), extent(0.2)))
    balls = InscribedSpheres(motion, 0.2)
    assert balls.sleep(motion.at(0.0), float(count)) == MOST_LEGS
    assert balls.sleep(motion.at(0.0), float(MOST_LEGS - 1)) == MOST_LEGS - 1
    assert balls.sleep(motion.at(0.0), float(count), worth=1.0) >= MOST_LEGS - 1
    assert balls.sleep(motion.at(0.0), float(count), worth=1.5) <= 3.0


def test_a_body_whose_middle_is_hollow_has_none():
    moves = Constant((1.0, 0.0, 0.0), O)
    solid, hollow = (Body("a", None, np.eye(4), m, (s,)) for m, s in ((moves, box(1, 1, 1)), (Fixed(), HOLLOW)))
    for bodies in ((solid, hollow), (hollow, solid)):
        (pair,) = pairs_that_might_collide(Scene(bodies, 0.0, 1.0, PairRules()), NarrowPhase(bodies), 0.0)
        assert pair.inscribed_spheres() is None


def test_a_spinning_box_deep_in_another_sleeps():
    """A cube turns once a second about its middle, 0.2 m from that of another, of 1 m each, and leaves it in time."""
    place = np.eye(4)
    place[:3, 3] = (0.2, 0.0, 0.0)
    spins = Constant((0.1, 0.0, 0.0), (2.0 * pi, 0.0, 0.0))
    bodies = (
        Body("still", None, np.eye(4), Fixed(), (box(1.0, 1.0, 1.0),)),
        Body("spins", None, place, spins, (box(1.0, 1.0, 1.0),)),
    )
    events = events_of(*bodies, end=9.0)
    (_, left) = [event for event in events if isinstance(event, Collision)]
    assert left.time == pytest.approx(8.0, abs=1e-6)
    contact = [e for e in events if isinstance(e, Wakeup) and e.reason in (Reason.START, Reason.CONTACT)]
    assert (contact[0].bound, contact[0].sleep) == (Bound.INSCRIBED_SPHERES, pytest.approx(8.0, abs=1e-6))
    assert len([wakeup for wakeup in contact if wakeup.time < left.time]) <= 4
