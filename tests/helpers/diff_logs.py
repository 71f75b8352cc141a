"""A scene with a bit of everything, its runs, and edits of its logs: what the tests of `diff` and others share."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import trimesh
from mcap.records import Channel, Message
from rewritten_logs import Change

from closecall.cli.application.run import run
from closecall.cli.options import options_of
from closecall.formats.log.container.checks import TYPES

SCENE = """\
closecall: 1
units: {length: mm, angle: deg}
time: {start: 0, end: 2}
meshes: {dome: {file: dome.stl, units: mm}}
bodies:
  arm:
    shapes: [{box: [40, 40, 40]}]
    motion:
      type: keyframes
      keys:
        - {t: 0, xyz: [0, 0, 0], name: home}
        - {t: 1, xyz: [200, 0, 0], name: reach}
        - {t: 2, xyz: [0, 0, 0], name: back}
  wall: {pose: {xyz: [230, 0, 0]}, shapes: [{box: [40, 200, 200]}]}
  rail: {pose: {xyz: [100, 70, 0]}, shapes: [{box: [20, 20, 20]}]}
  cover: {pose: {xyz: [100, -80, 0], rpy: [20, 0, 35]}, shapes: [{mesh: dome}]}
  ball: {pose: {xyz: [-300, 0, 400]}, shapes: [{sphere: 10}], motion: {type: constant, velocity: [300, 0, 0]}}
  post: {pose: {xyz: [0, 24, 400]}, shapes: [{capsule: {radius: 10, length: 100}}]}
pairs: {margins: [{between: [ball, post], margin: 6}]}
"""


def write_scene(folder: Path, text: str = SCENE, subdivisions: int = 2) -> Path:
    """Write the scene and its mesh, an icosphere; return the scene file."""
    folder.mkdir(parents=True, exist_ok=True)
    trimesh.creation.icosphere(subdivisions, 30.0).export(folder / "dome.stl")
    path = folder / "scene.yaml"
    path.write_text(text)
    return path


def run_scene(scene: Path, log: Path, *options: str) -> Path:
    """Run a scene as `closecall run` does, inside this process; return the log."""
    run(scene, log, options_of(["--log", "certificate", *options]))
    return log


def edited(topic: str, edit: Callable[[Any], bool | None], first: int | None = None) -> Change:
    """Return a change of a topic's messages by `edit`, which may return False to drop one; of the first few alone."""
    count = 0

    def change(channel: Channel, message: Message) -> Iterable[Message]:
        nonlocal count
        if channel.topic != topic or (first is not None and count >= first):
            return [message]
        decoded: Any = TYPES[topic].FromString(message.data)
        before = decoded.SerializeToString()
        kept = edit(decoded)
        count += kept is False or decoded.SerializeToString() != before
        return [] if kept is False else [replace(message, data=decoded.SerializeToString())]

    return change


def with_last_bits(channel: Channel, message: Message) -> Iterable[Message]:
    """Change every double by its last bit, up or down, and each time by a nanosecond: as another machine's libm may."""
    kind = TYPES[channel.topic]
    if not kind.DESCRIPTOR.full_name.startswith("closecall."):
        return [message]
    decoded: Any = kind.FromString(message.data)
    _nudge(decoded)
    return [replace(message, log_time=max(0, message.log_time - 1), data=decoded.SerializeToString())]


def _nudge(message: Any) -> None:
    for field, value in message.ListFields():
        if (
            isinstance(value, float) and math.isfinite(value) and not value.is_integer()
        ):  # a scene's own start and end are exact
            up = value.as_integer_ratio()[0] % 4 == 1  # the same way for the same value
            setattr(message, field.name, math.nextafter(value, math.inf if up else -math.inf))
        elif field.message_type is not None and field.message_type.full_name.startswith("closecall."):
            _nudge(value)
