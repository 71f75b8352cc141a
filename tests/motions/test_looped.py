"""Keys that repeat: where loops begin, where they jump, and that no number of them makes a bound dear or loose."""

from time import perf_counter

import numpy as np
import pytest
from drawn_motions import interval, keyframes, looped, paths, pose_error, reach_of

from closecall.scheduler.motions import Keyframes, LeverArms, Looped, Translation

STILL = np.tile([1.0, 0, 0, 0], (3, 1))
REACH = LeverArms(0.5, 0.5)


def keys_at(times, x, how=Translation.LINEAR) -> Keyframes:
    """Return keys along x without turning."""
    x = np.array(x, dtype=float)
    return Keyframes(np.array(times, dtype=float), np.column_stack((x, 0 * x, 0 * x)), STILL[: len(x)], how, False)


def before(t: float) -> float:
    return float(np.nextafter(t, -np.inf))


def test_a_loop_shows_the_first_key_at_its_end_and_jumps_there():
    motion = Looped(keys_at([1, 2, 3], [0, 1, 5]), False, True)
    assert motion.stop_after(0.0) == before(3.0)
    assert motion.stop_after(before(3.0)) == 3.0
    assert motion.stop_after(3.0) == before(5.0)
    assert motion.pose(before(3.0))[0, 3] == pytest.approx(5.0)
    assert motion.pose(3.0)[0, 3] == 0.0
    assert motion.pose(4.5)[0, 3] == pytest.approx(3.0)
    assert motion.pose(-7.0)[0, 3] == 0.0
    assert motion.velocities(-7.0)[0] == (0, 0, 0)
    assert motion.knot_after(3.5) == 4.0


def test_a_loop_before_the_keys_holds_the_last_key_after_them():
    motion = Looped(keys_at([1, 2, 3], [0, 1, 5]), True, False)
    assert motion.pose(0.5)[0, 3] == pytest.approx(3.0)
    assert motion.stop_after(0.0) == before(1.0)
    assert motion.stop_after(1.0) == np.inf
    assert motion.pose(3.0)[0, 3] == motion.pose(1e9)[0, 3] == 5.0
    assert motion.knot_after(3.0) == np.inf


def test_a_loop_whose_ends_meet_has_knots_and_no_stops():
    motion = Looped(keys_at([1, 2, 3], [0, 4, 0]), True, True)
    assert motion.stop_after(-100.0) == np.inf
    assert [motion.knot_after(t) for t in (0.5, 1.0, 2.0, 3.0)] == [1.0, 2.0, 3.0, 4.0]
    assert motion.velocities(3.0)[0] == (4, 0, 0)


def test_ends_that_differ_by_rounding_alone_meet():
    keys = keys_at([0, 1, 2], [0.1 + 0.2, 4, 0.3])
    turned = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [np.cos(np.pi), np.sin(np.pi), 0, 0]])
    keys = Keyframes(keys.times, keys.translations, turned, Translation.LINEAR, False)
    assert Looped(keys, False, True).stop_after(0.0) == np.inf


def test_the_last_of_stepped_keys_is_never_seen_in_a_loop():
    motion = Looped(keys_at([0, 1, 2], [0, 1, 7], Translation.STEP), False, True)
    seen = {motion.pose(t)[0, 3] for t in np.linspace(0, 10, 1001)}
    assert seen == {0.0, 1.0}
    stops = [motion.stop_after(0.0)]
    for _ in range(3):
        stops.append(motion.stop_after(stops[-1]))
    assert stops == [before(1.0), 1.0, before(2.0), 2.0]


def test_a_key_is_jumped_to_at_its_time_and_not_a_float_sooner():
    """Where floats are finer at a time than at the time since the first key, the float before it rounds up to it."""
    for first in (-0.5, -8.0, -1024.0):
        motion = Looped(keys_at([first, 0.296875, 2.0], [0, 1, 0], Translation.STEP), True, True)
        for key, shown in ((0.296875, 1.0), (2.0, 0.0)):
            assert motion.pose(before(key))[0, 3] == 1.0 - shown
            assert motion.pose(key)[0, 3] == shown
            assert motion.stop_after(before(before(key))) == before(key)
            assert motion.stop_after(before(key)) == key


def test_the_last_of_stepped_keys_is_not_even_seen_where_the_end_is_rounded_late():
    """1e5 s after the keys, loops begin at floats some 1e-11 s off: the last instants are more than a period late."""
    motion = Looped(keys_at([-1e5, -1e5 + 0.1, -1e5 + 0.3], [0, 1, 7], Translation.STEP), True, True)
    t, seen = -30.0, set()
    for _ in range(200):
        jump = motion.stop_after(motion.stop_after(t))
        seen |= {float(motion.pose(at)[0, 3]) for at in (before(jump), jump)}
        t = jump
    assert seen == {0.0, 1.0}


@pytest.mark.parametrize("how", [Translation.LINEAR, Translation.CUBIC])
def test_an_interval_up_to_a_jump_at_a_loops_end_covers_all_before_it(how):
    motion = Looped(keys_at([0, 1, 2], [0, 2, 5], how), True, True)
    for t in (-3.5, 0.3, 4.7):
        jump = motion.stop_after(motion.stop_after(t))
        reached = abs(motion.pose(before(jump))[0, 3] - motion.pose(t)[0, 3])
        assert reached <= motion.displacement(t, jump - t, REACH) * (1 + 1e-12) <= 1.1 * reached
        assert reached <= motion.path_length(t, jump - t, REACH) * (1 + 1e-12) <= 1.1 * reached


def test_a_single_key_is_held():
    motion = Looped(keys_at([1], [3]), True, True)
    assert {motion.pose(t)[0, 3] for t in (-1e6, 1.0, 1e6)} == {3.0}
    assert motion.stop_after(-5.0) == motion.stop_after(5.0) == np.inf
    assert motion.displacement(-5.0, 1e6, REACH) == motion.path_length(-5.0, 1e6, REACH) == 0.0


@pytest.mark.parametrize("offset", [0.0, 1e3, -1e6, 1e9])
def test_every_jump_lies_at_a_stop_and_every_knot_is_where_the_velocity_changes(offset):
    """Walk from knot to knot: the pose just before each is another exactly where it is a stop."""
    rng = np.random.default_rng(1)
    for _ in range(40):
        drawn = looped(rng)
        keys = drawn.keys
        moved = Keyframes(
            keys.times + offset, keys.translations, keys.quaternions, keys.translation, keys.step_rotation
        )
        motion = Looped(moved, drawn.before, drawn.after)
        t = float(rng.uniform(-20, 20)) + float(rng.choice([0.0, offset, 2 * offset]))
        for _ in range(25):
            knot = motion.knot_after(t)
            if knot == np.inf:
                assert motion.stop_after(t) == np.inf
                break
            assert knot > t
            jumps = np.abs(motion.pose(knot) - motion.pose(before(knot))).max() > 1e-3
            stops = {motion.stop_after(before(before(knot))), motion.stop_after(before(knot))}
            assert (knot in stops) == jumps
            assert jumps == (motion.stop_after(t) <= knot)
            inside = 0.5 * t + 0.5 * knot
            spacing = np.spacing(max(abs(t), abs(knot), abs(offset)))
            speed = np.abs(motion.velocities(inside)[0]).max() + 1.0
            assert np.abs(motion.pose(inside) - motion.pose(before(inside))).max() < 50 * speed * spacing + 1e-9
            t = knot


def test_bounds_hold_far_from_the_keys():
    rng = np.random.default_rng(2)
    for _ in range(100):
        keys = keyframes(rng, [Translation.LINEAR, Translation.CUBIC][int(rng.integers(0, 2))], closed=True)
        motion = Looped(keys, True, True)
        points = rng.normal(size=(5, 3))
        reach = reach_of(motion, points)
        _, duration = interval(rng, motion)
        t = float(rng.normal() * 10.0 ** rng.uniform(2, 7))
        error = 2 * pose_error(motion, t, duration, reach.radius)
        track = paths(motion, t, duration, points)
        assert motion.displacement(t, duration, reach) >= np.linalg.norm(track - track[0], axis=2).max() - error
        way = np.linalg.norm(np.diff(track, axis=0), axis=2).sum(axis=0).max()
        assert motion.path_length(t, duration, reach) >= way - len(track) * error


def test_a_billion_loops_cost_no_more_than_one_and_saturate():
    rng = np.random.default_rng(3)
    motion = Looped(keyframes(rng, Translation.CUBIC, closed=True), True, True)
    farthest = [motion.displacement(t, 1e9, REACH) for t in (0.0, 0.3, -1e8)]
    assert max(farthest) < 2 * np.linalg.norm(np.ptp(motion.keys.translations, axis=0)) + 4.0
    began = perf_counter()
    for _ in range(20):
        motion.displacement(0.1, 1e9, REACH)
        motion.path_length(0.1, 1e9, REACH)
        motion.knot_after(1e9)
    assert perf_counter() - began < 2.0
    period = motion.keys.times[-1] - motion.keys.times[0]
    once = motion.path_length(0.0, period, REACH)
    assert motion.path_length(0.0, 1e6 * period, REACH) == pytest.approx(1e6 * once, rel=1e-2)


def test_a_period_that_floats_cannot_resolve_is_refused():
    motion = Looped(keys_at([0, 1e-9, 2e-9], [0, 1, 0]), True, True)
    assert motion.rounding_scale((-1.0, 1.0), 1.0) > 0
    with pytest.raises(ValueError, match="cannot be distinguished"):
        motion.rounding_scale((0.0, 1e9), 1.0)
