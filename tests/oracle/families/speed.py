"""Families in which bounds on speed decide: fast spins, long levers, velocities that cancel."""

from __future__ import annotations

import numpy as np

from ..draw import Draw, random_rotation
from ..draw_motions import random_motion
from ..rigid import FloatArray
from ..scenes import Bodies
from .parts import Spec, body, box, shortened, small, some_turn


def fast_spin(draw: Draw) -> Bodies:
    """A rotor at up to 5000 rad/s beside something that it just misses, just touches, or strikes; another flies by."""
    shortened(draw, draw.pick(0.1, 0.2))
    rate = 10.0 ** draw.between(1.5, 3.7)
    length = draw.between(0.5, 1.5) * draw.size
    thick = length * 10.0 ** draw.between(-2.0, -0.5)
    rotor = draw.pick(
        box(draw, length, thick, thick),
        {"ellipsoid": draw.metres(np.array([0.5 * length, thick, thick]))},
        draw.shape(0.5 * length, ("mesh",)),
    )
    tip = 0.5 * np.hypot(length, thick) if "box" in rotor else 0.5 * length
    motion = draw.pick(
        {"type": "constant", "angular_velocity": draw.radians(np.array([0.0, 0.0, rate]))},
        {"type": "screw", "axis": [0, 0, 1], "rate": draw.radians(rate), "pitch": draw.metres(0.01 * draw.size)},
        {"type": "swing", "axis": [0, 0, 1], "amplitude": draw.radians(draw.between(0.5, 3.0)), "period": 20.0 / rate},
        {
            "type": "orbit",
            "axis": [0, 0, 1],
            "start": [1, 0, 0],
            "radius": draw.metres(0.1 * length),
            "rate": draw.radians(rate),
            "facing": True,
        },
    )
    if motion["type"] == "orbit":
        tip += 0.1 * length
    radius = 0.1 * draw.size
    wall = draw.pick(
        {"sphere": draw.metres(radius)}, {"cylinder": {"radius": draw.metres(radius), "length": draw.metres(draw.size)}}
    )
    gap = draw.pick(small(draw, -6.0), -draw.between(0.0, 0.3) * draw.size)
    bodies = {
        "rotor": body(draw, rotor, np.zeros(3), motion=motion),
        "post": body(draw, wall, np.array([tip + radius + gap, 0.0, 0.0])),
    }
    if draw.chance(0.5):
        bodies["fly"] = body(
            draw, draw.shape(0.05 * draw.size), draw.direction() * draw.size, motion=random_motion(draw, vigour=3.0)
        )
    return bodies


def long_bars(draw: Draw) -> Bodies:
    """Bars 100 to 2000 times as long as thick that turn past each other, a little apart or not."""
    shortened(draw, 1.0)
    length = draw.between(1.0, 5.0) * draw.size
    thick = length * 10.0 ** draw.between(-3.3, -2.0)
    gap = draw.pick(small(draw, -8.0, -3.0), 0.0, draw.between(-0.5, 0.5) * thick)
    level = np.array([0.0, 0.0, thick + gap])
    place = draw.rng.uniform(-0.4, 0.4, 3) * length * [1.0, 1.0, 0.0]
    bodies = {
        "low": body(draw, bar(draw, length, thick), np.zeros(3), motion=turning(draw, length)),
        "high": body(draw, bar(draw, length, thick), place + level, motion=turning(draw, length)),
    }
    if draw.chance(0.5):
        bodies["post"] = body(draw, draw.shape(5.0 * thick), draw.rng.uniform(-0.4, 0.4, 3) * length * [1.0, 1.0, 0.0])
    return bodies


def bar(draw: Draw, length: float, thick: float) -> Spec:
    """Write a bar along x."""
    along = {"axis_angle": {"axis": [0, 1, 0], "angle": draw.radians(0.5 * np.pi)}}
    radius, core = draw.metres(0.5 * thick), draw.metres(length)
    return draw.pick(
        box(draw, length, thick, thick),
        {"capsule": {"radius": radius, "length": core}, "pose": along},
        {"cylinder": {"radius": radius, "length": core}, "pose": along},
        {"ellipsoid": draw.metres(np.array([0.5 * length, 0.5 * thick, 0.5 * thick]))},
    )


def turning(draw: Draw, length: float) -> Spec | None:
    """Write a turn about z, some way along a bar."""
    point = draw.metres(np.array([draw.between(-0.5, 0.5) * length, 0.0, 0.0]))
    rate = draw.radians(draw.between(-6.0, 6.0))
    return draw.pick(
        {"type": "screw", "axis": [0, 0, 1], "point": point, "rate": rate},
        {"type": "swing", "axis": [0, 0, 1], "point": point, "amplitude": draw.radians(1.0), "period": 0.7},
        {"type": "constant", "velocity": draw.metres(np.array([0.0, length, 0.0])), "angular_velocity": [0, 0, rate]},
        {"type": "profile", "kind": "turn", "axis": [0, 0, 1], "point": point, "from": 0, "to": draw.radians(3.0)}
        | {"max_velocity": draw.radians(8.0), "max_acceleration": draw.radians(60.0), "t0": draw.start},
    )


def cancelling_velocities(draw: Draw) -> Bodies:
    """Two bodies that move fast and nearly alike: freely, or the one back in the other's frame."""
    shortened(draw, 1.0)
    speed = 10.0 ** draw.between(1.0, 4.0) * draw.size
    one, other = draw.shape(0.3 * draw.size), draw.shape(0.3 * draw.size)
    apart = draw.direction() * draw.between(0.5, 1.0) * draw.size
    turn = some_turn(draw)
    if draw.chance(0.5):
        common = draw.direction() * speed
        return {
            "one": body(draw, one, np.zeros(3), turn, motion=flying(draw, common)),
            "other": body(draw, other, apart, random_rotation(draw.rng), motion=flying(draw, common)),
        }
    axis, rate = draw.direction(), draw.between(3.0, 300.0)
    carrier = {"type": "constant", "angular_velocity": draw.radians(axis * rate)}
    back = {"type": "constant", "angular_velocity": draw.radians(-axis * rate * (1.0 + draw.pick(0.0, 1e-6, 1e-3)))}
    return {
        "carrier": {"motion": carrier},
        "carried": body(draw, one, np.zeros(3), parent="carrier", motion=back),
        "free": body(draw, other, apart, turn, motion=random_motion(draw, "harmonic", vigour=0.5)),
    }


def flying(draw: Draw, common: FloatArray) -> Spec:
    """Write a flight at the common velocity (3,) m/s and a little of its own."""
    own = draw.direction() * draw.between(0.0, 1.0) * draw.size
    if draw.chance(0.5):
        velocity = draw.metres(common + own)
        return {"type": "constant", "velocity": velocity, "angular_velocity": draw.radians(draw.direction())}
    terms = [np.zeros(3), common + own, common, -common + draw.direction() * 0.3 * draw.size]
    return {"type": "polynomial", "coefficients": [draw.metres(term) for term in terms], "t0": draw.start}
