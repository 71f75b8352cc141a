"""Trajectories as the EuRoC MAV data set has them: nanoseconds, place and quaternion, separated by commas.

The ground truth of a recording, `state_groundtruth_estimate0/data.csv`, goes on with velocities and biases.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from decimal import Decimal
from itertools import chain

from ..limits import LARGEST_NUMBER
from ..text.errors import quoted
from .table import LONGEST_TIME, Faults, Layout, Row, Table, TrajectoryError, read_table, text_lines

_COLUMNS = ("timestamp", "p_x", "p_y", "p_z", "q_w", "q_x", "q_y", "q_z")
_UNITS = ("ns", "m", "m", "m", "", "", "", "")
_EXPECTED = f"{len(_COLUMNS)} columns ({' '.join(_COLUMNS)}) or more, separated by commas"
_NANOSECONDS = re.compile(r"([-+]?[0-9]+(?:\.[0-9]*)?)(?:[eE]\+?([0-9]{1,2}))?\Z")
_NAME = re.compile(r"#?\s*(?P<name>[^\[]*?)\s*(\[(?P<unit>.*)\])?\s*\Z")


def read_euroc(data: bytes) -> Table:
    """Return the rows, their times in s: the first eight columns, whatever follows them is left out.

    A header, in the first line or behind a `#`, may name the columns as the data set does: `p_RS_R_x [m]`, `q_RS_w []`.

    Raises:
        TrajectoryError: a row cannot be read, or the header names the eight columns in another order or unit.
    """
    faults = Faults()
    rows = _rows(data)
    begin, first = next(rows, (0, _COLUMNS))
    if len(first) < len(_COLUMNS):
        raise TrajectoryError(f"expected {_EXPECTED}, got {len(first)}", begin)
    layout = Layout(len(first), tuple(enumerate(_COLUMNS)), f"{len(first)} columns as in line {begin}")
    table = read_table(_in_seconds(chain([(begin, first)] if begin else (), rows), faults), layout, faults)
    faults.raise_any()
    return table


def _rows(data: bytes) -> Iterator[Row]:
    """Yield the rows as they stand; a header before them must be that of the layout."""
    begun = False
    for line, text in enumerate(text_lines(data), start=1):
        cells = [cell.strip() for cell in text.split(",")]
        if not any(cells):
            continue
        if text.lstrip().startswith("#") or (not begun and cells[0].lower().startswith("time")):
            problem = "" if begun else _problem_of_header(cells)
            if problem:
                raise TrajectoryError(problem, line)
            continue
        begun = True
        yield line, cells


def _problem_of_header(cells: list[str]) -> str:
    """Return where a header names other columns than the layout has; nothing if it does not, or is a mere remark."""
    found = [match for match in map(_NAME.match, cells[: len(_COLUMNS)]) if match]
    letters = [match["name"][-1:].lower() for match in found[1:]]
    if len(found) < len(_COLUMNS) or not set(letters) <= set("wxyz"):
        return ""
    for column, match in enumerate(found):
        meant, unit = _COLUMNS[column], _UNITS[column]
        if column and letters[column - 1] != meant[-1]:
            return f"the header names {quoted(match['name'])} in column {column + 1}, where euroc has {meant}"
        if match["unit"] and match["unit"].strip() not in ("", unit):
            named = f"{quoted(match['name'])} is in {quoted(match['unit'])}"
            return f"the header says that {named}, where euroc has {unit or 'no unit'}"
    return ""


def _in_seconds(rows: Iterable[Row], faults: Faults) -> Iterator[Row]:
    """Yield the rows with their times as decimals in s; where a time is none, it is 0 and recorded as a fault."""
    for line, cells in rows:
        problem = _problem_of_time(cells[0])
        if problem:
            faults.add(line, problem)
        seconds = Decimal(0 if problem else cells[0]).to_integral_value().scaleb(-9)
        yield line, [str(seconds), *cells[1:]]


def _problem_of_time(text: str) -> str:
    if len(text) > LONGEST_TIME:
        return f"expected a time of up to {LONGEST_TIME} characters, got {len(text)}"
    if not _NANOSECONDS.match(text) or Decimal(text) != Decimal(text).to_integral_value():
        return f"expected whole nanoseconds in timestamp, got {quoted(text) if text else 'nothing'}"
    if abs(Decimal(text)) > Decimal(LARGEST_NUMBER).scaleb(9):
        return f"expected times up to {LARGEST_NUMBER:g} s, got {quoted(text)} ns"
    return ""
