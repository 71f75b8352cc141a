"""Warnings of sizes that look like a mistaken unit, and of places too far away for the sizes that are there.

And faults, where those are so far away that floating point cannot place the body at all.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import sqrt

import numpy as np

from ....scheduler.geometry.arrays import FloatArray
from ....scheduler.geometry.vector import ZERO
from ....scheduler.kinematics.chain import chain_to
from ....scheduler.model.extent import Ball, Extent
from ....scheduler.model.scene import Body, Mesh, Scene, Shape
from ....scheduler.model.world_poses import WorldPoses
from ....scheduler.motions import Fixed, Interval
from ..limits import COARSE_PLACE, COARSE_TERMS, MOST_ROUNDING, UNLIKELY_RATIO
from ..text.document import Findings
from ..text.errors import Where, counted


def check_sizes(scene: Scene, names: tuple[str, ...], files: Mapping[Mesh, str], findings: Findings) -> None:
    """Warn where a mesh file's size, or a body's distance from the origin, is such as only a wrong unit would explain.

    A body that floats cannot place is a fault. Each is told once, of the worst: what is wrong with one is often wrong
    with thousands.

    Args:
        scene: in SI.
        names: of its bodies, as written.
        files: the meshes that come from files, each with its key in the scene's `meshes`.
        findings: takes the warnings and faults.
    """
    boxes = {shape.mesh: _box(shape.mesh) for body in scene.bodies for shape in body.shapes}
    sized = {
        index: [(boxes[shape.mesh][1] + 2.0 * shape.radius, shape) for shape in body.shapes]
        for index, body in enumerate(scene.bodies)
    }
    # A mesh whose corners are all one point has no size that could tell anything.
    shapes = {index: those for index, own in sized.items() if (those := [one for one in own if one[0] > 0.0])}
    if not shapes:
        return
    _warn_of_units(list(shapes.values()), files, findings)
    centres = {
        index: np.array([(shape.pose @ boxes[shape.mesh][0])[:3] for _, shape in own]) for index, own in shapes.items()
    }
    distances = _distances(scene, centres)
    features = {index: min(size for size, _ in own) for index, own in shapes.items()}
    terms = {index: scene.bodies[index].motion.extent((scene.start, scene.end)) for index in shapes}
    if _refuse_the_lost(scene, names, shapes, centres, findings):
        return
    if not _warn_of_places(distances, features, names, findings):
        _warn_of_terms(terms, features, names, findings)


def _warn_of_units(bodies: list[list[tuple[float, Shape]]], files: Mapping[Mesh, str], findings: Findings) -> None:
    """Warn if a mesh file is so much larger or smaller than the rest of the scene: its unit is said, not known.

    Shapes that the scene itself spells out are all in one unit, so that a bolt beside a hall is meant as it is.

    Args:
        bodies: of each, its shapes with their sizes (m).
        files: as in `check_sizes`.
        findings: takes the warning.
    """
    sizes: dict[str | int, float] = {}
    for index, own in enumerate(bodies):
        for size, shape in own:
            thing = files.get(shape.mesh, index)  # a file counts once, however many bodies show it
            sizes[thing] = max(size, sizes.get(thing, 0.0))
    if len(sizes) < 2:
        return
    things = sorted(sizes, key=sizes.__getitem__)
    ordered = [sizes[thing] for thing in things]
    medians = {thing: _median_without(ordered, place) for place, thing in enumerate(things) if isinstance(thing, str)}
    ratios = {key: max(sizes[key] / median, median / sizes[key]) for key, median in medians.items()}
    worst = max(ratios, key=ratios.__getitem__, default="")
    if worst and ratios[worst] > UNLIKELY_RATIO:
        compared = "smaller" if sizes[worst] < medians[worst] else "larger"
        problem = (
            f"the mesh is {sizes[worst]:.3g} m in size, {ratios[worst]:.4g} times {compared} than what else there is"
        )
        median = f"the median is {medians[worst]:.3g} m"
        findings.warn(("meshes", worst, "units"), f"{problem} ({median}): is a unit wrong, mm for m?")


def _median_without(ordered: list[float], place: int) -> float:
    """Return the median (geometric, of two in the middle) of increasing positive numbers, two or more, without one."""
    count = len(ordered) - 1
    below, above = (ordered[middle + (middle >= place)] for middle in ((count - 1) // 2, count // 2))
    return sqrt(below) * sqrt(above)


def _warn_of_places(
    distances: dict[int, float], features: dict[int, float], names: tuple[str, ...], findings: Findings
) -> bool:
    """Warn if a body's distance (m) is so much more than its smallest feature (m); tell whether one is."""
    worst, ratio, others = _coarsest(distances, features, COARSE_PLACE)
    if ratio > COARSE_PLACE:
        problem = f"lies {distances[worst]:.3g} m from the origin, {ratio:.3g} times its smallest shape"
        findings.warn(_shapes(names[worst]), f"{problem}: rounding may show, move the origin{others}")
    return ratio > COARSE_PLACE


def _warn_of_terms(
    terms: dict[int, float], features: dict[int, float], names: tuple[str, ...], findings: Findings
) -> None:
    """Warn if the terms of a motion (m) cancel to a place that is so much nearer."""
    worst, ratio, others = _coarsest(terms, features, COARSE_TERMS)
    if ratio > COARSE_TERMS:
        problem = f"the motion's terms add up to {terms[worst]:.3g} m, {ratio:.3g} times the body's smallest shape"
        remedy = "rounding may show, let times and t0 be nearer to 0"
        findings.warn(("bodies", names[worst], "motion"), f"{problem}: {remedy}{others}")


def _refuse_the_lost(
    scene: Scene,
    names: tuple[str, ...],
    shapes: dict[int, list[tuple[float, Shape]]],
    centres: dict[int, FloatArray],
    findings: Findings,
) -> bool:
    """Refuse a body that rounding may misplace in its parent by more than its size; tell whether one is."""
    sizes = {index: max(size for size, _ in own) for index, own in shapes.items()}
    reaches = {index: float(np.linalg.norm(own[:, :3], axis=1).max()) + sizes[index] for index, own in centres.items()}
    times = {index: scene.shared_time(index, index) for index in reaches}
    errors = {index: _rounding(scene.bodies[index], reach, times[index]) for index, reach in reaches.items()}
    worst, ratio, others = _coarsest(errors, sizes, MOST_ROUNDING)
    if ratio <= MOST_ROUNDING:
        return False
    at_rest = replace(scene.bodies[worst], motion=Fixed())
    stays = _rounding(at_rest, reaches[worst], times[worst]) > 0.5 * errors[worst]
    remedy = "move the origin, or let a parent lie near it" if stays else "let times and t0 be nearer to 0"
    problem = f"rounding may misplace it by {errors[worst]:.3g} m, more than its size, {sizes[worst]:.3g} m"
    where = _shapes(names[worst]) if stays else ("bodies", names[worst], "motion")
    findings.fault(where, f"{problem}: {remedy}{others}")
    return True


def _rounding(body: Body, reach: float, times: Interval) -> float:
    """Return how far (m) floating point may misplace a body in its parent, no point of it farther than `reach` (m)."""
    extent = Extent(np.zeros((1, 3)), np.array([reach]), Ball(ZERO, reach))
    return chain_to((replace(body, parent=None),), 0, None, extent).rounding(times)


def _coarsest(lengths: dict[int, float], features: dict[int, float], most: float) -> tuple[int, float, str]:
    """Return the body whose length (m) is the most times its smallest feature (m), that ratio, and a word on others."""
    ratios = {index: length / features[index] for index, length in lengths.items()}
    worst = max(ratios, key=ratios.__getitem__)
    coarse = sum(ratio > most for ratio in ratios.values())
    return worst, ratios[worst], f" (and {counted(coarse - 1, 'more body', 'more bodies')})" if coarse > 1 else ""


def _distances(scene: Scene, centres: dict[int, FloatArray]) -> dict[int, float]:
    """Return how far (m) from the world's origin a shape's centre gets, by body, at the scene's start and end."""
    world_poses = WorldPoses(scene.bodies)
    poses = [world_poses.at(time) for time in (scene.start, scene.end)]
    return {
        index: max(
            float(np.linalg.norm(own @ world[index, :3, :3].T + world[index, :3, 3], axis=1).max()) for world in poses
        )
        for index, own in centres.items()
    }


def _shapes(name: str) -> Where:
    return ("bodies", name, "shapes")


def _box(mesh: Mesh) -> tuple[FloatArray, float]:
    """Return the centre (x, y, z, 1) and the longest side (m) of a mesh's bounding box."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    return np.append(low + 0.5 * (high - low), 1.0), float((high - low).max())
