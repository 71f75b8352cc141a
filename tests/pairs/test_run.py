"""The loop against closed forms: what it must find, and when."""

from itertools import pairwise
from math import asin, cos, inf, nan, pi, sin, sqrt

import numpy as np
import pytest

from closecall.scheduler.model.events import Collision, ContactKind, Phase, Reason, Span, Verdict, Wakeup
from closecall.scheduler.model.scene import Body, Mesh, PairRules, PairSet, Scene, Settings, Shape, pair_id
from closecall.scheduler.motions import Ballistic, Constant, Fixed, Harmonic, Keyframes, Screw, Swing, Translation
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide
from closecall.scheduler.run import run

O = (0.0, 0.0, 0.0)  # noqa: E741
SETTINGS = Settings()
TOLERANCE = SETTINGS.contact_tolerance

POINT = Mesh("point", np.zeros((1, 3)), np.array([[0, 0, 0]]), False)


def box_mesh(x, y, z) -> Mesh:
    vertices = np.array([[i, j, k] for i in (-x, x) for j in (-y, y) for k in (-z, z)]) / 2.0
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return Mesh("box", vertices, np.array(triangles), True)


def at(x=0.0, y=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, 3] = (x, y, z)
    return pose


HERE = at()


def sphere(radius, place=HERE) -> Shape:
    return Shape(POINT, radius, place)


def box(x, y, z, place=HERE) -> Shape:
    return Shape(box_mesh(x, y, z), 0.0, place)


ALL = PairRules()


def body(name, motion, *shapes, pose=HERE, parent=None) -> Body:
    return Body(name, parent, pose, motion, shapes)


def events_of(*bodies, start=0.0, end=1.0, rules=ALL, settings=SETTINGS):
    scene = Scene(bodies, start, end, rules)
    return list(run(pairs_that_might_collide(scene, NarrowPhase(bodies), settings.margin), settings))


def collisions(events, phase):
    return [e for e in events if isinstance(e, Collision) and e.phase is phase]


def spans(events):
    return [e for e in events if isinstance(e, Span)]


def brackets(collision, time):
    low, high = sorted((collision.time_clear, collision.time_touching))
    return high - low <= TOLERANCE and low - 1e-9 <= time <= high + 1e-9


def test_two_spheres_at_constant_velocity_touch_and_part_when_the_quadratic_says():
    events = events_of(
        body("a", Constant((1.0, 0.0, 0.0), O), sphere(0.5), pose=at(-2)),
        body("b", Constant((-1.0, 0.0, 0.0), O), sphere(0.25), pose=at(2, 0.3)),
        end=5.0,
    )
    half = sqrt(0.75**2 - 0.3**2)
    (begin,), (end,) = collisions(events, Phase.BEGIN), collisions(events, Phase.END)
    assert brackets(begin, (4 - half) / 2)
    assert brackets(end, (4 + half) / 2)
    assert [s.verdict for s in spans(events)] == [Verdict.CLEAR, Verdict.CONTACT, Verdict.CLEAR]


def test_a_ballistic_sphere_lands_on_a_box_when_the_parabola_says():
    events = events_of(
        body("ball", Ballistic((0.3, 0.0, 2.0), (0.0, 0.0, -9.81), (1.0, 2.0, 3.0)), sphere(0.1), pose=at(0, 0, 1)),
        body("floor", Fixed(), box(10, 10, 0.2, at(0, 0, -0.1))),
    )
    # 1 + 2 t - 9.81 t^2 / 2 = 0.1
    (begin,) = collisions(events, Phase.BEGIN)
    assert brackets(begin, (2.0 + sqrt(4.0 + 2 * 9.81 * 0.9)) / 9.81)


def test_a_swinging_bar_strikes_a_ball_at_the_angle_where_its_face_reaches_it():
    amplitude, period = 1.2, 2.0
    events = events_of(
        body("bar", Swing((0.0, 0.0, 1.0), O, amplitude, period, 0.0), box(2.0, 0.1, 0.1, at(1.0, 0, 0))),
        body("ball", Fixed(), sphere(0.2), pose=at(1.5 * cos(0.9), 1.5 * sin(0.9))),
        end=0.5,
    )
    # The ball's centre is 1.5 from the hinge; the bar's face, 0.05 off its axis, is tangent when sin(gap) = 0.25 / 1.5.
    angle = 0.9 - asin(0.25 / 1.5)
    (begin,) = collisions(events, Phase.BEGIN)
    assert brackets(begin, asin(angle / amplitude) * period / (2 * pi))


def test_a_screw_reaches_a_wall_by_its_pitch():
    events = events_of(
        body("screw", Screw((0.0, 0.0, 1.0), O, 3.0, 0.4), box(0.5, 0.3, 0.2)),
        body("wall", Fixed(), box(4, 4, 0.1, at(0, 0, 1.0))),
        end=6.0,
    )
    # The top face at 0.1 advances 0.4 * 3 / 2 pi per second to 0.95.
    (begin,) = collisions(events, Phase.BEGIN)
    assert brackets(begin, 0.85 / (0.4 * 3.0 / (2 * pi)))


def test_spinning_bar_is_not_slept_past_its_tip():
    """The literal formula uses the velocity of the closest points, 0.7 m from the axis, and misses the tip's strike."""
    tip = (9.5 * cos(0.12), 9.5 * sin(0.12))
    posts = [(0.0, 0.7), (0.0, -0.7), tip, (-tip[0], -tip[1])]
    events = events_of(
        body("bar", Constant(O, (0.0, 0.0, 1.0)), box(20, 0.2, 0.2)),
        body("posts", Fixed(), *(box(0.2, 0.2, 0.2, at(x, y)) for x, y in posts)),
        end=0.12,
    )
    (begin,) = collisions(events, Phase.BEGIN)
    # The bar's upper face, -x sin a + y cos a = 0.1, meets the cube's corner (x + 0.1, y - 0.1).
    x, y = tip[0] + 0.1, tip[1] - 0.1
    angle = np.arctan2(y, x) - asin(0.1 / np.hypot(x, y))
    assert angle == pytest.approx(0.09797, abs=5e-6)
    assert brackets(begin, angle)


def test_a_concentric_rotor_and_stator_never_sleep_past_contact():
    """Centres coincide, so the literal radius between centres is 0 and the literal bound infinite."""
    events = events_of(
        body("rotor", Constant(O, (0.0, 0.0, 2.0)), box(1.8, 0.1, 0.1)),
        body("stator", Fixed(), box(0.1, 0.1, 0.1, at(0, 0.9)), box(0.1, 0.1, 0.1, at(0, -0.9))),
        end=1.0,
    )
    (begin,) = collisions(events, Phase.BEGIN)
    low, high = 0.5, pi / 2
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _rotor_hits(middle) else (middle, high)
    assert brackets(begin, low / 2.0)


def _rotor_hits(angle) -> bool:
    """Dense separating-axis test of two rectangles in the plane, independent of the narrow phase."""
    a = np.array([[0.9, 0.05], [0.9, -0.05], [-0.9, -0.05], [-0.9, 0.05]])
    turn = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
    a, b = a @ turn.T, np.array([[0.05, 0.95], [0.05, 0.85], [-0.05, 0.85], [-0.05, 0.95]])
    for axis in (turn[:, 0], turn[:, 1], np.array([1.0, 0]), np.array([0, 1.0])):
        p, q = a @ axis, b @ axis
        if p.max() < q.min() or q.max() < p.min():
            return False
    return True


def test_a_graze_shorter_than_the_time_resolution_is_never_called_clear():
    """A sphere passes another at 100 m/s, overlapping by 1e-6 m for 4.5e-6 s."""
    rng = np.random.default_rng(3)
    for _ in range(50):
        depth, offset = 10 ** rng.uniform(-9, -5), rng.uniform(0.2, 0.8)
        events = events_of(
            body("bullet", Constant((100.0, 0.0, 0.0), O), sphere(0.01), pose=at(-100.0 * offset)),
            body("post", Fixed(), sphere(0.02), pose=at(0, 0.03 - depth)),
        )
        for span in spans(events):
            if span.verdict is Verdict.CLEAR:
                assert not span.start < offset < span.end


def test_an_unresolved_graze_is_no_deeper_than_its_limit():
    settings = Settings(time_resolution=1e-3, contact_tolerance=1e-3)
    depth = 1e-7
    events = events_of(
        body("bullet", Constant((100.0, 0.0, 0.0), O), sphere(0.01), pose=at(-50.0)),
        body("post", Fixed(), sphere(0.02), pose=at(0, 0.03 - depth)),
        settings=settings,
    )
    doubtful = [s for s in spans(events) if s.verdict is not Verdict.CLEAR and s.start <= 0.5 <= s.end]
    assert doubtful
    assert all(s.depth_limit >= depth for s in doubtful if s.verdict is Verdict.UNRESOLVED)


def test_a_ball_inside_a_closed_box_is_in_contact_though_the_surfaces_are_apart():
    events = events_of(
        body("ball", Harmonic((1.0, 0.0, 0.0), 0.2, 1.0, 0.0), sphere(0.5)), body("case", Fixed(), box(10, 10, 10))
    )
    (begin,) = collisions(events, Phase.BEGIN)
    assert begin.kind is ContactKind.CONTAINED
    assert begin.time_clear == begin.time_touching == 0.0
    assert [s.verdict for s in spans(events)] == [Verdict.CONTACT]
    assert len([e for e in events if isinstance(e, Wakeup)]) < 20  # contained, it sleeps by the surfaces' distance


def test_a_contact_leaves_by_the_surface_and_begins_contained():
    events = events_of(
        body("ball", Constant((1.0, 0.0, 0.0), O), sphere(0.1)), body("case", Fixed(), box(1, 1, 1)), end=1.0
    )
    (begin,), (end,) = collisions(events, Phase.BEGIN), collisions(events, Phase.END)
    assert begin.kind is ContactKind.CONTAINED
    assert brackets(end, 0.6)


def test_a_step_into_a_solid_is_seen_at_the_jump():
    keys = Keyframes(
        np.array([0.0, 0.4, 0.8]), np.array([[5.0, 0, 0], [0, 0, 0], [0, 0, 9.0]]), np.tile([1.0, 0, 0, 0], (3, 1)),
        Translation.STEP, False,
    )  # fmt: skip
    events = events_of(body("ball", keys, sphere(0.1)), body("case", Fixed(), box(1, 1, 1)), end=0.8)
    (begin,), (end,) = collisions(events, Phase.BEGIN), collisions(events, Phase.END)
    assert (begin.time_touching, begin.kind) == (0.4, ContactKind.CONTAINED)
    assert end.time_clear == 0.8
    assert Reason.KNOT in {e.reason for e in events if isinstance(e, Wakeup)}


def test_a_body_at_rest_until_a_knot_is_not_slept_past_it():
    keys = Keyframes(
        np.array([0.0, 0.5, 1.0]), np.array([[5.0, 0, 0], [5.0, 0, 0], [-5.0, 0, 0]]), np.tile([1.0, 0, 0, 0], (3, 1)),
        Translation.LINEAR, False,
    )  # fmt: skip
    events = events_of(body("a", keys, box(1, 1, 1)), body("b", Fixed(), box(1, 1, 1)))
    (begin,) = collisions(events, Phase.BEGIN)
    assert brackets(begin, 0.5 + 4.0 / 20.0)


def test_two_boxes_on_one_conveyor_sleep_to_the_end_by_the_lectures_bound():
    moves = [Constant((2.0, 0.0, 0.0), O), Constant((2.0, 0.0, 0.0), O)]
    events = events_of(body("a", moves[0], box(1, 1, 1)), body("b", moves[1], box(1, 1, 1), pose=at(1.1)), end=100.0)
    assert [e.bound.value for e in events if isinstance(e, Wakeup)] == ["speed_acceleration", ""]
    (span,) = spans(events)
    assert (span.verdict, span.clearance) == (Verdict.CLEAR, pytest.approx(0.1, abs=1e-9))


def test_a_parent_and_its_moving_child_are_paired_in_the_parents_frame():
    """The parent's own fast motion cancels: child and parent wake as if the parent stood still."""
    parent = body("parent", Constant((50.0, 0.0, 0.0), (9.0, 0.0, 0.0)), box(1, 1, 1))
    child = body("child", Constant((0.0, -1.0, 0.0), O), box(1, 1, 1), pose=at(0, 3), parent=0)
    events = events_of(parent, child, end=3.0)
    (begin,) = collisions(events, Phase.BEGIN)
    assert brackets(begin, 2.0)
    assert len([e for e in events if isinstance(e, Wakeup) and e.time < 1.99]) < 10
    # the point of contact is told in the world's frame, 100 m on
    assert begin.point[0] == pytest.approx(100.0, abs=0.6)


def test_bodies_that_never_move_relative_to_each_other_are_never_paired():
    bodies = (
        body("table", Fixed(), box(1, 1, 1)),
        body("lamp", Fixed(), box(1, 1, 1), parent=0),
        body("cart", Constant((1.0, 0.0, 0.0), O), box(1, 1, 1), pose=at(9)),
        body("load", Fixed(), box(1, 1, 1), pose=at(0, 0, 1), parent=2),
        body("frame", Fixed()),
    )
    scene = Scene(bodies, 0.0, 1.0, ALL)
    pairs = [(p.key.a, p.key.b) for p in pairs_that_might_collide(scene, NarrowPhase(bodies), 0.0)]
    assert pairs == [(0, 2), (0, 3), (1, 2), (1, 3)]


def test_a_rule_that_checks_overrides_one_that_ignores():
    everyone, one = frozenset(range(3)), frozenset({0})
    rules = PairRules((PairSet(everyone, everyone),), (PairSet(one, frozenset({2})),))
    assert [rules.allow(0, 1), rules.allow(0, 2), rules.allow(2, 0), rules.allow(1, 2)] == [
        False,
        True,
        True,
        False,
    ]


def test_pair_ids_count_the_pairs_in_order():
    assert [pair_id(a, b, 5) for a in range(5) for b in range(a + 1, 5)] == list(range(10))


def test_resting_contact_stands_from_start_to_end():
    events = events_of(
        body("crate", Constant((0.3, 0.0, 0.0), O), box(1, 1, 1, at(0, 0, 0.5))),
        body("floor", Fixed(), box(10, 10, 1, at(0, 0, -0.5))),
        end=0.2,
    )
    assert [s.verdict for s in spans(events)] == [Verdict.CONTACT]
    assert not collisions(events, Phase.END)


def test_spans_of_every_pair_tile_the_time_and_wakeups_go_back_by_no_more_than_the_resolution():
    rng = np.random.default_rng(5)
    bodies = tuple(
        body(f"b{i}", Constant(tuple(rng.normal(size=3)), tuple(rng.normal(size=3))), box(*rng.uniform(0.2, 1, 3)),
             pose=at(*rng.uniform(-2, 2, 3)))
        for i in range(6)
    )  # fmt: skip
    events = events_of(*bodies, end=2.0)
    by_pair = {}
    for span in spans(events):
        by_pair.setdefault(span.pair.id, []).append(span)
    assert len(by_pair) == 15
    for own in by_pair.values():
        assert (own[0].start, own[-1].end) == (0.0, 2.0)
        assert all(a.end == b.start and a.verdict is not b.verdict for a, b in pairwise(own))
    times = [e.time for e in events if isinstance(e, Wakeup) and e.reason is not Reason.MINIMUM]
    assert min(b - a for a, b in pairwise(times)) >= -SETTINGS.time_resolution * (1 + 1e-9)


def test_simultaneous_wakeups_come_in_order_of_pair_id():
    bodies = tuple(body(f"b{i}", Constant((0.0, 0.0, 1.0), O), sphere(0.1), pose=at(i)) for i in range(4))
    events = events_of(*bodies)
    starts = [e.pair.id for e in events if isinstance(e, Wakeup) and e.reason is Reason.START]
    assert starts == sorted(starts) == list(range(6))


def test_unresolved_is_the_only_verdict_with_a_depth_limit_and_contact_has_none():
    events = events_of(
        body("a", Constant((1.0, 0.0, 0.0), O), sphere(0.5), pose=at(-2)), body("b", Fixed(), sphere(0.5)), end=5.0
    )
    for span in spans(events):
        expected = {Verdict.CLEAR: 0.0, Verdict.CONTACT: nan}.get(span.verdict, inf)
        assert span.depth_limit == expected or (np.isnan(expected) and np.isnan(span.depth_limit))
