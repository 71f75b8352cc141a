"""By hand, from tests/: `python -m oracle SCENE LOG` checks a log, `python -m oracle SEED FOLDER` writes a scene."""

from __future__ import annotations

import sys
from pathlib import Path

from .check import check_log, unresolved_share
from .logs import read_log
from .scenes import write_scene

first, second = sys.argv[1:]
if first.isdecimal():
    Path(second).mkdir(parents=True, exist_ok=True)
    print(write_scene(int(first), Path(second)))
else:
    faults = check_log(Path(first), Path(second))
    print(*faults, sep="\n")
    print(f"{len(faults)} faults, {unresolved_share(read_log(Path(second))):.2%} of the time unresolved")
    sys.exit(bool(faults))
