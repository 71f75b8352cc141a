"""What writing the log takes of a run without viewer topics: `python -m benchmarks.log_share [BODIES [SECONDS]]`."""

from __future__ import annotations

import sys
from collections.abc import Iterator

from .peers import command
from .rocks import Rocks
from .table import Row

MOST = 0.1


def rows(count: int, seconds: float) -> Iterator[Row]:
    """Yield the share of `seconds.log` in `seconds.total`, both wall-clock."""
    took = command(Rocks(count), seconds, "--log", "certificate").told["seconds"]
    share = took["log"] / took["total"]
    yield Row(f"writing the log, {count} rocks, no viewer topics", f"{share:.1%}", f"under {MOST:.0%}", share < MOST)


if __name__ == "__main__":
    kinds = (int, float)
    given = [kind(text) for kind, text in zip(kinds, sys.argv[1:], strict=False)]
    for row in rows(*given) if len(given) == 2 else rows(40, 5.0):
        print(row.markdown())
