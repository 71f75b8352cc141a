"""The motions of the scene file as (n, 4, 4) matrices at n times, each from its formula in the scene format."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .rigid import FloatArray, IntArray, about_point, numbers, pose_of, rigid, rotations, unit

ZERO = (0.0, 0.0, 0.0)
Spec = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Units:
    """What one unit of the file is, in m and in rad."""

    metres: float
    radians: float


def motion_at(spec: Spec | None, times: FloatArray, units: Units) -> FloatArray:
    """Return the motion's matrices (n, 4, 4) at scene times (n,) s; no motion is the identity."""
    if spec is None:
        return rigid(None, np.zeros((len(times), 3)))
    if spec["type"] not in MOTIONS:
        raise NotImplementedError(f"the oracle does not know motion {spec['type']!r}")
    return MOTIONS[spec["type"]](spec, times - float(spec.get("t0", 0.0)), units)


def spin(spec: Spec, t: FloatArray, units: Units) -> FloatArray:
    """Return (n, 3, 3): the turn by `angular_velocity` times t."""
    rate = numbers(spec.get("angular_velocity", ZERO)) * units.radians
    speed = float(np.linalg.norm(rate))
    axis = rate / speed if speed > 0.0 else np.array([0.0, 0.0, 1.0])
    return rotations(axis, speed * t)


def polynomial(spec: Spec, t: FloatArray, units: Units) -> FloatArray:
    terms = numbers(spec["coefficients"]) * units.metres
    powers = t[:, None] ** np.arange(len(terms))
    return rigid(spin(spec, t, units), powers @ terms)


def ballistic(spec: Spec, t: FloatArray, units: Units) -> FloatArray:
    velocity = numbers(spec.get("velocity", ZERO)) * units.metres
    acceleration = numbers(spec.get("acceleration", ZERO)) * units.metres
    return rigid(spin(spec, t, units), t[:, None] * velocity + 0.5 * t[:, None] ** 2 * acceleration)


def screw(spec: Spec, t: FloatArray, units: Units) -> FloatArray:
    axis, point = unit(spec["axis"]), numbers(spec.get("point", ZERO)) * units.metres
    angle = float(spec["rate"]) * units.radians * t
    out = about_point(rotations(axis, angle), point)
    out[:, :3, 3] += (float(spec.get("pitch", 0.0)) * units.metres * angle / (2.0 * np.pi))[:, None] * axis
    return out


def orbit(spec: Spec, t: FloatArray, units: Units) -> FloatArray:
    axis = unit(spec["axis"])
    start = numbers(spec["start"])
    start = unit(start - axis * (axis @ start))
    angle = (float(spec["rate"]) * t + float(spec.get("phase", 0.0))) * units.radians
    circle = np.cos(angle)[:, None] * start + np.sin(angle)[:, None] * np.cross(axis, start)
    turn = rotations(axis, angle) if spec.get("facing", False) else None
    return rigid(turn, float(spec["radius"]) * units.metres * circle)


def sine(spec: Spec, t: FloatArray, units: Units) -> FloatArray:
    """Return sin(2 pi t / period + phase), (n,)."""
    phase = float(spec.get("phase", 0.0)) * units.radians
    return np.sin(2.0 * np.pi * t / float(spec["period"]) + phase)


def harmonic(spec: Spec, t: FloatArray, units: Units) -> FloatArray:
    amplitude = float(spec["amplitude"]) * units.metres
    return rigid(None, amplitude * sine(spec, t, units)[:, None] * unit(spec["direction"]))


def swing(spec: Spec, t: FloatArray, units: Units) -> FloatArray:
    angle = float(spec["amplitude"]) * units.radians * sine(spec, t, units)
    point = numbers(spec.get("point", ZERO)) * units.metres
    return about_point(rotations(unit(spec["axis"]), angle), point)


def trapezoid(t: FloatArray, travel: float, velocity: float, acceleration: float) -> FloatArray:
    """Return the way gone (n,) of a trapezoidal speed profile over `travel` >= 0 that starts at t = 0."""
    ramp = min(velocity / acceleration, float(np.sqrt(travel / acceleration)))
    top = ramp * acceleration
    total = ramp + (travel / top if top > 0.0 else 0.0)
    t = np.clip(t, 0.0, total)
    rising = 0.5 * acceleration * np.minimum(t, ramp) ** 2
    cruising = top * np.clip(t - ramp, 0.0, total - 2.0 * ramp)
    braking = np.clip(t - (total - ramp), 0.0, ramp)
    return rising + cruising + top * braking - 0.5 * acceleration * braking**2


def profile(spec: Spec, t: FloatArray, units: Units) -> FloatArray:
    slides = spec["kind"] == "slide"
    scale = units.metres if slides else units.radians
    begin, end = float(spec["from"]) * scale, float(spec["to"]) * scale
    gone = trapezoid(t, abs(end - begin), float(spec["max_velocity"]) * scale, float(spec["max_acceleration"]) * scale)
    value = begin + np.sign(end - begin) * gone
    axis = unit(spec["axis"])
    if slides:
        return rigid(None, value[:, None] * axis)
    return about_point(rotations(axis, value), numbers(spec.get("point", ZERO)) * units.metres)


def keyframes(spec: Spec, t: FloatArray, units: Units) -> FloatArray:
    """Interpolate the keys: step holds the last key at or before t, the other ways blend towards the next."""
    keys = spec["keys"]
    at = numbers([key["t"] for key in keys])
    poses = np.array([pose_of(key, units.metres, units.radians) for key in keys])
    t = wrapped(spec, t, at)
    now = np.clip(np.searchsorted(at, t, side="right") - 1, 0, len(at) - 1)
    left = np.minimum(now, max(len(at) - 2, 0))
    right = np.minimum(left + 1, len(at) - 1)
    length = np.where(right > left, at[right] - at[left], 1.0)
    part = (t - at[left]) / length
    ways = spec.get("interpolation", {})
    how, turns = ways.get("translation", "linear"), ways.get("rotation", "slerp")
    places = poses[:, :3, 3]
    if how == "step":
        translation = places[now]
    elif how == "cubic":
        translation = hermite(places, tangents(spec, at, places, units), left, right, part, length)
    else:
        translation = places[left] + part[:, None] * (places[right] - places[left])
    rotation = poses[now, :3, :3] if turns == "step" else slerp(poses[:, :3, :3], left, right, part)
    return rigid(rotation, translation)


def wrapped(spec: Spec, t: FloatArray, at: FloatArray) -> FloatArray:
    """Bring times outside the keys inside: looped where the spec says so, else held at the nearer end."""
    span = at[-1] - at[0]
    looped = at[0] + np.mod(t - at[0], span) if span > 0.0 else np.full_like(t, at[0])
    t = np.where((t < at[0]) & (spec.get("before") == "loop"), looped, t)
    t = np.where((t > at[-1]) & (spec.get("after") == "loop"), looped, t)
    return np.clip(t, at[0], at[-1])


def slerp(turns: FloatArray, left: IntArray, right: IntArray, part: FloatArray) -> FloatArray:
    """Return (n, 3, 3): from turns[left] along the shortest turn to turns[right], `part` of the way."""
    first, second = Rotation.from_matrix(turns[left]), Rotation.from_matrix(turns[right])
    way = (first.inv() * second).as_rotvec()
    return (first * Rotation.from_rotvec(part[:, None] * way)).as_matrix()


def tangents(spec: Spec, at: FloatArray, places: FloatArray, units: Units) -> FloatArray:
    """Return the velocities (keys, 3) m/s at the keys: stated, else non-uniform Catmull-Rom."""
    keys = spec["keys"]
    if all("velocity" in key for key in keys):
        return numbers([key["velocity"] for key in keys]) * units.metres
    slopes = np.diff(places, axis=0) / np.diff(at)[:, None]
    before, after = np.diff(at)[:-1, None], np.diff(at)[1:, None]
    inner = (after * slopes[:-1] + before * slopes[1:]) / (before + after)
    return np.concatenate([slopes[:1], inner, slopes[-1:]])


def hermite(
    places: FloatArray,
    speeds: FloatArray,
    left: IntArray,
    right: IntArray,
    part: FloatArray,
    length: FloatArray,
) -> FloatArray:
    s, h = part[:, None], length[:, None]
    return (
        (1.0 + 2.0 * s) * (1.0 - s) ** 2 * places[left]
        + s * (1.0 - s) ** 2 * h * speeds[left]
        + s**2 * (3.0 - 2.0 * s) * places[right]
        + s**2 * (s - 1.0) * h * speeds[right]
    )


MOTIONS: dict[str, Callable[[Spec, FloatArray, Units], FloatArray]] = {
    "constant": ballistic,
    "ballistic": ballistic,
    "polynomial": polynomial,
    "screw": screw,
    "orbit": orbit,
    "harmonic": harmonic,
    "swing": swing,
    "profile": profile,
    "keyframes": keyframes,
}
