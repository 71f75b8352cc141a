"""Two bodies made for each other: one that just touches or just misses the other, one that is inside the other."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .bodies import Surface, surface_of
from .draw import CRISP, Draw, random_rotation
from .draw_motions import random_motion
from .rigid import RADIANS, FloatArray, pose_of
from .sampling import TICK

Bodies = dict[str, dict[str, Any]]

DOWN = np.array([0.0, 0.0, -1.0])


def built(draw: Draw, shapes: list[dict[str, Any]]) -> Surface:
    """Return the surface of a body of these shapes, as read back from the files."""
    scene = {
        "units": {"length": draw.length, "angle": draw.angle},
        "meshes": draw.meshes,
        "bodies": {"it": {"shapes": shapes}},
    }
    return surface_of(scene, "it", draw.folder)


def grazing_couple(draw: Draw, parent: str | None, name: str) -> Bodies:
    """Return a guest whose lowest point just reaches, or just misses, the top of a host below it.

    Both live in one frame, which may move. The gap, from -1e-3 to 1e-3 sizes, is exact to rounding: it follows
    from the guest's support (slides) or reach (turns), not from sampling.
    """
    way = draw.pick("harmonic", "ballistic", "keyframes", "swing", "screw")
    turns = way in ("swing", "screw")
    shape = draw.shape(0.4 * draw.size, CRISP) if turns else draw.shape(0.4 * draw.size)
    shape["pose"] = draw.pose(np.zeros(3), random_rotation(draw.rng))
    if turns:
        lowest, motion = turning_guest(draw, shape, way)
    else:
        lowest, motion = sliding_guest(draw, shape, way)
    gap = draw.pick(-1.0, 1.0) * 10.0 ** draw.between(-7.0, -3.0) * draw.size
    host, depth = host_below(draw)
    top = lowest + gap * DOWN
    place = draw.rng.uniform(-0.5, 0.5, 3) * draw.size
    bodies: Bodies = {
        f"{name}_guest": {"pose": draw.pose(place, None), "shapes": [shape], "motion": motion},
        f"{name}_host": {"pose": draw.pose(place + top + depth * DOWN, None), "shapes": [host]},
    }
    for body in bodies.values():
        if parent is not None:
            body["parent"] = parent
    return bodies


def host_below(draw: Draw) -> tuple[dict[str, Any], float]:
    """Return a shape and how far (m) its top lies above its origin."""
    if draw.chance(0.6):
        sides = np.array([1.5, 1.5, 0.3]) * draw.size
        return {"box": draw.metres(sides)}, 0.15 * draw.size
    radius = draw.between(0.2, 0.5) * draw.size
    return {"sphere": draw.metres(radius)}, radius


def sliding_guest(draw: Draw, shape: dict[str, Any], way: str) -> tuple[FloatArray, dict[str, Any]]:
    """Return the lowest point (3,) m that the guest ever reaches, and its motion up and down."""
    lowest = built(draw, [shape]).lowest()
    travel = draw.between(0.3, 1.0) * draw.size
    if way == "harmonic":
        motion = random_motion(draw, "harmonic") | {"direction": [0, 0, 1], "amplitude": draw.metres(travel)}
        motion["period"] = draw.between(0.3, 1.9)
        return lowest + travel * DOWN, motion
    if way == "ballistic":
        turn_at = draw.start + draw.between(0.2, 0.8) * (draw.end - draw.start)
        acceleration = 2.0 * draw.between(0.5, 2.0) * draw.size / turn_at**2
        motion = {"type": "ballistic", "velocity": draw.metres(acceleration * turn_at * DOWN)}
        motion["acceleration"] = draw.metres(-acceleration * DOWN)
        return lowest + 0.5 * acceleration * turn_at**2 * DOWN, motion
    begin, end = round(draw.start / TICK), round(draw.end / TICK)
    ticks = [begin, int(draw.rng.integers(begin + 10, end - 10)), end]
    heights = (travel, 0.0, draw.between(0.1, 1.0) * draw.size)
    keys = [{"t": tick * TICK, "xyz": draw.metres(-height * DOWN)} for tick, height in zip(ticks, heights, strict=True)]
    return lowest, {"type": "keyframes", "keys": keys}


def turning_guest(draw: Draw, shape: dict[str, Any], way: str) -> tuple[FloatArray, dict[str, Any]]:
    """Turn the shape about x until its outermost corner is at the bottom; return that point and the motion."""
    surface = built(draw, [shape])
    corners = surface.triangles.reshape(-1, 3)
    tip = corners[np.linalg.norm(corners[:, 1:], axis=1).argmax()]
    reach = float(np.linalg.norm(tip[1:]))
    angle = -0.5 * np.pi - np.arctan2(tip[2], tip[1])
    inner = Rotation.from_matrix(inner_rotation(draw, shape))
    shape["pose"] = draw.pose(np.zeros(3), Rotation.from_rotvec([angle, 0.0, 0.0]) * inner)
    lowest = np.array([tip[0], 0.0, -reach - surface.radii[0]])
    motion = random_motion(draw, way) | {"axis": [1, 0, 0], "point": [0, 0, 0]}
    if way == "swing":
        motion |= {"amplitude": draw.radians(draw.between(0.5, 2.5)), "period": draw.between(0.4, 1.9)}
        return lowest, motion
    motion |= {"pitch": 0.0, "rate": draw.radians(draw.pick(-1.0, 1.0) * draw.between(3.5, 9.0))}
    return lowest, motion


def inner_rotation(draw: Draw, shape: dict[str, Any]) -> FloatArray:
    """Return the (3, 3) rotation that the shape's pose states."""
    return pose_of(shape["pose"], 1.0, RADIANS[draw.angle])[:3, :3]


def contained_couple(draw: Draw, parent: str | None, name: str) -> Bodies:
    """Return a large closed host and a small guest that starts inside it, perhaps to leave, or jumps into it."""
    hollow = {"box": draw.metres(np.full(3, 1.2 * draw.size))}
    host_shape = hollow if draw.chance(0.5) else draw.shape(1.3 * draw.size, ("mesh",))
    host: dict[str, Any] = {"shapes": [host_shape]}
    guest: dict[str, Any] = {"shapes": [draw.shape(0.1 * draw.size)]}
    guest["pose"] = draw.pose(draw.rng.uniform(-0.1, 0.1, 3) * draw.size, None)
    guest["motion"] = random_motion(draw, vigour=draw.pick(0.2, 1.0, 2.0))
    if draw.chance(0.3):
        host["motion"] = random_motion(draw, vigour=0.2)
    if parent is not None:
        host["parent"] = parent
        guest["parent"] = parent if draw.chance(0.5) else f"{name}_host"
    return {f"{name}_host": host, f"{name}_guest": guest}
