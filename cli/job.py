"""One run: read the scene, schedule it, write the log, say what it took."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from time import perf_counter

import click

from ..formats.log.container.chunks import Compression
from ..formats.log.doubts import doubts
from ..formats.log.summary import Summary
from ..formats.log.viewer.pictures import Picture
from ..formats.log.viewer.viewer import ViewerOptions
from ..formats.log.writer import LogOptions, LogWriter, Topics
from ..formats.scene.loaded import LoadedScene
from ..formats.scene.reader import read_scene
from ..formats.scene.text.errors import SceneError, WarnedError, counted, whole_file
from ..scheduler.broad.active_pairs import ActivePairs
from ..scheduler.broad.broad_phase import BroadPhase
from ..scheduler.broad.windows import Sweeps
from ..scheduler.model.events import Event
from ..scheduler.model.pair_count import count_pairs
from ..scheduler.model.scene import Scene, Settings, least_duration
from ..scheduler.narrow.narrow_phase import NarrowPhase
from ..scheduler.pairs.pair_factory import PairFactory
from ..scheduler.parallel.merge import merged, observer_of
from ..scheduler.parallel.transport import Work
from ..scheduler.run import run
from ..scheduler.snapshots.schedule import observed, snapshot_times
from .faults import raise_interrupts
from .options import RunOptions
from .progress import HERE, TOLD, shares_shown, shown
from .rate import snapshot_rate, thinned
from .sharing import Camera, told_by_workers

Events = tuple[Generator[Event | Picture, None, None], Callable[[], float]]
"""What is told, and after that, the wall-clock seconds it took inside FCL, summed over all processes."""

#: Up to so many pairs each is watched throughout, and its least distance told. Of more, swept boxes say which are.
FEW_PAIRS = 1000


@dataclass(frozen=True, slots=True)
class Result:
    """The findings, warnings and notes of a run, and the wall-clock seconds of its parts.

    `length_unit` is that of the scene file, for texts that people read; the summary is in m.
    `schedule` is the loop with its measurements, of which `fcl` is a part, summed over all processes; `log` is writing.
    """

    summary: Summary
    warnings: tuple[str, ...]
    note: str | None
    seconds: dict[str, float]
    length_unit: str = "m"

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
    note = thinned(loaded.scene.end - loaded.scene.start, options.rate) if options.log == "full" else None
    loaded, total = counted_pairs(loaded, options.strict)
    crowded = total > FEW_PAIRS if options.broad_phase == "auto" else options.broad_phase == "on"
    if not crowded:
        require_few(loaded, total, options.max_pairs)
    work = Work(loaded.scene, settings, crowded)
    ready = perf_counter()
    raise_interrupts()
    writing = 0.0
    with LogWriter(output, loaded, settings, total, _log_options(options)) as log:
        alone = options.jobs == 1 and options.cluster is None
        if alone:
            events, fcl = _run_here(work, options)
        else:
            events, fcl = _run_by_workers(work, total, scene_path.name, options)
        if not options.quiet:
            events = shown(events, loaded.scene.start, loaded.scene.end, scene_path.name, HERE if alone else TOLD)
        with closing(events):
            for event in events:
                wrote = perf_counter()
                log.write(event)
                writing += perf_counter() - wrote
        scheduled = perf_counter()
        summary = log.summary()
    done = perf_counter()
    seconds = {
        "load": ready - began,
        "schedule": scheduled - ready - writing,
        "fcl": fcl(),
        "log": writing + done - scheduled,
        "total": done - began,
    }
    unit = loaded.length_unit
    return Result(summary, (*loaded.warnings, *doubts(summary["pairs"], unit)), note, seconds, unit)


def _run_here(work: Work, options: RunOptions) -> Events:
    """Run the scene in this process."""
    pairing = PairFactory(work.scene, NarrowPhase(work.scene.bodies), work.settings.margin)
    pairs = () if work.crowded else tuple(pairing.all())
    crowd = ActivePairs(pairing, work.settings, BroadPhase(work.scene, Sweeps(pairing))) if work.crowded else None
    events = run(pairs, work.settings, crowd)
    viewer = _viewer_options(options)
    if viewer is not None:
        observer = observer_of(pairing, None if work.crowded else pairs, viewer.pairs)
        events = observed(events, observer, _times(work.scene, options), work.settings.time_resolution)
    return events, lambda: pairing.narrow_phase.seconds


def _run_by_workers(work: Work, total: int, name: str, options: RunOptions) -> Events:
    """Have the scene, called `name`, run by workers, which share its `total` pairs."""
    viewer = _viewer_options(options)
    times = [] if viewer is None else list(_times(work.scene, options))
    camera = None if viewer is None else Camera(times, viewer, options.epoch)
    with shares_shown(name, options.quiet) as show:
        streams, pictures, fcl = told_by_workers(work, total, options.jobs, options.cluster, camera, show)
    if camera is None:
        return merged(streams), lambda: fcl
    return observed(merged(streams), pictures, times, work.settings.time_resolution), lambda: fcl


def counted_pairs(loaded: LoadedScene, strict: bool) -> tuple[LoadedScene, int]:
    """Return the scene with its last warnings, and how many pairs are to be checked.

    Raises:
        WarnedError: under `strict` for any warning.
    """
    pairs = count_pairs(loaded.scene).checked
    if not pairs:
        nothing = "nothing to check: no two bodies that may be checked move relative to each other"
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


def _log_options(options: RunOptions) -> LogOptions:
    """Return what the log shall hold."""
    return LogOptions(
        compression=Compression(options.compression),
        epoch=options.epoch,
        attach_meshes=options.attach_meshes,
        topics=Topics(options.topics),
        viewer=_viewer_options(options),
    )


def _viewer_options(options: RunOptions) -> ViewerOptions | None:
    """Return what viewers get, None for the certificate alone."""
    return ViewerOptions(options.viz_pairs, options.viz_triangles) if options.log == "full" else None


def _times(scene: Scene, options: RunOptions) -> Iterator[float]:
    """Yield when (s) snapshots are taken, besides at collisions."""
    return snapshot_times(scene, snapshot_rate(scene.end - scene.start, options.rate))


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
