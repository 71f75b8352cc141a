"""Families of bodies in bodies and frames on frames."""

from __future__ import annotations

import numpy as np

from ..draw import Draw, random_rotation
from ..draw_motions import random_motion
from ..scenes import Bodies
from .parts import Spec, body, box, hollow_box, shortened, small, some_turn


def nested_shells(draw: Draw) -> Bodies:
    """Boxes with cavities, one in the other, and a kernel inside that rattles, leaves, or jumps from place to place."""
    shortened(draw, draw.pick(1.0, 2.0))
    bodies: Bodies = {}
    side = draw.between(1.0, 2.0) * draw.size
    for level in range(int(draw.rng.integers(1, 4))):
        wall = draw.between(0.02, 0.1) * side
        outer = np.full(3, side) * (1.0 + draw.pick(0.0, 0.3) * draw.rng.random(3))
        shape = hollow_box(draw, outer, wall) if draw.chance(0.8) else {"box": draw.metres(outer)}
        bodies[f"shell_{level}"] = body(draw, shape, np.zeros(3), motion=shaking(draw, 0.2 * side))
        side = (side - 2.0 * wall) * draw.between(0.45, 0.75)
    kernel = draw.shape(0.3 * side)
    bodies["kernel"] = body(draw, kernel, draw.rng.uniform(-0.1, 0.1, 3) * side, some_turn(draw))
    bodies["kernel"]["motion"] = (
        jumping(draw, side) if draw.chance(0.4) else shaking(draw, side) or {"type": "constant"}
    )
    if draw.chance(0.3):
        bodies["kernel"]["parent"] = "shell_0"
    return bodies


def shaking(draw: Draw, reach: float) -> Spec | None:
    """Write a motion of about `reach` m, or none."""
    if draw.chance(0.3):
        return None
    return random_motion(draw, draw.pick("harmonic", "swing", "orbit", "constant"), vigour=0.5 * reach / draw.size)


def jumping(draw: Draw, reach: float) -> Spec:
    """Write steps from the middle to anywhere within 2 `reach` m and back."""
    count = round((draw.end - draw.start) * 64)
    ticks = sorted(draw.rng.choice(np.arange(1, count), 4, replace=False).tolist())
    keys = []
    for i, tick in enumerate([0, *ticks, count]):
        place = np.zeros(3) if i % 2 == 0 else draw.rng.uniform(-2.0, 2.0, 3) * reach
        keys.append({"t": draw.start + tick / 64.0, "xyz": draw.metres(place), "name": f"place {i}"})
    return {"type": "keyframes", "keys": keys, "interpolation": {"translation": "step"}}


def shared_parents(draw: Draw) -> Bodies:
    """Siblings that move little on a chain of frames that moves much; the frames have shapes of their own, or not."""
    shortened(draw, 1.0)
    bodies: Bodies = {}
    parent = None
    for level in range(int(draw.rng.integers(2, 6))):
        frame: Spec = {"pose": draw.random_pose(2.0), "motion": random_motion(draw, vigour=draw.pick(1.0, 30.0))}
        if parent is not None:
            frame["parent"] = parent
        parent = f"frame_{level}"
        bodies[parent] = frame
    if draw.chance(0.4):
        bodies[parent or ""]["shapes"] = [draw.shape(0.2 * draw.size)]
    side = 0.4 * draw.size
    gap = draw.pick(small(draw, -8.0, -3.0), draw.between(0.0, 0.5) * side)
    for index, place in enumerate((np.zeros(3), np.array([side + gap, 0.0, 0.0]))):
        slide = {"direction": [0, 1, 0], "amplitude": draw.metres(draw.between(0.1, 2.0) * side), "period": 0.6}
        motion = draw.pick(None, {"type": "harmonic", **slide}, random_motion(draw, vigour=0.3))
        if index == 1:
            motion = motion or {"type": "harmonic", **slide}
        shape = box(draw, side, side, side) if draw.chance(0.6) else draw.shape(0.5 * side)
        bodies[f"sibling_{index}"] = body(draw, shape, place, parent=parent, motion=motion)
    if draw.chance(0.5):
        child = draw.shape(0.2 * side)
        turn = random_rotation(draw.rng)
        bodies["child"] = body(
            draw, child, np.array([0.0, side, 0.0]), turn, parent="sibling_1", motion=random_motion(draw)
        )
    names = list(bodies)
    draw.rng.shuffle(names)
    return {name: bodies[name] for name in names}
