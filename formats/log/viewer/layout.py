"""The Foxglove layout that travels with a log: the scene in view, the minimum plotted, collisions and pairs told."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor, log10
from typing import Any

from .camera import FIELD_OF_VIEW, Camera
from .transforms import WORLD
from .view_extent import Reach

_GRID_CELLS = 10  # across the scene, or fewer by up to a factor 2.5


@dataclass(frozen=True, slots=True)
class CloseUp:
    """What a scene too large for its bodies is seen by as well: the frame to stay with, and from how far, m."""

    frame: str
    distance: float


def layout(reach: Reach, view: Camera, topics: Sequence[str], close_up: CloseUp | None = None) -> bytes:
    """Return the layout as JSON.

    Args:
        reach: where the bodies get to.
        view: from where they are seen.
        topics: what is drawn.
        close_up: shown beside all the bodies, where there is one.
    """
    panels = {
        "3D!scene": _scene_panel(reach, view, topics),
        "Plot!distance": _plot_panel(),
        "StateTransitions!states": _states_panel(),
        "Table!pairs": {"topicPath": "/world.pairs"},
        "RosOut!log": {"topicToRender": "/log", "minLogLevel": 1, "searchTerms": []},
    }
    seen: str | dict[str, Any] = "3D!scene"
    if close_up is not None:
        panels["3D!close-up"] = _close_up_panel(panels["3D!scene"], close_up)
        seen = {"direction": "column", "first": "3D!scene", "second": "3D!close-up", "splitPercentage": 50}
    left = {"direction": "column", "first": seen, "second": "Table!pairs", "splitPercentage": 74}
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


def _scene_panel(reach: Reach, view: Camera, topics: Sequence[str]) -> dict[str, Any]:
    return {
        "cameraState": {
            "perspective": True,
            "distance": _plain(view.distance),
            "phi": _plain(view.phi),
            "thetaOffset": _plain(view.theta),
            "targetOffset": [_plain(value) for value in view.target.tolist()],
            "target": [0, 0, 0],
            "targetOrientation": [0, 0, 0, 1],
            "fovy": FIELD_OF_VIEW,
            "near": _plain(1e-3 * view.distance),
            "far": _plain(100.0 * view.distance),
        },
        "followMode": "follow-none",
        "followTf": WORLD,
        "scene": {
            "transforms": {
                "showLabel": False,
                "labelSize": _plain(0.018 * reach.size),
                "axisScale": 0.0,
                "lineWidth": 0,
            }
        },
        "transforms": {f"frame:{WORLD}": {"visible": False}},
        "topics": {name: {"visible": True, "showOutlines": False} for name in topics},  # white edges hide colours
        "layers": {"grid": _grid(reach)},
        "publish": {},
    }


def _close_up_panel(whole: dict[str, Any], close_up: CloseUp) -> dict[str, Any]:
    """Return the panel that goes with a frame, and looks in the direction of that of the whole scene."""
    distance = close_up.distance
    camera = whole["cameraState"] | {
        "distance": _plain(distance),
        "targetOffset": [0, 0, 0],
        "near": _plain(1e-3 * distance),
        "far": _plain(100.0 * distance),
    }
    follow = {"followMode": "follow-position", "followTf": close_up.frame}
    return whole | follow | {"cameraState": camera, "layers": {}}


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
