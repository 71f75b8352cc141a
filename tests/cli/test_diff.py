"""`closecall diff` as a shell and a CI server see it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from cli_process import closecall_inside, command, on_a_terminal
from diff_logs import SCENE, run_scene, write_scene


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("diff")
    run_scene(write_scene(folder), folder / "golden.mcap")
    run_scene(write_scene(folder), folder / "same.mcap", "--epoch", "5", "--compression", "lz4")
    changed = SCENE.replace("t: 1,", "t: 1.0032,").replace("[100, 70, 0]", "[100, 25, 0]")
    run_scene(write_scene(folder, changed), folder / "new.mcap")
    (folder / "cut.mcap").write_bytes((folder / "same.mcap").read_bytes()[:-2000])
    return folder


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["golden.mcap", "same.mcap"], 0),
        (["golden.mcap", "new.mcap"], 1),
        (["golden.mcap", "new.mcap", "--ignore", "arm"], 0),
        (["golden.mcap", "new.mcap", "--ignore", "rail|*", "--time-tol", "0.01"], 0),
        (["golden.mcap", "none.mcap"], 2),
        (["golden.mcap", "scene.yaml"], 2),
        (["golden.mcap", "."], 2),
        (["golden.mcap"], 2),
        (["golden.mcap", "new.mcap", "--time-tol", "-1"], 2),
        (["golden.mcap", "new.mcap", "--junit", "nowhere/report.xml"], 2),
        (["golden.mcap", "cut.mcap"], 3),
    ],
)
def test_the_exit_code_says_how_it_went(folder, arguments, code):
    done = closecall_inside("diff", *arguments, cwd=folder)
    assert done.returncode == code, done
    assert "Traceback" not in done.stderr
    assert bool(done.stderr) == (code in (2, 3))
    if code == 3:
        assert done.stderr.startswith("cut.mcap: unfinished at byte ")
        assert done.stderr.count("\n") == 1
    assert not list(folder.glob("*.partial"))


def test_quiet_prints_nothing(folder):
    done = closecall_inside("diff", "golden.mcap", "new.mcap", "-q", cwd=folder)
    assert (done.returncode, done.stdout, done.stderr) == (1, "", "")


@pytest.mark.parametrize("columns", [40, 60, 80, 200])
def test_a_terminal_of_any_width_shows_all_of_it(folder, columns):
    shown = on_a_terminal("diff", "golden.mcap", "new.mcap", cwd=folder, columns=columns, NO_COLOR="1")
    shown = re.sub(r"\x1b\[[0-9;]*m", "", shown)
    assert max(len(line) for line in shown.splitlines()) <= columns
    letters = "".join(shown.split())
    for phrase in (
        "arm|rail",
        "clear->contact",
        "contactbeginmoved",
        "3.04mslater",
        "armbetweenhomeandreach",
        "first:",
    ):
        assert phrase in letters


def test_json_has_every_difference_and_the_first(folder):
    told = json.loads(closecall_inside("diff", "golden.mcap", "new.mcap", "--json", cwd=folder).stdout)
    assert told["same"] is False
    assert sum(told["by_cause"].values()) == len(told["differences"]) == 5
    assert (told["first"]["cause"], told["first"]["subject"]) == ("verdict changed", "arm|rail")
    (begin,) = (one for one in told["differences"] if one["cause"] == "contact begin moved")
    assert begin["change"] == pytest.approx(0.00304, abs=2e-6)
    assert begin["new"] - begin["golden"] == begin["change"]
    assert begin["keys"] == {"arm": ["home", "reach"]}
    same = json.loads(closecall_inside("diff", "golden.mcap", "same.mcap", "--json", cwd=folder).stdout)
    assert (same["same"], same["first"], same["differences"]) == (True, None, [])


def test_limit_says_how_many_are_not_shown(folder):
    shown = closecall_inside("diff", "golden.mcap", "new.mcap", "--limit", "2", cwd=folder).stdout
    assert "contact appeared: 2, the largest\n" in shown
    assert "5 differences in 2 of 9 pairs" in shown


def test_junit_has_a_case_for_every_pair(folder, tmp_path):
    report = tmp_path / "report.xml"
    report.write_text("<?xml an older report")
    assert closecall_inside("diff", "golden.mcap", "new.mcap", "--junit", report, "-q", cwd=folder).returncode == 1
    suite = ElementTree.parse(report).getroot().find("testsuite")
    assert suite is not None
    cases = {case.get("name"): case for case in suite.findall("testcase")}
    assert len(cases) == int(suite.get("tests", "")) == 9
    assert {name for name, case in cases.items() if case.find("failure") is not None} == {"arm|wall", "arm|rail"}
    failure = cases["arm|wall"].find("failure")
    assert failure is not None
    assert "contact begin moved 3.04 ms later" in failure.get("message", "")
    assert closecall_inside("diff", "golden.mcap", "cut.mcap", "--junit", report, "-q", cwd=folder).returncode == 3
    suite = ElementTree.parse(report).getroot().find("testsuite")
    assert suite is not None
    assert (suite.get("failures"), suite.get("errors")) == ("0", "1")


@pytest.mark.parametrize("name", ["golden.mcap", "new.mcap", "link.xml"])
def test_a_junit_report_never_replaces_a_log(folder, name):
    (folder / "link.xml").unlink(missing_ok=True)
    (folder / "link.xml").symlink_to(folder / "new.mcap")
    before = {path: path.read_bytes() for path in folder.glob("*.mcap")}
    done = closecall_inside("diff", "golden.mcap", "new.mcap", "--junit", name, cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"{name}: would overwrite the input ")
    assert done.stderr.endswith("choose another output with --junit\n")
    assert {path: path.read_bytes() for path in folder.glob("*.mcap")} == before


def test_of_a_junit_report_that_cannot_be_written_nothing_is_left(folder, tmp_path, monkeypatch):
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    report = tmp_path / "report.xml"
    report.write_text("<?xml an older report")
    monkeypatch.setattr(os, "fsync", full)
    done = closecall_inside("diff", "golden.mcap", "new.mcap", "--junit", report, cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"{report}.partial: cannot write: No space left on device; ")
    assert [report.read_text(), *tmp_path.iterdir()] == ["<?xml an older report", report]


def test_a_reader_that_leaves_early_gets_no_traceback(folder):
    first = subprocess.run(
        [
            "bash",
            "-c",
            '"$@" | head -1',
            "bash",
            *command("diff", "golden.mcap", "new.mcap", "--all", "--limit", "900"),
        ],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert first.stdout == "verdict changed: 1\n"
    assert "Traceback" not in first.stderr
