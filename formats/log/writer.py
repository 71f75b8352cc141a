"""A run's log: its facts as they come, its inputs, and its summary at the end."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from types import TracebackType
from typing import Self

from foxglove_schemas_protobuf.Log_pb2 import Log

from closecall import __version__

from ...scheduler.model.events import (
    Collision,
    Distance,
    Event,
    Phase,
    Snapshot,
    Span,
    Verdict,
    Wakeup,
    Window,
)
from ...scheduler.model.scene import Settings
from ..scene.loaded import LoadedScene
from . import messages_pb2 as pb
from .container.chunks import Channel, ChunkWriter, Compression, MessageT, Topic
from .container.clock import LATEST_LOG_TIME_NS, coarseness_told, nanoseconds
from .container.contents import (
    LAYOUT,
    METADATA,
    METADATA_AT_START,
    SCENE,
    SETTINGS,
    SUMMARY,
    input_bytes,
    input_files,
    settings_json,
)
from .container.identity import identity
from .container.output import LOG, destination
from .doubts import doubts
from .errors import LogError
from .messages import FactFiller
from .summary import Summary, SummaryBuilder, subject_of, to_json
from .viewer.pictures import Picture
from .viewer.viewer import Viewer, ViewerOptions
from .viewer.wire import Pieces

# The file counts its channels with 16 bits; the topics that are not of a body have the rest.
_MOST_BODY_TOPICS = 65_000


class Topics(Enum):
    """Whether distances go to one topic, or to one for each first body: `/distances/<body_a>`."""

    SINGLE = "single"
    BODY = "body"


@dataclass(frozen=True, slots=True)
class LogOptions:
    """What the log shall hold.

    Attributes:
        compression: of the chunks.
        epoch: ns, added to every log time and timestamp.
        attach_meshes: whether mesh files travel with the log, so that it alone is enough to re-check the run;
            their SHA-256 does always.
        topics: where distances go.
        viewer: what viewers are shown; None for the certificate alone.
    """

    compression: Compression = Compression.ZSTD
    epoch: int = 0
    attach_meshes: bool = True
    topics: Topics = Topics.SINGLE
    viewer: ViewerOptions | None = None


class LogWriter:
    """Writes a run's log, as a context manager: events inside, the finished file only after a clean end.

    Until then the log is `partial`, beside the output. An exception inside leaves it there, unfinished but
    readable up to its last chunk, unless no event was written yet; and the output untouched.

    Args:
        path: the output; an existing file is replaced at the end.
        loaded: the scene as read.
        settings: as resolved for this run.
        pairs_total: how many pairs the rules let be checked.
        options: what the log shall hold.

    Raises:
        LogError: at once, for an output that cannot be written, is an input, or cannot hold the run's times or
            topics; later, when the disk refuses.
    """

    def __init__(
        self, path: Path, loaded: LoadedScene, settings: Settings, pairs_total: int, options: LogOptions
    ) -> None:
        self._output = destination(path, [loaded.path, *(file.path for _, file in input_files(loaded))], LOG)
        self._loaded = loaded
        self._settings = settings
        self._pairs_total = pairs_total
        self._options = options
        self._start = self._log_time(loaded.scene.start)
        self._end = self._log_time(loaded.scene.end)
        self._require_times()
        self._require_topics()
        self._identity = identity(loaded, settings, pairs_total, options.epoch)
        self._filler = FactFiller(tuple(body.name for body in loaded.scene.bodies), loaded.key_names)
        self._summary = SummaryBuilder(subject_of(loaded.scene, settings, pairs_total), self._filler.keys_around)
        wakeup, distance, collision, span, log = pb.Wakeup(), pb.Distance(), pb.Collision(), pb.Span(), Log()
        window = pb.Window()
        log.name = "closecall"
        self._wakeups = Topic("/wakeups", wakeup, wakeup.timestamp)
        self._distances = Topic("/distances", distance, distance.timestamp)
        self._distances_by_body: dict[int, Topic[pb.Distance]] = {}
        self._collisions = Topic("/collisions", collision, collision.timestamp)
        self._spans = Topic("/spans", span, span.timestamp)
        self._windows = Topic("/windows", window, window.timestamp)
        self._log = Topic("/log", log, log.timestamp)
        self._viewer = None if options.viewer is None else Viewer(loaded.scene, options.viewer)
        self._empty = True

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

    def write(self, event: Event | Picture) -> None:
        """Add a fact under its own time, which may lie before facts already written; or what viewers are shown."""
        self._empty = False
        if isinstance(event, Picture):
            self._show_picture(event)
            return
        self._summary.add(event)
        match event:
            case Wakeup():
                self._filler.fill_wakeup(self._wakeups.message, event)
                self._add(self._wakeups, event.time)
            case Distance():
                self._filler.fill_distance(self._distances.message, event)
                self._add(self._distance_topic(event), event.time)
            case Collision():
                self._filler.fill_collision(self._collisions.message, event)
                self._add(self._collisions, event.time)
                self._tell_collision(event)
            case Span():
                self._filler.fill_span(self._spans.message, event)
                self._add(self._spans, event.time)
                if event.verdict is Verdict.BREACH:
                    between = f"from {event.start!r} s to {event.end!r} s"
                    pair = self._filler.pair_name(event.pair)
                    self._tell(Log.WARNING, f"{pair}: closer than the margin {between}", event.time)
            case Window():
                self._filler.fill_window(self._windows.message, event)
                self._add(self._windows, event.time)
            case Snapshot():
                if self._viewer is not None:
                    log_time = self._log_time(event.time)
                    self._show(self._viewer.shown(event, log_time), log_time)

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
            raise LogError(path, "log times would start before 0", f"give an --epoch of at least {least}")
        if self._end > LATEST_LOG_TIME_NS:
            most = self._options.epoch - (self._end - LATEST_LOG_TIME_NS)
            raise LogError(path, "log times would pass 2^63 ns", f"give an --epoch of at most {most}")

    def _require_topics(self) -> None:
        bodies = len(self._loaded.scene.bodies)
        if self._options.topics is Topics.BODY and bodies > _MOST_BODY_TOPICS:
            problem = f"a log cannot hold one topic for each of {bodies} bodies"
            raise LogError(self._output.path, problem, "run with --topics single")

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

    def _show_picture(self, picture: Picture) -> None:
        assert self._viewer is not None
        channels = {channel.name: channel for channel in self._viewer.channels}
        messages = ((channels[topic], pieces) for topic, pieces in picture.messages)
        self._show(messages, self._log_time(picture.time))

    def _show(self, messages: Iterable[tuple[Channel, Pieces]], log_time: int) -> None:
        with self._faults_named():
            for channel, pieces in messages:
                self._chunks.add_serialized(channel, b"".join(pieces), log_time)

    def _distance_topic(self, event: Distance) -> Topic[pb.Distance]:
        if self._options.topics is Topics.SINGLE:
            return self._distances
        topic = self._distances_by_body.get(event.pair.a)
        if topic is None:
            message = self._distances.message
            topic = Topic(f"{self._distances.name}/{message.body_a}", message, message.timestamp)
            self._distances_by_body[event.pair.a] = topic
        return topic

    def _tell(self, level: Log.Level.ValueType, message: str, time: float) -> None:
        self._log.message.level = level
        self._log.message.message = message
        self._add(self._log, time)

    def _tell_collision(self, event: Collision) -> None:
        pair = self._filler.pair_name(event.pair)
        bracket = f"(touching at {event.time_touching!r} s, clear at {event.time_clear!r} s)"
        for body in (event.pair.a, event.pair.b):
            bracket += self._keys_told(body, event.time)
        if event.phase is Phase.BEGIN:
            # The level that stands out in a viewer's log panel, and is left alone by its filter.
            self._tell(Log.ERROR, f"{pair}: contact begins {bracket}", event.time)
        else:
            self._tell(Log.INFO, f"{pair}: contact ends {bracket}", event.time)

    def _keys_told(self, body: int, time: float) -> str:
        before, after = self._filler.keys_around(body, time)
        told = [f"after {before!r}"] * bool(before) + [f"before {after!r}"] * bool(after)
        return f", {self._loaded.scene.bodies[body].name} {' and '.join(told)}" if told else ""

    def _write_inputs(self) -> None:
        self._chunks.add_metadata(METADATA_AT_START, self._identity)
        kind = "application/json" if self._loaded.path.suffix == ".json" else "application/yaml"
        self._chunks.add_attachment(SCENE, kind, self._loaded.source, self._start)
        settings = settings_json(self._settings).encode()
        self._chunks.add_attachment(SETTINGS, "application/json", settings, self._start)
        if self._options.attach_meshes:
            files = {f"{kind}/{file.sha256}": file for kind, file in input_files(self._loaded)}
            for name, file in files.items():
                self._chunks.add_attachment(name, "application/octet-stream", input_bytes(file), self._start)
        self._chunks.flush()

    def _write_opening(self) -> None:
        scene = self._loaded.scene
        self._tell(
            Log.INFO,
            f"closecall {__version__} runs {self._loaded.path.name}: {len(scene.bodies)} bodies, "
            f"{self._pairs_total} pairs, from {scene.start!r} s to {scene.end!r} s",
            scene.start,
        )
        for warning in self._loaded.warnings_by_name:
            self.warn(warning)
        coarse = coarseness_told(self._settings.contact_tolerance, scene.start, scene.end)
        if coarse:
            self._tell(Log.INFO, coarse, scene.start)
        if self._viewer is not None:
            self._show(self._viewer.opening(self._start), self._start)
            for remark in self._viewer.remarks:
                self._tell(Log.INFO, remark, scene.start)

    def _write_closing(self) -> None:
        summary = self._summary.summary()
        for doubt in doubts(summary["pairs"], self._loaded.length_unit):
            self.warn(doubt, self._loaded.scene.end)
        totals = summary["totals"]
        verdicts = ", ".join(f"{count} {verdict}" for verdict, count in totals["pairs"].items())
        self._tell(
            Log.INFO,
            f"finished: of {self._pairs_total} pairs {verdicts}; {totals['contacts']} contacts, "
            f"{totals['wakeups']} wakeups",
            self._loaded.scene.end,
        )
        self._chunks.flush()
        self._chunks.add_metadata(METADATA, self._identity | self._counts())
        if self._viewer is not None:
            self._chunks.add_attachment(LAYOUT, "application/json", self._viewer.layout(summary), self._start)
        self._chunks.add_attachment(SUMMARY, "application/json", to_json(summary).encode(), self._end)

    def _counts(self) -> dict[str, str]:
        """Return how many messages each topic has; distances by body are counted together."""
        channels: list[Channel] = [self._wakeups, self._distances, self._collisions, self._spans, self._log]
        channels += [self._windows] * bool(self._windows.written)
        if self._viewer is not None:
            channels += self._viewer.channels
        counts = {channel.name: channel.written for channel in channels}
        counts[self._distances.name] += sum(topic.written for topic in self._distances_by_body.values())
        return {f"count{name}": str(count) for name, count in counts.items()}

    def _abandon(self) -> None:
        if self._empty:
            self._output.discard()
            return
        # The fault under way matters more than a disk that refuses the last chunk too.
        with suppress(OSError):
            self._chunks.salvage()
        self._output.abandon()
