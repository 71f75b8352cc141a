"""Runs of the sample scenes, once a session for all tests, and what the tests ask of their summaries and of the oracle.

A figure of a header is proved where it is derived anew, by a closed form or by the oracle's sampling, found in the
header's text, and found in the log of the run.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from time import sleep
from typing import Any

import numpy as np
from places import SAMPLES

from oracle.logs import Log, read_log
from oracle.rigid import FloatArray
from oracle.truth import Truth

FOLDER = SAMPLES
NAMES = sorted(path.name for path in FOLDER.iterdir() if path.is_dir())

HASH_SEEDS = ("1", "2")

SLACK = 1e-9
"""s or m: rounding allowed between a closed form and the tool."""

PATIENCE = 300
"""s that a test waits for the runs of a sample in another process."""


@dataclass(frozen=True)
class Sample:
    """A sample after two runs, one for each hash seed."""

    name: str
    logs: tuple[Path, ...]
    summary: dict[str, Any]
    warnings: str

    @property
    def path(self) -> Path:
        return FOLDER / self.name / "scene.yaml"

    @cached_property
    def truth(self) -> Truth:
        return Truth(self.path)

    @cached_property
    def log(self) -> Log:
        return read_log(self.logs[0])

    @cached_property
    def header(self) -> str:
        return header_of(self.path)

    def says(self, figure: str) -> bool:
        """Whether the header has this text, wherever its lines are broken."""
        assert figure in self.header, f"{self.name} does not say: {figure}"
        return True

    def pair(self, name: str) -> dict[str, Any]:
        return next(pair for pair in self.summary["pairs"] if pair["pair"] == name)

    def pairs_with(self, verdict: str) -> set[str]:
        return {pair["pair"] for pair in self.summary["pairs"] if pair["verdict"] == verdict}


def header_of(path: Path) -> str:
    """Return the comment above a scene, in one line."""
    lines = path.read_text(encoding="utf-8").split("closecall: 1")[0].splitlines()
    return " ".join(" ".join(line.removeprefix("#") for line in lines).split())


@cache
def sample_of(name: str) -> Sample:
    """Return a sample that was run once with each hash seed, by the test process that first asked for it."""
    folder = Path(os.environ["CLOSECALL_SAMPLE_RUNS"]) / name
    logs = tuple(folder / f"{seed}.mcap" for seed in HASH_SEEDS)
    told = folder / "told.json"
    try:
        folder.mkdir()
    except FileExistsError:
        wait_for(told)
    else:
        ready = folder / "told.json.partial"
        ready.write_text(json.dumps(run_of(name, logs)))
        ready.rename(told)
    summary, warnings = json.loads(told.read_text())
    return Sample(name, logs, summary, warnings)


def wait_for(path: Path) -> None:
    for _ in range(10 * PATIENCE):
        if path.exists():
            return
        sleep(0.1)
    raise TimeoutError(f"another process did not finish {path}")


def run_of(name: str, logs: tuple[Path, ...]) -> tuple[dict[str, Any], str]:
    """Run a sample with each hash seed, both at a time; return the summary and the warnings of the first.

    Where the header says that a `--fail-on` exits with 0, the runs are given that option.
    """
    path = FOLDER / name / "scene.yaml"
    claimed = re.findall(r"`(--fail-on) ([a-z,]+)` exits with 0", header_of(path))
    options = [word for option in claimed for word in option]
    command = [sys.executable, "-m", "closecall", "run", str(path), "--json", *options, "-o"]
    runs = [
        subprocess.Popen(
            [*command, str(log)],
            env=os.environ | {"PYTHONHASHSEED": seed},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for seed, log in zip(HASH_SEEDS, logs, strict=True)
    ]
    said = [run.communicate() for run in runs]
    assert [run.returncode for run in runs] == [0, 0], said
    return json.loads(said[0][0]), said[0][1]


def is_bracketed(times: list[float], time: float) -> bool:
    """Whether a contact's begin or end is told to a microsecond, around a time."""
    return min(times) - SLACK <= time <= max(times) + SLACK and abs(times[1] - times[0]) <= 1e-6


def has_contacts(pair: dict[str, Any], expected: list[tuple[float, float]]) -> bool:
    """Whether a pair's contacts are bracketed, begin (s) and end (s) of each, and there are no others."""
    told = pair["contacts"]
    assert len(told) == len(expected), told
    return all(
        is_bracketed(one["begin"], begin) and is_bracketed(one["end"], end)
        for one, (begin, end) in zip(told, expected, strict=True)
    )


def is_enclosed(pair: dict[str, Any], least: float) -> bool:
    """Whether a pair's least distance, m, lies between its bounds; polyhedra are nearer by up to the chord error."""
    lower, upper = pair["distance"]["lower"], pair["distance"]["upper"]
    return lower <= least + SLACK and least - pair["chord_error"] <= upper + SLACK


def least_value(curve: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Return the least value of a curve that falls and then rises, and where, by thirds."""
    for _ in range(100):
        early, late = low + (high - low) / 3.0, high - (high - low) / 3.0
        low, high = (low, late) if curve(early) <= curve(late) else (early, high)
    return curve(low), low


def crossing(curve: Callable[[float], float], low: float, high: float, value: float) -> float:
    """Return where a curve that is above `value` at one end and below it at the other crosses it, by halving."""
    rises = curve(low) < value
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if (curve(middle) < value) == rises else (low, middle)
    return low


def least_distance(truth: Truth, pair: tuple[str, str], low: float, high: float, count: int) -> tuple[float, float]:
    """Return the least signed distance, m, and its time, s, by sampling [low, high] and then around the least."""
    distances, times = np.zeros(0), np.zeros(0)
    for _ in range(7):
        times = np.linspace(low, high, count)
        distances = truth.signed(*pair, times)
        best = int(distances.argmin())
        low, high, count = times[max(best - 1, 0)], times[min(best + 1, count - 1)], 25
    return float(distances.min()), float(times[distances.argmin()])


def changes(truth: Truth, pair: tuple[str, str], times: FloatArray, margin: float = 0.0) -> list[float]:
    """Return when, s, a pair comes as near as `margin` (m) or parts again, by bisection between the given times.

    At a margin of 0: when it begins or ceases to touch.
    """
    near = truth.signed(*pair, times) <= margin
    found = np.flatnonzero(near[1:] != near[:-1])
    low, high = times[found], times[found + 1]
    for _ in range(40 if len(found) else 0):
        middle = 0.5 * (low + high)
        early = (truth.signed(*pair, middle) <= margin) == near[found]
        low, high = np.where(early, middle, low), np.where(early, high, middle)
    return [float(time) for time in low]
