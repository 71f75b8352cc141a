"""Random scenes run through the tool, their logs held against the oracle by brute force.

A failure names its seeds. By hand, from tests/: `python -m oracle SEED FOLDER` writes the scene of a seed, and
`python -m oracle SCENE LOG` checks a log of it. The adversarial families are in test_adversarial_families.py.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from certified_runs import DEEP, EPOCH, QUICK, clear_the_contact, logged

from oracle.check import check, check_log, unresolved_share
from oracle.logs import Log, read_log
from oracle.sampling import Effort
from oracle.scenes import write_scene
from oracle.truth import Truth

SCENES_PER_TEST = 5

DEEP_SCENES = int(os.environ.get("CLOSECALL_DEEP_SCENES", "300"))
"""How many seeds the deep test takes; CLOSECALL_DEEP_FIRST is the first of them."""

DEEP_FIRST = int(os.environ.get("CLOSECALL_DEEP_FIRST", "1000000"))

DEEP_EFFORT = QUICK if os.environ.get("CLOSECALL_DEEP_EFFORT") == "plain" else DEEP
"""How many instants the deep test tries."""


def run(seed: int, folder: Path, *options: str) -> tuple[Path, Path]:
    """Write the scene of a seed, run the tool on it, and return the scene file and the log; odd ones are short."""
    folder.mkdir()
    scene = write_scene(seed, folder)
    return scene, logged(scene, *(["--log", "certificate"] if seed % 2 else []), *options)


def faults_of(seed: int, folder: Path, effort: Effort, *options: str) -> list[str]:
    """Return what is wrong with the log of a seed, each line with the seed."""
    return [f"seed {seed}: {fault}" for fault in check_log(*run(seed, folder, *options), effort=effort)]


@pytest.mark.parametrize("first", range(0, 20, SCENES_PER_TEST))
def test_the_log_of_a_random_scene_is_true(first: int, tmp_path: Path) -> None:
    seeds = range(first, first + SCENES_PER_TEST)
    print("seeds", *seeds)
    faults = [fault for seed in seeds for fault in faults_of(seed, tmp_path / str(seed), Effort(seed=seed, **QUICK))]
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize("first", range(60, 70, SCENES_PER_TEST))
def test_the_log_of_a_random_scene_whose_pairs_come_and_go_is_true(first: int, tmp_path: Path) -> None:
    on = ("--broad-phase", "on")
    seeds = range(first, first + SCENES_PER_TEST)
    faults = [f for seed in seeds for f in faults_of(seed, tmp_path / str(seed), Effort(seed=seed, **QUICK), *on)]
    assert not faults, "\n".join(faults)


@pytest.mark.deep
def test_the_logs_of_many_random_scenes_are_true(tmp_path: Path) -> None:
    failed: list[str] = []
    for seed in range(DEEP_FIRST, DEEP_FIRST + DEEP_SCENES):
        on = ("--broad-phase", "on") if seed % 3 == 0 else ()
        faults = faults_of(seed, tmp_path / str(seed), Effort(seed=seed, **DEEP_EFFORT), *on)
        print(f"seed {seed}: {len(faults)} faults", *faults, sep="\n", flush=True)
        failed += faults[:3]
    assert not failed, "\n".join(failed)


@pytest.fixture(scope="module")
def eventful(tmp_path_factory: pytest.TempPathFactory) -> tuple[Truth, Log]:
    """The first random scene whose log has a contact that begins after the start, and ends."""
    folder = tmp_path_factory.mktemp("eventful")
    for seed in range(100):
        scene, path = run(seed, folder / str(seed))
        log = read_log(path)
        ended = {event["pair"] for event in log.of("collisions") if event["phase"] == "END"}
        began = {event["pair"] for event in log.of("collisions") if event["time_clear"] != event["time_touching"]}
        if ended & began:
            return Truth(scene), log
    raise AssertionError("no random scene has a contact that begins and ends")


@pytest.fixture(scope="module")
def unlisted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Truth, Log]:
    """The first random scene whose log has a pair that windows alone cleared, and several windows of a body."""
    folder = tmp_path_factory.mktemp("unlisted")
    for seed in range(100):
        scene, path = run(seed, folder / str(seed), "--broad-phase", "on")
        truth, log = Truth(scene), read_log(path)
        listed = set(log.by_pair("spans"))
        alone = [pair for pair in truth.pairs() if "|".join(pair) not in listed]
        if alone and len(windows_of(log, alone[0][0])) > 2:
            return truth, log
    raise AssertionError("no random scene has a pair that windows alone clear")


def windows_of(log: Log, body: str) -> list[dict[str, Any]]:
    return [window for window in log.of("windows") if window["body"] == body]


def raise_a_clearance(log: Log) -> None:
    """Say of the span around the first measured distance that the pair stays further apart than that, round or not."""
    one = next(one for one in log.of("distances") if one["distance"] > 0.0)
    time = (one["timestamp"] - EPOCH) * 1e-9
    span = next(span for span in log.by_pair("spans")[one["pair"]] if span["start"] <= time < span["end"])
    span["clearance"] = one["distance"] + one["excess"] + 1e-5


def shift_a_bracket(log: Log) -> None:
    event = next(one for one in log.of("collisions") if one["time_clear"] != one["time_touching"])
    way = event["time_clear"] - event["time_touching"]
    event["time_touching"] += 3e5 * way
    event["time_clear"] += 3e5 * way


def tear_a_gap(log: Log) -> None:
    next(span for span in log.of("spans") if span["verdict"] == "CLEAR")["end"] -= 1e-6


def overstate_clearances(log: Log) -> None:
    for wakeup in log.of("wakeups"):
        wakeup["clearance"] += 0.01


SPOILED: list[tuple[Callable[[Log], None], str]] = [
    (clear_the_contact, "touches at"),
    (raise_a_clearance, "nearer than its clearance"),
    (shift_a_bracket, "apart at its touching end"),
    (tear_a_gap, "gap"),
    (overstate_clearances, "wakeup at"),
]


@pytest.mark.parametrize(("spoil", "said"), SPOILED, ids=lambda value: getattr(value, "__name__", ""))
def test_a_spoiled_log_is_objected_to(eventful: tuple[Truth, Log], spoil: Callable[[Log], None], said: str) -> None:
    truth, log = eventful[0], deepcopy(eventful[1])
    spoil(log)
    faults = check(truth, log, epoch=EPOCH)
    assert any(said in fault for fault in faults), "\n".join(faults)


def lose_a_window(log: Log) -> None:
    log.topics["windows"].remove(next(one for one in log.of("windows") if len(windows_of(log, one["body"])) > 2))


def widen_the_windows(log: Log) -> None:
    for window in log.of("windows"):
        window["box_min"] = dict.fromkeys("xyz", -1e6)


def shrink_the_windows(log: Log) -> None:
    for window in log.of("windows"):
        window["box_max"] = window["box_min"]


SPOILED_WINDOWS: list[tuple[Callable[[Log], None], str]] = [
    (lose_a_window, "has"),
    (widen_the_windows, "no spans, and boxes"),
    (shrink_the_windows, "leaves its box"),
]


@pytest.mark.parametrize(("spoil", "said"), SPOILED_WINDOWS, ids=lambda value: getattr(value, "__name__", ""))
def test_a_log_of_spoiled_windows_is_objected_to(
    unlisted: tuple[Truth, Log], spoil: Callable[[Log], None], said: str
) -> None:
    truth, log = unlisted[0], deepcopy(unlisted[1])
    spoil(log)
    faults = [fault for fault in check(truth, log, epoch=EPOCH) if said in fault]
    assert faults


def test_little_of_the_time_stays_unresolved(tmp_path: Path) -> None:
    """Honest but useless logs would pass all else: over the first scenes almost all time must have a verdict."""
    shares = [unresolved_share(read_log(run(seed, tmp_path / str(seed))[1])) for seed in range(6)]
    assert sum(shares) / len(shares) < 0.02
