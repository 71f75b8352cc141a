"""Scenes written to a folder and read again: what the tests of the scene file share."""

from __future__ import annotations

from pathlib import Path

import pytest

from closecall.formats.scene.loaded import LoadedScene
from closecall.formats.scene.reader import read_scene
from closecall.formats.scene.text.errors import SceneError
from closecall.scheduler.model.scene import Body
from closecall.scheduler.motions import Motion

HEAD = "closecall: 1\nunits: {length: mm, angle: deg}\ntime: {start: 0, end: 1}\n"
"""Three lines: what follows begins in line 4."""

MOTION = f"{HEAD}bodies:\n  a:\n    motion: "
"""What follows stands in line 6 from column 13."""

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
"""An OBJ file."""


def load(folder: Path, text: str, name: str = "scene.yaml") -> LoadedScene:
    (folder / name).write_text(text, encoding="utf-8")
    return read_scene(folder / name)


def body(folder: Path, text: str) -> Body:
    """Return the only body of a scene, given by what stands in its mapping."""
    return load(folder, f"{HEAD}bodies: {{a: {{{text}}}}}").scene.bodies[0]


def motion(folder: Path, text: str) -> Motion:
    return load(folder, MOTION + text).scene.bodies[0].motion


def faults(folder: Path, text: str) -> list[str]:
    """Return every fault of a scene, from its line on."""
    path = folder / "scene.yaml"
    with pytest.raises(SceneError) as caught:
        load(folder, text)
    told = [str(fault) for fault in caught.value.faults]
    assert all(line.isprintable() for line in told)
    return [line.removeprefix(f"{path}:") for line in told]


def fault(folder: Path, text: str) -> str:
    """Return the only fault of a scene, from its line on."""
    (line,) = faults(folder, text)
    return line


def warnings(folder: Path, text: str) -> list[str]:
    """Return every warning of a scene, from its line on."""
    return [line.removeprefix(f"{folder / 'scene.yaml'}:") for line in load(folder, text).warnings]
