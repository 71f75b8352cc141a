"""A run's log: its facts as they come, its inputs, and its summary at the end."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from foxglove_schemas_protobuf.Log_pb2 import Log

from closecall import __version__

from ...scheduler.events import Collision, Distance, Event, Phase, Span, Wakeup
from ...scheduler.scene import Settings
from ..scene.loaded import LoadedScene
from . import messages_pb2 as pb
from .chunks import ChunkWriter, Compression, MessageT, Topic
from .clock import LATEST_LOG_TIME_NS, nanoseconds
from .contents import (
    METADATA,
    METADATA_AT_START,
    SCENE,
    SETTINGS,
    SUMMARY,
    identity,
    mesh_attachment,
    mesh_bytes,
    settings_json,
)
from .errors import LogError
from .facts import FactFiller
from .output import Output
from .summary import Summary, SummaryBuilder, to_json


@dataclass(frozen=True, slots=True)
class LogOptions:
    """What the log shall hold.

    Attributes:
        compression: of the chunks.
        epoch: ns, added to every log time and timestamp.
        attach_meshes: whether mesh files travel with the log, so that it alone is enough to re-check the run;
            their SHA-256 does always.
    """

    compression: Compression = Compression.ZSTD
    epoch: int = 0
    attach_meshes: bool = True


class LogWriter:
    """Writes a run's log, as a context manager: events inside, the finished file only after a clean end.

    Until then the log is `partial`, beside the output. An exception inside leaves it there, unfinished but
    readable up to its last chunk, and the output untouched.

    Args:
        path: the output; an existing file is replaced at the end.
        loaded: the scene as read.
        settings: as resolved for this run.
        pairs_total: how many pairs the rules let be checked.
        options: what the log shall hold.

    Raises:
        LogError: at once, for an output that cannot be written, is an input, or cannot hold the run's times;
            later, when the disk refuses.
    """

    def __init__(
        self, path: Path, loaded: LoadedScene, settings: Settings, pairs_total: int, options: LogOptions
    ) -> None:
        self._output = Output(path, [loaded.path, *(mesh.path for mesh in loaded.mesh_files)])
        self._loaded = loaded
        self._settings = settings
        self._pairs_total = pairs_total
        self._options = options
        self._start = self._log_time(loaded.scene.start)
        self._end = self._log_time(loaded.scene.end)
        self._require_times()
        self._identity = identity(loaded, settings, pairs_total, options.epoch)
        self._summary = SummaryBuilder(loaded.scene, settings, pairs_total)
        self._filler = FactFiller(tuple(body.name for body in loaded.scene.bodies))
        wakeup, distance, collision, span, log = pb.Wakeup(), pb.Distance(), pb.Collision(), pb.Span(), Log()
        log.name = "closecall"
        self._wakeups = Topic("/wakeups", wakeup, wakeup.timestamp)
        self._distances = Topic("/distances", distance, distance.timestamp)
        self._collisions = Topic("/collisions", collision, collision.timestamp)
        self._spans = Topic("/spans", span, span.timestamp)
        self._log = Topic("/log", log, log.timestamp)

    @property
    def partial(self) -> Path:
        """The file that holds the log until it is finished, and after a fault."""
        return self._output.partial

    def __enter__(self) -> Self:
        stream = self._output.open()
        try:
            with self._faults_named():
                self._chunks = ChunkWriter(stream, self._options.compression, f"closecall {__version__}")
                self._write_inputs()
                self._write_opening()
        except BaseException:
            self._output.discard()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        if fault is not None:
            self._abandon()
            return
        try:
            with self._faults_named():
                self._write_closing()
                self._chunks.finish()
                self._output.publish()
        finally:
            self._output.abandon()

    def write(self, event: Event) -> None:
        """Add a fact under its own time, which may lie before facts already written."""
        self._summary.add(event)
        match event:
            case Wakeup():
                self._filler.fill_wakeup(self._wakeups.message, event)
                self._add(self._wakeups, event.time)
            case Distance():
                self._filler.fill_distance(self._distances.message, event)
                self._add(self._distances, event.time)
            case Collision():
                self._filler.fill_collision(self._collisions.message, event)
                self._add(self._collisions, event.time)
                self._tell_collision(event)
            case Span():
                self._filler.fill_span(self._spans.message, event)
                self._add(self._spans, event.time)

    def warn(self, message: str, time: float | None = None) -> None:
        """Add a warning to /log, at the scene time `time` or else at the start."""
        self._tell(Log.WARNING, message, self._loaded.scene.start if time is None else time)

    def summary(self) -> Summary:
        """Return the summary of what was written so far."""
        return self._summary.summary()

    def _log_time(self, time: float) -> int:
        return nanoseconds(time) + self._options.epoch

    def _require_times(self) -> None:
        path = self._output.path
        if self._start < 0:
            least = self._options.epoch - self._start
            raise LogError(path, "log times would begin before 0", f"give an --epoch of at least {least}")
        if self._end > LATEST_LOG_TIME_NS:
            most = self._options.epoch - (self._end - LATEST_LOG_TIME_NS)
            raise LogError(path, "log times would pass 2^63 ns", f"give an --epoch of at most {most}")

    @contextmanager
    def _faults_named(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise self._output.fault(error) from error

    def _add(self, topic: Topic[MessageT], time: float) -> None:
        try:
            self._chunks.add_message(topic, self._log_time(time))
        except OSError as error:
            raise self._output.fault(error) from error

    def _tell(self, level: Log.Level.ValueType, message: str, time: float) -> None:
        self._log.message.level = level
        self._log.message.message = message
        self._add(self._log, time)

    def _tell_collision(self, event: Collision) -> None:
        pair = self._filler.pair_name(event.pair)
        bracket = f"(touching at {event.time_touching!r} s, clear at {event.time_clear!r} s)"
        if event.phase is Phase.BEGIN:
            # The level that stands out in a viewer's log panel, and is left alone by its filter.
            self._tell(Log.ERROR, f"{pair}: contact begins {bracket}", event.time)
        else:
            self._tell(Log.INFO, f"{pair}: contact ends {bracket}", event.time)

    def _write_inputs(self) -> None:
        self._chunks.add_metadata(METADATA_AT_START, self._identity)
        kind = "application/json" if self._loaded.path.suffix == ".json" else "application/yaml"
        self._chunks.add_attachment(SCENE, kind, self._loaded.source, self._start)
        settings = settings_json(self._settings).encode()
        self._chunks.add_attachment(SETTINGS, "application/json", settings, self._start)
        if self._options.attach_meshes:
            for mesh in {mesh.sha256: mesh for mesh in self._loaded.mesh_files}.values():
                kind = "application/octet-stream"
                self._chunks.add_attachment(mesh_attachment(mesh), kind, mesh_bytes(mesh), self._start)
        self._chunks.flush()

    def _write_opening(self) -> None:
        scene = self._loaded.scene
        self._tell(
            Log.INFO,
            f"closecall {__version__} runs {self._loaded.path.name}: {len(scene.bodies)} bodies, "
            f"{self._pairs_total} pairs, from {scene.start!r} s to {scene.end!r} s",
            scene.start,
        )
        for warning in self._loaded.warnings:
            self.warn(warning)

    def _write_closing(self) -> None:
        summary = self._summary.summary()
        totals = summary["totals"]
        verdicts = ", ".join(f"{count} {verdict}" for verdict, count in totals["pairs"].items())
        self._tell(
            Log.INFO,
            f"finished: of {self._pairs_total} pairs {verdicts}; {totals['contacts']} contacts, "
            f"{totals['wakeups']} wakeups",
            self._loaded.scene.end,
        )
        self._chunks.flush()
        topics = (self._wakeups, self._distances, self._collisions, self._spans, self._log)
        counts = {f"count{topic.name}": str(topic.written) for topic in topics}
        self._chunks.add_metadata(METADATA, self._identity | counts)
        self._chunks.add_attachment(SUMMARY, "application/json", to_json(summary).encode(), self._end)

    def _abandon(self) -> None:
        # The fault under way matters more than a disk that refuses the last chunk too.
        with suppress(OSError):
            self._chunks.salvage()
        self._output.abandon()
