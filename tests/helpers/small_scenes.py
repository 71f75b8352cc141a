"""Boxes and balls put before the loop: what tests of the scheduler share."""

from __future__ import annotations

import numpy as np

from closecall.scheduler.model.events import Event
from closecall.scheduler.model.scene import Body, Mesh, PairRules, Scene, Settings, Shape
from closecall.scheduler.narrow.narrow_phase import POINT, NarrowPhase
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide
from closecall.scheduler.run import run

HERE = np.eye(4)


def box(x: float, y: float, z: float) -> Shape:
    vertices = np.array([[i, j, k] for i in (-x, x) for j in (-y, y) for k in (-z, z)]) / 2.0
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return Shape(Mesh("box", vertices, np.array(triangles), True), 0.0, HERE)


def round_shape(radius: float) -> Shape:
    return Shape(POINT, radius, HERE)


def events_of(*bodies: Body, end: float = 4.0, settings: Settings | None = None) -> list[Event]:
    settings = settings or Settings()
    scene = Scene(bodies, 0.0, end, PairRules())
    return list(run(pairs_that_might_collide(scene, NarrowPhase(bodies), settings.margin), settings))
