"""Everything at once: a Markdown table of each case, what was measured and what was to be reached.

`python -m benchmarks --quick` takes a few minutes instead of an hour or so: fewer and smaller scenes, which need not
reach what is asked of the full ones. `--only peers bodies` runs some parts alone. CPU times are those of a child, so
that a busy machine matters less; ratios are of one run. Peers that are not installed are left out
(`pip install 'closecall[peers]'`).
"""

from __future__ import annotations

import argparse
import os
import platform
from collections.abc import Callable, Iterator

from . import crowds, ideal, jobs, log_share, many_bodies, mechanisms, nothing, peers, python_share, start_up
from .table import HEAD, Row

PARTS: dict[str, tuple[Callable[[], Iterator[Row]], Callable[[], Iterator[Row]]]] = {
    "peers": (lambda: peers.rows(40, 5.0, 200), lambda: peers.rows(12, 1.0, 100)),
    "crowds": (lambda: crowds.rows(1.0), lambda: crowds.rows(0.05)),
    "queries": (lambda: ideal.rows(40, 5.0, 200), lambda: ideal.rows(12, 1.0, 20)),
    "python": (lambda: python_share.rows(40, 5.0), lambda: python_share.rows(12, 1.0)),
    "start": (lambda: start_up.rows(8), lambda: start_up.rows(6)),
    "log": (lambda: log_share.rows(40, 5.0), lambda: log_share.rows(12, 1.0)),
    "nothing": (lambda: nothing.rows(100_000, 120), lambda: nothing.rows(10_000, 60)),
    "mechanisms": (lambda: mechanisms.rows(1.0), lambda: mechanisms.rows(0.05)),
    "jobs": (lambda: jobs.rows(2, 44, 30.0), lambda: jobs.rows(2, 12, 1.0)),
    "bodies": (
        lambda: many_bodies.rows([100, 1000, 10_000, 100_000], 20.0),
        lambda: many_bodies.rows([100, 300, 1000], 20.0),
    ),
}
"""Each part's rows, in full and quick."""


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", nargs="+", choices=list(PARTS), default=list(PARTS), metavar="PART")
    given = parser.parse_args()
    print(f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}\n\n{HEAD}")
    for name in given.only:
        full, quick = PARTS[name]
        for row in quick() if given.quick else full():
            print(row.markdown(), flush=True)


if __name__ == "__main__":
    main()
