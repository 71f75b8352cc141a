"""Which contact of one log is which of another: a pair may touch often, and any of its contacts may move or go."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

Interval = tuple[float, float]


def aligned(golden: Sequence[Interval], new: Sequence[Interval]) -> list[tuple[int | None, int | None]]:
    """Return by index which interval of `new` is which of `golden`, None where there is none; both in time order.

    Intervals that overlap are the same one. Between two such matches, as many on both sides are the same in their
    order, for all of them moved; otherwise they went and came.
    """
    out: list[tuple[int | None, int | None]] = []
    last = (0, 0)
    for i, j in (*_overlapping(golden, new), (len(golden), len(new))):
        went, came = range(last[0], i), range(last[1], j)
        if len(went) == len(came):
            out.extend(zip(went, came, strict=True))
        else:
            out.extend((k, None) for k in went)
            out.extend((None, k) for k in came)
        out.append((i, j))
        last = (i + 1, j + 1)
    return out[:-1]


def _overlapping(golden: Sequence[Interval], new: Sequence[Interval]) -> Iterator[tuple[int, int]]:
    """Yield which intervals share an instant, each at most once."""
    i = j = 0
    while i < len(golden) and j < len(new):
        if golden[i][1] < new[j][0]:
            i += 1
        elif new[j][1] < golden[i][0]:
            j += 1
        else:
            yield i, j
            i, j = i + 1, j + 1


def gap(one: Sequence[float], other: Sequence[float]) -> float:
    """Return how far apart two brackets lie, 0 where they overlap."""
    return max(min(one) - max(other), min(other) - max(one), 0.0)
