"""Families in which rounding decides: faces that are nearly parallel, places a million metres away."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from ..draw import Draw
from ..draw_motions import random_motion
from ..scenes import Bodies
from .parts import Spec, body, box, shortened, small


def parallel_sliding(draw: Draw) -> Bodies:
    """A flat body that slides over another, a hair apart or in it, tilted by a hair or not at all."""
    shortened(draw, 1.0)
    tilt = draw.pick(0.0, 10.0 ** draw.between(-12.0, -3.0))
    gap = draw.pick(0.0, small(draw, -10.0, -3.0), small(draw, -4.0, -1.0))
    lift = 0.3 * draw.size + 0.5 * draw.size * np.sin(tilt) + gap
    turn = Rotation.from_rotvec(np.array([np.cos(1.0), np.sin(1.0), 0.0]) * tilt) if tilt else None
    slide = draw.pick(
        {"type": "harmonic", "direction": [1, 0, 0], "amplitude": draw.metres(draw.size), "period": 1.3},
        {"type": "constant", "velocity": draw.metres(np.array([2.0, 0.3, 0.0]) * draw.size)},
        {"type": "constant", "angular_velocity": draw.radians(np.array([0.0, 0.0, 5.0]))},
        {"type": "orbit", "axis": [0, 0, 1], "start": [1, 0, 0], "radius": draw.metres(0.5 * draw.size), "rate": 300},
        {"type": "profile", "kind": "slide", "axis": [1, 0, 0], "from": draw.metres(-draw.size)}
        | {"to": draw.metres(draw.size), "max_velocity": draw.metres(3.0 * draw.size)}
        | {"max_acceleration": draw.metres(20.0 * draw.size), "t0": draw.start},
    )
    flat = [
        box(draw, draw.size, draw.size, 0.3 * draw.size),
        {"cylinder": {"radius": draw.metres(0.5 * draw.size), "length": draw.metres(0.3 * draw.size)}},
    ]
    bodies = {
        "low": body(draw, draw.pick(*flat), np.zeros(3)),
        "high": body(draw, draw.pick(*flat), np.array([0.0, 0.0, lift]), turn, motion=slide),
    }
    if draw.chance(0.5):
        carrier: Spec = {"motion": random_motion(draw, vigour=1.0), "pose": draw.random_pose(1.0)}
        return {"carrier": carrier, **{name: {"parent": "carrier", **one} for name, one in bodies.items()}}
    return bodies


def far_offsets(draw: Draw) -> Bodies:
    """An ordinary couple or three a million metres from the origin: by their own poses, or by their parent's."""
    shortened(draw, 1.0)
    offset = draw.direction() * 1e6
    bodies: Bodies = {}
    for index in range(int(draw.rng.integers(2, 4))):
        place = draw.rng.uniform(-0.8, 0.8, 3) * draw.size
        bodies[f"body_{index}"] = body(draw, draw.shape(0.35 * draw.size), place)
        if index or draw.chance(0.5):
            bodies[f"body_{index}"]["motion"] = random_motion(draw)
    if draw.chance(0.5):
        carrier: Spec = {"pose": draw.pose(offset, None)}
        if draw.chance(0.6):
            carrier["motion"] = random_motion(draw, vigour=draw.pick(1.0, 100.0))
        return {"carrier": carrier, **{name: {"parent": "carrier", **one} for name, one in bodies.items()}}
    for one in bodies.values():
        pose = one["pose"]
        if "matrix" in pose:
            for row, shift in zip(pose["matrix"], draw.metres(offset), strict=False):
                row[3] += shift
        else:
            pose["xyz"] = (np.array(pose["xyz"]) + draw.metres(offset)).tolist()
    return bodies
