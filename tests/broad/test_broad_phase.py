"""Swept boxes against brute force, and a crowd against all of its pairs: what windows clear must be clear."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import inf, nextafter

import numpy as np
import pytest
from small_scenes import box, round_shape

from closecall.scheduler.broad.active_pairs import ActivePairs
from closecall.scheduler.broad.box_grid import BoxGrid
from closecall.scheduler.broad.broad_phase import BroadPhase
from closecall.scheduler.broad.windows import Sweeps, ToldWindows, Windows
from closecall.scheduler.model.events import (
    Bound,
    Collision,
    Event,
    Nearness,
    Reason,
    Span,
    Verdict,
    Wakeup,
    Window,
)
from closecall.scheduler.model.extent import body_extent
from closecall.scheduler.model.pair_count import count_pairs
from closecall.scheduler.model.scene import (
    ALWAYS,
    Body,
    PairRules,
    PairSet,
    Scene,
    Settings,
    all_pairs,
    bodies_of_pair,
    pair_id,
)
from closecall.scheduler.model.share import shares_of
from closecall.scheduler.model.world_poses import WorldPoses
from closecall.scheduler.motions import (
    Ballistic,
    Constant,
    Fixed,
    Harmonic,
    Keyframes,
    Limits,
    Motion,
    Swing,
    Translation,
)
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.monitor import Plan
from closecall.scheduler.pairs.pair_factory import PairFactory, ignored_pairs
from closecall.scheduler.run import run
from closecall.scheduler.snapshots.nearest_pairs import CrowdObserver
from closecall.scheduler.snapshots.snapshot import Observer, existing

END = 3.0
SETTINGS = Settings(margin=0.02)
SEEDS = range(2)


def at(place) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = place
    return pose


def random_motion(rng) -> Motion:
    velocity, turning = (tuple(vector) for vector in rng.normal(0.0, 1.0, (2, 3)).tolist())
    kind = rng.integers(7)
    if kind == 0:
        return Fixed()
    if kind == 1:
        return Constant(velocity, turning)
    if kind == 2:
        return Ballistic(velocity, (0.0, 0.0, -1.0), turning)
    if kind == 3:
        return Harmonic((1.0, 0.0, 0.0), 1.5, 2.0, 0.0)
    if kind == 4:
        return Swing((0.0, 0.0, 1.0), (0.5, 0.0, 0.0), 2.0, 1.5, 0.0)
    if kind == 5:
        return Limits(0.5, 0.1, 0.2, inf)
    times = np.array([0.0, 0.7, 1.9, END])
    return steps(times, rng.normal(0.0, 2.0, (4, 3)))


def steps(times: np.ndarray, places: np.ndarray) -> Keyframes:
    """Return jumps from place to place."""
    return Keyframes(times, places, np.tile((1.0, 0.0, 0.0, 0.0), (len(times), 1)), Translation.STEP, False)


def random_scene(seed: int, bodies: int = 30) -> Scene:
    rng = np.random.default_rng(seed)
    made = []
    for index in range(bodies):
        parent = int(rng.integers(index)) if index and rng.random() < 0.2 else None
        place = at(rng.uniform(-5.0, 5.0, 3) if parent is None else rng.uniform(-2.0, 2.0, 3))
        shape = round_shape(rng.uniform(0.2, 0.6)) if rng.random() < 0.4 else box(*rng.uniform(0.1, 1.5, 3))
        exists = tuple(sorted(rng.uniform(-1.0, 1.3 * END, 2).tolist())) if rng.random() < 0.3 else ALWAYS
        shapes = () if rng.random() < 0.05 else (shape,)
        made.append(Body(f"b{index}", parent, place, random_motion(rng), shapes, exists))
    some, others = (frozenset(rng.choice(bodies, 8, replace=False).tolist()) for _ in range(2))
    rules = PairRules(
        ignored=(PairSet(some, others),),
        checked=(PairSet(frozenset({1, 2, 3}), some),),
        default=bool(rng.random() < 0.8),
        margins=((PairSet(some, frozenset(range(bodies))), 0.3),),
    )
    return Scene(tuple(made), 0.0, END, rules)


def crowd_of(scene: Scene) -> ActivePairs:
    factory = PairFactory(scene, NarrowPhase(scene.bodies), SETTINGS.margin)
    return ActivePairs(factory, SETTINGS, BroadPhase(scene, Sweeps(factory)))


def crowd_events(scene: Scene) -> list[Event]:
    return list(run((), SETTINGS, crowd_of(scene)))


def all_events(scene: Scene) -> list[Event]:
    return list(run(PairFactory(scene, NarrowPhase(scene.bodies), SETTINGS.margin).all(), SETTINGS))


def test_a_grid_finds_what_brute_force_finds_while_boxes_come_and_change() -> None:
    rng = np.random.default_rng(1)
    grid, count = BoxGrid(300), 300
    low, high = np.full((count, 3), np.nan), np.full((count, 3), np.nan)
    for _ in range(60):
        boxes = np.sort(rng.choice(count, int(rng.choice([1, 5, 100])), replace=False))
        sides = rng.choice([1e-3, 0.3, 1.0, 1.0, 5.0, 1e3, 1e9], len(boxes))[:, None] * rng.uniform(0.1, 1, (1, 3))
        places = rng.uniform(-10.0, 10.0, (len(boxes), 3)) * rng.choice([1.0, 1.0, 1e8])
        low[boxes], high[boxes] = places, places + sides
        grid.put(boxes, low[boxes], high[boxes])
        one, other = grid.meeting(boxes)
        found = sorted(map(tuple, np.sort(np.column_stack((one, other)), axis=1).tolist()))
        meets = ((low[:, None] <= high[None]) & (low[None] <= high[:, None])).all(axis=2)
        asked = set(boxes.tolist())
        true = [(a, b) for a, b in np.argwhere(meets).tolist() if a < b and (a in asked or b in asked)]
        assert found == true


@pytest.mark.parametrize("seed", SEEDS)
def test_pairs_are_counted_as_if_they_were_named(seed: int) -> None:
    scene = random_scene(seed)
    pairs = list(PairFactory(scene, NarrowPhase(scene.bodies), 0.0).all())
    free = PairFactory(replace(scene, rules=PairRules()), NarrowPhase(scene.bodies), 0.0).all()
    ignored = [(pair.key.a, pair.key.b) for pair in free if not scene.rules.allow(pair.key.a, pair.key.b)]
    assert list(ignored_pairs(scene)) == ignored
    assert count_pairs(scene) == (len(pairs), len(ignored))


def test_a_pair_is_found_by_its_rank() -> None:
    for bodies in (2, 3, 7, 200):
        assert [bodies_of_pair(pair_id(a, b, bodies), bodies) for a, b in all_pairs(bodies)] == list(all_pairs(bodies))
    assert bodies_of_pair(pair_id(99_998, 99_999, 100_000), 100_000) == (99_998, 99_999)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_crowd_has_the_contacts_and_spans_of_all_its_pairs(seed: int) -> None:
    scene = random_scene(seed)
    few, every = crowd_events(scene), all_events(scene)

    def contacts(events):
        return sorted((e.pair.id, e.phase.value, e.time) for e in events if isinstance(e, Collision))

    assert [told[:2] for told in contacts(few)] == [told[:2] for told in contacts(every)]
    for (*_, one), (*_, other) in zip(contacts(few), contacts(every), strict=True):
        assert one == pytest.approx(other, abs=2.0 * SETTINGS.contact_tolerance)
    examined = {event.pair.id for event in few if isinstance(event, Wakeup)}
    worse = {event.pair.id for event in every if isinstance(event, Span) and event.verdict is not Verdict.CLEAR}
    assert worse <= examined
    assert len(examined) < len({event.pair.id for event in every if isinstance(event, Wakeup)})


@pytest.mark.parametrize("seed", SEEDS)
def test_what_windows_clear_of_a_pair_is_below_its_distance(seed: int) -> None:
    """Spans of an examined pair tile its time; where windows alone cleared it, the clearance holds too."""
    scene = random_scene(seed)
    factory = PairFactory(scene, NarrowPhase(scene.bodies), SETTINGS.margin)
    events = crowd_events(scene)
    spans: dict[int, list[Span]] = {}
    for event in events:
        if isinstance(event, Span):
            spans.setdefault(event.pair.id, []).append(event)
    assert spans
    assert any(event.reason is Reason.WINDOW for event in events if isinstance(event, Wakeup))
    for number, told in spans.items():
        pair = factory.pair(*bodies_of_pair(number, len(scene.bodies)))
        assert pair is not None
        told.sort(key=lambda span: span.start)
        assert (told[0].start, told[-1].end) == (pair.start, pair.end)
        assert all(one.end == other.start for one, other in pairwise(told))
        for span in told:
            for time in np.linspace(span.start, span.end, 23)[1:-1]:
                if span.verdict is Verdict.CLEAR:
                    assert pair.measure_exactly(time).above >= span.clearance > pair.margin


@pytest.mark.parametrize("seed", SEEDS)
def test_the_windows_of_a_body_follow_one_another_and_hold_it(seed: int) -> None:
    scene = random_scene(seed)
    windows: dict[int, list[Window]] = {}
    for window in crowd_events(scene):
        if isinstance(window, Window):
            windows.setdefault(window.body, []).append(window)
    poses = WorldPoses(scene.bodies)
    for index, body in enumerate(scene.bodies):
        begin, end = scene.shared_time(index, index)
        told = windows.get(index, [])
        assert bool(told) == (bool(body.shapes) and begin < end)
        if not told:
            continue
        assert (told[0].start, told[-1].end) == (begin, end)
        assert all(b.start in (a.end, nextafter(a.end, inf)) for a, b in pairwise(told))
        extent = body_extent(body)
        for window in told:
            for time in np.linspace(window.start, window.end, 7).tolist():
                pose = poses.at(min(time, window.end))[index]
                points = extent.points @ pose[:3, :3].T + pose[:3, 3]
                assert (points - extent.radii[:, None] >= np.array(window.low)).all()
                assert (points + extent.radii[:, None] <= np.array(window.high)).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_windows_are_the_same_whoever_makes_them(seed: int) -> None:
    """Whether as they are asked for, or before by others, each some bodies."""
    scene = random_scene(seed)
    factory = PairFactory(scene, NarrowPhase(scene.bodies), SETTINGS.margin)
    shares = [Sweeps(factory, share).all() for share in reversed(shares_of(3))]
    ticks, told = (list(BroadPhase(scene, source)) for source in (Sweeps(factory), ToldWindows(Windows.joined(shares))))
    assert len(ticks) == len(told) > 10
    for one, other in zip(ticks, told, strict=True):
        assert one.time == other.time
        assert np.array_equal(one.meeting, other.meeting)
        assert all(map(np.array_equal, one.windows, other.windows))


def test_a_pair_that_parts_leaves_the_queue_and_comes_back() -> None:
    """A ball swings past a small one, over and over: far away it is not in the queue, and every touch is found."""
    swinging = Body("a", None, at((10.0, 0.0, 0.0)), Harmonic((1.0, 0.0, 0.0), 10.0, 2.0, 0.0), (round_shape(0.5),))
    still = Body("b", None, at((0.5, 0.0, 0.0)), Fixed(), (round_shape(0.5),))
    scene = Scene((swinging, still), 0.0, 6.0, PairRules())
    events = crowd_events(scene)
    begins = [event.time for event in events if isinstance(event, Collision) and event.phase.name == "BEGIN"]
    # 10 + 10 sin(pi t) <= 1.5
    first = 1.0 + np.arcsin(0.85) / np.pi
    assert begins == pytest.approx([first, first + 2.0, first + 4.0], abs=1e-6)
    assert sum(event.reason is Reason.WINDOW for event in events if isinstance(event, Wakeup)) >= 1


def test_windows_of_now_do_not_clear_what_was_before_them() -> None:
    """A pair whose last step is to be tried finer is decided up to an earlier time, when its boxes met."""
    moving = Body("a", None, np.eye(4), Constant((4.0, 0.0, 0.0), (0.0, 0.0, 0.0)), (box(1, 1, 1),))
    still = Body("b", None, at((0.0, 1.1, 0.0)), Fixed(), (box(1, 1, 1),))
    scene = Scene((moving, still), 0.0, 4.0, PairRules())
    crowd = crowd_of(scene)
    entered = []
    while crowd.next_tick < 2.0:
        meeting = crowd.meet()
        try:
            while True:
                next(meeting)
        except StopIteration as ended:
            entered += ended.value
    ((_, _, watch),) = entered
    plan = Plan(2.0, Reason.TIME_BOUND, Bound.SPEED_ACCELERATION)
    list(watch.learn(watch.pair.measure(0.0)))
    assert crowd.retire(watch, plan) is None
    list(watch.learn(watch.pair.measure(crowd.next_tick)))
    retired = crowd.retire(watch, plan._replace(time=crowd.next_tick))
    assert retired is not None
    assert retired.bound is Bound.WINDOWS


def test_jumping_bodies_meet_at_the_jump_alone() -> None:
    """The one jumps onto the other for a while; nothing on the way between counts."""
    times, places = np.array([0.0, 1.0, 2.0, 4.0]), np.array([[0.0, 0, 0], [50, 0, 0], [0, 0, 0], [0, 0, 0]])
    jumping = Body("a", None, np.eye(4), steps(times, places), (box(1, 1, 1),))
    target = Body("b", None, at((50.4, 0.0, 0.0)), Fixed(), (box(1, 1, 1),))
    between = Body("c", None, at((25.0, 0.0, 0.0)), Fixed(), (box(1, 1, 1),))
    scene = Scene((jumping, target, between), 0.0, 4.0, PairRules())
    events = crowd_events(scene)
    told = [(e.pair.a, e.pair.b, e.time_touching) for e in events if isinstance(e, Collision)]
    assert told == [(0, 1, 1.0), (0, 1, nextafter(2.0, 0.0))]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_crowds_nearest_pairs_are_those_of_all_its_pairs(seed: int) -> None:
    scene = random_scene(seed)
    narrow_phase = NarrowPhase(scene.bodies)
    factory = PairFactory(scene, narrow_phase, SETTINGS.margin)
    crowd, every = CrowdObserver(factory, 5), Observer(scene, list(factory.all()), 5, narrow_phase)
    for time in np.linspace(0.0, END, 7).tolist():
        one, other = crowd.at(time, frozenset()), every.at(time, frozenset())
        assert np.array_equal(one.poses, other.poses)
        assert np.array_equal(one.there, existing(scene, time))
        assert [rounded(near) for near in one.nearest] == [rounded(near) for near in other.nearest]


@pytest.mark.parametrize("alone", [False, True])
def test_a_picture_looks_at_no_more_pairs_for_bodies_that_ignore_each_other(alone: bool) -> None:
    chips = range(3, 3 + 60)  # a heap of them, all within reach of each other
    rng = np.random.default_rng(1)
    places = [(0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (6.0, 0.0, 0.0), *rng.uniform(-1.0, 1.0, (60, 3))]
    motion = Constant((0.1, 0.0, 0.0), (0.0, 0.0, 0.0))
    bodies = tuple(Body(str(i), None, at(place), motion, (box(0.1, 0.1, 0.1),)) for i, place in enumerate(places))
    tools, heap = frozenset({0, 1, 2}), frozenset(chips)
    checked = (PairSet(tools, tools),) if alone else (PairSet(tools, tools), PairSet(frozenset({0}), heap))
    scene = Scene(bodies, 0.0, END, PairRules(checked=checked, default=False))
    narrow_phase = NarrowPhase(bodies)
    factory = PairFactory(scene, narrow_phase, 0.0)
    asked: list[tuple[int, int]] = []
    factory.pair = lambda a, b: asked.append((a, b)) or PairFactory.pair(factory, a, b)  # type: ignore[method-assign]
    crowd, every = CrowdObserver(factory, 10), Observer(scene, list(PairFactory.all(factory)), 10, narrow_phase)
    asked.clear()
    one, other = crowd.at(1.0, frozenset()), every.at(1.0, frozenset())
    assert [rounded(near) for near in one.nearest] == [rounded(near) for near in other.nearest]
    assert all(scene.rules.allow(a, b) for a, b in asked)
    assert len(asked) <= (3 if alone else 63)


def test_bodies_are_placed_together_where_each_motion_places_its_own() -> None:
    scene = random_scene(5)
    flight = Ballistic((1.0, -2.0, 0.5), (0.0, 0.0, -9.81), (0.0, 0.0, 0.0))
    flying = (replace(body, motion=flight) if index % 3 else body for index, body in enumerate(scene.bodies))
    scene = replace(scene, bodies=tuple(flying))
    for time in np.linspace(-1.0, END, 5).tolist():
        placed = WorldPoses(scene.bodies).at(time)
        for index, body in enumerate(scene.bodies):
            above = np.eye(4) if body.parent is None else placed[body.parent]
            assert np.allclose(placed[index], above @ body.pose @ body.motion.pose(time), rtol=0.0, atol=1e-14)


def rounded(near: Nearness) -> tuple[int, float, Verdict]:
    return near.pair.id, round(near.distance, 9), near.verdict
