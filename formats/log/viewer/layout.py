"""The Foxglove layout that travels with a log: the scene in view, the minimum plotted, collisions and pairs told."""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import atan2, ceil, cos, degrees, floor, log10, radians, sin, tan
from typing import Any

import numpy as np

from ....scheduler.scene import FloatArray
from .reach import Reach
from .transforms import WORLD

_FIELD_OF_VIEW = 45.0  # degrees, upright
_ASPECT = 1.05  # width by height of the 3D panel, while the sidebar is open
_FILL = 0.92  # of the panel's half height and width

# Seen from a side and above; what is flat is seen more from above. Degrees from the z axis.
_SLANT, _SLANT_OF_FLAT, _FLATNESS = 62.0, 38.0, 0.2

# Degrees off the direction across which motion spreads most: what is square is not seen face on.
_OBLIQUE = 20.0

# As wide as long, nearly: such motion has no direction, and is seen along y.
_ROUND = 0.8

_GRID_CELLS = 10  # across the scene, or fewer by up to a factor 2.5


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """Where the camera looks at (m, world), from how far (m), and from where.

    Attributes:
        phi: degrees from the z axis.
        theta: degrees about the z axis; from 0 the camera looks along y, from 90 along x.
    """

    target: FloatArray
    distance: float
    phi: float
    theta: float


def camera(reach: Reach) -> Camera:
    """Return a camera that has all in view, as near as it may be."""
    x, y, z = (reach.high - reach.low).tolist()
    phi = _SLANT_OF_FLAT if z < _FLATNESS * max(x, y) else _SLANT
    theta = _bearing(reach)
    axes = _axes(phi, theta)
    across, upright, depth = np.ascontiguousarray((reach.points @ axes.T).T)
    target = axes @ (0.5 * (reach.low + reach.high))
    high, distance = _FILL * tan(radians(_FIELD_OF_VIEW / 2.0)), reach.size
    for _ in range(8):  # the picture of the points comes nearer to the middle with each round
        depths = np.maximum(distance + depth - target[2], 1e-3 * reach.size)
        for axis, seen in enumerate((across, upright)):
            slopes = (seen - target[axis]) / depths
            target[axis] += 0.5 * distance * (slopes.min() + slopes.max())
        widths = np.maximum(np.abs(across - target[0]) / _ASPECT, np.abs(upright - target[1])) / high
        distance = max(float((widths - depth).max() + target[2]), 0.1 * reach.size)
    return Camera(target @ axes, distance, phi, theta)


def layout(reach: Reach, labelled: bool, crowded: bool = False) -> bytes:
    """Return the layout as JSON.

    Args:
        reach: what the camera must see.
        labelled: whether moving bodies bear their names.
        crowded: whether there are bodies on /scene/boxes.
    """
    panels = {
        "3D!scene": _scene_panel(reach, labelled, crowded),
        "Plot!distance": _plot_panel(),
        "StateTransitions!states": _states_panel(),
        "Table!pairs": {"topicPath": "/world.pairs"},
        "RosOut!log": {"topicToRender": "/log", "minLogLevel": 1, "searchTerms": []},
    }
    left = {"direction": "column", "first": "3D!scene", "second": "Table!pairs", "splitPercentage": 74}
    below = {"direction": "column", "first": "StateTransitions!states", "second": "RosOut!log", "splitPercentage": 50}
    right = {"direction": "column", "first": "Plot!distance", "second": below, "splitPercentage": 36}
    document = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": {"direction": "row", "first": left, "second": right, "splitPercentage": 62},
    }
    return (json.dumps(document, indent=1, allow_nan=False) + "\n").encode()


def _bearing(reach: Reach) -> float:
    """Return theta from which motion is seen in its full width, from the side where it takes place."""
    if len(reach.moving) < 2:
        return _OBLIQUE
    flat = reach.moving[:, :2]
    spreads, directions = np.linalg.eigh(np.cov(flat, rowvar=False))
    if spreads[0] > _ROUND * spreads[1]:
        return _OBLIQUE
    x, y = directions[:, 0]  # across the widest spread
    aside = flat.mean(axis=0) - 0.5 * (reach.low + reach.high)[:2]
    towards = float(aside @ (x, y))
    if abs(towards) < 0.02 * reach.size:
        towards = -y  # no side is better: from the front
    side = 1.0 if towards >= 0.0 else -1.0
    return degrees(atan2(-side * x, -side * y)) + _OBLIQUE


def _axes(phi: float, theta: float) -> FloatArray:
    """Return unit vectors to the right, up and forward of a camera, in the world, as rows (3, 3)."""
    tilt, turn = radians(phi), radians(theta)
    right = np.array((cos(turn), -sin(turn), 0.0))
    forward = np.array((sin(tilt) * sin(turn), sin(tilt) * cos(turn), -cos(tilt)))
    return np.array((right, np.cross(right, forward), forward))


def _scene_panel(reach: Reach, labelled: bool, crowded: bool) -> dict[str, Any]:
    view = camera(reach)
    topics: dict[str, Any] = {name: {"visible": True} for name in ("/scene/meshes", "/viz/clearance", "/viz/contacts")}
    if crowded:
        topics["/scene/boxes"] = {"visible": True, "showOutlines": False}  # white edges would hide their colours
    return {
        "cameraState": {
            "perspective": True,
            "distance": _plain(view.distance),
            "phi": _plain(view.phi),
            "thetaOffset": _plain(view.theta),
            "targetOffset": [_plain(value) for value in view.target.tolist()],
            "target": [0, 0, 0],
            "targetOrientation": [0, 0, 0, 1],
            "fovy": _FIELD_OF_VIEW,
            "near": _plain(1e-3 * view.distance),
            "far": _plain(100.0 * view.distance),
        },
        "followMode": "follow-none",
        "followTf": WORLD,
        "scene": {
            "transforms": {
                "showLabel": labelled,
                "labelSize": _plain(0.018 * reach.size),
                "axisScale": 0.0,
                "lineWidth": 0,
            }
        },
        "transforms": {f"frame:{WORLD}": {"visible": False}},
        "topics": topics,
        "layers": {"grid": _grid(reach)},
        "publish": {},
    }


def _grid(reach: Reach) -> dict[str, Any]:
    """Return a grid under the bodies, with cells of 1, 2 or 5 times a power of ten metres."""
    extents = reach.high - reach.low
    middle = 0.5 * (reach.low + reach.high)
    widest = float(extents[:2].max()) or reach.size
    cell = _round_length(widest / _GRID_CELLS)
    cells = 2 * ceil(0.6 * widest / cell)
    x, y = (cell * round(float(value) / cell) for value in middle[:2])
    return {
        "visible": True,
        "frameLocked": True,
        "label": f"Grid, {cell:g} m",
        "instanceId": "grid",
        "layerId": "foxglove.Grid",
        "frameId": WORLD,
        "size": _plain(cell * cells),
        "divisions": cells,
        "lineWidth": 1,
        "color": "#80808059",
        "position": [_plain(x), _plain(y), _plain(float(reach.low[2]))],
        "rotation": [0, 0, 0],
        "order": 1,
    }


def _plain(value: float) -> float:
    """Return a number to six digits: more say nothing here, and the last ones depend on the machine."""
    return float(f"{value:.6g}")


def _round_length(least: float) -> float:
    """Return the smallest 1, 2 or 5 times a power of ten that is not below `least` > 0."""
    power = 10.0 ** floor(log10(least))
    return next((step * power for step in (1, 2, 5) if step * power >= least), 10.0 * power)


def _plot_panel() -> dict[str, Any]:
    path = {
        "value": "/world.min_distance",
        "enabled": True,
        "timestampMethod": "receiveTime",
        "label": "least distance",
    }
    return {
        "title": "Least distance of all pairs (m)",
        "paths": [path],
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "showLegend": True,
        "legendDisplay": "floating",
        "showPlotValuesInLegend": True,
        "isSynced": True,
        "xAxisVal": "timestamp",
    }


def _states_panel() -> dict[str, Any]:
    paths = [
        {"value": value, "label": label, "timestampMethod": "receiveTime"}
        for value, label in (("/collisions.phase", "collisions"), ("/wakeups.reason", "wakeups"))
    ]
    return {"isSynced": True, "paths": paths}
