"""Paths given by poses at times: keyframes written in the scene, and trajectory files."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from decimal import Decimal
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from ....scheduler.geometry.arrays import FloatArray
from ....scheduler.motions import Fixed, Interval, Keyframes, Looped, Motion, Translation
from ..grammar.motions import FileMotion, Key, KeyframesMotion, PathMotion
from ..limits import SMALLEST_SIZE
from ..loaded import InputFile, KeyNames
from ..quantities.arrays import read_only
from ..quantities.poses import placement
from ..quantities.turns import spelling_of, turn_warnings, written_turn
from ..quantities.units import Scale, metres_of
from ..text.document import Findings
from ..text.errors import Where, printable, quoted
from ..text.folder import Folder, FolderError
from ..trajectory_files.kitti import Clock, Stamps, read_stamps
from ..trajectory_files.trajectories import LARGEST_TRAJECTORY, Trajectory, TrajectoryError, read_trajectory
from .names import name_problem, normal

Content = TypeVar("Content", Trajectory, Stamps)

_TRANSLATIONS = {"linear": Translation.LINEAR, "cubic": Translation.CUBIC, "step": Translation.STEP}


class _End(NamedTuple):
    """The first or last pose of a path: where the scene has it, and if that is a file, its name and line."""

    where: Where
    line: str = ""


class PathReader:
    """Reads the paths of one scene.

    Attributes:
        files: the trajectory files, by the body that moves so; files of times by BODY/times.
        key_names: the named keys, by the body that moves by them.
    """

    def __init__(self, folder: Folder, scale: Scale, findings: Findings, least_period: float) -> None:
        """Take where files may lie, the scene's units, what takes the faults, and how short (s) a loop may be."""
        self._folder = folder
        self._scale = scale
        self._findings = findings
        self._least_period = least_period
        self.files: list[InputFile] = []
        self.key_names: dict[str, KeyNames] = {}

    def keyframes(self, part: KeyframesMotion, body: str, needed: Interval) -> Motion:
        """Return the path through the keys; Fixed, with the faults recorded, if anything is wrong."""
        where: Where = ("bodies", body, "motion")
        keys = (*where, "keys")
        faults_before = len(self._findings.faults)
        _check_order(part.keys, keys, self._findings)
        times = np.array([key.t for key in part.keys]) + part.t0
        if len(self._findings.faults) == faults_before:
            ends = _End((*keys, 0, "t")), _End((*keys, len(part.keys) - 1, "t"))
            self._check_times(part, times, needed, ends, where)
        velocities = self._velocities(part, keys)
        placements = [placement(key, (*keys, i), self._scale, self._findings) for i, key in enumerate(part.keys)]
        names = self._names(part.keys, keys)
        if len(self._findings.faults) > faults_before:
            return Fixed()
        quaternions = np.array([place.quaternion for place in placements])
        if part.interpolation.rotation == "slerp":
            self._warn_of_turns(part.keys, quaternions, keys)
        if names:
            self._keep_names(part, body, times, names)
        translations = np.array([place.translation for place in placements])
        return _path(part, times, translations, quaternions, velocities)

    def trajectory(self, part: FileMotion, body: str, needed: Interval) -> Motion:
        """Return the path through a file's poses; Fixed, with the faults recorded, if anything is wrong."""
        where: Where = ("bodies", body, "motion")
        faults_before = len(self._findings.faults)
        self._check_layout(part, where)
        trajectory = self._read(part, body, where)
        if trajectory is None:
            return Fixed()
        times = trajectory.times
        shown = printable(part.file)
        first, last = (_End((*where, "file"), f"{shown}:{trajectory.lines[place]}: ") for place in (0, -1))
        self._check_times(part, times, needed, (first, last), where)
        if len(self._findings.faults) > faults_before:
            return Fixed()
        turns = trajectory.turns if part.interpolation.rotation == "slerp" else ()
        for warning in (*trajectory.warnings, *turns):
            self._findings.warn((*where, "file"), f"{shown}: {warning}")
        if trajectory.loose:
            self._findings.loose((*where, "file"), trajectory.stretch, f"{shown}: {trajectory.loose}")
        translations = metres_of(trajectory.translations, self._length_unit(part))
        return _path(part, times, translations, trajectory.quaternions, None)

    def _length_unit(self, part: FileMotion) -> str:
        return part.units or self._scale.length_unit if part.layout == "csv" else "m"

    def _check_layout(self, part: FileMotion, where: Where) -> None:
        """Record keys that a file's layout has no use for, or lacks."""
        if part.layout != "csv" and part.units is not None:
            self._findings.fault((*where, "units"), f"the {part.layout} layout is in m, leave the key out")
        clocks = [key for key in ("times", "period") if getattr(part, key) is not None]
        if part.layout == "kitti" and not clocks:
            problem = "the kitti layout has no times, expected times (a file) or period (seconds from pose to pose)"
            self._findings.fault((*where, "layout"), problem)
        elif part.layout == "kitti" and len(clocks) > 1:
            self._findings.fault((*where, "period"), "expected times or period, not both")
        elif part.layout != "kitti" and clocks:
            problem = f"the {part.layout} layout has times of its own, leave the key out"
            self._findings.fault((*where, clocks[0]), problem)

    def _read(self, part: FileMotion, body: str, where: Where) -> Trajectory | None:
        """Return what a trajectory file holds, in the scene's time."""
        clock = self._clock(part, body, (*where, "times")) if part.layout == "kitti" else None
        if part.layout == "kitti" and clock is None:
            return None

        def read(data: bytes) -> Trajectory:
            angle, unit = self._scale.angle(1.0), self._length_unit(part)
            return read_trajectory(data, part.layout, part.max_gap, angle, part.duplicates, clock, unit)

        trajectory = self._readable(part.file, normal(body), (*where, "file"), read, part.times)
        return None if trajectory is None else trajectory.in_scene_time(part.time_origin, part.t0)

    def _clock(self, part: FileMotion, body: str, where: Where) -> Clock | None:
        """Return when the poses of a file without times are; None if that is not said, or has a fault."""
        if part.times is not None:
            return self._readable(part.times, f"{normal(body)}/times", where, read_stamps)
        return None if part.period is None else Decimal(repr(part.period))

    def _readable(
        self, file: str, name: str, where: Where, read: Callable[[bytes], Content], times: str | None = None
    ) -> Content | None:
        """Return what a file holds, kept by a name among the scene's files; None, with the fault recorded, if none."""
        try:
            path = self._folder.found(file)
            data = _file_bytes(path)
            content = read(data)
        except FolderError as error:
            self._findings.fault(where, error.message)
            return None
        except OSError as error:
            problem = f"the file cannot be read: {error.strerror or error}"
            self._findings.fault(where, f"{printable(file)}: {problem}")
            return None
        except TrajectoryError as error:
            line = "" if error.line is None else f":{error.line}"
            if times is not None and error.of_times:
                file, where = times, (*where[:-1], "times")
            self._findings.fault(where, f"{printable(file)}{line}: {error.message}")
            return None
        self.files.append(InputFile(name, path, hashlib.sha256(data).hexdigest()))
        return content

    def _check_times(
        self, part: PathMotion, times: FloatArray, needed: Interval, ends: tuple[_End, _End], where: Where
    ) -> None:
        """Record a fault where the poses end before they may."""
        gaps = np.diff(times)
        if not np.all(gaps > 0.0):
            problem = f"times so near to each other are equal once {quoted(part.t0)} s is added"
            self._findings.fault((*where, "t0"), problem)
        elif not np.all(gaps >= SMALLEST_SIZE):
            problem = f"two poses are {quoted(float(gaps.min()))} s apart, expected at least {SMALLEST_SIZE:g} s"
            self._findings.fault(where, problem)
        first, last = float(times[0]), float(times[-1])
        begin, end = needed
        remedy = "or say before: hold or loop"
        if first > begin and part.before == "error":
            problem = f"{ends[0].line}expected the first pose at {quoted(begin)} s or before, {remedy}"
            self._findings.fault(ends[0].where, f"{problem}, got {quoted(first)} s")
        if last < end and part.after == "error":
            remedy = remedy.replace("before", "after")
            problem = f"{ends[1].line}expected the last pose at {quoted(end)} s or after, {remedy}"
            self._findings.fault(ends[1].where, f"{problem}, got {quoted(last)} s")
        for side in ("before", "after"):
            if getattr(part, side) == "loop":
                self._check_loop(times, (*where, side))

    def _check_loop(self, times: FloatArray, where: Where) -> None:
        period = float(times[-1] - times[0])
        if len(times) < 2:
            self._findings.fault(where, "one pose cannot be repeated, expected two or more, or hold")
        elif period < self._least_period:
            problem = f"poses over {period:.6g} s are too short a loop for the scene's time"
            self._findings.fault(where, f"{problem}, expected at least {self._least_period:.6g} s")

    def _warn_of_turns(self, keys: tuple[Key, ...], quaternions: FloatArray, where: Where) -> None:
        """Warn where slerp's way between two keys may not be the one that was meant."""
        spellings = [spelling_of(key, self._scale) for key in keys]
        written = np.array([written_turn(one, other) for one, other in pairwise(spellings)])
        for first, text in turn_warnings(quaternions, written, lambda i: f"keys {i} and {i + 1}", "key"):
            self._findings.warn((*where, first + 1), text)

    def _velocities(self, part: KeyframesMotion, where: Where) -> FloatArray | None:
        """Return the keys' velocities (n, 3) m/s, None where they have none."""
        given = [i for i, key in enumerate(part.keys) if key.velocity is not None]
        if not given:
            return None
        if part.interpolation.translation != "cubic":
            problem = "a key's velocity needs interpolation: {translation: cubic}, or leave it out"
            self._findings.fault((*where, given[0], "velocity"), problem)
        elif len(given) < len(part.keys):
            missing = next(i for i, key in enumerate(part.keys) if key.velocity is None)
            problem = f"expected a velocity at every key or at none, key {missing} has none"
            self._findings.fault((*where, given[0], "velocity"), problem)
        return np.array([self._scale.lengths(key.velocity or (0.0, 0.0, 0.0)) for key in part.keys])

    def _names(self, keys: tuple[Key, ...], where: Where) -> list[tuple[int, str]]:
        """Return the keys that have a name, by index."""
        named = [(i, normal(key.name)) for i, key in enumerate(keys) if key.name is not None]
        for i, name in named:
            problem = name_problem(name)
            if problem:
                self._findings.fault((*where, i, "name"), problem)
        return named

    def _keep_names(self, part: PathMotion, body: str, times: FloatArray, names: list[tuple[int, str]]) -> None:
        self.key_names[normal(body)] = KeyNames(
            times=tuple(float(times[i]) for i, _ in names),
            names=tuple(name for _, name in names),
            first=float(times[0]),
            last=float(times[-1]),
            before=part.before == "loop",
            after=part.after == "loop",
        )


def _file_bytes(path: Path) -> bytes:
    """Return the bytes of a trajectory file; pipes and devices, which may never end, are none.

    Raises:
        OSError, TrajectoryError: it cannot be read, or is too large.
    """
    if path.exists() and not path.is_file():
        raise TrajectoryError("expected a file")
    size = path.stat().st_size
    if size > LARGEST_TRAJECTORY:
        raise TrajectoryError(f"the file has {size} bytes, expected up to {LARGEST_TRAJECTORY}")
    return path.read_bytes()


def _path(
    part: PathMotion,
    times: FloatArray,
    translations: FloatArray,
    quaternions: FloatArray,
    velocities: FloatArray | None,
) -> Motion:
    keys = Keyframes(
        times=read_only(times),
        translations=read_only(translations),
        quaternions=read_only(quaternions),
        translation=_TRANSLATIONS[part.interpolation.translation],
        step_rotation=part.interpolation.rotation == "step",
        key_velocities=None if velocities is None else read_only(velocities),
    )
    before, after = part.before == "loop", part.after == "loop"
    return Looped(keys, before, after) if before or after else keys


def _check_order(keys: tuple[Key, ...], where: Where, findings: Findings) -> None:
    for i, (before, after) in enumerate(pairwise(keys), start=1):
        if after.t == before.t:
            findings.fault((*where, i, "t"), f"two keys at {quoted(after.t)} s, expected one pose at a time")
        elif after.t < before.t:
            problem = f"expected a time after the key before it ({quoted(before.t)} s), got {quoted(after.t)} s"
            findings.fault((*where, i, "t"), problem)
