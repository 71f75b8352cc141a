"""What the families share: bodies put together, small gaps, a hollow mesh."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ..bodies import BOX_CORNERS, BOX_TRIANGLES
from ..draw import Draw, random_rotation
from ..rigid import METRES, FloatArray
from ..solids import write_mesh

Spec = dict[str, Any]


def body(draw: Draw, shape: Any, place: FloatArray, turn: Rotation | None = None, **rest: Any) -> Spec:
    """Write a body of one shape at a place (3,) m; what is None is left out."""
    out: Spec = {"pose": draw.pose(np.asarray(place, dtype=float), turn), "shapes": [shape]}
    return out | {key: value for key, value in rest.items() if value is not None}


def some_turn(draw: Draw) -> Rotation | None:
    """Return a random rotation, or none."""
    return random_rotation(draw.rng) if draw.chance(0.6) else None


def small(draw: Draw, least: float = -9.0, most: float = -2.0) -> float:
    """Return m: a size of 10^least to 10^most of the scene's, of either sign."""
    return draw.pick(-1.0, 1.0) * 10.0 ** draw.between(least, most) * draw.size


def box(draw: Draw, x: float, y: float, z: float) -> Spec:
    """Write a box of these sides, m."""
    return {"box": draw.metres(np.array([x, y, z]))}


def hollow_box(draw: Draw, outer: FloatArray, wall: float) -> Spec:
    """Write a mesh file of a closed box with a closed cavity in it, and the shape that shows it.

    Args:
        outer: (3,) m, full lengths.
        wall: m, its thickness.
    """
    shell = (BOX_CORNERS * outer)[BOX_TRIANGLES]
    cavity = (BOX_CORNERS * (outer - 2.0 * wall))[BOX_TRIANGLES][:, ::-1]
    name = f"shell_{len(draw.meshes)}"
    unit = draw.pick("m", "mm")
    write_mesh(draw.folder / f"{name}.obj", np.concatenate([shell, cavity]) / METRES[unit], draw.seed)
    draw.meshes[name] = {"file": f"{name}.obj", "units": unit}
    return {"mesh": name}


def shortened(draw: Draw, duration: float) -> None:
    """Let the scene last only so long, s, in whole ticks."""
    draw.end = draw.start + max(1, round(duration * 64.0)) / 64.0
