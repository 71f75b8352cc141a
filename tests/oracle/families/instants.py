"""Families in which single instants decide: jumps, the start, the end."""

from __future__ import annotations

import numpy as np

from ..draw import Draw, random_rotation
from ..draw_motions import random_motion
from ..rigid import FloatArray
from ..scenes import Bodies
from .parts import Spec, body, box, shortened, small, some_turn


def knots_with_jumps(draw: Draw) -> Bodies:
    """Bodies that jump: onto, into and out of each other, at one time, at the very end, where a loop begins anew."""
    shortened(draw, draw.pick(1.0, 2.0))
    count = round((draw.end - draw.start) * 64)
    common = sorted(draw.rng.choice(np.arange(1, count), 3, replace=False).tolist())
    bodies: Bodies = {}
    for index in range(int(draw.rng.integers(2, 4))):
        ticks = common if draw.chance(0.5) else sorted(draw.rng.choice(np.arange(1, count), 3, replace=False).tolist())
        spot = draw.rng.uniform(-0.5, 0.5, 3) * draw.size
        motion = jumps(draw, [0, *ticks, count])
        bodies[f"body_{index}"] = body(draw, draw.shape(0.35 * draw.size), spot, some_turn(draw), motion=motion)
    if draw.chance(0.4):
        bodies["still"] = body(draw, draw.shape(0.4 * draw.size), np.zeros(3))
    if draw.chance(0.4):
        cut = (draw.start + ticks_to(draw, common[0]), draw.end + draw.pick(0.0, 1.0))
        bodies["body_0"]["exists"] = list(cut)
    return bodies


def ticks_to(draw: Draw, tick: int) -> float:
    """Return s after the start; mostly a round number."""
    return tick / 64.0 if draw.chance(0.8) else tick / 64.0 + draw.between(-0.01, 0.01) / 64.0


def jumps(draw: Draw, ticks: list[int]) -> Spec:
    """Write steps of the place, of the turn, or of both, at ticks after the start; or half of them, over and over."""
    keys = []
    for tick in ticks:
        pose = draw.pose(draw.rng.uniform(-0.6, 0.6, 3) * draw.size, random_rotation(draw.rng))
        while "matrix" in pose:
            pose = draw.pose(draw.rng.uniform(-0.6, 0.6, 3) * draw.size, random_rotation(draw.rng))
        keys.append({"t": draw.start + tick / 64.0, **pose})
    ways = draw.pick(("step", "step"), ("step", "slerp"), ("linear", "step"), ("cubic", "step"))
    out: Spec = {"type": "keyframes", "keys": keys}
    out["interpolation"] = {"translation": ways[0], "rotation": ways[1]}
    if draw.chance(0.4):
        del keys[draw.pick(2, 3) :]
        out["after"] = draw.pick("loop", "loop", "hold")
        if draw.chance(0.4):
            out |= {"t0": 1.0 / 64.0 * draw.pick(1, 5, 20), "before": draw.pick("loop", "hold")}
        if draw.chance(0.5):  # a loop without steps inside whose ends differ
            out["interpolation"] = {"translation": "linear", "rotation": "slerp"}
    return out


def contact_at_the_start(draw: Draw) -> Bodies:
    """A body that stands on, in, or a hair above another at the start, and leaves, slides, sinks or stays."""
    shortened(draw, 1.0)
    return {"low": lower(draw), "high": upper(draw, touching_at=draw.start)}


def contact_at_the_end(draw: Draw) -> Bodies:
    """A body that reaches another at the very end, or would a hair later, or jumps there."""
    shortened(draw, 1.0)
    if draw.chance(0.3):
        inside = draw.metres(draw.rng.uniform(-0.05, 0.05, 3) * draw.size)
        keys = [{"t": draw.start, "xyz": draw.metres(np.array([0.0, 0.0, draw.size]))}, {"t": draw.end, "xyz": inside}]
        steps = {"type": "keyframes", "keys": keys, "interpolation": {"translation": "step"}}
        return {"low": lower(draw), "high": body(draw, draw.shape(0.05 * draw.size), np.zeros(3), motion=steps)}
    return {"low": lower(draw), "high": upper(draw, touching_at=draw.end)}


def lower(draw: Draw) -> Spec:
    """Write a body whose top is at z = 0.2 sizes above its middle."""
    height = 0.2 * draw.size
    shape = draw.pick(
        box(draw, draw.size, draw.size, 2.0 * height),
        {"sphere": draw.metres(height)},
        {"cylinder": {"radius": draw.metres(0.5 * draw.size), "length": draw.metres(2.0 * height)}},
        {"ellipsoid": draw.metres(np.array([0.5 * draw.size, 0.3 * draw.size, height]))},
    )
    return body(draw, shape, np.zeros(3))


def upper(draw: Draw, touching_at: float) -> Spec:
    """Write a body that touches the lower one at a time (s), but for a small gap or depth, or none."""
    half = 0.15 * draw.size
    shape = draw.pick(
        box(draw, 2.0 * half, 2.0 * half, 2.0 * half),
        {"sphere": draw.metres(half)},
        {"cone": {"radius": draw.metres(half), "length": draw.metres(2.0 * half)}},
        {"ellipsoid": draw.metres(np.array([half, half, half]))},
    )
    gap = draw.pick(0.0, small(draw, -13.0, -6.0), small(draw, -6.0, -2.0))
    away = np.array([0.0, 0.0, 1.0 if touching_at == draw.start else -1.0])
    return body(
        draw,
        shape,
        np.array([0.0, 0.0, 0.2 * draw.size + half + gap]),
        motion={"t0": touching_at, **approach(draw, away)},
    )


def approach(draw: Draw, away: FloatArray) -> Spec:
    """Write a motion that is at rest's pose at t = 0; mostly one along `away` (3,)."""
    speed = draw.size * 10.0 ** draw.between(-3.0, 0.5)
    way = draw.pick("line", "line", "curve", "aside", "sine", "spin", "other")
    if way == "line":
        return {"type": "constant", "velocity": draw.metres(away * speed)}
    if way == "curve":
        lift = np.array([0.0, 0.0, 1.0]) * speed
        return {"type": "polynomial", "coefficients": [[0, 0, 0], [0, 0, 0], draw.metres(lift)]}
    if way == "aside":
        return {"type": "ballistic", "velocity": draw.metres(np.array([speed, 0.0, 0.0]))}
    if way == "sine":
        return {"type": "harmonic", "direction": away.tolist(), "amplitude": draw.metres(speed), "period": 4.0}
    if way == "spin":
        return {"type": "constant", "angular_velocity": draw.radians(np.array([0.0, 0.0, draw.between(1.0, 9.0)]))}
    return random_motion(draw, "ballistic")
