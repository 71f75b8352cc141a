"""Lengths and times in words: bounds are rounded so that they stay true."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from math import ceil, log10

from ..log.container.clock import seconds_told

_UNITS = (("km", 1e3, 1e4), ("m", 1.0, 1.0), ("mm", 1e-3, 1e-3), ("µm", 1e-6, 1e-6), ("nm", 1e-9, 0.0))
"""Of lengths: name, m, and from how many m on."""

_DIGITS = 4


def length(metres: float, rounding: str = ROUND_HALF_EVEN) -> str:
    """Return a length >= 0, m, in four digits and the unit that fits it."""
    if metres == 0.0:
        return "0"
    unit, size, _ = next(row for row in _UNITS if metres >= row[2])
    exact = _decimal(metres) / _decimal(size)
    return f"{_plain(Context(prec=_DIGITS, rounding=rounding).plus(exact))} {unit}"


def at_least(metres: float) -> str:
    """Return a lower bound, m, rounded down."""
    return length(metres, ROUND_FLOOR)


def moment(seconds: float) -> str:
    """Return a time, s, in six digits, or in whole microseconds where those are more."""
    return f"{seconds_told(seconds)} s"


def interval(start: float, end: float) -> str:
    """Return an interval of time, s, rounded outwards in as many digits as its length is told by."""
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
