"""Motions with many keys: far away they take no wakeups, however many there are; and sleeps past them are sound."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

import numpy as np
import pytest
from small_scenes import box, events_of

from closecall.scheduler.bounds.sphere_slabs import MOST_SLABS, SphereSlabs
from closecall.scheduler.kinematics.chain import Chain, Joint
from closecall.scheduler.kinematics.relative_motion import RelativeMotion
from closecall.scheduler.model.events import Span, Verdict, Wakeup
from closecall.scheduler.model.extent import Ball, Extent
from closecall.scheduler.model.scene import Body
from closecall.scheduler.motions import Constant, Fixed, Keyframes, Limits, Looped, Translation

END = 100.0
CORNERS = np.linspace(0.0, END, 11)
PATHS = 40
ROUNDING = 1e-9

Way = Callable[[np.ndarray], np.ndarray]


def at(x: float, y: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = (x, y, z)
    return pose


def past(t: np.ndarray) -> np.ndarray:
    return np.stack((10.0 * t - 500.0, 0.0 * t + 60.0, 0.0 * t), axis=1)


def around(t: np.ndarray) -> np.ndarray:
    return np.stack((100.0 * np.cos(0.06 * t), 100.0 * np.sin(0.06 * t), 0.0 * t), axis=1)


def keyed(way: Way, keys: int, end: float = END, how: Translation = Translation.LINEAR) -> Keyframes:
    """Return the polyline through the same eleven corners, with `keys` more on its straight parts, turning about z."""
    times = np.linspace(0.0, end, keys + 1)
    corners = np.linspace(0.0, end, 11)
    places = np.stack([np.interp(times, corners, axis) for axis in way(corners).T], axis=1)
    half = 0.15 * times
    turns = np.stack((np.cos(half), 0.0 * half, 0.0 * half, np.sin(half)), axis=1)
    return Keyframes(times, places, turns, how, False)


POST = Body("post", None, np.eye(4), Fixed(), (box(1, 1, 1),))


def bodies(name: str, keys: int) -> tuple[Body, ...]:
    car = (box(2, 1, 1),)
    match name:
        case "past":
            return Body("car", None, np.eye(4), keyed(past, keys), car), POST
        case "around":
            return Body("car", None, np.eye(4), keyed(around, keys), car), POST
        case "curved":
            return Body("car", None, np.eye(4), keyed(past, keys, how=Translation.CUBIC), car), POST
        case "looped":
            loop = Looped(keyed(lambda t: 0.1 * around(25.0 * t), keys, 4.0), False, True)
            return Body("car", None, at(60.0, 0.0, 0.0), loop, car), POST
        case "chained":
            train = Body("train", None, np.eye(4), keyed(around, keys), ())
            return train, Body("car", 0, at(1.0, 0.0, 0.0), keyed(lambda t: 0.03 * around(t), keys), car), POST
    assert name == "of unknown path"
    probe = Body("probe", None, np.eye(4), Limits(0.0, 0.0, 0.1, inf), (box(1, 1, 1),))
    return Body("car", None, np.eye(4), keyed(past, keys), car), probe


def wakeups(name: str, keys: int) -> int:
    events = events_of(*bodies(name, keys), end=END)
    assert {event.verdict for event in events if isinstance(event, Span)} == {Verdict.CLEAR}
    return sum(isinstance(event, Wakeup) for event in events)


@pytest.mark.parametrize("name", ["past", "around", "curved", "looped", "chained", "of unknown path"])
def test_bodies_far_apart_wake_no_more_often_for_a_hundred_times_the_keys(name: str) -> None:
    assert wakeups(name, 2000) <= wakeups(name, 20) + 2


def test_keys_that_are_few_enough_are_followed_one_by_one() -> None:
    """Side by side at 10 m/s, 30 m apart: what each is displaced by says little, a slab to the next key all."""
    left, right = (Body(name, None, at(0, y, 0), keyed(past, 40), (box(2, 1, 1),)) for name, y in (("l", 0), ("r", 30)))
    assert sum(isinstance(event, Wakeup) for event in events_of(left, right, end=END)) == 2


def test_balls_stay_apart_past_any_number_of_keys() -> None:
    rng = np.random.default_rng(1)
    passed = 0
    for _ in range(PATHS):
        times = np.sort(rng.uniform(0.0, 10.0, 600))
        places = np.cumsum(rng.normal(0.0, 0.05, (600, 3)), axis=0) + rng.normal(0.0, 0.05, (600, 3))
        turns = rng.normal(size=(600, 4))
        turns /= np.linalg.norm(turns, axis=1)[:, None]
        how = Translation.CUBIC if rng.random() < 0.5 else Translation.LINEAR
        path = Keyframes(times, places, turns, how, False)
        carried = Constant(tuple(rng.normal(size=3).tolist()), tuple(rng.normal(0.0, 0.3, 3).tolist()))
        one, other = (Extent(np.zeros((1, 3)), np.array([0.5]), Ball((0.2, 0.0, 0.0), 0.5)) for _ in range(2))
        joints = (Joint(at(8.0, 0.0, 0.0), carried), Joint(np.eye(4), path))
        unknown = (Limits(1.0, 0.0, 0.3, inf),) if rng.random() < 0.3 else ()
        motion = RelativeMotion(Chain(joints, np.eye(4), one), Chain((), np.eye(4), other), unknown)
        start = float(rng.uniform(0.0, 2.0))
        slabs = SphereSlabs(motion, 0.0, motion.at(start), 9.0, 0.0)
        sleep = slabs.sleep(0.0)
        passed += np.count_nonzero((times > start) & (times < start + sleep)) > MOST_SLABS
        for duration in (sleep, 0.4 * sleep):
            clearance, gap = slabs.clearance(duration), inf
            for t in np.linspace(start, start + duration, 300).tolist():
                now = motion.at(t)
                apart = np.linalg.norm(np.subtract(now.a.centre, now.b.centre))
                gap = min(gap, apart - motion.radii - motion.spread(t))
            assert clearance >= 0.0
            assert gap >= clearance - ROUNDING
    assert passed > PATHS // 2
