"""The motions of the scene file as (n, 4, 4) matrices at n times, each from its formula in the scene format."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .rigid import FloatArray, about_point, numbers, rigid, rotations, unit

ZERO = (0.0, 0.0, 0.0)
Spec = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Units:
    """What one unit of the file is, in m and in rad."""

    metres: float
    radians: float


def known(word: str, *words: str) -> str:
    """Return the word, which must be one of those that the oracle knows."""
    if word not in words:
        raise NotImplementedError(f"the oracle knows {', '.join(words)}, not {word!r}")
    return word


def motion_at(spec: Spec, times: FloatArray, units: Units) -> FloatArray:
    """Return matrices (n, 4, 4) at scene times (n,) s of any motion but the paths (see paths)."""
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
    """Return sin(2 pi t / period + phase), (n,); after many periods the remainder, which is exact."""
    phase, period = float(spec.get("phase", 0.0)) * units.radians, float(spec["period"])
    return np.sin(2.0 * np.pi * np.fmod(t, period) / period + phase)


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
    slides = known(spec["kind"], "slide", "turn") == "slide"
    scale = units.metres if slides else units.radians
    begin, end = float(spec["from"]) * scale, float(spec["to"]) * scale
    gone = trapezoid(t, abs(end - begin), float(spec["max_velocity"]) * scale, float(spec["max_acceleration"]) * scale)
    value = begin + np.sign(end - begin) * gone
    axis = unit(spec["axis"])
    if slides:
        return rigid(None, value[:, None] * axis)
    return about_point(rotations(axis, value), numbers(spec.get("point", ZERO)) * units.metres)


def limits(spec: Spec, t: FloatArray, units: Units) -> FloatArray:
    """Return one of the paths within the limits: straight on as fast as may be, turning about the way."""
    velocity = numbers(spec.get("velocity", ZERO))
    begin = float(np.linalg.norm(velocity))
    way = velocity / begin if begin > 0.0 else np.array([1.0, 0.0, 0.0])
    most, steepness = (float(spec.get(key, np.inf)) for key in ("max_speed", "max_acceleration"))
    since = np.maximum(t, 0.0)
    if np.isinf(steepness):
        gone = most * since
    else:
        rising = np.minimum(since, (most - begin) / steepness if steepness > 0.0 else np.inf)
        cruising = np.where(since > rising, since - rising, 0.0)
        gone = begin * rising + 0.5 * steepness * rising**2 + (begin + steepness * rising) * cruising
    turn = rotations(way, float(spec.get("max_angular_speed", 0.0)) * units.radians * since)
    return rigid(turn, (gone * units.metres)[:, None] * way)


MOTIONS: dict[str, Callable[[Spec, FloatArray, Units], FloatArray]] = {
    "constant": ballistic,
    "ballistic": ballistic,
    "polynomial": polynomial,
    "screw": screw,
    "orbit": orbit,
    "harmonic": harmonic,
    "swing": swing,
    "profile": profile,
    "limits": limits,
}
