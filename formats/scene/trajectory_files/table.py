"""The numbers of a trajectory file: cells of text to columns of float64, with the line of each fault."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from itertools import chain, islice
from operator import itemgetter

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ..limits import LARGEST_NUMBER
from ..text.errors import quoted
from ..text.signatures import named_format

LONGEST_TIME = 100
"""Characters. A longer time is refused: exact differences would take space and time without end."""

_BLOCK = 1 << 11
"""Rows read at a time: their texts are dropped before the next ones come."""

_NUMERAL = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?\Z")
_NOT_FINITE = re.compile(r"[-+]?(?:nan|inf|infinity)\Z", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+\Z")
_ZERO = Decimal(0)

Row = tuple[int, Sequence[str]]
"""The line a row begins in, from 1, and its cells."""


class TrajectoryError(Exception):
    """A trajectory file that cannot be used: what is wrong first, in which line if in one, and how much more is.

    Attributes:
        of_times: whether the fault lies in the file of times that goes with it.
    """

    def __init__(self, message: str, line: int | None = None, of_times: bool = False) -> None:
        super().__init__(message)
        self.message = message
        self.line = line
        self.of_times = of_times


class Faults:
    """The faults found so far: the one nearest to the file's start, and how many there are."""

    def __init__(self, of_times: bool = False) -> None:
        self.count = 0
        self._of_times = of_times
        self._message = ""
        self._line = 0

    def add(self, line: int, message: str) -> None:
        """Take one more; of two in one line the earlier is kept."""
        if self.count == 0 or line < self._line:
            self._line, self._message = line, message
        self.count += 1

    def raise_any(self) -> None:
        """Refuse the file if there was a fault.

        Raises:
            TrajectoryError: there was.
        """
        if self.count:
            more = f" (and {self.count - 1} more)" if self.count > 1 else ""
            raise TrajectoryError(self._message + more, self._line, self._of_times)


@dataclass(frozen=True, slots=True)
class Layout:
    """Which cells of a row are read, the time first.

    Attributes:
        width: how many cells a row has.
        columns: the cells that are read, from 0, and how messages name them.
        expected: what a row of another width should have been.
    """

    width: int
    columns: tuple[tuple[int, str], ...]
    expected: str


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """Rows of numbers.

    Attributes:
        numbers: (n, k) up to LARGEST_NUMBER; times are in s.
        exact_times: n, s, the decimals in the first column of `numbers`, which are the nearest float64.
        lines: (n,) where each row begins, from 1.
    """

    numbers: FloatArray
    exact_times: tuple[Decimal, ...]
    lines: IntArray


def text_lines(data: bytes) -> Iterator[str]:
    r"""Yield the lines of UTF-8 text with their ends as "\n", without a byte order mark.

    Raises:
        TrajectoryError: at a byte that is none of UTF-8, or of a file of another format, which it names.
    """
    named = named_format(data)
    if named:
        raise TrajectoryError(f"the file is {named}, expected UTF-8 text")
    try:
        yield from io.TextIOWrapper(io.BytesIO(data), encoding="utf-8-sig", newline=None)
    except UnicodeDecodeError:
        start = _undecodable(data)
        before = data[:start].replace(b"\r\n", b"\n")
        line = before.count(b"\n") + before.count(b"\r") + 1
        raise TrajectoryError(f"expected UTF-8 text, got the byte 0x{data[start]:02x}", line) from None


def _undecodable(data: bytes) -> int:
    """Return where the first byte lies that is none of UTF-8."""
    try:
        data.decode()
    except UnicodeDecodeError as error:
        return error.start
    return 0


def word_rows(data: bytes) -> Iterator[Row]:
    """Yield the lines of UTF-8 text that have words before a `#`, and these.

    Raises:
        TrajectoryError: at a byte that is none of UTF-8.
    """
    for line, text in enumerate(text_lines(data), start=1):
        cells = (text[: text.index("#")] if "#" in text else text).split()
        if cells:
            yield line, cells


def read_table(rows: Iterable[Row], layout: Layout, faults: Faults) -> Table:
    """Return the numbers of all rows; where there are faults, they stand in `faults` and 0 in the table."""
    count = len(layout.columns)
    pick = itemgetter(*(cell for cell, _ in layout.columns)) if count > 1 else tuple
    numbers: list[FloatArray] = [np.empty((0, count))]
    exact_times: list[Decimal] = []
    lines: list[int] = []
    iterator = iter(rows)
    while block := list(islice(iterator, _BLOCK)):
        whole = _whole_rows(block, layout, faults)
        cells = list(chain.from_iterable(pick(row) for _, row in whole))
        block_lines = [line for line, _ in whole]
        found = _numbers(cells, layout)
        if found is None:
            found = _numbers_one_by_one(cells, block_lines, layout, faults)
        found += 0.0  # -0.0 is 0.0
        times = zip(cells[::count], found[:, 0].tolist(), strict=True)
        exact_times += [Decimal(text.strip()) if time else _ZERO for text, time in times]
        numbers.append(found)
        lines += block_lines
    return Table(np.concatenate(numbers), tuple(exact_times), np.array(lines, dtype=np.int64))


def _whole_rows(block: list[Row], layout: Layout, faults: Faults) -> list[Row]:
    whole = [row for row in block if len(row[1]) == layout.width]
    if len(whole) < len(block):
        for line, row in block:
            if len(row) != layout.width:
                faults.add(line, f"expected {layout.expected}, got {len(row)}")
    return whole


def _numbers(cells: list[str], layout: Layout) -> FloatArray | None:
    """Return the cells as numbers (n, k), None if one of them is none or in doubt."""
    count = len(layout.columns)
    try:
        numbers: FloatArray = np.fromiter(map(float, cells), np.float64, len(cells)).reshape(-1, count)
    except ValueError:
        return None
    joined = "".join(cells)  # float() would also take 1_000 and the digits of other scripts
    if not joined.isascii() or "_" in joined or max(map(len, cells[::count]), default=0) > LONGEST_TIME:
        return None
    return numbers if bool((np.abs(numbers) <= LARGEST_NUMBER).all()) else None


def _numbers_one_by_one(cells: list[str], lines: list[int], layout: Layout, faults: Faults) -> FloatArray:
    """Return the cells as numbers (n, k), recording the first fault of each row; its numbers are 0."""
    count = len(layout.columns)
    names = [name for _, name in layout.columns]
    numbers: FloatArray = np.zeros((len(lines), count))
    for index, line in enumerate(lines):
        texts = [text.strip() for text in cells[index * count : (index + 1) * count]]
        problem = _problem_of_time(texts[0]) or next(filter(None, map(_problem, texts, names)), "")
        if problem:
            faults.add(line, problem)
        else:
            numbers[index] = [float(text) for text in texts]
    return numbers


def _problem(text: str, name: str) -> str:
    """Return what is wrong with a cell, nothing if it is a number that can be read."""
    if _NOT_FINITE.match(text):
        return f"expected a finite number in {name}, got {quoted(text)}"
    if not _NUMERAL.match(text):
        hint = " (write the decimal point as '.')" if _DECIMAL_COMMA.match(text) else ""
        return f"expected a number in {name}, got {quoted(text) if text else 'nothing'}{hint}"
    if abs(float(text)) > LARGEST_NUMBER:
        return f"expected numbers up to {LARGEST_NUMBER:g} in {name}, got {quoted(text)}"
    return ""


def _problem_of_time(text: str) -> str:
    if len(text) > LONGEST_TIME:
        return f"expected a time of up to {LONGEST_TIME} characters, got {len(text)}"
    if _NUMERAL.match(text) and abs(float(text)) > LARGEST_NUMBER:
        return f"expected times up to {LARGEST_NUMBER:g} s, got {quoted(text)} (is it in nanoseconds?)"
    return ""
