"""Plain scalars by the core schema of YAML 1.2: `1e-3` is a number, `on` is text."""

from __future__ import annotations

import math
import re

_NUMBER = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?\Z")
_INTEGER = re.compile(r"[-+]?[0-9]+\Z")
_PREFIXED = {"0o": (re.compile(r"0o[0-7]+\Z"), 8), "0x": (re.compile(r"0x[0-9a-fA-F]+\Z"), 16)}
_NOT_FINITE = re.compile(r"(?:[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))\Z")
_WORDS: dict[str, bool | None] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_LONGEST_INTEGER = 310
"""Digits. No float64 has more, and Python refuses to convert very long ones."""


class NotFiniteError(ValueError):
    """A number that no finite float64 holds."""


def plain_scalar(text: str) -> str | int | float | bool | None:
    """Return the value that an unquoted YAML scalar stands for.

    Raises:
        NotFiniteError: infinities, NaN, and numbers too large for float64.
    """
    if text in _WORDS:
        return _WORDS[text]
    if _NUMBER.match(text):
        return number(text)
    if _NOT_FINITE.match(text):
        raise NotFiniteError
    pattern, base = _PREFIXED.get(text[:2], (None, 10))
    if pattern is not None and pattern.match(text):
        return _finite_integer(text, base)
    return text


def number(text: str) -> int | float:
    """Return the number written as `text`, decimal, an int when it has neither point nor exponent.

    Raises:
        NotFiniteError: it is too large for float64.
    """
    if _INTEGER.match(text):
        return _finite_integer(text, 10)
    value = float(text)
    if not math.isfinite(value):
        raise NotFiniteError
    return value


def _finite_integer(text: str, base: int) -> int:
    if len(text) > _LONGEST_INTEGER:
        raise NotFiniteError
    value = int(text, base)
    try:
        float(value)
    except OverflowError:
        raise NotFiniteError from None
    return value
