"""The progress of a run on a terminal: which step, how much of it is done, and a time left that is true."""

from __future__ import annotations

import re
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np
import pytest
from cli_process import on_a_terminal
from small_scenes import box

from closecall.cli.progress import HERE, LEAST_SECONDS, Steps, TimeLeft
from closecall.scheduler.broad.active_pairs import ActivePairs
from closecall.scheduler.broad.broad_phase import BroadPhase
from closecall.scheduler.broad.windows import Sweeps
from closecall.scheduler.model.scene import Body, PairRules, Scene, Settings
from closecall.scheduler.motions import Constant, Fixed, Harmonic
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import PairFactory
from closecall.scheduler.parallel.merge import observer_of
from closecall.scheduler.run import run
from closecall.scheduler.snapshots.schedule import observed, snapshot_times

ENGINE = """closecall: 1
units: {length: m, angle: rad}
time: {start: 0, end: 2}
bodies:
  pin: {shapes: [{box: [0.1, 0.2, 0.3]}], motion: {type: constant, angular_velocity: [3, 5, 7]}}
"""
"""A pin that spins amid posts, near which least distances take long."""


def at(x: float) -> np.ndarray:
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


def seconds(words: str) -> int:
    assert words.endswith(" left")
    total = 0
    for part in words.removesuffix(" left").split(":"):
        total = 60 * total + int(part)
    return total


def test_at_a_steady_pace_the_time_left_is_the_time_that_it_takes() -> None:
    left = TimeLeft(100.0)
    for spent in range(2, 50):
        assert abs(seconds(left.told(100.0 + spent, spent / 50.0)) - (50 - spent)) <= 1


def test_the_time_left_never_rises_and_ends_no_sooner_than_the_step() -> None:
    rng = np.random.default_rng(1)
    left, now, share, told = TimeLeft(0.0), 0.0, 0.0, []
    while share < 0.99:
        now, share = now + float(rng.exponential(1.0)), share + (0.99 - share) * float(rng.uniform(0.0, 0.1)) + 1e-4
        if words := left.told(now, share):
            told.append(seconds(words))
    assert len(told) > 20
    assert all(before >= after for before, after in pairwise(told))
    assert min(told) >= 1


def test_nothing_is_said_of_the_time_left_before_anything_can_be_known() -> None:
    left = TimeLeft(0.0)
    assert left.told(0.5 * LEAST_SECONDS, 0.5) == ""
    assert left.told(1000.0, 0.0) == ""
    assert left.told(1001.0, 0.5) == "16:41 left"
    assert TimeLeft(0.0).told(36000.0, 0.5) == "10:00:00 left"


@pytest.mark.parametrize("crowded", [False, True])
def test_steps_follow_each_other_and_each_is_done_in_the_end(crowded: bool) -> None:
    slider = Body("slider", None, at(0.0), Harmonic((0.0, 1.0, 0.0), 0.8, 1.5, 0.0), (box(1, 1, 1),))
    spinner = Body("spinner", None, at(5.0), Constant((0.1, 0.0, 0.0), (3.0, 1.0, 0.0)), (box(1, 1, 1),), (0.0, 1.0))
    posts = [Body(f"post{k}", None, at(0.3 * k + 1.0), Fixed(), (box(0.1, 1, 1),)) for k in range(3)]
    scene = Scene((slider, spinner, *posts), 0.0, 3.0, PairRules())
    settings = Settings()
    factory = PairFactory(scene, NarrowPhase(scene.bodies), 0.0)
    pairs = () if crowded else tuple(factory.all())
    crowd = ActivePairs(factory, settings, BroadPhase(scene, Sweeps(factory))) if crowded else None
    observer = observer_of(factory, None if crowded else pairs, 5)
    events = observed(run(pairs, settings, crowd), observer, snapshot_times(scene, 30.0), settings.time_resolution)
    steps = Steps(0.0, 3.0, HERE)
    told = [(steps.step, steps.share)]
    for event in events:
        steps.tell(event)
        told.append((steps.step, steps.share))
    order = [name for name, _ in groupby(step for step, _ in told)]
    assert order == list(HERE)
    for step in HERE:
        shares = [share for name, share in told if name == step]
        assert all(0.0 <= before <= after <= 1.0 for before, after in pairwise(shares))
    assert told[-1][1] == 1.0


@pytest.mark.parametrize("columns", [40, 60, 100])
def test_a_terminal_of_any_width_shows_the_step_in_one_line(columns: int, tmp_path: Path) -> None:
    post = "  post{}: {{pose: {{xyz: [{}, 0, 0]}}, shapes: [{{box: [0.1, 0.1, 0.1]}}]}}"
    posts = [post.format(k, 0.35 + 0.01 * k) for k in range(12)]
    (tmp_path / "a_scene_of_a_rather_long_name.yaml").write_text(ENGINE + "\n".join(posts) + "\n")
    words = ("run", "a_scene_of_a_rather_long_name.yaml", "-o", "out.mcap")
    shown = on_a_terminal(*words, cwd=tmp_path, columns=columns, NO_COLOR="1")
    lines = re.split(r"[\r\n]+", re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown))
    assert any("certifying" in line for line in lines)
    assert max(len(line.rstrip()) for line in lines if "%" in line) <= columns
