"""What a person sees on a terminal, and many scenes in one go."""

import json
import re
from pathlib import Path

import pytest
from cli_process import SPHERES, closecall, long_scene, on_a_terminal


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SPHERES)
    return path


def test_a_terminal_shows_progress_and_a_pipe_does_not(scene, tmp_path):
    scene.write_text(long_scene().replace("1e-5", "4e-3"))
    shown = on_a_terminal("run", scene, "-o", "out.mcap", cwd=tmp_path)
    assert "of 5 s" in shown
    assert "wakeups" in shown
    piped = closecall("run", scene, "-o", "out.mcap", cwd=tmp_path)
    assert piped.stderr == ""
    assert "wakeups" not in piped.stdout


def test_quiet_shows_nothing_at_all(scene, tmp_path):
    assert on_a_terminal("run", scene, "-o", "out.mcap", "-q", cwd=tmp_path) == ""


def test_no_color_is_respected(scene, tmp_path):
    assert "\x1b[1;31m" in on_a_terminal("run", scene, "-o", "out.mcap", cwd=tmp_path)
    plain = on_a_terminal("summary", "out.mcap", cwd=tmp_path, NO_COLOR="1")
    assert "31m" not in plain


@pytest.mark.parametrize("columns", [40, 60, 80, 200])
def test_the_table_fits_the_terminal_and_loses_nothing(scene, tmp_path, columns):
    scene.write_text(SPHERES.replace("left", "a_body_with_a_rather_long_name_of_its_own"))
    closecall("run", scene, "-o", "out.mcap", cwd=tmp_path)
    shown = on_a_terminal("summary", "out.mcap", cwd=tmp_path, columns=columns, NO_COLOR="1")
    shown = re.sub(r"\x1b\[[0-9;]*m", "", shown)
    assert max(len(line) for line in shown.splitlines()) <= columns
    letters = "".join(shown.split())
    assert "contact" in letters
    assert "a_body_with" in letters


def test_many_scenes_make_one_table_and_a_failure_does_not_stop_the_rest(tmp_path):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "scene.yaml").write_text(SPHERES)
    (tmp_path / "bad.yaml").write_text("closecall: 1\n")
    arguments = ["run", "one/scene.yaml", "bad.yaml", "two/scene.yaml", "--out-dir", "logs"]
    done = closecall(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert sorted(path.name for path in (tmp_path / "logs").iterdir()) == ["one.mcap", "two.mcap"]
    assert "bad.yaml:1:1:" in done.stderr
    assert done.stdout.count("1 contact") == 2
    assert "failed" in done.stdout
    assert closecall("run", "one/scene.yaml", "--out-dir", "logs", cwd=tmp_path).returncode == 0
    assert closecall("run", "one/scene.yaml", "--out-dir", "logs", "--fail-on", "contact", cwd=tmp_path).returncode == 1


def test_many_scenes_as_json_are_a_list_with_each_summary(tmp_path):
    (tmp_path / "a.yaml").write_text(SPHERES)
    done = closecall("run", "a.yaml", "nowhere.yaml", "--out-dir", ".", "--json", cwd=tmp_path)
    told = json.loads(done.stdout)["scenes"]
    assert [(scene["scene"], scene["exit"]) for scene in told] == [("a.yaml", 0), ("nowhere.yaml", 2)]
    assert told[0]["summary"]["pairs"][0]["verdict"] == "contact"
    assert told[1]["summary"] is None


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["scene.yaml"], "-o LOG"),
        (["scene.yaml", "-o", "x.mcap", "--out-dir", "."], "-o LOG"),
        (["scene.yaml", "scene.yaml", "-o", "x.mcap"], "--out-dir"),
        (["scene.yaml", "./scene.yaml", "--out-dir", "."], "would write"),
        (["scene.yaml", "-o", "x.mcap", "--rate", "-1"], "--rate"),
        (["scene.yaml", "-o", "x.mcap", "--rate", "nan"], "--rate"),
    ],
)
def test_a_senseless_command_is_told_in_a_line(scene, tmp_path, arguments, said):
    done = closecall("run", *arguments, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.glob("*.mcap*"))
