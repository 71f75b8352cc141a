"""Trajectories as comma-separated values (RFC 4180, as people write it): a header that names the columns, then rows."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass

from ..text.errors import printable, quoted, suggestion
from .table import Faults, Layout, Row, Table, TrajectoryError, read_table, text_lines

_MEANINGS = {
    "t": ("t", "time", "timestamp"),
    "x": ("x", "tx"),
    "y": ("y", "ty"),
    "z": ("z", "tz"),
    **{name: (name,) for name in ("qw", "qx", "qy", "qz", "roll", "pitch", "yaw")},
}
"""What a column can be, and the names it goes by."""

_MEANING_OF = {name: meaning for meaning, names in _MEANINGS.items() for name in names}
_PLACE = ("t", "x", "y", "z")
_QUATERNION = ("qw", "qx", "qy", "qz")
_ANGLES = ("roll", "pitch", "yaw")
_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}
_MOST_NAMED = 8
"""Columns left out that a warning names. Of more it gives the number."""

_MOST_TRIED = 100
"""Unknown columns among which a missing one is sought."""


@dataclass(frozen=True, slots=True)
class Header:
    """What the header of a file says.

    Attributes:
        line: where it is, from 1.
        separator: between cells, `,` or `;` or a tab.
        layout: which columns are read: t x y z, then those of the rotation.
        rotation: qw qx qy qz, or roll pitch yaw, or nothing.
        warnings: the columns that are not read.
    """

    line: int
    separator: str
    layout: Layout
    rotation: tuple[str, ...]
    warnings: tuple[str, ...]


def read_csv(data: bytes) -> tuple[Table, Header]:
    """Return the rows and what their columns mean: t x y z, then the header's rotation.

    Blank lines, rows of empty cells and lines that begin with `#` are left out.

    Raises:
        TrajectoryError: the header or a row cannot be read.
    """
    lines = text_lines(data)
    header = _read_header(lines)
    faults = Faults()
    table = read_table(_rows(lines, header, faults), header.layout, faults)
    faults.raise_any()
    return table, header


def _read_header(lines: Iterator[str]) -> Header:
    for line, text in enumerate(lines, start=1):
        names = text.removesuffix("\n")
        if names.startswith("#"):
            names = names.lstrip("# ")
            if not {"t", "x"} <= set(map(_meaning, _split(names)[1])):
                continue  # a remark; numpy.savetxt writes its header behind one
        if names.strip():
            return _header(*_split(names), line)
    raise TrajectoryError("the file is empty, expected a header that names the columns t, x, y, z")


def _split(text: str) -> tuple[str, list[str]]:
    """Return the separator that the header shows, and the names it separates."""
    found: dict[str, list[str]] = {}
    for separator in _SEPARATORS:
        try:
            found[separator] = next(csv.reader([text], delimiter=separator, strict=True, skipinitialspace=True))
        except (csv.Error, StopIteration):
            found[separator] = [text]
    best = max(
        found, key=lambda separator: (sum(_meaning(name) != "" for name in found[separator]), len(found[separator]))
    )
    return best, [name.strip() for name in found[best]]


def _meaning(name: str) -> str:
    return _MEANING_OF.get(name.strip().lower(), "")


def _header(separator: str, names: list[str], line: int) -> Header:
    cells: dict[str, int] = {}
    unknown = []
    for cell, name in enumerate(names):
        meaning = _meaning(name)
        if not meaning:
            unknown.append(name)
        elif meaning in cells:
            first = quoted(names[cells[meaning]])
            raise TrajectoryError(f"the header names {meaning} twice, as {first} and as {quoted(name)}", line)
        else:
            cells[meaning] = cell
    if not cells:
        problem = "expected a header that names the columns t, x, y, z, separated by commas, semicolons or tabs"
        raise TrajectoryError(f"{problem}, got {quoted(separator.join(names))}", line)
    rotation = _rotation(cells, unknown, line)
    columns = tuple((cells[meaning], quoted(names[cells[meaning]])) for meaning in (*_PLACE, *rotation))
    expected = f"{len(names)} columns as in the header, separated by {_SEPARATORS[separator]}"
    layout = Layout(len(names), columns, expected)
    return Header(line, separator, layout, rotation, _left_out(unknown, rotation))


def _rotation(cells: dict[str, int], unknown: list[str], line: int) -> tuple[str, ...]:
    """Return the columns of the rotation, if the header has all columns that it must have."""
    if any(name in cells for name in _QUATERNION) and any(name in cells for name in _ANGLES):
        raise TrajectoryError("the header names a quaternion and roll, pitch, yaw, expected one of them", line)
    rotation = next((names for names in (_QUATERNION, _ANGLES) if any(name in cells for name in names)), ())
    missing = [name for name in (*_PLACE, *rotation) if name not in cells]
    if missing:
        near = next(((name, hint) for name in unknown[:_MOST_TRIED] if (hint := _hint(name, missing))), None)
        meant = f"; it has {quoted(near[0])}{near[1]}" if near else ""
        raise TrajectoryError(f"the header lacks {', '.join(missing)}{meant}", line)
    return rotation


def _hint(name: str, meanings: list[str]) -> str:
    return suggestion(name.lower(), [known for meaning in meanings for known in _MEANINGS[meaning]])


def _left_out(unknown: list[str], rotation: tuple[str, ...]) -> tuple[str, ...]:
    """Return the warning of columns that are not read; if there is no rotation, one of them may be meant for it."""
    if not unknown:
        return ()
    candidates = [] if rotation else [*_QUATERNION, *_ANGLES]
    shown = ", ".join(quoted(name) + _hint(name, candidates) for name in unknown[:_MOST_NAMED])
    more = f" and {len(unknown) - _MOST_NAMED} more" if len(unknown) > _MOST_NAMED else ""
    unturned = "" if rotation else ", and no rotation"
    return (f"has columns that are left out: {shown}{more}{unturned}",)


def _rows(lines: Iterator[str], header: Header, faults: Faults) -> Iterator[Row]:
    """Yield the rows after the header; what no CSV can hold is recorded and ends them."""
    remarks_blanked = ("" if text.startswith("#") else text for text in lines)
    reader = csv.reader(remarks_blanked, delimiter=header.separator, strict=True, skipinitialspace=True)
    line = header.line + 1
    try:
        for row in reader:
            if row and (row[0] or any(cell.strip() for cell in row)):
                yield line, row
            line = header.line + reader.line_num + 1
    except csv.Error as error:
        faults.add(header.line + max(reader.line_num, 1), f"the row cannot be read as CSV: {printable(str(error))}")
