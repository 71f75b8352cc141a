"""Lemmas of pairs that other tests see only from afar: how long contacts last, what is inside, what is within reach."""

from collections.abc import Generator
from math import inf
from typing import Any

import numpy as np
import pytest
from small_scenes import box, events_of, round_shape

from closecall.formats.scene.build.primitive_meshes import segment_mesh
from closecall.scheduler.model.events import Span, Verdict
from closecall.scheduler.model.scene import Body, PairRules, Scene, Shape
from closecall.scheduler.motions import Constant, Fixed, Keyframes, Looped, Motion, Translation
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.contact import ContactSleep
from closecall.scheduler.pairs.least_distance import LeastDistance
from closecall.scheduler.pairs.pair import Pair
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide
from closecall.scheduler.pairs.separation import Tuning
from closecall.scheduler.pairs.span_record import Stretch

O = (0.0, 0.0, 0.0)  # noqa: E741
CASES = 20


def placed(x, y, z) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = (x, y, z)
    return pose


def body(name: str, shape: Shape, place=O, motion: Motion | None = None) -> Body:
    return Body(name, None, placed(*place), motion or Fixed(), (shape,))


def pair_of(*bodies: Body, end=10.0) -> Pair:
    (pair,) = pairs_that_might_collide(Scene(bodies, 0.0, end, PairRules()), NarrowPhase(bodies), 0.0)
    return pair


def lying(radius, turn) -> Shape:
    """Return a capsule of 2 m along the axis that `turn` (3, 3) takes z to."""
    pose = np.eye(4)
    pose[:3, :3] = turn
    return Shape(segment_mesh(2.0), radius, pose)


ALONG_X = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
ALONG_Y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def test_capsules_that_cross_at_their_ends_touch_until_they_have_gone_their_depth():
    """One lies across the other, far from both middles, and is lifted: depth over speed, and no longer."""
    rng = np.random.default_rng(1)
    for _ in range(CASES):
        radii, height = rng.uniform(0.1, 0.3, 2), float(rng.uniform(0.3, 0.95))
        speed = float(10.0 ** rng.uniform(-1.0, 1.0))
        height *= float(radii.sum())
        upper = body("upper", lying(radii[1], ALONG_Y), (0.9, 0.9, height), Constant((0.0, 0.0, speed), O))
        pair = pair_of(body("lower", lying(radii[0], ALONG_X)), upper)
        truth = (float(radii.sum()) - height) / speed
        sleep, _ = ContactSleep(pair, 1e-9).sleep(pair.measure(0.0), 10.0)
        assert 0.99 * truth <= sleep <= truth * (1.0 + 1e-9)


def test_a_corner_inside_a_box_is_as_deep_as_the_nearest_face():
    """A small box stands out of a large one by a side; lifted out by its depth, it touches no longer."""
    rng = np.random.default_rng(2)
    for _ in range(CASES):
        depth, aside = float(rng.uniform(0.01, 0.19)), rng.uniform(-0.5, 0.5, 2)
        small = body("small", box(0.2, 0.2, 0.2), (1.1 - depth, *aside), Constant((1.0, 0.0, 0.0), O))
        pair = pair_of(body("large", box(2.0, 2.0, 2.0)), small)
        found = pair.depth(pair.measure(0.0))
        assert 0.99 * depth <= found <= depth
        assert pair.measure(found * (1.0 - 1e-9)).touching
        assert not pair.measure(depth * (1.0 + 1e-9)).touching


@pytest.mark.parametrize("speed", [20.0, 50.0, 100.0])
def test_what_is_shot_into_a_solid_between_two_steps_is_in_contact(speed):
    """A grain crosses the face of a box in less than any step: its surface touches at no wakeup, the solid does."""
    radius = 1e-9
    grain = body("grain", round_shape(radius), (-2.0, 0.1, 0.2), Constant((speed, 0.0, 0.0), O))
    spans = [one for one in events_of(body("box", box(2.0, 2.0, 2.0)), grain, end=0.5) if isinstance(one, Span)]
    enters, leaves = 1.0 / speed, 3.0 / speed
    for start, end in ((0.0, enters), (leaves, 0.5)):
        within = [one for one in spans if one.start < end - 1e-5 and one.end > start + 1e-5]
        assert {one.verdict for one in within} == {Verdict.CLEAR}
    inside = [one for one in spans if one.start < leaves - 1e-5 and one.end > enters + 1e-5]
    assert {one.verdict for one in inside} == {Verdict.CONTACT}


def test_what_triangles_are_left_out_of_slabs_is_farther_away_than_the_bodies_get():
    rng = np.random.default_rng(3)
    for _ in range(CASES):
        velocity, spin = rng.normal(size=3), rng.normal(size=3) * 3.0
        moves = Constant(tuple(velocity.tolist()), tuple(spin.tolist()))
        pair = pair_of(body("still", box(1.0, 1.0, 1.0)), body("moves", box(1.0, 0.5, 0.2), (1.5, 0.2, 0.1), moves))
        measurement = pair.measure_exactly(0.0)
        duration, beyond = float(rng.uniform(0.01, 0.5)), float(rng.uniform(0.0, 0.2))
        slabs = pair.slabs(measurement, duration, beyond)
        assert slabs is not None
        corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.25, 0.25) for z in (-0.1, 0.1)])
        poses = [moves.pose(s) for s in np.linspace(0.0, duration, 50).tolist()]
        places = np.array([corners @ pose[:3, :3].T + pose[:3, 3] for pose in poses])
        truth = float(np.linalg.norm(places - places[0], axis=2).max())
        assert truth + beyond <= slabs.reach <= 3.0 * truth + beyond


def test_what_is_certified_of_a_distance_is_less_by_the_error():
    """Of what is measured by bounding spheres, and by triangles; far from the origin the error is seen."""
    far = 1e7
    one, other = box(1.0, 1.0, 1.0), box(1.0, 1.0, 1.0)
    moves = Constant((1.0, 0.0, 0.0), O)
    pair = pair_of(body("one", one, (far, 0.0, 0.0)), body("other", other, (far + 4.0, 0.0, 0.0), moves))
    assert 1e-9 < pair.error < 1e-5
    spheres, exact = pair.measure_beyond(0.0, 0.0), pair.measure_beyond(0.0, inf)
    assert spheres.proximity is None
    assert spheres.clearance <= 4.0 - 3.0**0.5 - 0.9 * pair.error
    assert 3.0 - 3.0 * pair.error <= exact.clearance <= 3.0 - 0.9 * pair.error
    assert 3.0 <= exact.above <= 3.0 + 3.0 * pair.error


def drained(generator: Generator[Any, None, Any]) -> tuple[list[Any], Any]:
    """Return what a generator yields, and what it returns."""
    yielded = []
    while True:
        try:
            yielded.append(next(generator))
        except StopIteration as end:
            return yielded, end.value


def test_the_least_distance_is_sought_beyond_a_jump():
    """A box goes from 0.1 m away to 7.5 m and jumps back, each second; one stretch is known from far off on."""
    turns = np.tile((1.0, 0.0, 0.0, 0.0), (3, 1))
    places = np.array([(1.1, 0.0, 0.0), (8.0, 0.0, 0.0), (8.5, 0.0, 0.0)])
    keys = Keyframes(np.array([0.0, 0.1, 1.0]), places, turns, Translation.LINEAR, False)
    loops = body("loops", box(1.0, 1.0, 1.0), O, Looped(keys, False, True))
    pair = pair_of(body("still", box(1.0, 1.0, 1.0)), loops, end=3.5)
    stretches = [Stretch(0.5, 3.5, Verdict.CLEAR, 0.01, 0.0, inf)]
    search = LeastDistance(pair, stretches, 0.01, 1e-3, Tuning())
    measured, raised = drained(search.narrowed())
    assert measured
    assert 0.1 <= search.upper <= 0.1 + 1e-9
    assert 0.098 <= min(stretch.clearance for stretch in raised) <= 0.1
