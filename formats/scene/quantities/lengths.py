"""Lengths as people write and read them: a number and a unit."""

from __future__ import annotations

import re
from decimal import ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from math import isfinite, isnan

from .units import METRES, metres

_WRITTEN = re.compile(rf"(\S+?)\s*({'|'.join(METRES)})?")

# Digits in which a length is converted from one unit to another before it is rounded.
_EXACT = Context(prec=60)

# Numbers from the first to below the second are written without an exponent.
_PLAIN = Decimal("1e-4"), Decimal("1e15")


def read_length(text: str) -> float:
    """Return a length such as "2mm" or "0.08 in" in m; a number without a unit is in m.

    Raises:
        ValueError: for a text that is not such a length, or not a number.
    """
    written = _WRITTEN.fullmatch(text.strip())
    if written is None:
        raise ValueError(text)
    value = metres(float(written[1]), written[2] or "m")
    if isnan(value):
        raise ValueError(text)
    return value


def length_text(value: float, unit: str, digits: int = 6, rounding: str = ROUND_HALF_EVEN) -> str:
    """Return a length, m, as a number in `unit`, rounded to some digits, and the unit; 0 needs no unit."""
    number = length_number(value, unit, digits, rounding)
    return number if number == "0" else f"{number} {unit}"


def at_least_text(value: float, unit: str) -> str:
    """Return a lower bound of a length, m, in four digits in `unit`, rounded down."""
    return length_text(value, unit, 4, ROUND_FLOOR)


def length_number(value: float, unit: str, digits: int = 6, rounding: str = ROUND_HALF_EVEN) -> str:
    """Return a length, m, as a number in `unit`, rounded to some digits."""
    if not isfinite(value):
        return str(value)
    numerator, denominator = METRES[unit]
    scaled = _EXACT.divide(_EXACT.multiply(Decimal(repr(value)), Decimal(denominator)), Decimal(numerator))
    rounded = Context(prec=digits, rounding=rounding).plus(scaled)
    least, beyond = _PLAIN
    if rounded == 0:
        return "0"
    if not least <= abs(rounded) < beyond:
        return re.sub("e[+]?(-?)0*", r"e\1", f"{float(rounded):.{digits}g}")
    text = f"{rounded:f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
