"""A small scene with one of everything viewers show, run into logs, and read back without closecall."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, radians, sin
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from closecall.formats.log.viewer.viewer import ViewerOptions
from closecall.formats.log.writer import LogOptions, LogWriter
from closecall.formats.scene.reader import read_scene
from closecall.scheduler.model.events import Snapshot
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide
from closecall.scheduler.run import run
from closecall.scheduler.snapshots.schedule import observed, snapshot_times
from closecall.scheduler.snapshots.snapshot import Observer

# The hammer falls on the anvil and leaves it again; the pin hangs on the carriage through a frame without shapes.
SCENE = """\
closecall: 1
units: {length: m, angle: deg}
time: {start: 0.5, end: 1.5}
meshes:
  wedge: {file: wedge.obj, units: m}
bodies:
  floor: {pose: {xyz: [0, 0, -2], rpy: [0, 0, 30]}, shapes: [{box: [6, 6, 0.5]}]}
  anvil: {pose: {xyz: [0, 0, -1]}, shapes: [{sphere: 0.5}, {mesh: wedge, pose: {xyz: [0.4, 0, 0.1]}}]}
  hammer:
    pose: {xyz: [0, 0, 0.8]}
    shapes: [{mesh: wedge, pose: {xyz: [0.1, 0, 0], rpy: [0, 0, 90]}}]
    motion: {type: harmonic, direction: [0, 0, -1], amplitude: 1.6, period: 1, phase: 90}
  pin: {parent: joint, pose: {xyz: [0.3, 0, 0]}, shapes: [{capsule: {radius: 0.1, length: 0.6}}]}
  joint: {parent: carriage, motion: {type: constant, angular_velocity: [0, 0, 400]}}
  carriage: {shapes: [{sphere: 0.2}], motion: {type: constant, velocity: [3, 0, 0]}}
pairs:
  ignore: [{between: [pin, carriage], reason: joined}]
"""
MOVING = ["hammer", "pin", "joint", "carriage"]
WEDGE = """\
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""


@dataclass
class Shown:
    """A log and the snapshots that were written to it."""

    path: Path
    snapshots: list[Snapshot]

    def decoded(self) -> Iterator[tuple[str, int, Any]]:
        """Yield topic, log time (ns) and message."""
        with self.path.open("rb") as file:
            reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
            for _, channel, record, message in reader.iter_decoded_messages():
                yield channel.topic, record.log_time, message

    def messages(self, topic: str) -> list[tuple[int, Any]]:
        """Return a topic's log times (ns) and messages."""
        return [(time, message) for name, time, message in self.decoded() if name == topic]

    def attachment(self, name: str) -> bytes | None:
        """Return a file of the log, None if it is not there."""
        with self.path.open("rb") as file:
            return next((entry.data for entry in make_reader(file).iter_attachments() if entry.name == name), None)


def write_scene(folder: Path, text: str = SCENE) -> Path:
    """Write the scene with its mesh; return its path."""
    (folder / "wedge.obj").write_text(WEDGE)
    path = folder / "scene.yaml"
    path.write_text(text)
    return path


def show(scene: Path, out: Path, *, rate: float = 30.0, viewer: ViewerOptions | None = None, **options: Any) -> Shown:
    """Run a scene into a log with viewer topics, at `rate` Hz."""
    viewer = viewer or ViewerOptions()
    loaded = read_scene(scene, ())
    narrow_phase = NarrowPhase(loaded.scene.bodies)
    pairs = tuple(pairs_that_might_collide(loaded.scene, narrow_phase, loaded.settings.margin))
    observer = Observer(loaded.scene, pairs, viewer.pairs, narrow_phase)
    events = run(pairs, loaded.settings)
    snapshots = []
    with LogWriter(out, loaded, loaded.settings, len(pairs), LogOptions(viewer=viewer, **options)) as log:
        for event in observed(events, observer, snapshot_times(loaded.scene, rate), loaded.settings.time_resolution):
            log.write(event)
            if isinstance(event, Snapshot):
                snapshots.append(event)
    return Shown(out, snapshots)


def seen_by(view: dict[str, Any], points: np.ndarray) -> np.ndarray:
    """Return what `seen` does, for the camera of a layout."""
    return seen(points, view["distance"], view["phi"], view["thetaOffset"], np.array(view["targetOffset"]))


def seen(points: np.ndarray, distance: float, phi: float, theta: float, target: np.ndarray) -> np.ndarray:
    """Return the points' slopes off the axis and depths, (n, 3), for a camera as Foxglove places it."""
    tilt, turn = radians(phi), radians(theta)
    place = target + distance * np.array((-sin(tilt) * sin(turn), -sin(tilt) * cos(turn), cos(tilt)))
    forward = (target - place) / np.linalg.norm(target - place)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    depths = (points - place) @ forward
    across, upright = (points - place) @ right, (points - place) @ np.cross(right, forward)
    return np.column_stack((across / depths, upright / depths, depths))
