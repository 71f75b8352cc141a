"""One run: read the scene, schedule it, write the log."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

from ...formats.log.container.chunks import Compression
from ...formats.log.doubts import doubts
from ...formats.log.summary import Summary
from ...formats.log.viewer.viewer import ViewerOptions
from ...formats.log.writer import LogOptions, LogWriter, Topics
from ...formats.scene.loaded import LoadedScene
from ...scheduler.broad.active_pairs import ActivePairs
from ...scheduler.broad.broad_phase import BroadPhase
from ...scheduler.broad.windows import Sweeps
from ...scheduler.model.scene import Scene, Settings, least_duration
from ...scheduler.narrow.narrow_phase import NarrowPhase
from ...scheduler.pairs.pair_factory import PairFactory
from ...scheduler.parallel.merge import merged, observer_of
from ...scheduler.parallel.transport import Work
from ...scheduler.run import run as schedule
from ...scheduler.snapshots.schedule import observed, snapshot_times
from .errors import OptionError
from .options import FEW_PAIRS, RunOptions
from .rate import snapshot_rate, thinned
from .scenes import counted_pairs, load, require_few
from .sharing import Camera, told_by_workers
from .watcher import UNWATCHED, Events, Watcher
from .workers import processes

Told = tuple[Events, Callable[[], float]]
"""The events of a run, and then the wall-clock seconds inside FCL, summed over all processes."""


@dataclass(frozen=True, slots=True)
class Result:
    """The results of a run.

    Attributes:
        summary: the summary in the log, in SI units.
        warnings: one line each: about the scene, and about results that are less precise than usual.
        note: says so if snapshots were taken less often than usual.
        seconds: wall-clock seconds per stage. `schedule` is the loop with its measurements, `fcl` the part of it
            inside FCL, summed over all processes; `log` is writing.
        length_unit: that of the scene file, for texts that people read.
    """

    summary: Summary
    warnings: tuple[str, ...]
    note: str | None
    seconds: dict[str, float]
    length_unit: str = "m"

    def finds(self, wanted: Sequence[str]) -> bool:
        """Tell whether any pair has one of the wanted verdicts."""
        return any(pair["verdict"] in wanted for pair in self.summary["pairs"])


def run(
    scene: str | Path | LoadedScene,
    output: str | Path,
    options: RunOptions | None = None,
    *,
    watcher: Watcher = UNWATCHED,
    **changes: Any,
) -> Result:
    """Run a scene and write its log.

    Args:
        scene: the file, or a scene from `load`, for which `mesh_roots` and `max_bytes` have no effect.
        output: the log to write; `-` means standard output.
        options: of the run; None takes the defaults.
        watcher: is called as the run goes on.
        changes: options by name, which replace those of `options`.

    Raises:
        OptionError: for an option with a value that it cannot have.
        SceneError: for a scene that cannot be read, is wrong, or is refused.
        LogError: for a log that cannot be written.
        WorkerError: for workers that cannot be reached, or were lost.
    """
    options = (options or RunOptions()).changed(**changes)
    began = perf_counter()
    if not isinstance(scene, LoadedScene):
        scene = load(scene, mesh_roots=options.mesh_roots, max_bytes=options.max_bytes)
    settings = _settings(scene.scene, scene.settings, options)
    note = thinned(scene.scene.end - scene.scene.start, options.rate) if options.log == "full" else None
    loaded, total = counted_pairs(scene, options.strict)
    crowded = total > FEW_PAIRS if options.broad_phase == "auto" else options.broad_phase == "on"
    if not crowded:
        require_few(loaded, total, options.max_pairs)
    work = Work(loaded.scene, settings, crowded)
    ready = perf_counter()
    watcher.ready()
    writing = 0.0
    with LogWriter(Path(output), loaded, settings, total, log_options(options)) as log:
        alone = options.jobs == 1 and options.cluster is None
        told, fcl = _run_here(work, options) if alone else _run_by_workers(work, total, options, watcher)
        with closing(watcher.events(told, loaded.scene, not alone)) as events:
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


def log_options(options: RunOptions) -> LogOptions:
    """Return what the log holds."""
    return LogOptions(
        compression=Compression(options.compression),
        epoch=options.epoch,
        attach_meshes=options.attach_meshes,
        topics=Topics(options.topics),
        viewer=_viewer_options(options),
    )


def _run_here(work: Work, options: RunOptions) -> Told:
    """Run the scene in this process."""
    factory = PairFactory(work.scene, NarrowPhase(work.scene.bodies), work.settings.margin)
    pairs = () if work.crowded else tuple(factory.all())
    crowd = ActivePairs(factory, work.settings, BroadPhase(work.scene, Sweeps(factory))) if work.crowded else None
    events = schedule(pairs, work.settings, crowd)
    viewer = _viewer_options(options)
    if viewer is not None:
        observer = observer_of(factory, None if work.crowded else pairs, viewer.pairs)
        events = observed(events, observer, _times(work.scene, options), work.settings.time_resolution)
    return events, lambda: factory.narrow_phase.seconds


def _run_by_workers(work: Work, total: int, options: RunOptions, watcher: Watcher) -> Told:
    """Have the scene run by workers, which share its `total` pairs."""
    viewer = _viewer_options(options)
    times = [] if viewer is None else list(_times(work.scene, options))
    camera = None if viewer is None else Camera(times, viewer, options.epoch)
    with watcher.shares() as done:
        streams, pictures, fcl = told_by_workers(work, total, processes(options.jobs), options.cluster, camera, done)
    if camera is None:
        return merged(streams), lambda: fcl
    return observed(merged(streams), pictures, times, work.settings.time_resolution), lambda: fcl


def _viewer_options(options: RunOptions) -> ViewerOptions | None:
    """Return what viewers get, None for the certificate alone."""
    return ViewerOptions(options.viz_pairs, options.viz_triangles) if options.log == "full" else None


def _times(scene: Scene, options: RunOptions) -> Iterator[float]:
    """Yield when (s) snapshots are taken, besides at collisions."""
    return snapshot_times(scene, snapshot_rate(scene.end - scene.start, options.rate))


def _settings(scene: Scene, settings: Settings, options: RunOptions) -> Settings:
    """Return the scene's settings with the run's options over them.

    Raises:
        OptionError: for a duration that is too short for the scene's times.
    """
    least = least_duration(scene.start, scene.end)
    given = {"time_resolution": options.time_resolution, "contact_tolerance": options.contact_tolerance}
    chosen = {name: value for name, value in given.items() if value is not None}
    for name, value in chosen.items():
        if value < least:
            raise OptionError(name, f"expected at least {least:.3g} s, got {value}")
    margin = settings.margin if options.margin is None else options.margin
    share = settings.distance_tolerance if options.distance_tolerance is None else options.distance_tolerance
    return replace(settings, margin=margin, distance_tolerance=None if share == "none" else share, **chosen)
