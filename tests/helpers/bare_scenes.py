"""Loaded scenes without shapes: a log takes its names, times and files, and asks for nothing else."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np

from closecall.formats.scene.loaded import InputFile, LoadedScene
from closecall.scheduler.model.scene import Body, PairRules, Scene, Settings


def loaded(
    folder: Path,
    *,
    names: Sequence[str] = ("gear", "hammer"),
    start: float = 0.0,
    end: float = 1e6,
    meshes: Sequence[bytes] = (),
    warnings: tuple[str, ...] = (),
) -> LoadedScene:
    """Write a scene file, and files of meshes with these bytes, into a folder; return the scene of the bodies."""
    path = folder / "scene.yaml"
    path.write_bytes(b"closecall: 1\n")
    bodies = tuple(Body(name, None, np.eye(4), cast(Any, None), ()) for name in names)
    files = []
    for number, data in enumerate(meshes):
        file = folder / f"{number}.stl"
        file.write_bytes(data)
        files.append(InputFile(f"part_{number}", file, hashlib.sha256(data).hexdigest()))
    scene = Scene(bodies, start, end, PairRules())
    return LoadedScene(path, path.read_bytes(), scene, Settings(), tuple(files), warnings)
