"""How often a run takes snapshots for viewers: so that a short one shows curves, and a long one ends."""

from __future__ import annotations

import click

from .options import LEAST_SNAPSHOTS, MOST_ASKED, MOST_SNAPSHOTS, USUAL_RATE


def snapshot_rate(seconds: float, asked: float | None) -> float:
    """Return the rate (Hz) of snapshots over a run of so many seconds.

    Raises:
        click.BadParameter: where the rate that is asked for makes more than `MOST_ASKED`.
    """
    if asked is None:
        return min(max(USUAL_RATE, LEAST_SNAPSHOTS / seconds), MOST_SNAPSHOTS / seconds)
    if asked * seconds > MOST_ASKED:
        problem = f"{asked:g} Hz over {seconds:g} s asks for {asked * seconds:,.0f} snapshots"
        remedy = f"at most {MOST_ASKED:,} are taken: {MOST_ASKED / seconds:.3g} Hz"
        raise click.BadParameter(f"{problem}; {remedy}.", param_hint="--rate")
    return asked


def thinned(seconds: float, asked: float | None) -> str | None:
    """Return what is said of a run so long that snapshots are taken less often than usual; None of others."""
    rate = snapshot_rate(seconds, asked)
    if asked is not None or rate >= USUAL_RATE:
        return None
    return f"snapshots every {1.0 / rate:.3g} s, {MOST_SNAPSHOTS:,} in all, for a run of {seconds:g} s; see --rate"
