"""Lengths and times as text: lower bounds are rounded down, intervals outwards."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from math import ceil, log10

from ..log.container.clock import seconds_told
from ..scene.quantities.lengths import length_text

_DIGITS = 4


def length(metres: float, unit: str) -> str:
    """Return a length, m, as text in `unit` with four digits."""
    return length_text(metres, unit, _DIGITS)


def moment(seconds: float) -> str:
    """Return a time, s, as text with six digits, or with more if microseconds need them."""
    return f"{seconds_told(seconds)} s"


def interval(start: float, end: float) -> str:
    """Return an interval of time, s, rounded outwards to the digits that its length needs."""
    if start == end:
        return f"{start!r} s"
    low, high = sorted((start, end))
    places = Decimal(1).scaleb(-max(3, ceil(-log10(high - low)) + 1))
    outer = _decimal(low).quantize(places, ROUND_FLOOR), _decimal(high).quantize(places, ROUND_CEILING)
    return " to ".join(map(_plain, outer if start < end else outer[::-1])) + " s"


def _decimal(value: float) -> Decimal:
    """Return a number as it is written, the shortest that is read back as the same."""
    return Decimal(repr(value))


def _plain(number: Decimal) -> str:
    """Return a number without an exponent and without trailing zeros behind the point."""
    text = f"{number:f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
