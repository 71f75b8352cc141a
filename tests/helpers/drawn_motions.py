"""Random motions of every kind, what they are in the scene file's words, and densely sampled paths of their points."""

from collections.abc import Callable
from typing import Any

import numpy as np

from closecall.scheduler.geometry.vector import Vector
from closecall.scheduler.kinematics.chain import Chain, Joint
from closecall.scheduler.kinematics.relative_motion import RelativeMotion
from closecall.scheduler.model.extent import Ball, Extent
from closecall.scheduler.motions import (
    Ballistic,
    Constant,
    Delayed,
    Harmonic,
    Keyframes,
    LeverArms,
    Looped,
    Motion,
    Orbit,
    Polynomial,
    Screw,
    Swing,
    Translation,
    Trapezoid,
)
from oracle.rigid import rotations

EPSILON = float(np.finfo(float).eps)
SAMPLES = 100


def vector(array) -> Vector:
    x, y, z = map(float, array)
    return x, y, z


def random_unit(rng) -> Vector:
    v = rng.normal(size=3)
    return vector(v / np.linalg.norm(v))


def random_vector(rng, size=1.0) -> Vector:
    return vector(rng.normal(size=3) * size)


def constant(rng) -> Motion:
    spin = random_vector(rng, 3.0) if rng.random() < 0.8 else (0.0, 0.0, 0.0)
    return Constant(random_vector(rng), spin)


def ballistic(rng) -> Motion:
    return Ballistic(random_vector(rng), random_vector(rng, 4.0), random_vector(rng, rng.choice([0.0, 3.0])))


def screw(rng) -> Motion:
    return Screw(random_unit(rng), random_vector(rng), float(rng.normal() * 4), float(rng.normal()))


def orbit(rng, facing=False) -> Motion:
    axis = random_unit(rng)
    start = np.cross(axis, random_unit(rng))
    start = vector(start / np.linalg.norm(start))
    return Orbit(axis, start, float(rng.uniform(0.1, 3)), float(rng.normal() * 4), float(rng.uniform(-9, 9)), facing)


def facing_orbit(rng) -> Motion:
    return orbit(rng, facing=True)


def harmonic(rng) -> Motion:
    return Harmonic(random_unit(rng), float(rng.normal()), float(rng.uniform(0.05, 3)), float(rng.uniform(-9, 9)))


def swing(rng) -> Motion:
    amplitude, period, phase = float(rng.normal() * 2), float(rng.uniform(0.05, 3)), float(rng.uniform(-9, 9))
    return Swing(random_unit(rng), random_vector(rng), amplitude, period, phase)


def polynomial(rng) -> Motion:
    count = int(rng.integers(1, 22))
    terms = rng.normal(size=(count, 3)) / 1.7 ** np.arange(count)[:, None]
    spin = random_vector(rng, 3.0) if rng.random() < 0.5 else (0.0, 0.0, 0.0)
    return Polynomial(tuple(vector(term) for term in terms), spin)


def profile(rng, turns=False) -> Trapezoid:
    begin, end = map(float, rng.normal(size=2) * rng.choice([0.1, 3.0]))
    velocity, acceleration = map(float, rng.uniform(0.1, 3.0, 2))
    start = float(rng.uniform(-3, 2))
    return Trapezoid(turns, random_unit(rng), random_vector(rng), begin, end, velocity, acceleration, start)


def turning_profile(rng) -> Trapezoid:
    return profile(rng, turns=True)


def keyframes(rng, translation=Translation.LINEAR, step_rotation=False, closed=False, velocities=False) -> Keyframes:
    count = int(rng.integers(2, 7))
    times = np.cumsum(rng.uniform(0.1, 1.5, count)) - 2.0
    quaternions = rng.normal(size=(count, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1)[:, None]
    places = rng.normal(size=(count, 3))
    if closed:
        quaternions[-1], places[-1] = -quaternions[0], places[0]
    speeds = rng.normal(size=(count, 3)) * 2 if velocities else None
    return Keyframes(times, places, quaternions, translation, step_rotation, speeds)


def stepped_translation(rng) -> Motion:
    return keyframes(rng, Translation.STEP)


def stepped_rotation(rng) -> Motion:
    return keyframes(rng, step_rotation=True)


def cubic(rng) -> Motion:
    return keyframes(rng, Translation.CUBIC)


def cubic_with_velocities(rng) -> Motion:
    return keyframes(rng, Translation.CUBIC, velocities=True)


def looped(rng) -> Looped:
    """Keys whose ends differ, so that every loop ends in a jump."""
    before = bool(rng.random() < 0.7)
    translation = [Translation.LINEAR, Translation.STEP, Translation.CUBIC][int(rng.integers(0, 3))]
    return Looped(keyframes(rng, translation), before, not before or bool(rng.random() < 0.7))


def closed_loop(rng) -> Motion:
    return Looped(keyframes(rng, closed=True), True, True)


def closed_cubic_loop(rng) -> Motion:
    return Looped(keyframes(rng, Translation.CUBIC, closed=True), True, True)


SMOOTH = [constant, ballistic, screw, orbit, facing_orbit, harmonic, swing, polynomial]


def delayed(rng) -> Motion:
    return Delayed(SMOOTH[int(rng.integers(0, len(SMOOTH)))](rng), float(rng.normal() * 2))


#: Without jumps.
CONTINUOUS = [
    *SMOOTH,
    profile,
    turning_profile,
    keyframes,
    cubic,
    cubic_with_velocities,
    closed_loop,
    closed_cubic_loop,
    delayed,
]
KINDS: list[Callable[..., Motion]] = [*CONTINUOUS, stepped_translation, stepped_rotation, looped]


def spec_of(motion: Motion) -> dict[str, Any]:
    """Return the motion in the scene file's words, in m and rad."""
    match motion:
        case Ballistic(v, a, w):
            return {"type": "ballistic", "velocity": v, "acceleration": a, "angular_velocity": w}
        case Screw(axis, point, rate, pitch):
            return {"type": "screw", "axis": axis, "point": point, "rate": rate, "pitch": pitch}
        case Orbit(axis, start, radius, rate, phase, facing):
            circle = {"radius": radius, "rate": rate, "phase": phase, "facing": facing}
            return {"type": "orbit", "axis": axis, "start": start, **circle}
        case Harmonic(direction, amplitude, period, phase):
            return {
                "type": "harmonic", "direction": direction, "amplitude": amplitude, "period": period, "phase": phase
            }  # fmt: skip
        case Swing(axis, point, amplitude, period, phase):
            sine = {"amplitude": amplitude, "period": period, "phase": phase}
            return {"type": "swing", "axis": axis, "point": point, **sine}
        case Polynomial(terms, w):
            return {"type": "polynomial", "coefficients": terms, "angular_velocity": w}
        case Trapezoid(turns, axis, point, begin, end, velocity, acceleration, start):
            limits = {"max_velocity": velocity, "max_acceleration": acceleration}
            line = {"kind": "turn" if turns else "slide", "axis": axis, "point": point}
            return {"type": "profile", **line, "from": begin, "to": end, "t0": start, **limits}
        case Looped(keys, before, after):
            ways = {"before": "loop" if before else "hold", "after": "loop" if after else "hold"}
            return {**spec_of(keys), **ways}
        case Delayed(inner, delay):
            return {**spec_of(inner), "t0": delay}
        case Keyframes():
            return _keys_of(motion)
    raise AssertionError(motion)


def _keys_of(motion: Keyframes) -> dict[str, Any]:
    rows = zip(motion.times, motion.translations, motion.quaternions, strict=True)
    keys = [{"t": t, "xyz": place, "quat_wxyz": q} for t, place, q in rows]
    if motion.key_velocities is not None:
        for key, velocity in zip(keys, motion.key_velocities, strict=True):
            key["velocity"] = velocity
    ways = {"translation": motion.translation.value, "rotation": "step" if motion.step_rotation else "slerp"}
    return {"type": "keyframes", "keys": keys, "interpolation": ways}


def reach_of(motion: Motion, points: np.ndarray) -> LeverArms:
    radius = float(np.max(np.linalg.norm(points, axis=1)))
    if motion.axis is None:
        return LeverArms(radius, radius)
    arms = np.cross(points - np.array(motion.axis.point), np.array(motion.axis.direction))
    return LeverArms(radius, float(np.max(np.linalg.norm(arms, axis=1))))


def interval(rng, motion: Motion) -> tuple[float, float]:
    """Return a random t and duration without a jump after t and before or at t + duration."""
    t = float(rng.uniform(-2, 2))
    duration = float(rng.choice([1e-4, 0.01, 0.1, 1.0, 4.0]) * rng.uniform(0.1, 1))
    return t, min(duration, (motion.stop_after(t) - t) * (1 - 1e-9))


def paths(motion: Motion, t: float, duration: float, points: np.ndarray) -> np.ndarray:
    """Return the points at SAMPLES times, (SAMPLES, points, 3)."""
    poses = np.array([motion.pose(float(s)) for s in np.linspace(t, t + duration, SAMPLES)])
    return np.einsum("tij,pj->tpi", poses[:, :3, :3], points) + poses[:, None, :3, 3]


def pose_error(motion: Motion, t: float, duration: float, radius: float) -> float:
    """Return how far (m) the motion's own account lets floating point misplace a point over an interval."""
    return 8 * EPSILON * motion.rounding_scale((t, t + duration), radius)


def random_rest(rng, size=1.0) -> np.ndarray:
    """Return a random 4x4 pose."""
    rest = np.eye(4)
    rest[:3, :3] = rotations(np.array(random_unit(rng)), np.array([rng.uniform(-3, 3)]))[0]
    rest[:3, 3] = rng.normal(size=3) * size
    return rest


class RandomCourse:
    """Two bodies on random chains of motions, and a random time of theirs.

    Attributes:
        t, duration: s, when it begins, and how long it is.
    """

    def __init__(self, rng) -> None:
        size = float(10.0 ** rng.uniform(-2, 0.5))
        one, other = (random_chain(rng, rng.normal(size=(5, 3)) * size, 0.0, CONTINUOUS) for _ in range(2))
        self.motion = RelativeMotion(one, other)
        self.t, self.duration = float(rng.uniform(-1, 1)), float(10.0 ** rng.uniform(-1, 1))
        self.state = self.motion.at(self.t)

    def apart(self, state) -> float:
        """Return how far (m) the middles of the bodies are apart."""
        return float(np.linalg.norm(np.subtract(state.b.centre, state.a.centre)))

    def samples(self, duration, count) -> list[float]:
        """Return how far (m) they are apart at so many times from t on."""
        return [self.apart(self.motion.at(t)) for t in (self.t + np.linspace(0.0, duration, count)).tolist()]


def random_chain(rng, points, radius, kinds=CONTINUOUS) -> Chain:
    """Return a chain of one to four joints that carries these points, each rounded by `radius`."""
    drawn = [kinds[int(rng.integers(0, len(kinds)))] for _ in range(int(rng.integers(1, 5)))]
    joints = [Joint(random_rest(rng), kind(rng)) for kind in drawn]
    tail = np.eye(4)
    tail[:3, 3] = rng.normal(size=3) * 0.3
    centre = points.mean(axis=0)
    ball = Ball(vector(centre), float(np.max(np.linalg.norm(points - centre, axis=1)) + radius))
    return Chain(tuple(joints), tail, Extent(points, np.full(len(points), radius), ball))
