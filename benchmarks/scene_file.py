"""The scene files of the benchmarks: lengths in m, angles in rad, from time 0 on."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def write_scene_file(
    path: Path, seconds: float, meshes: Mapping[str, Mapping[str, str]], bodies: Mapping[str, Mapping[str, Any]]
) -> Path:
    """Write a scene as JSON; return its path.

    Args:
        path: of the scene file.
        seconds: at which the run ends.
        meshes: by name, as the grammar has them, without units: their files are in m.
        bodies: by name, as the grammar has them.
    """
    scene = {
        "closecall": 1,
        "units": {"length": "m", "angle": "rad"},
        "time": {"start": 0, "end": seconds},
        "meshes": {name: {**mesh, "units": "m"} for name, mesh in meshes.items()},
        "bodies": bodies,
    }
    path.write_text(json.dumps(scene))
    return path
