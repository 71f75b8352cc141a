"""Differences in words: what a reviewer reads in a table, a report or a test's failure."""

from __future__ import annotations

from math import isnan

from ...scene.text.errors import counted
from ..container.clock import seconds_told
from .difference import Cause, Difference, Value

_SCALES = {
    "s": ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns")),
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "um"), (1e-9, "nm")),
}

# "minimum fell by 0.4 mm", but "verdict changed: clear -> contact".
_READ_ON = (Cause.BEGIN, Cause.END, Cause.BREACH_MOVED, Cause.MINIMUM_FELL, Cause.MINIMUM_ROSE, Cause.FIELD)


def amount(value: float, unit: str) -> str:
    """Return a size in three digits, in a unit of which it is a tenth or more."""
    for scale, name in _SCALES.get(unit, ()):
        if abs(value) >= 0.1 * scale:
            return f"{abs(value) / scale:.3g} {name}"
    return f"{abs(value):.3g} {unit}".rstrip()


def told(difference: Difference) -> str:
    """Return what differs, without the pair: "contact begins 3.2 ms later"."""
    one = difference
    size = amount(one.change, one.unit)
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
            return f"{size} {'later' if one.change > 0 else 'earlier'}: {_arrow(one)}"
        case Cause.MINIMUM_FELL | Cause.MINIMUM_ROSE:
            allowed = "" if one.proved else ", within both brackets"
            return f"by {size}{allowed}: {_arrow(one)}"
        case Cause.UNRESOLVED | Cause.POSSIBLE | Cause.MARGIN:
            return f"{size} {'more' if one.change > 0 else 'less'}: {_arrow(one)}"
        case Cause.MISSING | Cause.EXTRA:
            return counted(one.count, "message")
    by = "" if isnan(one.change) else f" by up to {size}"
    return f"in {counted(one.count, 'message')}{by}: {_arrow(one)}"


def place(difference: Difference) -> str:
    """Return when a difference shows, and the named keys that the bodies are between then."""
    keys = ", ".join(f"{body} {between(*around)}" for body, around in difference.keys.items())
    at = "" if difference.time is None else f"{seconds_told(difference.time, 7)} s"
    return f"{at} ({keys})" if keys else at


def sentence(difference: Difference) -> str:
    """Return a difference in one line, with its cause, its pair and its time."""
    where = place(difference)
    subject = f"{difference.subject.replace('|', ' | ')}: " if difference.subject else ""
    joint = " " if difference.cause in _READ_ON else ": "
    return f"{subject}{difference.cause.label}{joint}{told(difference)}{f', at {where}' if where else ''}"


def between(before: str, after: str) -> str:
    """Return which named keys a moment lies between, of which either may be missing."""
    if before and after:
        return f"between {before} and {after}"
    return f"after {before}" if before else f"before {after}"


def _arrow(one: Difference) -> str:
    return f"{_value(one.golden, one.unit)} -> {_value(one.new, one.unit)}"


def _value(value: Value, unit: str) -> str:
    if value is None:
        return "the end" if unit == "s" else "none"
    if not isinstance(value, float):
        return str(value)
    return f"{seconds_told(value, 7) if unit == 's' else f'{value:.7g}'} {unit}".rstrip()
