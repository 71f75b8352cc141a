"""Filters by name: written as tables print them they match; one that matches nothing is refused, with near names."""

from __future__ import annotations

from pathlib import Path

import pytest
from cli_process import closecall_inside
from diff_logs import SCENE, run_scene, write_scene
from mcap.reader import make_reader

from closecall.formats.log.filters import TOPICS
from closecall.formats.log.message_filter import is_pair_among


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("filters")
    return run_scene(write_scene(folder), folder / "out.mcap", "--log", "full", "--rate", "2")


@pytest.mark.parametrize(
    "pattern", ["wall|arm", "wall | arm", "arm |wall", " wa* | arm ".strip(), "w\N{COMBINING ACUTE ACCENT}all"]
)
def test_a_pair_is_matched_as_tables_print_it_and_as_any_keyboard_types_it(pattern: str) -> None:
    pair = "arm|ẃall" if "\N{COMBINING ACUTE ACCENT}" in pattern else "arm|wall"
    assert is_pair_among(pair, (pattern,))
    assert not is_pair_among("arm|rail", (pattern,))


def test_a_name_with_blanks_at_its_end_is_still_matched() -> None:
    assert is_pair_among("arm |wall", ("arm |wall",))
    assert not is_pair_among("arm |wall", ("arm|wall",))


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["summary", "--pair", "arm|wal"], "--pair 'arm|wal' matches no pairs; similar names: 'arm|wall', 'arm|"),
        (["summary", "--pair", "wal | arm"], "--pair 'wal | arm' matches no pairs; similar names: 'arm|wall'"),
        (
            ["summary", "--json", "--pair", "arm", "--pair", "coverr"],
            "--pair 'coverr' matches no pairs; similar names: 'cover'",
        ),
        (["summary", "--pair", "q?"], "--pair 'q?' matches no pairs; choose from: 'arm', 'wall', 'rail' and 3 more"),
        (["export", "--topic", "/spans", "--pair", "balll"], "--pair 'balll' matches no pairs; similar names: 'ball'"),
        (["export", "-o", "tables", "--pair", "balll"], "--pair 'balll' matches no pairs; similar names: 'ball'"),
        (["extract", "-o", "part.mcap", "--pair", "balll"], "--pair 'balll' matches no pairs; similar names: 'ball'"),
        (["extract", "-o", "part.mcap", "--topic", "/span"], "--topic '/span' matches no topics; choose from /spans"),
        (["diff", "OUT", "--ignore", "cable*"], "--ignore 'cable*' matches no pairs; similar names: 'wall'"),
        (
            ["diff", "OUT", "--ignore", "/wakeup.sleep"],
            "--ignore '/wakeup.sleep' matches no topics; choose from /wakeups",
        ),
    ],
)
def test_a_filter_that_matches_nothing_exits_2_with_near_names(
    log: Path, tmp_path: Path, arguments: list[str], problem: str
) -> None:
    command, *options = (str(log) if word == "OUT" else word for word in arguments)
    done = closecall_inside(command, log, *options, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"{log}: {problem}")
    assert done.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_filters_by_what_was_found_or_by_time_may_match_nothing(log: Path, tmp_path: Path) -> None:
    assert closecall_inside("summary", log, "--verdict", "possible", cwd=tmp_path).returncode == 0
    assert closecall_inside("export", log, "--topic", "/spans", "--from", "100", cwd=tmp_path).returncode == 0
    same = closecall_inside("diff", log, log, "--ignore", "arm | wall", "--ignore", "/wakeups.sleep", cwd=tmp_path)
    assert (same.returncode, same.stdout) == (0, "no differences: 8 pairs\n")


def test_a_log_that_is_cut_short_may_have_lost_the_pair(log: Path, tmp_path: Path) -> None:
    (tmp_path / "cut.mcap").write_bytes(log.read_bytes()[:-3000])
    assert closecall_inside("summary", "cut.mcap", "--pair", "nosuch", cwd=tmp_path).returncode == 3


def test_a_pair_that_swept_boxes_cleared_is_no_mistake(tmp_path: Path) -> None:
    run_scene(write_scene(tmp_path, SCENE), tmp_path / "out.mcap", "--broad-phase", "on")
    done = closecall_inside("summary", "out.mcap", "--pair", "ball|arm", cwd=tmp_path)
    assert (done.returncode, "no listed pair matches" in done.stdout) == (0, True), done
    assert closecall_inside("summary", "out.mcap", "--pair", "ball|arn", cwd=tmp_path).returncode == 2


def test_every_topic_of_a_full_log_is_one_that_filters_know(log: Path) -> None:
    with log.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    topics = {channel.topic for channel in summary.channels.values()}
    assert topics <= set(TOPICS)
    assert {"/viz/clearance", "/scene/meshes", "/tf", "/log"} <= topics
