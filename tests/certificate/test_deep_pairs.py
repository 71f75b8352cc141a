"""Many random pairs of bodies, each log held against instants that lie densest where the log has least to spare.

A failure names its scene. By hand, from tests/: `python -m oracle pairs:NUMBER FOLDER` writes the scene of a number,
and `python -m oracle SCENE LOG` checks a log of it.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterable
from copy import deepcopy
from pathlib import Path
from time import monotonic

import pytest
from certified_runs import EPOCH, clear_the_contact, logged

from oracle.check import check
from oracle.check_minimum import Tally
from oracle.logs import Log, read_log
from oracle.pair_scenes import write_pairs
from oracle.sampling import IN_STRETCH, Effort, tightest
from oracle.truth import Truth
from oracle.wall import WALL, true_log

DEEP_PAIRS = int(os.environ.get("CLOSECALL_DEEP_PAIRS", "20000"))
"""How many pairs the deep test takes; CLOSECALL_DEEP_PAIRS_FIRST is the number of the first scene."""

DEEP_FIRST = int(os.environ.get("CLOSECALL_DEEP_PAIRS_FIRST", "0"))

ADAPTIVE = {"uniform": 96, "scattered": 24, "ends": 40, "knots": 20, "minima": 3, "messages": 6, "tight": 96}

KINDS = {
    "missed contacts": ("touches at",),
    "false clearances": ("nearer than its clearance", "inside the margin", "clearance"),
    "wrong minima": ("least distance", "told are", "apart at the least"),
}
"""What a fault's line says of each kind; all else is "other"."""


def kind_of(fault: str) -> str:
    """Return which kind a fault is of."""
    return next((kind for kind, words in KINDS.items() if any(word in fault for word in words)), "other")


def faults_of(number: int, folder: Path, tally: Tally) -> list[str]:
    """Return what is wrong with the log of a scene of pairs, each line with the scene; a faulty one stays on disk."""
    folder.mkdir()
    scene = write_pairs(number, folder)
    log = read_log(logged(scene, "--log", "certificate"))
    found = check(Truth(scene), log, effort=Effort(seed=number, **ADAPTIVE), epoch=EPOCH, tally=tally)
    if not found:
        shutil.rmtree(folder)
    return [f"pairs:{number}: {fault}" for fault in found]


def check_many(numbers: Iterable[int], pairs: int, folder: Path, *, every: int) -> list[str]:
    """Check scenes until there were so many pairs, and return the faults; say after `every` scenes how it stands."""
    tally, failed, began = Tally(), list[str](), monotonic()
    for done, number in enumerate(numbers, 1):
        found = faults_of(number, folder / str(number), tally)
        failed += found
        print(*found, sep="\n", end="\n" * bool(found), flush=True)
        over = tally.pairs >= pairs
        if over or done % every == 0:
            kinds = ", ".join(f"{sum(kind_of(one) == kind for one in failed)} {kind}" for kind in (*KINDS, "other"))
            print(f"up to scene {number}, {monotonic() - began:.0f} s: {tally}; {kinds}", flush=True)
        if over:
            break
    return failed


def test_the_logs_of_some_pairs_are_true(tmp_path: Path) -> None:
    faults = check_many(range(102, 110), 25, tmp_path, every=10)
    assert not faults, "\n".join(faults)


@pytest.mark.deep
def test_the_logs_of_many_pairs_are_true(tmp_path: Path) -> None:
    numbers = range(DEEP_FIRST, DEEP_FIRST + DEEP_PAIRS)
    faults = check_many(numbers, DEEP_PAIRS, tmp_path, every=50)
    assert not faults, "\n".join(faults[:100])


def test_the_least_clearance_is_looked_at_most(tmp_path: Path) -> None:
    """The dart wakes 0.65 m away at 0 s and 0.15 m away at 0.5 s, and meets the wall at 0.65 s."""
    (tmp_path / "wall.yaml").write_text(WALL)
    log, effort = true_log(), Effort(tight=2 * IN_STRETCH)
    spans, wakeups = (log.by_pair(topic)["wall|dart"] for topic in ("spans", "wakeups"))
    for wakeup in wakeups[:2]:
        wakeup["clearance"] = 0.1 * wakeup["clearance"]
    spans[0]["clearance"] = 0.5
    times = tightest(Truth(tmp_path / "wall.yaml"), ("wall", "dart"), spans, wakeups, effort, 0)
    assert len(times) >= IN_STRETCH
    assert ((times > 0.5) & (times < 0.65) | (times > 1.35)).all(), times


@pytest.fixture(scope="module")
def eventful(tmp_path_factory: pytest.TempPathFactory) -> tuple[Truth, Log]:
    """The first scene of pairs in which one pair touches, and another comes near in a curve and never touches."""
    folder = tmp_path_factory.mktemp("eventful")
    for number in range(100):
        (folder / str(number)).mkdir()
        scene = write_pairs(number, folder / str(number))
        log = read_log(logged(scene, "--log", "certificate"))
        if log.of("collisions") and passing(log) is not None:
            truth = Truth(scene)
            assert not check(truth, log, effort=Effort(**ADAPTIVE), epoch=EPOCH)
            return truth, log
    raise AssertionError("no scene of pairs has both")


def passing(log: Log) -> str | None:
    """Return a pair that is CLEAR throughout and was measured farther apart than at its least distance."""
    for pair, spans in log.by_pair("spans").items():
        measured = [one["distance"] for one in log.by_pair("distances").get(pair, ())]
        if {span["verdict"] for span in spans} == {"CLEAR"} and measured and max(measured) > 1.5 * min(measured):
            return pair
    return None


def raise_the_clearance_of_the_nearest(log: Log) -> None:
    """Say that a pair stays a little farther apart than it was measured to be at its nearest."""
    pair = passing(log) or ""
    nearest = min(log.by_pair("distances")[pair], key=lambda one: one["distance"])
    for span in log.by_pair("spans")[pair]:
        span["clearance"] = max(span["clearance"], nearest["distance"] + 1e-6)


def move_the_minimum(log: Log) -> None:
    """Tell of a pair that its least distance is one that was truly measured, but not the least."""
    pair = passing(log) or ""
    farther = max(log.by_pair("distances")[pair], key=lambda one: one["distance"])
    summary = json.loads(log.attachments["summary.json"])
    told = next(one for one in summary["pairs"] if one["pair"] == pair)
    time = (farther["timestamp"] - EPOCH) / 1e9
    told["distance"] |= {"lower": farther["distance"] * (1.0 - 1e-6), "upper": farther["distance"], "time": time}
    log.attachments["summary.json"] = json.dumps(summary).encode()


def widen_the_minimum(log: Log) -> None:
    """Tell of a pair no more than that it does not touch."""
    summary = json.loads(log.attachments["summary.json"])
    told = next(one for one in summary["pairs"] if one["pair"] == passing(log))
    told["distance"]["lower"] = 0.0
    log.attachments["summary.json"] = json.dumps(summary).encode()


SPOILED: list[tuple[Callable[[Log], None], str]] = [
    (clear_the_contact, "missed contacts"),
    (raise_the_clearance_of_the_nearest, "false clearances"),
    (move_the_minimum, "wrong minima"),
    (widen_the_minimum, "wrong minima"),
]


@pytest.mark.parametrize(("spoil", "kind"), SPOILED, ids=lambda value: getattr(value, "__name__", ""))
def test_a_spoiled_log_is_counted_as_what_it_is(
    eventful: tuple[Truth, Log], spoil: Callable[[Log], None], kind: str
) -> None:
    truth, log = eventful[0], deepcopy(eventful[1])
    spoil(log)
    kinds = {kind_of(fault) for fault in check(truth, log, effort=Effort(**ADAPTIVE), epoch=EPOCH)}
    assert kind in kinds, kinds
