"""A scene as read from a file: what the scheduler needs, and what the log keeps to prove where it came from."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import fmod, nextafter
from pathlib import Path

from ...scheduler.model.scene import Scene, Settings
from .text.errors import printable


@dataclass(frozen=True, slots=True)
class InputFile:
    """A file the scene refers to: its name in the scene, where it lies, and its bytes' SHA-256 (hex)."""

    name: str
    path: Path
    sha256: str


@dataclass(frozen=True, slots=True)
class KeyNames:
    """The named keys of a body's motion, in order of time.

    Attributes:
        times: of the named keys, scene s.
        names: as written.
        first, last: s, of all keys, named or not.
        before, after: whether the motion is repeated before the first and after the last key.
    """

    times: tuple[float, ...]
    names: tuple[str, ...]
    first: float
    last: float
    before: bool
    after: bool

    def around(self, time: float) -> tuple[str, str]:
        """Return the names of the last named key at or before a time (s) and of the first after it; empty for none.

        Where the keys repeat they follow one another: after the last named one comes the first.
        """
        loop, period = 0, self.last - self.first
        repeats = (time < self.first and self.before) or (time >= self.last and self.after)
        if repeats and period > 0.0:
            loop = -1 if time < self.first else 1
            since = fmod(time - self.first, period)
            within = self.first + (since if since >= 0.0 else since + period)
            time = min(within, nextafter(self.last, self.first))  # a float before the loop's end is not rounded onto it
        place = bisect_right(self.times, time)
        earlier = self.names[place - 1] if place or loop > 0 or self.before else ""
        later = self.names[place % len(self.names)] if place < len(self.names) or loop < 0 or self.after else ""
        return earlier, later


@dataclass(frozen=True, slots=True, eq=False)
class LoadedScene:
    """A scene file, read and checked.

    Attributes:
        path: the scene file.
        source: its bytes, as read.
        settings: the file's own settings over the defaults; command-line options override them.
        mesh_files: in document order, by the mesh's name.
        warnings: one line each, located like errors.
        trajectory_files: in document order, by the name of the body that moves so; files of times by BODY/times.
        length_unit: of the scene file, in which lengths are printed for people.
        key_names: by body, the names of the keys it moves by; of its own, or of the nearest ancestor that has any.
    """

    path: Path
    source: bytes
    scene: Scene
    settings: Settings
    mesh_files: tuple[InputFile, ...]
    warnings: tuple[str, ...]
    trajectory_files: tuple[InputFile, ...] = ()
    key_names: Mapping[int, KeyNames] = field(default_factory=dict)
    length_unit: str = "m"

    @property
    def warnings_by_name(self) -> tuple[str, ...]:
        """The warnings with the scene file's name alone: what a log holds does not rest on how its path was typed."""
        path, name = printable(str(self.path)), printable(self.path.name)
        return tuple(
            name + warning.removeprefix(path) if warning.startswith(path) else warning for warning in self.warnings
        )
