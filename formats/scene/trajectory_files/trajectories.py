"""Trajectory files to poses at times: the layouts of TUM, EuRoC and KITTI, and comma-separated values with a header."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from decimal import Context, Decimal
from itertools import pairwise
from typing import Literal

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ..limits import LARGEST_DOCUMENT
from ..quantities.arrays import read_only
from ..quantities.poses import turns_between
from ..text.errors import counted, quoted
from .csv_layout import read_csv
from .euroc import read_euroc
from .kitti import Clock, Stamps, read_kitti
from .rotations import read_rotations, turns_told
from .table import Faults, Layout, Table, TrajectoryError, read_table, word_rows

__all__ = ["LARGEST_TRAJECTORY", "Trajectory", "TrajectoryError", "read_trajectory"]

LARGEST_TRAJECTORY = 4 * LARGEST_DOCUMENT
"""Bytes. A larger trajectory file, of some 3 million poses, is refused before it is parsed."""

Duplicates = Literal["error", "first", "last"]
"""What is done with poses at one time: refused, or the first or the last of them kept."""

_QUATERNION = ("qw", "qx", "qy", "qz")
_MATRIX = tuple(f"r{row}{column}" for row in range(3) for column in range(3))

_EXACT = Context(prec=450)
"""Digits enough for sums of times: at most 16 before the point, 324 (the least float's) + LONGEST_TIME behind it."""

_TUM = Layout(
    width=8,
    columns=((0, "timestamp"), (1, "tx"), (2, "ty"), (3, "tz"), (7, "qw"), (4, "qx"), (5, "qy"), (6, "qz")),
    expected="8 columns (timestamp tx ty tz qx qy qz qw)",
)


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Poses at increasing times; arrays are read-only.

    Attributes:
        times: (n,) s, increasing, n >= 1, the float64 nearest to the file's decimals.
        translations: (n, 3), in the file's unit of length.
        quaternions: (n, 4) w x y z of length 1, each in the sign that the file has.
        lines: (n,) the line of the file in which each pose begins, from 1.
        exact_times: n, s, those decimals themselves.
        warnings: what is doubtful in the file.
        turns: what is doubtful in turning from pose to pose.
        stretch, loose: how far its worst rotation stretches, less 1, and what is to be told of such ones, if anything.
    """

    times: FloatArray
    translations: FloatArray
    quaternions: FloatArray
    lines: IntArray
    exact_times: tuple[Decimal, ...]
    warnings: tuple[str, ...]
    turns: tuple[str, ...] = ()
    stretch: float = 0.0
    loose: str = ""

    def only(self, kept: IntArray) -> Trajectory:
        """Return the poses with these indices."""
        return replace(
            self,
            times=read_only(self.times[kept]),
            translations=read_only(self.translations[kept]),
            quaternions=read_only(self.quaternions[kept]),
            lines=read_only(self.lines[kept]),
            exact_times=tuple(self.exact_times[index] for index in kept),
        )

    def in_scene_time(self, origin: Literal["first", "zero"], t0: float) -> Trajectory:
        """Return the trajectory on the clock of which t0 (s) is its first pose's time, or its own clock's 0.

        Every time is the float64 nearest to the exact sum: times since 1970 are 2.4e-7 s apart in float64, so that
        differences of `times` are off by as much.
        """
        shift = _EXACT.subtract(Decimal(t0), self.exact_times[0] if origin == "first" else 0)
        if not shift:
            return self
        exact_times = tuple(_EXACT.add(time, shift) for time in self.exact_times)
        times: FloatArray = np.fromiter(map(float, exact_times), np.float64, len(exact_times))
        return replace(self, times=read_only(times), exact_times=exact_times)


def read_trajectory(
    data: bytes,
    layout: str,
    max_gap: float | None = None,
    radians_per_unit: float = 1.0,
    duplicates: Duplicates = "error",
    clock: Clock | None = None,
    length_unit: str = "m",
) -> Trajectory:
    """Return what a trajectory file holds.

    Args:
        data: the file.
        layout: `tum`, lines of `timestamp tx ty tz qx qy qz qw`; `euroc`, lines of `timestamp,x,y,z,qw,qx,qy,qz` in ns;
            `kitti`, lines of 3x4 matrices; or `csv`, whose header names `t x y z` in any order and, if the body turns,
            `qw qx qy qz` or `roll pitch yaw` (about fixed axes x, y, z in this order).
        max_gap: s, the longest time allowed between successive poses; None allows any.
        radians_per_unit: rad, the unit of roll, pitch and yaw.
        duplicates: what is done with successive poses at one time.
        clock: when the poses are, of kitti alone.
        length_unit: of the file, for its warnings.

    Raises:
        TrajectoryError: the file has a fault; that nearest to its start is told, others are counted.
    """
    if len(data) > LARGEST_TRAJECTORY:
        raise TrajectoryError(f"the file has {len(data)} bytes, expected up to {LARGEST_TRAJECTORY}")
    table, rotation, warnings = _read_table(data, layout, clock)
    if len(table.lines) == 0:
        raise TrajectoryError("the file has no poses, expected at least one")
    faults = Faults()
    time_faults = Faults(of_times=True) if isinstance(clock, Stamps) else faults
    rotations = read_rotations(table.numbers[:, 4 : 4 + len(rotation)], table.lines, radians_per_unit, faults)
    kept = _kept(table.exact_times, duplicates)
    _check_times(table, clock.lines if isinstance(clock, Stamps) else table.lines, kept, max_gap, time_faults)
    faults.raise_any()
    time_faults.raise_any()
    poses = Trajectory(
        times=table.numbers[:, 0],
        translations=table.numbers[:, 1:4],
        quaternions=rotations.quaternions,
        lines=table.lines,
        exact_times=table.exact_times,
        warnings=warnings,
        stretch=rotations.stretch,
        loose=rotations.loose,
    )
    of_duplicates = _of_duplicates(poses, kept, duplicates, length_unit)
    poses = poses.only(kept)
    angles = None if rotations.angles is None else rotations.angles[kept]
    of_turns = turns_told(poses.quaternions, angles, poses.lines)
    return replace(poses, warnings=(*poses.warnings, *of_duplicates), turns=of_turns)


def _read_table(data: bytes, layout: str, clock: Clock | None) -> tuple[Table, tuple[str, ...], tuple[str, ...]]:
    """Return the rows of a file: time, place and rotation; how the rotation is written; and warnings."""
    if layout == "csv":
        table, header = read_csv(data)
        return table, header.rotation, header.warnings
    if layout == "tum":
        return _read_tum(data), _QUATERNION, ()
    if layout == "euroc":
        return read_euroc(data), _QUATERNION, ()
    if layout == "kitti" and clock is not None:
        return read_kitti(data, clock), _MATRIX, ()
    raise ValueError(f"unknown layout {layout!r}, or no clock for it")


def _read_tum(data: bytes) -> Table:
    faults = Faults()
    table = read_table(word_rows(data), _TUM, faults)
    faults.raise_any()
    return table


def _kept(times: tuple[Decimal, ...], duplicates: Duplicates) -> IntArray:
    """Return which poses are kept of those at successive times (s): of equal ones the first or the last, or all."""
    changes = np.array([before != after for before, after in pairwise(times)], dtype=bool)
    all_kept = np.ones(len(times), dtype=bool)
    if duplicates == "first":
        all_kept[1:] = changes
    elif duplicates == "last":
        all_kept[:-1] = changes
    return np.flatnonzero(all_kept)


def _check_times(table: Table, lines_of_times: IntArray, kept: IntArray, max_gap: float | None, faults: Faults) -> None:
    """Record where the times of the poses kept do not increase, are too near to differ, or leave a gap."""
    times, lines = table.numbers[kept, 0], lines_of_times[kept].tolist()
    exact = [table.exact_times[index] for index in kept]
    steps = np.diff(times)
    fuzz = 4.0 * float(np.spacing(2.0 * np.abs(times).max()))
    for i in np.flatnonzero(steps <= fuzz).tolist():
        before, after = exact[i], exact[i + 1]
        if after == before:
            shown = quoted(float(after))
            problem = f"lines {lines[i]} and {lines[i + 1]} are both at {shown} s, expected one pose at a time"
            faults.add(lines[i + 1], f"{problem}, or duplicates: first or last")
        elif after < before:
            problem = f"expected a time after that of line {lines[i]}"
            faults.add(lines[i + 1], f"{problem} ({quoted(float(before))} s), got {quoted(float(after))} s")
        elif steps[i] == 0.0 or _since(exact[0], before) == _since(exact[0], after):
            apart = quoted(_since(before, after))
            problem = f"lines {lines[i]} and {lines[i + 1]} are {apart} s apart, too little to be told apart"
            faults.add(lines[i + 1], f"{problem} beside the file's other times")
    if max_gap is None:
        return
    for i in np.flatnonzero(steps > max_gap - fuzz).tolist():
        gap = _since(exact[i], exact[i + 1])
        if gap > max_gap:
            between = f"lines {lines[i]} and {lines[i + 1]} are {quoted(gap)} s apart"
            faults.add(lines[i + 1], f"{between}, expected at most {quoted(max_gap)} s (max_gap)")


def _since(before: Decimal, after: Decimal) -> float:
    """Return the s from one time to another, the float64 nearest to the exact difference."""
    return float(_EXACT.subtract(after, before))


def _of_duplicates(poses: Trajectory, kept: IntArray, duplicates: Duplicates, unit: str) -> tuple[str, ...]:
    """Return the warning of poses that are left out for others at their times, and of how far they are from those."""
    left_out = np.setdiff1d(np.arange(len(poses.lines)), kept)
    if not len(left_out):
        return ()
    instead = kept[np.searchsorted(kept, left_out) - (duplicates == "first")]
    apart = float(np.linalg.norm(poses.translations[left_out] - poses.translations[instead], axis=1).max())
    turned = math.degrees(turns_between(poses.quaternions[left_out], poses.quaternions[instead]).max())
    text = f"has {counted(len(left_out), 'pose')} at the time of another, first in line {poses.lines[left_out[0]]}"
    difference = f"they differ by up to {apart:.3g} {unit} and {turned:.3g} degrees"
    return (f"{text}: the {duplicates} of each is taken, {difference}",)
