"""Scenes before a run: read them, count their pairs, and refuse those that are too large."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ...formats.scene.limits import LARGEST_DOCUMENT
from ...formats.scene.loaded import LoadedScene
from ...formats.scene.reader import read_scene
from ...formats.scene.text.errors import SceneError, WarnedError, counted, whole_file
from ...scheduler.model.pair_count import count_pairs


def load(scene: str | Path, *, mesh_roots: Sequence[str | Path] = (), max_bytes: int = LARGEST_DOCUMENT) -> LoadedScene:
    """Read and validate a scene file.

    Args:
        scene: the file, YAML or (by its suffix) JSON.
        mesh_roots: folders from which the scene can use files, besides its own folder.
        max_bytes: a larger scene file is refused.

    Returns:
        The scene in SI units and radians, with its warnings.

    Raises:
        SceneError: for a file that cannot be read or is wrong. It carries every fault, with line and column.
    """
    return read_scene(Path(scene), tuple(map(Path, mesh_roots)), max_bytes)


def counted_pairs(loaded: LoadedScene, strict: bool) -> tuple[LoadedScene, int]:
    """Return the scene with its last warnings, and how many pairs are to be checked.

    Raises:
        WarnedError: under `strict` for any warning.
    """
    pairs = count_pairs(loaded.scene).checked
    if not pairs:
        nothing = "nothing to check: no two checked bodies move relative to each other"
        loaded = replace(loaded, warnings=(*loaded.warnings, str(whole_file(loaded.path, nothing))))
    if strict and loaded.warnings:
        raise WarnedError(loaded.warnings)
    return loaded, pairs


def require_few(loaded: LoadedScene, total: int, max_pairs: int) -> None:
    """Check that a scene of which each pair is watched has few enough.

    Raises:
        SceneError: for more than `max_pairs` pairs.
    """
    if total > max_pairs:
        raise SceneError(
            [whole_file(loaded.path, f"more than {counted(max_pairs, 'pair')}, ignore some or raise --max-pairs")]
        )
