"""The cost of keys and pictures where nothing happens: `python -m benchmarks.nothing`.

The keys belong to a path far from everything else, the pictures to bodies that ignore each other. Prints how many
times as often a pair wakes for a thousand times the keys, and how many times the CPU time of the certificate a full log
takes, the middle of paired runs.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from math import cos, sin
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from .command import run_command
from .table import Row

PAIRS_OF_RUNS = 3
MOST_WAKEUPS, MOST_TIME = 2.0, 1.5


def drive(folder: Path, keys: int) -> Path:
    """Write a scene of a car that drives around a post, 60 m away, along a path of so many keys on 12 straight roads.

    Twelve keys are the roads' ends; more lie on the roads.
    """
    corners = np.linspace(0.0, 60.0, 13)
    times = np.union1d(corners, np.linspace(0.0, 60.0, keys))
    x, y = (np.interp(times, corners, [60.0 * way(0.1 * t) for t in corners]) for way in (cos, sin))
    rows = "\n".join(f"{t!r},{a!r},{b!r},0" for t, a, b in zip(times.tolist(), x.tolist(), y.tolist(), strict=True))
    (folder / "path.csv").write_text(f"t,x,y,z\n{rows}\n")
    car = {"shapes": [{"box": [4, 2, 1.5]}], "motion": {"type": "file", "file": "path.csv", "layout": "csv"}}
    return scene(folder, 60.0, {"car": car, "post": {"shapes": [{"box": [1, 1, 3]}]}})


def heap(folder: Path, chips: int) -> Path:
    """Write a scene of 30 tools, to be checked against 40 fixtures, and of chips that nothing is checked against."""
    rng = np.random.default_rng(1)
    slide = {"type": "harmonic", "direction": [1, 0, 0], "amplitude": 0.2, "period": 2}
    tools = {
        f"tool{k}": {
            "groups": ["tools"],
            "pose": {"xyz": [0, 0.5 * k, 0]},
            "shapes": [{"sphere": 0.1}],
            "motion": slide,
        }
        for k in range(30)
    }
    fixtures = {
        f"fixture{k}": {"groups": ["fixtures"], "pose": {"xyz": [1, 0.4 * k, 0]}, "shapes": [{"box": [0.2, 0.2, 0.2]}]}
        for k in range(40)
    }
    flying = {
        f"chip{k}": {
            "pose": {"xyz": rng.uniform(0.0, 4.0, 3).tolist()},
            "shapes": [{"sphere": 0.05}],
            "motion": {"type": "constant", "velocity": rng.normal(0.0, 0.05, 3).tolist()},
        }
        for k in range(chips)
    }
    pairs = {"default": "ignore", "check": [{"between": ["tools", "fixtures"]}]}
    return scene(folder, 2.0, {**tools, **fixtures, **flying}, pairs=pairs)


def scene(folder: Path, end: float, bodies: dict[str, Any], **more: Any) -> Path:
    """Write a scene from 0 s to its end."""
    path = folder / "scene.json"
    units = {"length": "m", "angle": "rad"}
    path.write_text(
        json.dumps({"closecall": 1, "units": units, "time": {"start": 0, "end": end}, "bodies": bodies, **more})
    )
    return path


def wakeups(keys: int) -> int:
    """Return how often the pair of a drive wakes."""
    with TemporaryDirectory() as name:
        path = drive(Path(name), keys)
        ran = run_command(path, Path(name) / "out.mcap", "--log", "certificate")
    return int(ran.told["totals"]["wakeups"])


def times(chips: int) -> float:
    """Return how many times the CPU time of the certificate a full log of a heap takes."""
    with TemporaryDirectory() as name:
        path, log = heap(Path(name), chips), Path(name) / "out.mcap"
        ratios = []
        for _ in range(PAIRS_OF_RUNS):
            certificate = run_command(path, log, "--log", "certificate")
            ratios.append(run_command(path, log).cpu / certificate.cpu)
    return median(ratios)


def rows(keys: int, chips: int) -> Iterator[Row]:
    """Yield what a thousand times the keys, and what pictures of a heap of chips cost."""
    few, many = wakeups(keys // 1000), wakeups(keys)
    share = many / few
    case = f"a path of {keys:,} keys around a post 60 m away, against {keys // 1000}"
    yield Row(case, f"{many} wakeups against {few}", f"{MOST_WAKEUPS:g} times at most", share <= MOST_WAKEUPS)
    ratio = times(chips)
    case = f"full log of {chips} bodies that ignore each other, against the certificate"
    yield Row(case, f"{ratio:.2f} times", f"{MOST_TIME:g} times at most", ratio <= MOST_TIME)


if __name__ == "__main__":
    for row in rows(100_000, 120):
        print(row.markdown())
