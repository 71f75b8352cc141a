"""One run: read the scene, schedule it, write the log, say what it took."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from time import perf_counter

import click

from ..formats.log.chunks import Compression
from ..formats.log.summary import Summary
from ..formats.log.viewer.viewer import ViewerOptions
from ..formats.log.writer import LogOptions, LogWriter, Topics
from ..formats.scene.errors import SceneError, counted, whole_file
from ..formats.scene.loaded import LoadedScene
from ..formats.scene.reader import read_scene
from ..scheduler.counting import count_pairs
from ..scheduler.crowd import Crowd
from ..scheduler.narrow_phase import NarrowPhase
from ..scheduler.nearest import CrowdObserver
from ..scheduler.pair import Pair
from ..scheduler.pairing import Pairing
from ..scheduler.run import run
from ..scheduler.scene import Scene, Settings, least_duration
from ..scheduler.snapshot import Observer, Observes, observed
from ..scheduler.streams import Work, merged
from .faults import raise_interrupts
from .options import LEAST_SNAPSHOTS, USUAL_RATE, RunOptions
from .progress import shares_shown, shown
from .workers import streams_of

#: Up to so many pairs each is watched throughout, and its least distance told. Of more, swept boxes say which are.
FEW_PAIRS = 1000


@dataclass(frozen=True, slots=True)
class Result:
    """What a run found, what it warned of, and the wall-clock seconds of its parts.

    `schedule` is the loop with its measurements, of which `fcl` is a part, summed over all processes; `log` is writing.
    """

    summary: Summary
    warnings: tuple[str, ...]
    seconds: dict[str, float]

    def finds(self, wanted: Sequence[str]) -> bool:
        """Tell whether any pair has one of the wanted verdicts."""
        return any(pair["verdict"] in wanted for pair in self.summary["pairs"])


def run_job(scene_path: Path, output: Path, options: RunOptions) -> Result:
    """Run a scene file into a log, settings given on the command line over the file's own.

    Raises:
        SceneError, LogError, WorkerError: for what the user can mend.
    """
    began = perf_counter()
    loaded = read_scene(scene_path, options.mesh_roots, options.max_bytes)
    settings = _settings(loaded.scene, loaded.settings, options)
    narrow_phase = NarrowPhase(loaded.scene.bodies)
    pairing = Pairing(loaded.scene, narrow_phase, settings.margin)
    loaded, total = counted_pairs(loaded, options.strict)
    crowded = total > FEW_PAIRS if options.broad_phase == "auto" else options.broad_phase == "on"
    pairs = () if crowded else all_of(loaded, pairing, total, options.max_pairs)
    ready = perf_counter()
    raise_interrupts()
    writing = fcl = 0.0
    with LogWriter(output, loaded, settings, total, _log_options(options)) as log:
        if options.jobs == 1 and options.cluster is None:
            events = run(pairs, settings, Crowd(pairing, settings) if crowded else None)
        else:
            work = Work(loaded.scene, settings, crowded)
            with shares_shown(scene_path.name, options.quiet) as show:
                streams, fcl = streams_of(work, total, options.jobs, options.cluster, show)
            events = merged(streams)
        if options.log == "full":
            observer = _observer(pairs, pairing, crowded, options)
            events = observed(events, observer, loaded.scene, _rate(loaded.scene, options), settings.time_resolution)
        if not options.quiet:
            events = shown(events, loaded.scene.start, loaded.scene.end, scene_path.name)
        with closing(events):
            for event in events:
                told = perf_counter()
                log.write(event)
                writing += perf_counter() - told
        scheduled = perf_counter()
        summary = log.summary()
    done = perf_counter()
    seconds = {
        "load": ready - began,
        "schedule": scheduled - ready - writing,
        "fcl": narrow_phase.seconds + fcl,
        "log": writing + done - scheduled,
        "total": done - began,
    }
    return Result(summary, loaded.warnings, seconds)


def counted_pairs(loaded: LoadedScene, strict: bool) -> tuple[LoadedScene, int]:
    """Return the scene with its last warnings, and how many pairs are to be checked.

    Raises:
        SceneError: under `strict` for any warning.
    """
    pairs = count_pairs(loaded.scene).checked
    if not pairs:
        nothing = "nothing to check: no two bodies that may be checked move relative to each other"
        loaded = replace(loaded, warnings=(*loaded.warnings, str(whole_file(loaded.path, nothing))))
    if strict and loaded.warnings:
        raise SceneError([whole_file(loaded.path, f"under --strict: {text}") for text in loaded.warnings])
    return loaded, pairs


def all_of(loaded: LoadedScene, pairing: Pairing, total: int, max_pairs: int) -> tuple[Pair, ...]:
    """Return all pairs of a scene, of which there are `total`.

    Raises:
        SceneError: for more than `max_pairs` pairs.
    """
    if total > max_pairs:
        raise SceneError(
            [whole_file(loaded.path, f"more than {counted(max_pairs, 'pair')}, ignore some or raise --max-pairs")]
        )
    return tuple(pairing.all())


def _observer(pairs: Sequence[Pair], pairing: Pairing, crowded: bool, options: RunOptions) -> Observes:
    """Return what takes the snapshots for viewers."""
    if crowded:
        return CrowdObserver(pairing, options.viz_pairs)
    return Observer(pairing.scene, pairs, options.viz_pairs, pairing.narrow_phase)


def _log_options(options: RunOptions) -> LogOptions:
    """Return what the log shall hold."""
    return LogOptions(
        compression=Compression(options.compression),
        epoch=options.epoch,
        attach_meshes=options.attach_meshes,
        topics=Topics(options.topics),
        viewer=ViewerOptions(options.viz_pairs, options.viz_triangles) if options.log == "full" else None,
    )


def _rate(scene: Scene, options: RunOptions) -> float:
    """Return how many snapshots a second are taken, Hz."""
    if options.rate is not None:
        return options.rate
    return max(USUAL_RATE, LEAST_SNAPSHOTS / (scene.end - scene.start))


def _settings(scene: Scene, settings: Settings, options: RunOptions) -> Settings:
    """Return the file's settings with the command line's over them."""
    least = least_duration(scene.start, scene.end)
    given = {"time_resolution": options.time_resolution, "contact_tolerance": options.contact_tolerance}
    chosen = {name: value for name, value in given.items() if value is not None}
    if options.margin is not None and not 0.0 <= options.margin < inf:
        raise click.BadParameter(f"expected 0 m or more, got {options.margin}.", param_hint="--margin")
    for name, value in chosen.items():
        if not least <= value < inf:
            option = "--" + name.replace("_", "-")
            raise click.BadParameter(f"expected at least {least:.3g} s, got {value}.", param_hint=option)
    margin = settings.margin if options.margin is None else options.margin
    share = settings.distance_tolerance if options.distance_tolerance is None else options.distance_tolerance
    return replace(settings, margin=margin, distance_tolerance=None if share == "none" else share, **chosen)
