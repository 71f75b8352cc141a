"""The share of a bound that covers the rounding of its own arithmetic."""

from __future__ import annotations

from math import ulp

#: Relative loss granted to the arithmetic of the bounds themselves, on clearances and on times.
RELATIVE_ROUNDING = 1e-12


def spendable(clearance: float) -> float:
    """Return the part of a clearance (m) that a bound may spend, the bound's own rounding taken off."""
    return clearance * (1.0 - RELATIVE_ROUNDING)


def shortened(now: float, duration: float) -> float:
    """Return a sleep (s) that stays below `duration` after rounding, at absolute time `now`."""
    return max(0.0, duration * (1.0 - RELATIVE_ROUNDING) - ulp(abs(now) + duration))
