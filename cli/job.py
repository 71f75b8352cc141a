"""One run: read the scene, schedule it, write the log, say what it took."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

import click

from ..formats.log.summary import Summary
from ..formats.log.writer import LogOptions, LogWriter
from ..formats.scene.reader import read_scene
from ..scheduler.narrow_phase import NarrowPhase
from ..scheduler.pair import pairs_that_might_collide
from ..scheduler.run import run
from ..scheduler.scene import Scene, Settings, least_duration


@dataclass(frozen=True, slots=True)
class Result:
    """What a run found, what it warned of, and the wall-clock seconds of its parts.

    `schedule` is the loop with its measurements, of which `fcl` is a part; `log` is writing.
    """

    summary: Summary
    warnings: tuple[str, ...]
    seconds: dict[str, float]


def run_job(
    scene_path: Path,
    output: Path,
    overrides: Mapping[str, float | None],
    options: LogOptions,
    mesh_roots: Sequence[Path],
) -> Result:
    """Run a scene file into a log, settings given on the command line over the file's own.

    Raises:
        SceneError, LogError: for what the user can mend.
    """
    began = perf_counter()
    loaded = read_scene(scene_path, mesh_roots)
    settings = _settings(loaded.scene, loaded.settings, overrides)
    narrow_phase = NarrowPhase(loaded.scene.bodies)
    pairs = tuple(pairs_that_might_collide(loaded.scene, narrow_phase))
    warnings = loaded.warnings
    if not pairs:
        warnings = (*warnings, f"{scene_path}: nothing to check: no two bodies move relative to each other")
    loaded = replace(loaded, warnings=warnings)
    ready = perf_counter()
    writing = 0.0
    with LogWriter(output, loaded, settings, len(pairs), options) as log:
        for event in run(loaded.scene, pairs, settings):
            told = perf_counter()
            log.write(event)
            writing += perf_counter() - told
        scheduled = perf_counter()
        summary = log.summary()
    done = perf_counter()
    seconds = {
        "load": ready - began,
        "schedule": scheduled - ready - writing,
        "fcl": narrow_phase.seconds,
        "log": writing + done - scheduled,
        "total": done - began,
    }
    return Result(summary, warnings, seconds)


def _settings(scene: Scene, settings: Settings, overrides: Mapping[str, float | None]) -> Settings:
    """Return the file's settings with the command line's over them."""
    least = least_duration(scene.start, scene.end)
    for name, value in overrides.items():
        if value is not None and not least <= value < float("inf"):
            option = "--" + name.replace("_", "-")
            raise click.BadParameter(f"expected at least {least:.3g} s, got {value}.", param_hint=option)
    return replace(settings, **{name: value for name, value in overrides.items() if value is not None})
