"""Poses whose rounding is known: each class of motions at large times, phases and coordinates, and exact places."""

from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
from drawn_motions import EPSILON, random_unit, random_vector, vector

from closecall.scheduler.motions import (
    Ballistic,
    Delayed,
    Harmonic,
    Interval,
    Keyframes,
    Looped,
    Motion,
    Orbit,
    Polynomial,
    Screw,
    Swing,
    Translation,
    Trapezoid,
)

CASES = 150
WIDE = np.longdouble
PI = WIDE("3.14159265358979323846264338327950288")


def wide(array) -> np.ndarray:
    return np.asarray(array, dtype=WIDE)


def about(axis, angle, q) -> np.ndarray:
    """Return q turned about `axis` of any length by `angle` (Rodrigues)."""
    k, q = wide(axis), wide(q)
    k = k / np.sqrt(k @ k)
    return q * np.cos(angle) + np.cross(k, q) * np.sin(angle) + k * (k @ q) * (1 - np.cos(angle))


Case = tuple[Motion, float, Interval, Any, np.ndarray]
"""A motion, a time, an interval that its account covers, a point, and where the point truly is at the time."""


def worst_share(cases) -> float:
    """Return the largest share of its account that any pose's error takes, over (motion, t, times, q, truth)."""
    shares = []
    for motion, t, times, q, truth in cases:
        found = wide(motion.pose(t)[:3, :3]) @ wide(q) + wide(motion.pose(t)[:3, 3])
        allowed = 8 * EPSILON * motion.rounding_scale(times, float(np.linalg.norm(q)))
        shares.append(float(np.sqrt(np.sum((found - truth) ** 2))) / allowed)
    assert np.isfinite(shares).all()
    return max(shares)


def span_of(rng, middle=0.0) -> tuple[float, Interval]:
    """Return a time, soon or long before or after `middle`, and an interval that holds it and goes not much beyond."""
    since = float(rng.choice([-1, 1]) * 10.0 ** rng.uniform(-3, 6))
    t, beyond = middle + since, middle + since * float(rng.uniform(1, 2))
    return t, (min(t, beyond), max(t, beyond))


def orbit_point(motion: Orbit, t, q) -> np.ndarray:
    angle = WIDE(motion.rate) * t + WIDE(motion.phase)
    centre = WIDE(motion.radius) * about(motion.axis_direction, angle, motion.start)
    return centre + (about(motion.axis_direction, angle, q) if motion.facing else wide(q))


def random_orbit(rng, facing) -> Orbit:
    axis = np.array(random_unit(rng))
    start = np.cross(axis, random_unit(rng))
    radius, rate = float(10.0 ** rng.uniform(-3, 5)), float(rng.normal() * 10.0 ** rng.uniform(-2, 2))
    phase = float(rng.choice([0.0, 1.0, 1e6]) * rng.normal())
    return Orbit(vector(axis), vector(start / np.linalg.norm(start)), radius, rate, phase, facing)


def orbits(facing) -> Iterator[Case]:
    rng = np.random.default_rng(1)
    for _ in range(CASES):
        motion, (t, times), q = random_orbit(rng, facing), span_of(rng), random_vector(rng)
        yield motion, t, times, q, orbit_point(motion, WIDE(t), q)


def polynomial_point(motion: Polynomial, t: Fraction, q) -> np.ndarray:
    terms = [[Fraction(x) for x in term] for term in motion.coefficients]
    place = [sum(term[axis] * t**k for k, term in enumerate(terms)) for axis in range(3)]
    # a fraction in two floats, high and low
    high = [float(x) for x in place]
    low = [float(x - Fraction(h)) for x, h in zip(place, high, strict=True)]
    spin = wide(motion.angular_velocity)
    angle = np.sqrt(spin @ spin) * (WIDE(float(t)) + WIDE(float(t - Fraction(float(t)))))
    return about(spin, angle, q) + wide(high) + wide(low)


def cancelling_polynomials() -> Iterator[Case]:
    """Up to the twentieth degree."""
    rng = np.random.default_rng(2)
    for _ in range(CASES):
        degree, t = int(rng.integers(0, 21)), float(rng.normal() * 10.0 ** rng.uniform(-2, 3))
        terms = rng.normal(size=(degree + 1, 3)) * abs(t) ** -np.arange(degree + 1.0)[:, None]
        if rng.random() < 0.5:
            terms[0] -= np.sum(terms * t ** np.arange(degree + 1.0)[:, None], axis=0)
        motion = Polynomial(tuple(map(vector, terms)), random_vector(rng, 3.0))
        q = random_vector(rng)
        yield motion, t, (t, t), q, polynomial_point(motion, Fraction(t), q)


def trapezoid(motion: Trapezoid, t) -> np.ndarray:
    """Return the profile's value at t, from its formula over real numbers."""
    begin, end, top, steepness = map(WIDE, (motion.begin, motion.end, motion.max_velocity, motion.max_acceleration))
    travel = abs(end - begin)
    ramp = min(top / steepness, np.sqrt(travel / steepness))
    total = ramp + travel / (ramp * steepness)
    s = min(max(WIDE(t) - WIDE(motion.start_time), WIDE(0)), total)
    rising, braking = min(s, ramp), max(s - (total - ramp), WIDE(0))
    gone = steepness * rising**2 / 2 + ramp * steepness * (s - rising) - steepness * braking**2 / 2
    return begin + np.sign(end - begin) * gone


def late_profiles(turns) -> Iterator[Case]:
    rng = np.random.default_rng(3)
    for _ in range(2 * CASES):
        begin, end = map(float, rng.normal(size=2) * 10.0 ** rng.uniform(-3, 4))
        velocity, acceleration = map(float, 10.0 ** rng.uniform(-2, 2, 2))
        start = float(rng.normal() * 10.0 ** rng.uniform(-2, 6))
        motion = Trapezoid(turns, random_unit(rng), random_vector(rng), begin, end, velocity, acceleration, start)
        last = motion.start_time
        while (knot := motion.knot_after(last)) < np.inf:
            last = knot
        t, q = float(rng.uniform(start, last)), random_vector(rng)
        value = trapezoid(motion, t)
        if turns:
            point = wide(motion.point)
            truth = point + about(motion.axis_direction, value, wide(q) - point)
        else:
            truth = wide(q) + value * wide(motion.axis_direction)
        yield motion, t, (t, t), q, truth


def slerped(first, last, part, q) -> np.ndarray:
    """Return q turned by the slerp of two quaternions w x y z."""
    first, last = wide(first), wide(last)
    first, last = first / np.sqrt(first @ first), last / np.sqrt(last @ last)
    last = -last if first @ last < 0 else last
    angle = 2 * np.arctan2(np.sqrt(np.sum((last - first) ** 2)), np.sqrt(np.sum((last + first) ** 2)))
    if angle == 0:
        part, angle = WIDE(0), WIDE(1)
    w, *v = (np.sin((1 - part) * angle) * first + np.sin(part * angle) * last) / np.sin(angle)
    v, q = wide(v), wide(q)
    return q + 2 * np.cross(v, np.cross(v, q) + w * q)


def keyed_point(keys: Keyframes, t, q) -> np.ndarray:
    """Return where q is at t within the keys, from Hermite's and slerp's formulas."""
    times, places = wide(keys.times), wide(keys.translations)
    key = min(max(int(np.searchsorted(times, t, side="right")) - 1, 0), len(times) - 2)
    h = times[key + 1] - times[key]
    s = (t - times[key]) / h
    turned = slerped(keys.quaternions[key], keys.quaternions[key + 1], s, q)
    if keys.translation is Translation.LINEAR:
        return turned + places[key] + s * (places[key + 1] - places[key])
    slopes = np.diff(places, axis=0) / np.diff(times)[:, None]
    before, after = np.diff(times)[:-1, None], np.diff(times)[1:, None]
    inner = (after * slopes[:-1] + before * slopes[1:]) / (before + after)
    speeds = np.concatenate([slopes[:1], inner, slopes[-1:]])
    if keys.key_velocities is not None:
        speeds = wide(keys.key_velocities)
    place = (1 + 2 * s) * (1 - s) ** 2 * places[key] + s * (1 - s) ** 2 * h * speeds[key]
    return turned + place + s**2 * (3 - 2 * s) * places[key + 1] + s**2 * (s - 1) * h * speeds[key + 1]


def random_keys(rng, translation, closed=False) -> Keyframes:
    count = int(rng.integers(2, 8))
    start = float(rng.normal() * 10.0 ** rng.uniform(-2, 6))
    times = start + np.cumsum(10.0 ** rng.uniform(-2, 1, count))
    places = rng.normal(size=(count, 3)) * 10.0 ** rng.uniform(-2, 5, (count, 1) if rng.random() < 0.5 else (1, 1))
    quaternions = rng.normal(size=(count, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1)[:, None]
    if closed:
        places[-1], quaternions[-1] = places[0], -quaternions[0]
    speeds = rng.normal(size=(count, 3)) if translation is Translation.CUBIC and rng.random() < 0.3 else None
    return Keyframes(times, places, quaternions, translation, False, speeds)


def paths_along_keys(translation) -> Iterator[Case]:
    rng = np.random.default_rng(4)
    for _ in range(CASES):
        keys, q = random_keys(rng, translation), random_vector(rng)
        t = float(rng.uniform(keys.times[0], keys.times[-1]))
        yield keys, t, (t, t), q, keyed_point(keys, WIDE(t), q)


def long_loops(translation) -> Iterator[Case]:
    """Without a jump, after up to a million seconds."""
    rng = np.random.default_rng(5)
    for _ in range(CASES):
        keys, q = random_keys(rng, translation, closed=True), random_vector(rng)
        motion = Looped(keys, True, True)
        t, times = span_of(rng)
        first, period = WIDE(keys.times[0]), WIDE(keys.times[-1]) - WIDE(keys.times[0])
        yield motion, t, times, q, keyed_point(keys, first + np.mod(WIDE(t) - first, period), q)


def delays_of_what_swings_fast() -> Iterator[Case]:
    """A harmonic takes whole periods off exactly, its own account does not grow with time: the delay's does."""
    rng = np.random.default_rng(7)
    for _ in range(CASES):
        delay = float(rng.normal() * 10.0 ** rng.uniform(0, 9))
        t, times = span_of(rng, delay)
        direction, period = random_unit(rng), float(10.0 ** rng.uniform(-3, 0))
        inner = Harmonic(direction, float(rng.normal()), period, float(rng.normal()))
        angle = 2 * PI * np.fmod(WIDE(t) - WIDE(delay), WIDE(period))
        truth = WIDE(inner.amplitude) * np.sin(angle / WIDE(period) + WIDE(inner.phase)) * wide(direction)
        yield Delayed(inner, delay), t, times, (0.0, 0.0, 0.0), truth


def delays() -> Iterator[Case]:
    rng = np.random.default_rng(6)
    for _ in range(2 * CASES):
        delay, q = float(rng.normal() * 10.0 ** rng.uniform(-3, 9)), random_vector(rng)
        t, times = span_of(rng, delay)
        inner: Motion
        if rng.random() < 0.5:
            inner = random_orbit(rng, bool(rng.random() < 0.5))
            truth = orbit_point(inner, WIDE(t) - WIDE(delay), q)
        else:
            powers = abs(t - delay) ** -np.arange(4.0)[:, None]
            inner = Polynomial(tuple(map(vector, rng.normal(size=(4, 3)) * powers)), random_vector(rng))
            truth = polynomial_point(inner, Fraction(t) - Fraction(delay), q)
        yield Delayed(inner, delay), t, times, q, truth


def wave(motion: Harmonic | Swing, *times: float) -> np.longdouble:
    """Return the sine at the sum of the times; whole periods are taken off in fractions."""
    periods = sum(map(Fraction, times), Fraction(0)) / Fraction(motion.period)
    part = periods - int(periods)
    rest = WIDE(float(part)) + WIDE(float(part - Fraction(float(part))))
    return WIDE(np.sin(2 * PI * rest + WIDE(motion.phase)))


def smooth_point(motion: Motion, q, *times: float) -> np.ndarray:
    """Return where q is at the sum of the times, from the motions' formulas."""
    t = sum(map(WIDE, times))
    match motion:
        case Harmonic():
            return wide(q) + WIDE(motion.amplitude) * wave(motion, *times) * wide(motion.direction)
        case Swing():
            point, angle = wide(motion.point), WIDE(motion.amplitude) * wave(motion, *times)
            return point + about(motion.axis_direction, angle, wide(q) - point)
        case Screw():
            point, angle = wide(motion.point), WIDE(motion.rate) * t
            advance = WIDE(motion.pitch) * angle / (2 * PI) * wide(motion.axis_direction)
            return point + about(motion.axis_direction, angle, wide(q) - point) + advance
        case Ballistic():
            spin = wide(motion.angular_velocity)
            way = t * wide(motion.velocity) + t * t / 2 * wide(motion.acceleration)
            return about(spin, np.sqrt(spin @ spin) * t, q) + way
        case _:
            raise TypeError(motion)


def random_smooth(rng, kind: type) -> Motion:
    large, period, rate = (float(10.0 ** rng.uniform(-3, most)) for most in (6, 4, 2))
    axis, point, phase = random_unit(rng), random_vector(rng, 10.0 ** rng.uniform(-2, 6)), float(rng.normal())
    if kind is Harmonic:
        return Harmonic(axis, large, period, phase * float(rng.choice([1, 1e6])))
    if kind is Swing:
        return Swing(axis, point, rate, period, phase)
    if kind is Screw:
        return Screw(axis, point, rate, float(rng.normal()))
    return Ballistic(random_vector(rng, large), random_vector(rng, rate), random_vector(rng, rate))


SMOOTH = [Ballistic, Harmonic, Screw, Swing]


def motions_without_knots(kind) -> Iterator[Case]:
    rng = np.random.default_rng(8)
    for _ in range(2 * CASES):
        motion, (t, times), q = random_smooth(rng, kind), span_of(rng), random_vector(rng)
        yield motion, t, times, q, smooth_point(motion, q, t)


ROUNDING_CASES: dict[str, tuple[type[Motion], Callable[[], Iterator[Case]]]] = {
    "orbits": (Orbit, partial(orbits, False)),
    "orbits that face their centre": (Orbit, partial(orbits, True)),
    "polynomials that cancel": (Polynomial, cancelling_polynomials),
    "slides that start late": (Trapezoid, partial(late_profiles, False)),
    "turns that start late": (Trapezoid, partial(late_profiles, True)),
    "lines between keys": (Keyframes, partial(paths_along_keys, Translation.LINEAR)),
    "curves between keys": (Keyframes, partial(paths_along_keys, Translation.CUBIC)),
    "loops of lines": (Looped, partial(long_loops, Translation.LINEAR)),
    "loops of curves": (Looped, partial(long_loops, Translation.CUBIC)),
    "delays of what swings fast": (Delayed, delays_of_what_swings_fast),
    "delays": (Delayed, delays),
    **{f"{kind.__name__} without knots": (kind, partial(motions_without_knots, kind)) for kind in SMOOTH},
}
"""Each class of motions must be in here: scene/test_untried.py asks for it."""
