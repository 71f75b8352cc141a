"""Scenes of bodies that only translate, along straight lines from key to key, as other programs take them."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from .couples import Bodies
from .draw import Draw, random_rotation
from .families.parts import shortened
from .rigid import FloatArray, IntArray
from .sampling import TICK
from .scenes import begun, scene_of, write_document
from .surfaces import random_surface
from .truth import Pair, Truth

FIRST_SEED = 40_000_000
"""Scenes of translating bodies take seeds from here."""


def write_translations(number: int, folder: Path) -> Path:
    """Write the scene of this number, five bodies that start apart and pass the middle, and return the scene file."""
    draw = begun(FIRST_SEED + number, folder)
    draw.surface = random_surface
    shortened(draw, 1.0)
    bodies: Bodies = {}
    for index in range(5):
        bodies[f"body_{index}"] = translating_body(draw, index)
    scene = scene_of(draw, bodies, {})
    scene.get("settings", {}).pop("margin", None)
    return write_document(scene, draw)


def translating_body(draw: Draw, index: int) -> dict[str, Any]:
    """Return one of a body in the middle, the first, and others that fly past or into it and each other."""
    body: dict[str, Any] = {"shapes": [draw.shape(0.3 * draw.size, ("mesh", "mesh", "mesh", "box"))]}
    if index == 0 and draw.chance(0.5):
        return body | {"pose": draw.pose(np.zeros(3), random_rotation(draw.rng))}
    away = draw.direction() * draw.between(0.8, 1.3) * draw.size
    past = draw.rng.uniform(-0.25, 0.25, 3) * draw.size
    turn = random_rotation(draw.rng)
    there = turn.inv().apply(past - away)
    body["pose"] = draw.pose(away, turn)
    if draw.chance(0.5):
        body["motion"] = {"type": "constant", "velocity": draw.metres(2.0 * there), "t0": draw.start}
        return body
    begin, end = round(draw.start / TICK), round(draw.end / TICK)
    ticks = [begin, *sorted(draw.rng.choice(np.arange(begin + 4, end - 4), 2, replace=False).tolist()), end]
    places = [np.zeros(3), 0.8 * there, 1.2 * there, 1.5 * there + draw.rng.uniform(-0.3, 0.3, 3) * draw.size]
    keys = [{"t": tick * TICK, "xyz": draw.metres(place)} for tick, place in zip(ticks, places, strict=True)]
    return body | {"motion": {"type": "keyframes", "keys": keys}}


def start_apart(truth: Truth, pair: Pair) -> bool:
    """Tell whether two bodies do not touch, nor one is inside the other, at the start."""
    return bool(truth.signed(*pair, np.array([truth.start]))[0] > truth.tolerance)


def straight_pieces(truth: Truth, pair: Pair) -> list[tuple[float, float]]:
    """Return the times (s) between which two bodies move along straight lines."""
    knots = truth.kinematics.knots(*pair, start=truth.start, end=truth.end)
    times = np.unique([truth.start, *knots, truth.end]).tolist()
    return list(pairwise(times))


def welded(truth: Truth, pair: Pair, time: float) -> tuple[FloatArray, IntArray, IntArray]:
    """Return two bodies at a time (s) as one mesh in the first one's frame.

    Returns:
        (n, 3) m, the vertices; (n,) 0 or 1, whose they are; (m, 3) the triangles by their vertices.
    """
    vertices, owners, faces, count = [], [], [], 0
    poses = (np.eye(4), truth.kinematics.relative(*pair, np.array([time]))[0])
    for owner, (name, pose) in enumerate(zip(pair, poses, strict=True)):
        points, index = np.unique(truth.surfaces[name].triangles.reshape(-1, 3), axis=0, return_inverse=True)
        vertices.append(points @ pose[:3, :3].T + pose[:3, 3])
        owners.append(np.full(len(points), owner))
        faces.append(index.reshape(-1, 3) + count)
        count += len(points)
    return np.concatenate(vertices), np.concatenate(owners), np.concatenate(faces)
