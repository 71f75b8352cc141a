"""Trajectories as the KITTI odometry benchmark has them: a 3x4 matrix a line, and times in another file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal
from itertools import count

from ....scheduler.geometry.arrays import IntArray
from ..text.errors import counted
from .table import Faults, Layout, Row, Table, TrajectoryError, read_table, word_rows

_PLACE = (3, 7, 11)
_ROTATION = (0, 1, 2, 4, 5, 6, 8, 9, 10)
_WIDTH = 12
_MATRICES = Layout(
    width=1 + _WIDTH,
    columns=((0, "time"), *((1 + cell, f"column {cell + 1}") for cell in (*_PLACE, *_ROTATION))),
    expected=f"{_WIDTH} columns, a 3x4 matrix by rows",
)
_TIMES = Layout(width=1, columns=((0, "time"),), expected="1 time a line")


@dataclass(frozen=True, slots=True, eq=False)
class Stamps:
    """The times of a file that has one a line.

    Attributes:
        times: n, s.
        lines: (n,) where each stands, from 1.
    """

    times: tuple[Decimal, ...]
    lines: IntArray


Clock = Stamps | Decimal
"""When the poses of a file without times are: a file of times, or the s from each to the next, the first at 0."""


def read_stamps(data: bytes) -> Stamps:
    """Return the times of a file that has one in s a line.

    Raises:
        TrajectoryError: a line is none.
    """
    faults = Faults()
    table = read_table(word_rows(data), _TIMES, faults)
    faults.raise_any()
    return Stamps(table.exact_times, table.lines)


def read_kitti(data: bytes, clock: Clock) -> Table:
    """Return the rows: time, place, and the rotation's nine entries by rows, of parent_from_body.

    Raises:
        TrajectoryError: a row cannot be read, or there are more or fewer than times.
    """
    faults = Faults()
    table = read_table(_timed_rows(data, clock, faults), _MATRICES, faults)
    faults.raise_any()
    if isinstance(clock, Stamps) and len(clock.lines) != len(table.lines):
        poses, times = counted(len(table.lines), "pose"), counted(len(clock.lines), "time")
        raise TrajectoryError(f"the file has {poses}, the file of times has {times}, expected as many")
    return table


def _timed_rows(data: bytes, clock: Clock, faults: Faults) -> Iterator[Row]:
    """Yield the rows with their times before them; of rows beyond the last time, it is 0."""
    times = iter(clock.times) if isinstance(clock, Stamps) else (clock * number for number in count())
    for line, cells in word_rows(data):
        time = next(times, Decimal(0))
        if len(cells) == _WIDTH:
            yield line, [str(time), *cells]
        else:
            faults.add(line, f"expected {_MATRICES.expected}, got {len(cells)}")
