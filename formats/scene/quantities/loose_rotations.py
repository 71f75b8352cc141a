"""Warnings of rotations that are not quite rotations: how far taking the nearest ones moves a body's points at most."""

from __future__ import annotations

from collections import defaultdict
from decimal import ROUND_CEILING, Context

import numpy as np

from ....scheduler.geometry.transform import translation_of
from ....scheduler.geometry.vector import norm
from ....scheduler.model.body_tree import topological_order
from ....scheduler.model.scene import Scene, Shape
from ..text.document import Findings, Loose
from ..text.errors import Where, counted
from .units import in_unit

_TWO_DIGITS = Context(prec=2, rounding=ROUND_CEILING)


def warn_of_loose_rotations(scene: Scene, names: tuple[str, ...], unit: str, findings: Findings) -> None:
    """Warn of them, once for each body's pose, for each shape and for all keys of a motion: of the worst.

    Args:
        scene: in SI.
        names: of its bodies, as written.
        unit: of lengths, in which the warnings tell.
        findings: has what is loose, and takes the warnings.
    """
    if not findings.loose_rotations:
        return
    reaches = _Reaches(scene)
    together: dict[Where, list[Loose]] = defaultdict(list)
    for loose in findings.loose_rotations:
        together[loose.where[: 4 if loose.where[2] == "shapes" else 3]].append(loose)
    bodies = {name: index for index, name in enumerate(names)}
    for group, found in together.items():
        worst = max(found, key=lambda loose: loose.stretch)
        moved = in_unit(worst.stretch * reaches.of(bodies[str(group[1])], group[2:]), unit)
        at_most = f"{float(_TWO_DIGITS.create_decimal_from_float(moved)):g} {unit}"
        others = f" (and {counted(len(found) - 1, 'key')} less)" if len(found) > 1 else ""
        text = f"{worst.told}: the nearest rotation is taken, which moves points of the body by up to {at_most}"
        findings.warn(worst.where, f"{text}{others}")


class _Reaches:
    """How far (m) what a rotation turns may lie from its centre: points of the body and of those that it carries."""

    def __init__(self, scene: Scene) -> None:
        self._bodies, times = scene.bodies, (scene.start, scene.end)
        self._extents = [body.motion.extent(times) for body in scene.bodies]
        self._carried = [max(map(_reach_of_shape, body.shapes), default=0.0) for body in scene.bodies]
        for index in reversed(topological_order(scene.bodies)):
            parent = scene.bodies[index].parent
            if parent is not None:
                away = norm(translation_of(scene.bodies[index].pose)) + self._extents[index]
                self._carried[parent] = max(self._carried[parent], away + self._carried[index])

    def of(self, body: int, place: Where) -> float:
        """Return it for the rotation of a body's `pose`, of its `motion`, or of one of its `shapes`."""
        match place:
            case ("shapes", int(index)):
                return _reach_in_shape(self._bodies[body].shapes[index])
            case ("pose",):
                return self._extents[body] + self._carried[body]
            case _:
                return self._carried[body]


def _reach_in_shape(shape: Shape) -> float:
    """Return how far (m) a shape's points lie from its own origin."""
    return float(np.linalg.norm(shape.mesh.vertices, axis=1).max()) + shape.radius


def _reach_of_shape(shape: Shape) -> float:
    """Return how far (m) a shape's points may lie from the body's origin."""
    return norm(translation_of(shape.pose)) + _reach_in_shape(shape)
