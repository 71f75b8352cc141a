"""A scene as read from a file: what the scheduler needs, and what the log keeps to prove where it came from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ...scheduler.scene import Scene, Settings


@dataclass(frozen=True, slots=True)
class MeshFile:
    """A mesh file the scene refers to: its name in the scene, where it lies, and its bytes' SHA-256 (hex)."""

    name: str
    path: Path
    sha256: str


@dataclass(frozen=True, slots=True, eq=False)
class LoadedScene:
    """A scene file, read and checked.

    Attributes:
        path: the scene file.
        source: its bytes, as read.
        settings: the file's own settings over the defaults; command-line options override them.
        mesh_files: in document order.
        warnings: one line each, located like errors.
    """

    path: Path
    source: bytes
    scene: Scene
    settings: Settings
    mesh_files: tuple[MeshFile, ...]
    warnings: tuple[str, ...]
