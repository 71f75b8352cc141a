"""How often a run takes snapshots for viewers: so that a short one shows curves, and a long one ends."""

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
        OptionError: where the rate that is asked for makes more than `MOST_ASKED`.
    """
    if asked is None:
        return min(max(USUAL_RATE, LEAST_SNAPSHOTS / seconds), MOST_SNAPSHOTS / seconds)
    if asked * seconds > MOST_ASKED:
        problem = f"{asked:g} Hz over {seconds:g} s asks for {asked * seconds:,.0f} snapshots"
        remedy = f"at most {MOST_ASKED:,} are taken: {MOST_ASKED / seconds:.3g} Hz"
        raise OptionError("rate", f"{problem}; {remedy}")
    return asked


def thinned(seconds: float, asked: float | None) -> str | None:
    """Return what is said of a run so long that snapshots are taken less often than usual; None of others."""
    rate = snapshot_rate(seconds, asked)
    if asked is not None or rate >= USUAL_RATE:
        return None
    return f"snapshots every {1.0 / rate:.3g} s, {MOST_SNAPSHOTS:,} in all, for a run of {seconds:g} s; see --rate"
