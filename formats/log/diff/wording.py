"""Differences as text for a table, a report or the failure of a test."""

from __future__ import annotations

from math import isnan

from ...scene.quantities.lengths import length_text
from ...scene.text.errors import counted
from ..container.clock import seconds_told
from .difference import Cause, Difference, Value

_SCALES = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns"))

# "minimum fell by 0.4 mm", but "verdict changed: clear -> contact".
_READ_ON = (Cause.BEGIN, Cause.END, Cause.BREACH_MOVED, Cause.MINIMUM_FELL, Cause.MINIMUM_ROSE, Cause.FIELD)


def amount(value: float, unit: str, length_unit: str) -> str:
    """Return a size in three digits: a length (unit m) in `length_unit`, a time in s, ms, us or ns."""
    if unit == "m":
        return length_text(abs(value), length_unit, 3)
    for scale, name in _SCALES if unit == "s" else ():
        if abs(value) >= 0.1 * scale:
            return f"{abs(value) / scale:.3g} {name}"
    return f"{abs(value):.3g} {unit}".rstrip()


def told(difference: Difference, length_unit: str) -> str:
    """Return a difference without its cause and its pair, such as "3.2 ms later: 0.5 s -> 0.5032 s"."""
    one = difference
    size, arrow = amount(one.change, one.unit, length_unit), _arrow(one, length_unit)
    match one.cause:
        case Cause.VERDICT | Cause.PAIRS:
            return f"{one.golden} -> {one.new}"
        case Cause.CONTACT_APPEARED | Cause.BREACH_APPEARED:
            return f"{one.new} ({size})"
        case Cause.CONTACT_VANISHED | Cause.BREACH_VANISHED:
            return f"{one.golden} ({size})"
        case Cause.PAIR_REMOVED | Cause.PAIR_ADDED:
            return f"{one.golden or one.new}"
        case Cause.BEGIN | Cause.END | Cause.BREACH_MOVED:
            return f"{size} {'later' if one.change > 0 else 'earlier'}: {arrow}"
        case Cause.MINIMUM_FELL | Cause.MINIMUM_ROSE:
            allowed = "" if one.proved else ", within both brackets"
            return f"by {size}{allowed}: {arrow}"
        case Cause.UNRESOLVED | Cause.POSSIBLE | Cause.MARGIN:
            return f"{size} {'more' if one.change > 0 else 'less'}: {arrow}"
        case Cause.MISSING | Cause.EXTRA:
            return counted(one.count, "message")
    by = "" if isnan(one.change) else f" by up to {size}"
    return f"in {counted(one.count, 'message')}{by}: {arrow}"


def place(difference: Difference) -> str:
    """Return the time of a difference and the named keys around it."""
    keys = ", ".join(f"{body} {between(*around)}" for body, around in difference.keys.items())
    at = "" if difference.time is None else f"{seconds_told(difference.time, 7)} s"
    return f"{at} ({keys})" if keys else at


def sentence(difference: Difference, length_unit: str) -> str:
    """Return a difference in one line, with its cause, pair and time; lengths are in `length_unit`."""
    where = place(difference)
    subject = f"{difference.subject.replace('|', ' | ')}: " if difference.subject else ""
    joint = " " if difference.cause in _READ_ON else ": "
    return f"{subject}{difference.cause.label}{joint}{told(difference, length_unit)}{f', at {where}' if where else ''}"


def between(before: str, after: str) -> str:
    """Return the named keys around a time; either may be missing."""
    if before and after:
        return f"between {before} and {after}"
    return f"after {before}" if before else f"before {after}"


def _arrow(one: Difference, length_unit: str) -> str:
    return f"{_value(one.golden, one.unit, length_unit)} -> {_value(one.new, one.unit, length_unit)}"


def _value(value: Value, unit: str, length_unit: str) -> str:
    if value is None:
        return "the end" if unit == "s" else "none"
    if not isinstance(value, float):
        return str(value)
    if unit == "m":
        return length_text(value, length_unit, 7)
    return f"{seconds_told(value, 7)} s" if unit == "s" else f"{value:.7g} {unit}".rstrip()
