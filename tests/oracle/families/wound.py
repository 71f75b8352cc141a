"""Families of meshes whose winding numbers mislead: parts wound opposite ways, faces turned over, a part in itself."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..bodies import BOX_CORNERS, BOX_TRIANGLES
from ..draw import Draw, random_rotation
from ..rigid import METRES, FloatArray
from ..scenes import Bodies
from ..solids import random_solid, write_mesh
from .nested import jumping
from .parts import Spec, body, shortened, some_turn


def opposite_parts(draw: Draw) -> Bodies:
    """Two boxes of one mesh that overlap, one of them wound inwards; a body in the overlap, in one, or beside both."""
    sides = draw.rng.uniform(0.8, 1.2, (2, 3))
    shift = draw.rng.uniform(0.55, 0.75, 3) * draw.pick(1.0, -1.0) * sides.min(axis=0)
    one, other = box_of(sides[0], np.zeros(3)), box_of(sides[1], shift)
    mesh = np.concatenate(draw.pick([one, other[:, ::-1]], [one[:, ::-1], other]))
    return beside(draw, mesh, draw.pick(0.5 * shift, 0.5 * shift, -0.3 * shift, 1.2 * shift, -1.5 * shift), 0.05)


def turned_faces(draw: Draw) -> Bodies:
    """A closed mesh, some or half of its faces turned over, and a body inside it, or at a place in its box."""
    mesh = random_solid(draw.rng) if draw.chance(0.6) else box_of(draw.rng.uniform(0.8, 1.6, 3), np.zeros(3))
    turned = draw.rng.random(len(mesh)) < draw.pick(0.05, 0.5, 0.9, 1.0)
    mesh[turned] = mesh[turned][:, ::-1]
    return beside(draw, mesh, draw.pick(np.zeros(3), draw.rng.uniform(-0.5, 0.5, 3)), 0.05)


def joined_parts(draw: Draw) -> Bodies:
    """Two boxes that overlap, joined by a handle into one part that crosses itself; a body in the overlap or beside."""
    shift = draw.rng.uniform(0.45, 0.7, 3) * (1.0, 1.0, 0.3)
    mesh = joined_boxes(shift, inwards=False)
    if draw.chance(0.3):
        mesh = mesh[:, ::-1]
    return beside(draw, mesh, draw.pick(0.5 * shift, 0.5 * shift, -0.2 * shift, np.array([0.0, 0.0, 0.9])), 0.05)


def cavities(draw: Draw) -> Bodies:
    """A box with cavities that overlap or lie apart, perhaps an island in one, turned over or not; a body in one."""
    outer = box_of(np.full(3, 2.0), np.zeros(3))
    places = [np.array([-0.3, 0.05, 0.02]), np.array([draw.pick(0.25, 0.55), -0.04, 0.07])]
    holes = [box_of(draw.rng.uniform(0.5, 0.7, 3), place)[:, ::-1] for place in places]
    island = [box_of(draw.rng.uniform(0.05, 0.15, 3), places[0])] if draw.chance(0.4) else []
    mesh = np.concatenate([outer, *holes, *island])
    if draw.chance(0.3):
        mesh = mesh[:, ::-1]
    return beside(draw, mesh, draw.pick(0.5 * sum(places), *places, np.full(3, 0.8)), 0.04)


def beside(draw: Draw, mesh: FloatArray, place: FloatArray, size: float) -> Bodies:
    """Write a body that shows a mesh of about 1, and one of this size at a place in it that rests, shakes or jumps."""
    shortened(draw, 1.0)
    name, unit = "wound", draw.pick("m", "mm")
    file = f"{name}.{draw.pick('obj', 'stl')}"
    write_mesh(draw.folder / file, mesh * draw.size / METRES[unit], draw.seed)
    draw.meshes[name] = {"file": file, "units": unit}
    shape: Spec = {"mesh": name}
    turn = random_rotation(draw.rng)
    guest = draw.shape(size * draw.size, ("box", "sphere", "capsule"))
    at = turn.apply(np.asarray(place)) * draw.size
    motion = jumping(draw, 0.5 * draw.size) if draw.chance(0.3) else swaying(draw, 0.1 * draw.size)
    return {
        "mesh": body(draw, shape, np.zeros(3), turn, motion=swaying(draw, 0.05 * draw.size)),
        "guest": body(draw, guest, at, some_turn(draw), motion=motion),
    }


def swaying(draw: Draw, reach: float) -> Spec:
    """Write a slow swaying by `reach` m."""
    amplitude = draw.metres(draw.between(0.1, 1.0) * reach)
    return {"type": "harmonic", "direction": draw.direction().tolist(), "amplitude": amplitude, "period": 1.7}


def box_of(sides: FloatArray, place: FloatArray) -> FloatArray:
    """Return the outward triangles (12, 3, 3) of a box about a place."""
    return (BOX_CORNERS * sides + place)[BOX_TRIANGLES]


def joined_boxes(shift: FloatArray, inwards: bool) -> FloatArray:
    """Return the triangles of two unit cubes, the second moved, joined by a handle over both into one part.

    With `inwards` the handle turns inside out on its way, so that the second cube is wound the other way.
    """
    ring = np.array([(-0.1, -0.1, 0.0), (0.1, -0.1, 0.0), (0.1, 0.1, 0.0), (-0.1, 0.1, 0.0)])
    up = np.array([0.0, 0.0, 1.0])
    first, second = holed_cube(), holed_cube() + shift
    rings = [ring + 0.5 * up, ring + 1.5 * up]
    if not inwards:
        upright = np.column_stack((0.0 * ring[:, 0], ring[:, 1], -ring[:, 0]))
        rings.append(upright + 0.5 * shift + 2.5 * up)
        ring = ring * (-1.0, 1.0, 1.0)
    else:
        second = second[:, ::-1]
    rings += [ring + shift + 2.0 * up, ring + shift + 0.5 * up]
    return np.round(np.concatenate([first, second, *(wall(*two) for two in pairwise(rings))]), 9)


def holed_cube() -> FloatArray:
    """Return the outward triangles of a unit cube with a hole of 0.2 in its upper face."""
    cube = box_of(np.ones(3), np.zeros(3))
    lid = (cube[:, :, 2] > 0.0).all(axis=1)
    around = 0.5 * np.array([(-1.0, -1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, 1.0), (-1.0, 1.0, 1.0)])
    return np.concatenate([cube[~lid], wall(around, around * (0.2, 0.2, 1.0))])


def wall(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the triangles between two rings (k, 3) of points."""
    beside_low, beside_high = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
    return np.concatenate(
        [np.stack([low, beside_low, beside_high], axis=1), np.stack([low, beside_high, high], axis=1)]
    )
