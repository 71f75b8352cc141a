"""Trajectory files to poses at times: the layout of the TUM benchmark, and comma-separated values with a header."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from decimal import Context, Decimal

import numpy as np

from ...scheduler.scene import FloatArray, IntArray
from .arrays import read_only
from .errors import counted, quoted
from .limits import AMBIGUOUS_TURN, LARGEST_DOCUMENT, QUATERNION_TOLERANCE, WIDE_TURN
from .poses import successive_turns
from .trajectory_csv import read_csv
from .trajectory_table import Faults, Layout, Row, Table, TrajectoryError, read_table, text_lines

__all__ = ["LARGEST_TRAJECTORY", "Trajectory", "TrajectoryError", "read_trajectory"]

LARGEST_TRAJECTORY = 4 * LARGEST_DOCUMENT
"""Bytes. A larger trajectory file, of some 3 million poses, is refused before it is parsed."""

UNTOLD_UNIT_ERROR = 1e-6
"""How far the length of a quaternion may be from 1 without a warning. Normalising then turns it by nothing."""

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
    """

    times: FloatArray
    translations: FloatArray
    quaternions: FloatArray
    lines: IntArray
    exact_times: tuple[Decimal, ...]
    warnings: tuple[str, ...]

    def shifted_to_first(self) -> Trajectory:
        """Return the trajectory with its first pose at 0 s, every time the float64 nearest to the exact difference.

        Times since 1970 are 2.4e-7 s apart in float64, so that differences of `times` are off by as much.
        """
        first = self.exact_times[0]
        exact_times = tuple(_EXACT.subtract(time, first) for time in self.exact_times)
        times: FloatArray = np.fromiter(map(float, exact_times), np.float64, len(exact_times))
        return replace(self, times=read_only(times), exact_times=exact_times)


def read_trajectory(
    data: bytes, layout: str, max_gap: float | None = None, radians_per_unit: float = 1.0
) -> Trajectory:
    """Return what a trajectory file holds.

    Args:
        data: the file.
        layout: `tum`, lines of `timestamp tx ty tz qx qy qz qw`; or `csv`, whose header names `t x y z` in any
            order and, if the body turns, `qw qx qy qz` or `roll pitch yaw` (about fixed axes x, y, z in this order).
        max_gap: s, the longest time allowed between successive poses; None allows any.
        radians_per_unit: rad, the unit of roll, pitch and yaw.

    Raises:
        TrajectoryError: the file has a fault; that nearest to its start is told, others are counted.
    """
    if len(data) > LARGEST_TRAJECTORY:
        raise TrajectoryError(f"the file has {len(data)} bytes, expected up to {LARGEST_TRAJECTORY}")
    if layout == "csv":
        table, header = read_csv(data)
        rotation, warnings = header.rotation, header.warnings
    elif layout == "tum":
        table, rotation, warnings = _read_tum(data), ("qw", "qx", "qy", "qz"), ()
    else:
        raise ValueError(f"unknown layout {layout!r}")
    if len(table.lines) == 0:
        raise TrajectoryError("the file has no poses, expected at least one")
    faults = Faults()
    _check_times(table, max_gap, faults)
    quaternions, unit_errors = _quaternions(table, rotation, radians_per_unit, faults)
    faults.raise_any()
    return Trajectory(
        times=read_only(table.numbers[:, 0].copy()),
        translations=read_only(table.numbers[:, 1:4].copy()),
        quaternions=read_only(quaternions),
        lines=read_only(table.lines),
        exact_times=table.exact_times,
        warnings=(*warnings, *_of_units(unit_errors, table.lines), *_of_turns(quaternions, table.lines)),
    )


def _read_tum(data: bytes) -> Table:
    faults = Faults()
    table = read_table(_tum_rows(data), _TUM, faults)
    faults.raise_any()
    return table


def _tum_rows(data: bytes) -> Iterator[Row]:
    for line, text in enumerate(text_lines(data), start=1):
        cells = (text[: text.index("#")] if "#" in text else text).split()
        if cells:
            yield line, cells


def _check_times(table: Table, max_gap: float | None, faults: Faults) -> None:
    """Record where times do not increase, are too near to be told apart, or leave a gap."""
    times, lines, exact = table.numbers[:, 0], table.lines.tolist(), table.exact_times
    steps = np.diff(times)
    fuzz = 4.0 * float(np.spacing(2.0 * np.abs(times).max()))
    for i in np.flatnonzero(steps <= fuzz).tolist():
        before, after = exact[i], exact[i + 1]
        if after == before:
            shown = quoted(float(after))
            faults.add(
                lines[i + 1], f"lines {lines[i]} and {lines[i + 1]} are both at {shown} s, expected one pose at a time"
            )
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


def _quaternions(
    table: Table, rotation: tuple[str, ...], radians_per_unit: float, faults: Faults
) -> tuple[FloatArray, FloatArray]:
    """Return the unit quaternions (n, 4) w x y z, and how far their lengths (n,) were from 1 in the file."""
    count = len(table.lines)
    if not rotation:
        return np.tile((1.0, 0.0, 0.0, 0.0), (count, 1)), np.zeros(count)
    if len(rotation) == 3:
        quaternions = _of_fixed_axes(table.numbers[:, 4:] * radians_per_unit)
        return quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True), np.zeros(count)
    lengths: FloatArray = np.linalg.norm(table.numbers[:, 4:], axis=1)
    errors: FloatArray = np.abs(lengths - 1.0)
    for i in np.flatnonzero(errors > QUATERNION_TOLERANCE).tolist():
        problem = f"expected a unit quaternion, got one of length {quoted(float(lengths[i]))}"
        faults.add(int(table.lines[i]), problem)
    return table.numbers[:, 4:] / np.where(lengths > 0.0, lengths, 1.0)[:, None], errors


def _of_fixed_axes(angles: FloatArray) -> FloatArray:
    """Return the quaternions (n, 4) of Rz(yaw) Ry(pitch) Rx(roll) from roll, pitch, yaw (n, 3) in rad."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles / 2.0).T, np.sin(angles / 2.0).T
    return np.column_stack(
        (
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        )
    )


def _of_units(errors: FloatArray, lines: IntArray) -> tuple[str, ...]:
    """Return the warning of quaternions that were not quite of length 1."""
    count = int(np.count_nonzero(errors > UNTOLD_UNIT_ERROR))
    if count == 0:
        return ()
    worst = int(np.argmax(errors))
    text = (
        f"has {counted(count, 'quaternion')} whose length is off 1, by up to {errors[worst]:.2g} in line {lines[worst]}"
    )
    return (f"{text}: they are normalised",)


def _of_turns(quaternions: FloatArray, lines: IntArray) -> tuple[str, ...]:
    """Return the warnings where slerp's way between two poses may not be the one that was meant."""
    angles = successive_turns(quaternions)
    ambiguous = angles > math.pi - AMBIGUOUS_TURN
    wide = (angles > math.radians(WIDE_TURN)) & ~ambiguous
    warnings = []
    for found, amount, remark in (
        (ambiguous, "half a turn", "which way round is ambiguous, add poses between"),
        (wide, f"more than {WIDE_TURN:g} degrees", "the shorter way is taken, are poses missing?"),
    ):
        indices = np.flatnonzero(found)
        if len(indices):
            first = int(indices[0])
            where = f"lines {lines[first]} and {lines[first + 1]} ({math.degrees(angles[first]):.1f} degrees)"
            times = f"turns by {amount} between successive poses {counted(len(indices), 'time')}"
            warnings.append(f"{times}, first between {where}: {remark}")
    return tuple(warnings)
