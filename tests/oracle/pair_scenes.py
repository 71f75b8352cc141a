"""Scenes of many pairs from a seed: near misses of every motion, sliding, chains, solids and open meshes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .couples import Bodies, built, host_below
from .draw import Draw, random_rotation
from .draw_motions import KINDS, random_motion
from .families.parts import shortened
from .poses import Kinematics
from .rigid import FloatArray
from .scenes import begun, depth, random_existence, random_margin, scene_of, write_document
from .surfaces import random_surface

FIRST_SEED = 20_000_000
"""Scenes of pairs take seeds from here."""

SHAPES = ("mesh", "mesh", "mesh", "mesh", "box", "sphere", "capsule")
ROUND = ("cylinder", "cone", "ellipsoid")

SKIMMING = (*KINDS, "keyframes")
SLIDING = ("constant", "ballistic", "screw", "orbit", "harmonic", "swing", "polynomial", "profile", "keyframes")

UP = np.array([0.0, 0.0, 1.0])


def write_pairs(number: int, folder: Path) -> Path:
    """Write the scene of this number, of 4 to 6 bodies, into the folder and return the scene file."""
    draw = begun(FIRST_SEED + number, folder)
    return write_document(scene_of_pairs(draw), draw)


def scene_of_pairs(draw: Draw) -> dict[str, Any]:
    """Return the document of a scene of 4 to 6 bodies, whose meshes and trajectories are written."""
    draw.surface = random_surface
    shortened(draw, draw.pick(0.75, 1.0, 1.5))
    bodies: Bodies = {}
    couples = (skimming_couple, sliding_couple)
    for index in range(draw.pick(1, 2, 2)):
        couple = draw.pick(*couples)
        bodies |= couple(draw, frame(draw, bodies), f"{index}")
    wanted = int(draw.rng.integers(4, 7))
    while sum("shapes" in body for body in bodies.values()) < wanted:
        bodies[f"body_{len(bodies)}"] = free_body(draw, bodies)
    names = list(bodies)
    draw.rng.shuffle(names)
    scene = scene_of(draw, {name: bodies[name] for name in names}, {})
    settings = scene.setdefault("settings", {})
    for key in ("margin", "distance_tolerance"):
        settings.pop(key, None)
    if draw.chance(0.1):
        settings["margin"] = draw.metres(0.1 * random_margin(draw))
    return scene


def frame(draw: Draw, bodies: Bodies) -> str | None:
    """Perhaps add a frame without shapes that moves, on another one or not, and return its name."""
    if draw.chance(0.5):
        return None
    name = f"frame_{len(bodies)}"
    above = [one for one in bodies if one.startswith("frame_")]
    bodies[name] = {"pose": draw.random_pose(0.5), "motion": random_motion(draw, vigour=0.5)}
    if above and draw.chance(0.5):
        bodies[name]["parent"] = draw.pick(*above)
    return name


def shape_of(draw: Draw, size: float) -> dict[str, Any]:
    """Write a shape, mostly a mesh, one in twenty of them round."""
    return draw.shape(size, ROUND if draw.chance(0.05) else SHAPES)


def free_body(draw: Draw, bodies: Bodies) -> dict[str, Any]:
    """Return a body of one or two shapes that moves about among the others, perhaps as the child of one."""
    shapes = [shape_of(draw, draw.size * draw.between(0.2, 0.5)) for _ in range(draw.pick(1, 1, 2))]
    for shape in shapes[1:]:
        shape["pose"] = draw.random_pose(0.3)
    body: dict[str, Any] = {"shapes": shapes, "pose": draw.random_pose(1.2)}
    parents = [name for name in bodies if depth(bodies, name) < 3]
    if draw.chance(0.3):
        body["parent"] = draw.pick(*parents)
    if draw.chance(0.05):
        body["motion"] = random_motion(draw, "limits")
    elif draw.chance(0.9):
        body["motion"] = random_motion(draw, vigour=draw.pick(0.5, 1.0, 2.0))
    if draw.chance(0.05):
        body["exists"] = random_existence(draw)
    return body


def skimming_couple(draw: Draw, parent: str | None, name: str) -> Bodies:
    """Return a guest of any motion, and a host whose top is where the guest comes lowest, but for a small gap."""
    guest = {"shapes": [shape_of(draw, 0.4 * draw.size)], "motion": random_motion(draw, draw.pick(*SKIMMING))}
    lowest = lowest_of(draw, guest)
    return placed(draw, guest, lowest, small_gap(draw), parent, f"skim_{name}")


def sliding_couple(draw: Draw, parent: str | None, name: str) -> Bodies:
    """Return a guest that moves along the top of a host at a small height, on a face, an edge or a corner."""
    motion = flattened(random_motion(draw, draw.pick(*SLIDING)))
    shape = shape_of(draw, 0.4 * draw.size)
    if draw.chance(0.75):
        shape["pose"] = draw.pose(np.zeros(3), random_rotation(draw.rng))
    guest = {"shapes": [shape], "motion": motion}
    lowest = lowest_of(draw, guest)
    return placed(draw, guest, lowest, small_gap(draw), parent, f"slide_{name}")


def small_gap(draw: Draw) -> float:
    """Return m: from 1e-5 to 3e-2 sizes, one in five times negative."""
    return draw.pick(1.0, 1.0, 1.0, 1.0, -1.0) * 10.0 ** draw.between(-5.0, -1.5) * draw.size


def placed(draw: Draw, guest: dict[str, Any], lowest: FloatArray, gap: float, parent: str | None, name: str) -> Bodies:
    """Return the guest and a host whose top is `gap` m below the guest's lowest point (3,) m."""
    if draw.chance(0.6):
        shape, height = host_below(draw)
        top = height * UP
    else:
        shape = draw.shape(0.7 * draw.size, ("mesh",))
        upside_down = {**shape, "pose": {"axis_angle": {"axis": [1, 0, 0], "angle": draw.radians(np.pi)}}}
        top = built(draw, [upside_down]).lowest() * [1.0, -1.0, -1.0]
    place = draw.rng.uniform(-0.5, 0.5, 3) * draw.size
    bodies: Bodies = {
        f"{name}_guest": {"pose": draw.pose(place, None), **guest},
        f"{name}_host": {"pose": draw.pose(place + lowest - gap * UP - top, None), "shapes": [shape]},
    }
    for body in bodies.values():
        if parent is not None:
            body["parent"] = parent
    return bodies


def lowest_of(draw: Draw, guest: dict[str, Any]) -> FloatArray:
    """Return (3,) m: the lowest point that a guest, in its parent's frame, reaches at any time, nearly."""
    surface = built(draw, guest["shapes"])
    units = {"units": {"length": draw.length, "angle": draw.angle}, "bodies": {"it": guest}}
    kinematics = Kinematics(units, draw.folder)
    corners, first = np.unique(surface.triangles.reshape(-1, 3), axis=0, return_index=True)
    radii = np.repeat(surface.radii + surface.slack, 3)[first]
    low, high, lowest = draw.start, draw.end, np.zeros(3)
    for _ in range(4):
        times = np.linspace(low, high, 101)
        poses = kinematics.world_from_body("it", times)
        heights = poses[:, 2, :3] @ corners.T + poses[:, 2, 3:] - radii
        when, which = np.unravel_index(heights.argmin(), heights.shape)
        low, high = times[max(when - 1, 0)], times[min(when + 1, 100)]
        lowest = poses[when, :3, :3] @ corners[which] + poses[when, :3, 3] - radii[which] * UP
    return lowest


def flattened(motion: dict[str, Any]) -> dict[str, Any]:
    """Return the motion with everything across the z axis left out: it goes along the plane and turns about z."""
    out = dict(motion)
    for key in ("velocity", "acceleration", "direction"):
        if key in out:
            out[key] = level(out[key])
    if "coefficients" in out:
        out["coefficients"] = [level(term) for term in out["coefficients"]]
    if "angular_velocity" in out:
        out["angular_velocity"] = [0.0, 0.0, out["angular_velocity"][2]]
    if "axis" in out:
        out["axis"] = level(out["axis"]) if out.get("kind") == "slide" else [0.0, 0.0, 1.0]
    if "start" in out:
        out |= {"start": [1.0, 0.0, 0.0]}
    if "pitch" in out:
        out["pitch"] = 0.0
    if "keys" in out:
        out["keys"] = [flat_key(key) for key in out["keys"]]
    return out


def level(vector: Any) -> list[float]:
    """Return a vector without its z."""
    x, y, _ = np.asarray(vector, dtype=float).tolist()
    return [x, y, 0.0]


def flat_key(key: dict[str, Any]) -> dict[str, Any]:
    """Return a key with its place, velocity and turn in the plane."""
    out = {name: value for name, value in key.items() if name in ("t", "name")}
    place = [row[3] for row in key["matrix"][:3]] if "matrix" in key else key.get("xyz", [0.0, 0.0, 0.0])
    out["xyz"] = level(place)
    if "velocity" in key:
        out["velocity"] = level(key["velocity"])
    if "axis_angle" in key:
        out["axis_angle"] = {"axis": [0.0, 0.0, 1.0], "angle": key["axis_angle"]["angle"]}
    return out
