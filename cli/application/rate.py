"""The rate of snapshots for viewers: high enough for curves in short runs, and bounded in long runs."""

from __future__ import annotations

from .errors import OptionError

#: Hz, of snapshots. Short runs take the least number, which still shows a curve; long runs take the most.
USUAL_RATE = 30.0
LEAST_SNAPSHOTS, MOST_SNAPSHOTS = 120, 36_000
#: More snapshots than this are refused, if `rate` makes so many.
MOST_ASKED = 1_000_000


def snapshot_rate(seconds: float, asked: float | None) -> float:
    """Return the rate (Hz) of snapshots over a run of so many seconds.

    Raises:
        OptionError: for a rate that makes more than `MOST_ASKED` snapshots.
    """
    if asked is None:
        return min(max(USUAL_RATE, LEAST_SNAPSHOTS / seconds), MOST_SNAPSHOTS / seconds)
    if asked * seconds > MOST_ASKED:
        problem = f"{asked:g} Hz over {seconds:g} s would take {asked * seconds:,.0f} snapshots"
        remedy = f"the limit is {MOST_ASKED:,}, which is {MOST_ASKED / seconds:.3g} Hz"
        raise OptionError("rate", f"{problem}; {remedy}")
    return asked


def thinned(seconds: float, asked: float | None) -> str | None:
    """Return a note about a long run with fewer snapshots per second than usual; None for other runs."""
    rate = snapshot_rate(seconds, asked)
    if asked is not None or rate >= USUAL_RATE:
        return None
    return f"the run of {seconds:g} s takes a snapshot every {1.0 / rate:.3g} s, {MOST_SNAPSHOTS:,} in all; see --rate"
