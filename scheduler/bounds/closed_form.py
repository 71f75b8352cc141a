"""Closed-form bounds on sleeps, and on the time between two measurements. Pure numbers."""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, inf, sqrt

#: The search for the longest sleep ends when it is known to this fraction: a longer sleep would gain no more.
SEARCH_TOLERANCE = 0.03


def time_bound(clearance: float, speed: float, acceleration: float) -> float:
    """Return the seconds (inf allowed) during which the pair cannot touch: the lecture's t_c.

    A lower bound: the root of clearance = speed t + acceleration t^2 / 2, in the form that neither cancels nor divides
    by zero as acceleration -> 0. Source: the lecture, section 1.2.

    Args:
        clearance: m, lower bound on the distance now, >= 0.
        speed: m/s, upper bound over ALL pairs of points now, not the witnesses alone; negative where they part.
        acceleration: m/s^2, upper bound over the whole sleep, >= 0.
    """
    spread = hypot(speed, sqrt(2.0 * acceleration * clearance))
    if speed < 0.0:
        return (spread - speed) / acceleration if acceleration > 0.0 else inf
    return 2.0 * clearance / (speed + spread) if speed + spread > 0.0 else inf


def longest_sleep(displacement: Callable[[float], float], clearance: float, horizon: float, guess: float) -> float:
    """Return the longest duration (s) found, at most `horizon`, for which displacement(duration) < clearance.

    Args:
        displacement: m as a function of s, non-decreasing; what is returned has been evaluated.
        clearance: m, what may be spent.
        horizon: s, the longest sleep of interest.
        guess: s, where to start the search.
    """
    if displacement(horizon) < clearance:
        return horizon
    low, high = 0.0, horizon
    trial = guess if 0.0 < guess < horizon else 0.5 * horizon
    for _ in range(64):
        moved = displacement(trial)
        if moved < clearance:
            low = trial
        else:
            high = trial
        if high - low <= SEARCH_TOLERANCE * high:
            break
        trial = _next_trial(trial, moved, clearance, low, high)
    return low


def _next_trial(trial: float, moved: float, clearance: float, low: float, high: float) -> float:
    """Return where a displacement in proportion to time would reach the clearance, kept inside the bracket."""
    proportional = trial * clearance / moved * (1.0 - 0.5 * SEARCH_TOLERANCE) if moved > 0.0 else high
    if low == 0.0:
        return min(proportional, 0.5 * high) if proportional > 0.0 else 0.5 * high
    margin = 0.1 * (high - low)
    return min(max(proportional, low + margin), high - margin)


def two_sided_clearance(before: float, after: float, path_length: float) -> float:
    """Return a lower bound (m) on the distance between two measurements; touching is excluded where it is > 0.

    Negative, its size is the depth limit: no point of one solid gets deeper than that into the other.

    Args:
        before: m, lower bound on the distance at the interval's start.
        after: m, the same at its end.
        path_length: m, upper bound on the arc length of any point of one body relative to any of the other.
    """
    return 0.5 * (before + after - path_length)
