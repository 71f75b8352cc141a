"""By hand, from tests/: `python -m oracle SCENE LOG` checks a log, `python -m oracle SEED FOLDER` writes a scene.

A seed is a number, or a family and a number: `fast_spin:7`; `pairs:7` is a scene of many pairs.
"""

from __future__ import annotations

import sys
from pathlib import Path

from .check import check_log, unresolved_share
from .families import FAMILIES, write_family
from .logs import read_log
from .pair_scenes import write_pairs
from .scenes import write_scene

first, second = sys.argv[1:]
family, _, number = first.rpartition(":")
if number.isdecimal():
    folder = Path(second)
    folder.mkdir(parents=True, exist_ok=True)
    if family in FAMILIES:
        print(write_family(family, int(number), folder))
    else:
        print((write_pairs if family == "pairs" else write_scene)(int(number), folder))
else:
    faults = check_log(Path(first), Path(second))
    print(*faults, sep="\n")
    print(f"{len(faults)} faults, {unresolved_share(read_log(Path(second))):.2%} of the time unresolved")
    sys.exit(bool(faults))
