"""The commands as a shell sees them: what they print, where, and with which exit code."""

import json
from pathlib import Path
from typing import Any

import pytest
from cli_process import SPHERES, closecall, closecall_inside
from diff_logs import run_scene, write_scene
from places import ROOT


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SPHERES)
    return path


def test_run_prints_a_table_and_exits_0_whatever_it_finds(scene, tmp_path):
    done = closecall("run", scene, "-o", "out.mcap", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "left | right" in done.stdout
    assert "1 pair over [0, 5] s: 1 contact" in done.stdout
    assert (tmp_path / "out.mcap").exists()
    assert not (tmp_path / "out.mcap.partial").exists()


def test_fail_on_contact_exits_1_and_still_writes_the_log(scene, tmp_path):
    done = closecall("run", scene, "-o", "out.mcap", "--fail-on", "unresolved,contact", cwd=tmp_path)
    assert done.returncode == 1
    assert (tmp_path / "out.mcap").exists()
    assert closecall("run", scene, "-o", "out.mcap", "--fail-on", "unresolved", cwd=tmp_path).returncode == 0
    wrong = closecall("run", scene, "-o", "out.mcap", "--fail-on", "everything", cwd=tmp_path)
    assert wrong.returncode == 2
    assert "'everything' is not one of contact" in wrong.stderr


def test_json_is_the_logs_summary_with_the_seconds(scene, tmp_path):
    printed = json.loads(closecall("run", scene, "-o", "out.mcap", "--json", cwd=tmp_path).stdout)
    assert set(printed.pop("seconds")) == {"load", "schedule", "fcl", "log", "total"}
    assert json.loads(closecall("summary", "out.mcap", "--json", cwd=tmp_path).stdout) == printed
    (pair,) = printed["pairs"]
    assert pair["verdict"] == "contact"
    defaults = {"time_resolution": 0.001, "contact_tolerance": 1e-6, "margin": 0.0, "distance_tolerance": 0.01}
    assert printed["settings"] == defaults


def test_summary_prints_the_same_table_as_the_run(scene, tmp_path):
    ran = closecall("run", scene, "-o", "out.mcap", cwd=tmp_path)
    assert closecall("summary", "out.mcap", cwd=tmp_path).stdout == ran.stdout


def test_summary_filters_sorts_and_limits(tmp_path):
    run_scene(write_scene(tmp_path), tmp_path / "out.mcap")

    def rows(*options: str) -> list[str]:
        printed = closecall_inside("summary", "out.mcap", *options, cwd=tmp_path).stdout.splitlines()
        return [line.split("  ")[0] for line in printed if " | " in line]

    def pairs(*options: str) -> list[dict[str, Any]]:
        printed: dict[str, Any] = json.loads(
            closecall_inside("summary", "out.mcap", "--json", *options, cwd=tmp_path).stdout
        )
        assert printed["pairs_total"] == sum(printed["totals"]["pairs"].values()) == 9
        listed: list[dict[str, Any]] = printed["pairs"]
        return listed

    everything = pairs()
    assert len(everything) == 9
    assert rows("--pair", "wall|*") == ["arm | wall", "wall | ball"]
    assert rows("--pair", "wall", "--verdict", "contact,breach") == ["arm | wall"]
    assert [pair["pair"] for pair in pairs("--verdict", "breach")] == ["ball|post"]
    uppers = [pair["distance"]["upper"] or pair["distance"]["lower"] for pair in pairs("--sort", "distance")]
    assert uppers == sorted(uppers)
    assert [pair["pair"] for pair in pairs("--sort", "name")] == sorted(pair["pair"] for pair in everything)
    wakeups = [pair["wakeups"] for pair in pairs("--sort", "wakeups", "--limit", "4")]
    assert wakeups == sorted((pair["wakeups"] for pair in everything), reverse=True)[:4]
    assert rows("--sort", "time", "--verdict", "breach,contact") == ["arm | wall", "ball | post"]
    assert rows("--sort", "distance", "--verdict", "breach,contact") == ["arm | wall", "ball | post"]
    assert rows("--sort", "time", "--verdict", "breach,contact", "--limit", "1") == ["arm | wall"]
    limited = closecall_inside("summary", "out.mcap", "--limit", "2", cwd=tmp_path).stdout
    assert "... and 7 more pairs" in limited
    assert rows("--pair", "wall | arm") == ["arm | wall"], "as the table prints it"
    none = closecall_inside("summary", "out.mcap", "--verdict", "possible", cwd=tmp_path)
    assert (none.returncode, "no listed pair matches" in none.stdout) == (0, True)
    assert (
        "'bad' is not one of contact"
        in closecall_inside("summary", "out.mcap", "--verdict", "bad", cwd=tmp_path).stderr
    )


def test_options_override_the_scenes_settings(scene, tmp_path):
    options = ["--time-resolution", "0.01", "--contact-tolerance", "1e-4", "--distance-tolerance", "none"]
    printed = json.loads(closecall("run", scene, "-o", "out.mcap", "--json", *options, cwd=tmp_path).stdout)
    given = {"time_resolution": 0.01, "contact_tolerance": 1e-4, "margin": 0.0, "distance_tolerance": None}
    assert printed["settings"] == given
    low, high = printed["pairs"][0]["contacts"][0]["begin"]
    assert 1e-6 < high - low <= 1e-4


@pytest.mark.parametrize("value", ["0", "-1", "nan", "inf", "1e-300"])
def test_a_senseless_resolution_is_refused_by_name(scene, tmp_path, value):
    done = closecall("run", scene, "-o", "out.mcap", "--time-resolution", value, cwd=tmp_path)
    assert done.returncode == 2
    assert "--time-resolution" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.glob("*.mcap*"))


@pytest.mark.parametrize("value", ["0", "-1", "nan", "1", "1%", "tight"])
def test_a_senseless_distance_tolerance_is_refused_by_name(scene, tmp_path, value):
    done = closecall("run", scene, "-o", "out.mcap", "--distance-tolerance", value, cwd=tmp_path)
    assert done.returncode == 2
    assert "--distance-tolerance" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.glob("*.mcap*"))


def test_a_fault_in_the_scene_is_one_line_with_its_place_and_nothing_is_written(scene, tmp_path):
    scene.write_text(SPHERES.replace("sphere: 0.25", "sphere: -0.25"))
    done = closecall("run", "scene.yaml", "-o", "out.mcap", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("scene.yaml:6:55: bodies.right.shapes[0].sphere: ")
    assert done.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["scene.yaml"]


@pytest.mark.parametrize("output", ["missing/out.mcap", ".", "scene.yaml"])
def test_an_output_that_cannot_be_is_refused_in_one_line(scene, tmp_path, output):
    done = closecall("run", "scene.yaml", "-o", output, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert scene.read_text() == SPHERES


def test_a_scene_with_nothing_to_check_says_so(scene, tmp_path):
    scene.write_text(SPHERES.replace("bodies:", "pairs: {ignore: [{between: ['*', '*'], reason: trial}]}\nbodies:"))
    done = closecall("run", scene, "-o", "out.mcap", cwd=tmp_path)
    assert done.returncode == 0
    assert "warning:" in done.stderr
    assert "nothing to check" in done.stderr


def test_the_same_scene_gives_the_same_bytes_whatever_the_hash_seed(scene, tmp_path):
    logs = []
    for seed in ("0", "12345"):
        closecall("run", scene, "-o", f"{seed}.mcap", cwd=tmp_path, PYTHONHASHSEED=seed)
        logs.append((tmp_path / f"{seed}.mcap").read_bytes())
    assert logs[0] == logs[1]


def test_readme_prints_what_the_first_command_prints(tmp_path):
    root = ROOT
    readme = (root / "README.md").read_text(encoding="utf-8")
    shown = readme.split("It ends in a short table, worst pairs first:\n\n```\n")[1].split("```")[0]
    done = closecall("run", root / "sample_scenes" / "spinning_bar" / "scene.yaml", "-o", "bar.mcap", cwd=tmp_path)
    assert [line.rstrip() for line in done.stdout.splitlines()] == shown.splitlines()


def test_what_the_scene_ignores_is_counted_and_named(scene, tmp_path):
    scene.write_text(SPHERES + "pairs:\n  ignore: [{between: [left, right], reason: for once}]\n")
    done = closecall("run", scene, "-o", "out.mcap", cwd=tmp_path)
    assert "0 pairs over [0, 5] s: nothing to check; 1 ignored by the scene" in done.stdout
    assert json.loads(closecall("summary", "out.mcap", "--json", cwd=tmp_path).stdout)["pairs_ignored"] == 1
    assert "; 1 ignored: left|right" in closecall("check", scene, cwd=tmp_path).stdout


@pytest.mark.parametrize("gap", [1.23456, 0.999999, 7.7778e-5, 123456.7])
def test_no_bound_is_printed_above_itself(tmp_path, gap):
    ball = "shapes: [{sphere: 1}]"
    bodies = f"  a: {{{ball}}}\n  b: {{pose: {{xyz: [{2.0 + gap}, 0, 0]}}, {ball}, motion: {{type: constant}}}}\n"
    (tmp_path / "still.yaml").write_text(SPHERES.split("bodies:")[0] + "bodies:\n" + bodies)
    printed = closecall("run", "still.yaml", "-o", "out.mcap", cwd=tmp_path).stdout
    (row,) = (line for line in printed.splitlines() if line.startswith("a | b"))
    (pair,) = json.loads(closecall("summary", "out.mcap", "--json", cwd=tmp_path).stdout)["pairs"]
    lower = float(row.split("clear")[1].split(" ..")[0])
    assert 0.998 * pair["distance"]["lower"] < lower <= pair["distance"]["lower"]
