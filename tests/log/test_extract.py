"""Parts of logs, and files that travel with them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from cli_process import closecall_inside
from diff_logs import SCENE, run_scene, write_scene
from mcap.reader import make_reader
from rewritten_logs import rewrite

from closecall.formats.log.diff.compare import compare
from closecall.formats.log.diff.findings import Rules
from closecall.formats.log.extract import write_part
from closecall.formats.log.message_filter import Choice
from closecall.formats.log.result import fold, read_summary
from oracle.logs import read_log


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("extract")
    return run_scene(write_scene(folder), folder / "out.mcap", "--log", "full", "--epoch", "1000")


def taken(log: Path, path: Path, **choice: Any) -> Path:
    write_part(log, path, Choice(**choice))
    return path


def test_all_of_a_log_is_the_log(log, tmp_path):
    part = taken(log, tmp_path / "part.mcap")
    assert compare(log, part, Rules(), every_topic=True).differences == ()
    whole, copy = read_log(log), read_log(part)
    assert {name: len(messages) for name, messages in copy.topics.items()} == {
        name: len(messages) for name, messages in whole.topics.items()
    }
    assert copy.metadata["closecall"].items() >= whole.metadata["closecall/start"].items()
    for name, data in whole.attachments.items():
        if name != "summary.json":
            assert copy.attachments[name] == data


def test_a_part_says_of_its_time_and_pairs_what_the_log_said(log, tmp_path):
    part = taken(log, tmp_path / "part.mcap", start=1.0, end=1.5, pairs=("arm",))
    summary = read_summary(part)
    assert summary["time"] == [1.0, 1.5]
    assert summary["pairs_total"] == len(summary["pairs"]) == 5
    whole = {pair["pair"]: pair for pair in read_summary(log)["pairs"]}
    for pair in summary["pairs"]:
        said = whole[pair["pair"]]
        assert pair["verdict"] == said["verdict"]
        assert pair["contacts"] == said["contacts"], "a contact that reaches into the time is kept whole"
        assert pair["distance"]["lower"] >= said["distance"]["lower"]
    folded = fold(part)
    assert (folded.loss, folded.lost) == (None, {})
    content = read_log(part)
    assert all("arm" in message["pair"] for message in content.of("wakeups"))
    assert all(1.0 <= (message["log_time"] - 1000) / 1e9 <= 1.5 for message in content.of("distances"))
    assert content.of("distances")


def test_what_bodies_look_like_is_kept_for_viewers(log, tmp_path):
    part = taken(log, tmp_path / "part.mcap", start=1.5)
    with part.open("rb") as file:
        times = [(channel.topic, message.log_time - 1000) for _, channel, message in make_reader(file).iter_messages()]
    assert times[0] == ("/scene/meshes", 0)
    assert all(time >= 1_500_000_000 for topic, time in times if topic in ("/tf", "/world", "/viz/clearance"))
    assert {"/tf", "/world", "/viz/clearance"} <= {topic for topic, _ in times}


def test_topics_are_chosen_by_pattern(log, tmp_path):
    part = taken(log, tmp_path / "part.mcap", topics=("/spans", "/coll*"))
    content = read_log(part)
    assert set(content.topics) == {"spans", "collisions"}
    assert compare(log, part, Rules(within_brackets=True)).differences == ()


def test_a_part_outside_the_run_is_empty_and_a_log(log, tmp_path):
    part = taken(log, tmp_path / "part.mcap", start=7.0)
    assert read_summary(part)["pairs"] == []
    assert read_summary(part)["time"] == [2.0, 2.0]


@pytest.mark.parametrize(("times", "said"), [(["--from", "7"], "no listed pair matches in this time\n"), ([], "")])
def test_a_pair_that_has_no_spans_in_the_time_is_told(log, tmp_path, times, said):
    done = closecall_inside("extract", log, "--pair", "arm", *times, "-o", "part.mcap", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, said)
    assert bool(read_summary(tmp_path / "part.mcap")["pairs_total"]) is (said == "")


def test_files_that_travel_with_a_log_are_listed_and_taken(log, tmp_path):
    listed = closecall_inside("extract", log, cwd=tmp_path).stdout
    for name in ("scene", "settings.json", "mesh/", "layout.json", "summary.json"):
        assert name in listed
    assert closecall_inside("extract", log, "scene", cwd=tmp_path).stdout == SCENE
    assert closecall_inside("extract", log, "scene", "-o", "again.yaml", cwd=tmp_path).returncode == 0
    assert (tmp_path / "again.yaml").read_text() == SCENE


@pytest.mark.parametrize("choice", [[], ["--pair", "arm"]])
def test_a_part_of_a_cut_log_is_never_told_as_whole(log, tmp_path, choice):
    """Nor is a part of the part: what each says of the loss is what was said of the log."""
    rewrite(log, tmp_path / "chunks.mcap", attachments=False)
    data = (tmp_path / "chunks.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(data[: len(data) // 2])
    lost = closecall_inside("summary", "cut.mcap", cwd=tmp_path).stderr.strip().partition(": ")[2]
    assert re.fullmatch(r"unfinished at byte \d+: .*; read up to [0-9.]+ s", lost)
    for source, target in (("cut.mcap", "part.mcap"), ("part.mcap", "again.mcap")):
        extract = ["extract", source, "--from", "0", *choice, "-o", target]
        assert closecall_inside(*extract, cwd=tmp_path).returncode == 3
        lost = f"extracted from a log that was {lost}"
        for command in (["summary", target, "--json"], ["diff", target, target], ["export", target, "-o", "tables"]):
            done = closecall_inside(*command, cwd=tmp_path)
            assert done.returncode == 3
            assert set(done.stderr.splitlines()) == {f"{target}: {lost}"}
        with (tmp_path / target).open("rb") as file:
            assert "summary.json" not in {one.name for one in make_reader(file).iter_attachments()}
    summary = json.loads(closecall_inside("summary", "again.mcap", "--json", cwd=tmp_path).stdout)
    assert sum(summary["totals"]["pairs"].values()) == summary["pairs_total"]
    assert summary["totals"]["wakeups"] > 0
    assert summary["totals"]["pairs"]["clear"] == 0, "of no pair is all known"


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["out.mcap", "scnee"], 2, "has no complete attached file 'scnee'"),
        (["out.mcap", "--from", "1"], 2, "Give -o FILE"),
        (["out.mcap", "scene", "--from", "1"], 2, "Select either an attached file"),
        (["out.mcap", "--from", "1", "-o", "out.mcap"], 2, "would overwrite the input"),
        (["out.mcap", "--from", "1", "-o", "nowhere/part.mcap"], 2, "there is no folder"),
        (["none.mcap"], 2, "does not exist"),
        (["cut.mcap", "--from", "0", "-o", "part.mcap"], 3, "cut.mcap: unfinished at byte"),
    ],
)
def test_what_cannot_be_extracted_is_told(log, arguments, code, said):
    (log.parent / "cut.mcap").write_bytes(log.read_bytes()[:-3000])
    before = log.read_bytes()
    done = closecall_inside("extract", *arguments, cwd=log.parent)
    assert done.returncode == code
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert log.read_bytes() == before
    assert (log.parent / "part.mcap").exists() is (code == 3)
    (log.parent / "part.mcap").unlink(missing_ok=True)
