"""Scene seconds become log nanoseconds, or words, here and nowhere else."""

from __future__ import annotations

from math import ulp

from ....scheduler.model.scene import Settings, least_duration

NANOSECONDS_PER_SECOND = 1_000_000_000

# Several viewers and MCAP libraries keep log times in signed 64 bits, though the file's are unsigned.
LATEST_LOG_TIME_NS = 2**63 - 1


def nanoseconds(seconds: float) -> int:
    """Return the whole nanoseconds nearest to a finite time, ties to even.

    Exact, which `round(seconds * 1e9)` is not: the product is rounded before it is rounded again.
    """
    numerator, denominator = seconds.as_integer_ratio()
    whole, rest = divmod(numerator * NANOSECONDS_PER_SECOND, denominator)
    if 2 * rest > denominator or (2 * rest == denominator and whole % 2):
        return whole + 1
    return whole


def seconds_told(time: float, digits: int = 6) -> str:
    """Return a time, s, in so many digits, or in whole microseconds where they are more."""
    if abs(time) >= 1e5:
        digits = len(str(int(abs(time)))) + 6
    return f"{time:.{digits}g}"


def coarseness_told(tolerance: float, start: float, end: float) -> str:
    """Return why contacts are bracketed no finer than by `tolerance`, s, in times from start to end.

    Empty where floats are fine enough for the usual tolerance, or where the scene or an option sets a coarser one.
    """
    if not Settings().contact_tolerance < tolerance <= least_duration(start, end):
        return ""
    latest = max(abs(start), abs(end))
    spacing = f"floating-point times near {seconds_told(latest)} s are {ulp(latest):.2g} s apart"
    return f"begins and ends of contacts are known to within {tolerance:.3g} s, because {spacing}"
