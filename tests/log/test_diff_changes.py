"""Changes to scenes and to logs: which of them a reviewer wants to hear of, and which not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from diff_logs import SCENE, edited, run_scene, with_last_bits, write_scene
from mcap.writer import CompressionType
from rewritten_logs import rewrite

from closecall.formats.log.diff.compare import compare
from closecall.formats.log.diff.difference import Comparison, Ignored, Tolerances
from closecall.formats.log.diff.findings import Rules
from closecall.formats.log.diff.wording import sentence
from closecall.formats.log.errors import LogError

Make = Callable[[Path, Path], object]
"""Writes the new log, given the golden one and where to."""


@dataclass(frozen=True)
class Case:
    """A change, and what a comparison says of it: by cause, how many; the same where nothing is said."""

    make: Make
    says: dict[str, int]
    rules: Rules = Rules()  # noqa: RUF009
    every_topic: bool = False
    words: str = ""


def scene(text: str, *options: str, subdivisions: int = 2) -> Make:
    """Run a changed scene."""
    return lambda golden, new: run_scene(write_scene(new.parent / new.stem, text, subdivisions), new, *options)


def put(old: str, new: str, *options: str) -> Make:
    """Run the scene with one thing put in place of another."""
    assert old in SCENE
    return scene(SCENE.replace(old, new), *options)


def log(*, then: Callable[[Path], object] | None = None, **how: object) -> Make:
    """Write the golden log again, changed."""

    def make(golden: Path, new: Path) -> None:
        rewrite(golden, new, **how)  # type: ignore[arg-type]
        if then is not None:
            then(new)

    return make


def is_end(message) -> bool:
    return message.phase == 2


def drop(topic: str, pair: str, which: Callable[[Any], bool] = lambda message: True, first: int | None = None) -> Make:
    return log(change=edited(topic, lambda one: not (one.pair == pair and which(one)), first))


def later(message) -> None:
    if message.phase == 1:
        message.time_clear += 0.0032
        message.time_touching += 0.0032


def nearer(message) -> None:
    if message.pair == "arm|rail":
        message.distance -= 0.0004


def lower(message) -> None:
    if message.pair == "arm|rail":
        message.clearance -= 0.0004


def reordered() -> str:
    head, bodies = SCENE.split("bodies:\n")
    bodies, pairs = bodies.split("pairs:")
    arm, rest = bodies[: bodies.index("  wall")], bodies[bodies.index("  wall") :]
    return f"{head}bodies:\n{rest}{arm}pairs:{pairs}"


def in_metres() -> str:
    text = SCENE.replace("length: mm", "length: m")
    scaled = {
        "[40, 40, 40]": "[0.04, 0.04, 0.04]",
        "[200, 0, 0]": "[0.2, 0, 0]",
        "[230, 0, 0]": "[0.23, 0, 0]",
        "[40, 200, 200]": "[0.04, 0.2, 0.2]",
        "[100, 70, 0]": "[0.1, 0.07, 0]",
        "[20, 20, 20]": "[0.02, 0.02, 0.02]",
        "[100, -80, 0]": "[0.1, -0.08, 0]",
        "[-300, 0, 400]": "[-0.3, 0, 0.4]",
        "sphere: 10": "sphere: 0.01",
        "[300, 0, 0]": "[0.3, 0, 0]",
        "[0, 24, 400]": "[0, 0.024, 0.4]",
        "radius: 10, length: 100": "radius: 0.01, length: 0.1",
        "margin: 6": "margin: 0.006",
    }
    for old, new in scaled.items():
        assert old in text
        text = text.replace(old, new)
    return text


def renamed() -> str:
    """Return the scene with all its bodies under other names."""
    text = SCENE
    for name in ("arm", "wall", "rail", "cover", "ball", "post"):
        text = text.replace(name, f"new_{name}")
    return text


FAR = "  far: {pose: {xyz: [0, 0, 9000]}, shapes: [{sphere: 1}]}\npairs:"
WITHIN = Rules(within_brackets=True)
MOVED = {"minimum fell": 1, "minimum rose": 1}

CASES = {
    # changes of the scene that a reviewer wants to hear of
    "a keyframe moved 1 mm": Case(put("[200, 0, 0]", "[200, 1, 0]"), MOVED),
    "a keyframe moved 1 mm, brackets": Case(put("[200, 0, 0]", "[200, 1, 0]"), MOVED, WITHIN),
    "a keyframe 3.2 ms later": Case(
        put("t: 1,", "t: 1.0032,"), {"contact begin moved": 1, "contact end moved": 1}, words="3.04 ms later"
    ),
    "a wall moved away": Case(
        put("[230, 0, 0]", "[250, 0, 0]"), {"verdict changed": 1, "contact vanished": 1}, words="contact -> clear"
    ),
    "a rail moved into the way": Case(
        put("[100, 70, 0]", "[100, 25, 0]"),
        {"verdict changed": 1, "contact appeared": 2},
        words="arm between home and reach",
    ),
    "a body renamed": Case(put("rail", "guide"), {"pair removed": 2, "pair added": 2}),
    "a body added": Case(put("pairs:", FAR), {"pair added": 2}),
    "a body removed": Case(
        put("  rail: {pose: {xyz: [100, 70, 0]}, shapes: [{box: [20, 20, 20]}]}\n", ""), {"pair removed": 2}
    ),
    "a pair ignored": Case(
        put("pairs: {", "pairs: {ignore: [{between: [arm, wall], reason: a}], "), {"pair removed": 1}
    ),
    "a mesh decimated": Case(scene(SCENE, subdivisions=1), {"minimum rose": 1}, words="arm | cover"),
    "a margin raised": Case(
        put("margin: 6}", "margin: 50}"),
        {"margin changed": 1, "breach moved": 2},
        WITHIN,  # for the least distance is searched from other instants
        words="margin changed: 44 mm more",
    ),
    "a margin dropped": Case(
        put("pairs: {margins: [{between: [ball, post], margin: 6}]}\n", ""),
        {"verdict changed": 1, "margin changed": 1, "breach vanished": 1},
        WITHIN,
    ),
    "a path of its limits alone": Case(
        put(
            "motion: {type: constant, velocity: [300, 0, 0]}",
            "motion: {type: limits, velocity: [300, 0, 0], max_speed: 300}",
        ),
        {"verdict changed": 4, "possible time changed": 4},
        Rules(ignored=Ignored(("/collisions", "/distances", "*post"))),
    ),
    # changes of the scene that mean nothing
    "bodies in another order": Case(scene(reordered()), {}, WITHIN),
    "the scene in metres": Case(scene(in_metres()), {}, WITHIN),
    "named keys renamed": Case(put("reach", "stretch"), {}),
    "a comment": Case(put("bodies:", "# of the cell\nbodies:"), {}),
    "a body moved by 10 nm": Case(put("[100, 70, 0]", "[100.00001, 70, 0]"), {}, WITHIN),
    "another time resolution": Case(scene(SCENE, "--time-resolution", "0.01"), {}, WITHIN),
    "least distances not searched": Case(scene(SCENE, "--distance-tolerance", "none"), {}, WITHIN),
    "swept boxes": Case(scene(SCENE, "--broad-phase", "on"), {}, WITHIN),
    "a full log": Case(scene(SCENE, "--log", "full"), {}),
    "topics by body": Case(scene(SCENE, "--topics", "body"), {}),
    "another epoch": Case(scene(SCENE, "--epoch", "1700000000000000000"), {}, every_topic=True),
    "no compression": Case(scene(SCENE, "--compression", "none"), {}, every_topic=True),
    # changes of the log that mean nothing
    "recompressed in small chunks": Case(log(), {}, every_topic=True),
    "one chunk, zstd": Case(log(chunk_size=10**9, compression=CompressionType.ZSTD), {}, every_topic=True),
    "channels in another order": Case(log(first_channel=40), {}, every_topic=True),
    "messages in order of time": Case(log(in_file_order=False), {}, every_topic=True),
    "last bits of another machine": Case(log(change=with_last_bits), {}, every_topic=True),
    "another version of closecall": Case(
        log(metadata=lambda name, values: {**values, "version": "9.9"}), {}, every_topic=True
    ),
    "attachments left out": Case(log(attachments=False), {}),
    "a wakeup dropped": Case(drop("/wakeups", "arm|rail", first=1), {}),
    # changes of the log that mean something
    "a wakeup dropped, every topic": Case(
        drop("/wakeups", "arm|rail", first=1), {"messages missing": 1}, every_topic=True
    ),
    "the end of a contact dropped": Case(
        drop("/collisions", "arm|wall", is_end), {"contact end moved": 1}, words="1.05 s -> the end"
    ),
    "a contact dropped": Case(drop("/collisions", "arm|wall"), {"contact vanished": 1}),
    "a breach's span dropped": Case(
        drop("/spans", "ball|post", lambda one: one.verdict == 2),
        {"verdict changed": 1, "breach vanished": 1, "unresolved time changed": 1},
        words="breach -> unresolved",
    ),
    "all distances of a pair dropped": Case(drop("/distances", "arm|rail"), {}),
    "a contact 3.2 ms later": Case(
        log(change=edited("/collisions", later)), {"contact begin moved": 1}, words="3.2 ms later"
    ),
    "a contact 3.2 ms later, tolerated": Case(
        log(change=edited("/collisions", later)), {}, Rules(Tolerances(time=0.0033))
    ),
    "a minimum 0.4 mm lower": Case(
        log(change=edited("/distances", nearer)),
        {"minimum fell": 1},
        words="minimum fell by 0.4 mm, within both brackets",
    ),
    "a minimum 0.4 mm lower, tolerated": Case(
        log(change=edited("/distances", nearer)), {}, Rules(Tolerances(distance_share=0.011))
    ),
    "a minimum 0.4 mm lower, ignored": Case(
        log(change=edited("/distances", nearer)), {}, Rules(ignored=Ignored(("rail|*",)))
    ),
    "a field of a topic": Case(
        log(change=edited("/spans", lower)), {"field changed": 1}, every_topic=True, words="/spans.clearance arm | rail"
    ),
    "a field of a topic, ignored": Case(
        log(change=edited("/spans", lower)), {}, Rules(ignored=Ignored(("/spans.clearance",))), every_topic=True
    ),
}


@pytest.fixture(scope="module")
def golden(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("golden")
    return run_scene(write_scene(folder), folder / "golden.mcap")


def compared(golden: Path, case: Case, folder: Path) -> Comparison:
    new = folder / "new.mcap"
    case.make(golden, new)
    return compare(golden, new, case.rules, case.every_topic)


@pytest.mark.parametrize("name", CASES)
def test_a_reviewer_hears_of_what_matters_and_of_nothing_else(name: str, golden: Path, tmp_path: Path) -> None:
    case = CASES[name]
    found = compared(golden, case, tmp_path)
    said = [sentence(one, found.length_unit) for one in found.differences]
    assert {cause.label: count for cause, count in found.by_cause().items()} == case.says, said
    assert found.losses == ()
    assert case.words in "\n".join(said)


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (put("end: 2", "end: 1.9"), "covers \\[0, 1.9\\] s, but the golden log covers \\[0, 2\\] s"),
        (
            scene(renamed()),
            "no pair in common",
        ),
        (log(metadata=lambda name, values: None), "has no metadata of a closecall run"),
        (lambda golden, new: new.write_text("no log"), "is not an MCAP file"),
        (lambda golden, new: None, "does not exist"),
    ],
)
def test_what_cannot_be_compared_is_refused(make: Make, problem: str, golden: Path, tmp_path: Path) -> None:
    with pytest.raises(LogError, match=problem):
        compared(golden, Case(make, {}), tmp_path)


def test_a_cut_log_is_compared_in_the_time_that_is_left(golden, tmp_path):
    rewrite(golden, tmp_path / "whole.mcap")
    whole = (tmp_path / "whole.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) * 2 // 3])
    found = compare(golden, tmp_path / "cut.mcap", Rules())
    assert found.differences == ()
    assert [loss.cut for loss in found.losses] == [True]
    rewrite(golden, tmp_path / "later.mcap", edited("/collisions", later))
    (tmp_path / "cut.mcap").write_bytes((tmp_path / "later.mcap").read_bytes()[: len(whole) * 2 // 3])
    found = compare(golden, tmp_path / "cut.mcap", Rules())
    assert [one.cause.label for one in found.differences] == ["contact begin moved"]


def test_what_viewers_get_is_the_same_of_another_epoch_and_version(tmp_path):
    def version(message: Any) -> None:
        message.message = message.message.replace("closecall 0.", "closecall 9.")

    scene_file = write_scene(tmp_path)
    options = ["--log", "full", "--rate", "10"]
    one = run_scene(scene_file, tmp_path / "one.mcap", *options)
    other = run_scene(scene_file, tmp_path / "other.mcap", *options, "--epoch", "1700000000000000001")
    rewrite(other, tmp_path / "newer.mcap", edited("/log", version))
    assert compare(one, tmp_path / "newer.mcap", Rules(), every_topic=True).differences == ()
    rewrite(one, tmp_path / "drawn.mcap", edited("/viz/clearance", lambda message: False, first=1))
    found = compare(one, tmp_path / "drawn.mcap", Rules(), every_topic=True)
    said = [sentence(one, found.length_unit) for one in found.differences]
    assert said == ["/viz/clearance: messages missing: 1 message, at 0 s"]


def test_a_reviewer_is_told_what_is_no_difference(golden, tmp_path):
    run_scene(write_scene(tmp_path, SCENE.replace("rail", "guide")), tmp_path / "new.mcap", "--time-resolution", "0.01")
    rules = Rules(ignored=Ignored(("arm|guide", "arm|wall")), within_brackets=True)
    notes = compare(golden, tmp_path / "new.mcap", rules).notes
    assert notes == (
        "setting time_resolution: 0.001 -> 0.01",
        "body rail is missing and guide is new: was it renamed?",
    )


def test_the_first_in_time_and_the_largest_of_each_cause_are_named(golden, tmp_path):
    found = compared(golden, Case(put("[200, 0, 0]", "[220, 20, 0]"), {}), tmp_path)
    assert found.first is not None
    assert found.first.time == min(one.time for one in found.differences if one.time is not None)
    assert len(found.largest(2)) == 2
    assert {one.cause for one in found.largest(len(found.by_cause()))} == set(found.by_cause())
