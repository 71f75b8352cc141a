"""`closecall check` and `closecall schema` as a shell sees them: what they print, where, and their exit codes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, radians
from pathlib import Path

import pytest
import yaml
from cli_process import closecall, command
from closed_meshes import cube, together, write_obj
from places import SAMPLES

from closecall.cli.main import main

CELL = """\
closecall: 1
units: {length: mm, angle: deg}
time: {start: 0, end: 2}
settings: {margin: 4}
meshes:
  plate: {file: plate.obj, units: mm}
bodies:
  bench: {shapes: [{box: [600, 400, 20]}]}
  column: {pose: {xyz: [200, 0, 60]}, shapes: [{cylinder: {radius: 20, length: 100}}]}
  carriage: {motion: {type: harmonic, direction: [1, 0, 0], amplitude: 40, period: 2, t0: 0.5}}
  tool:
    parent: carriage
    pose: {xyz: [0, 0, 90]}
    shapes: [{sphere: 30}, {capsule: {radius: 5, length: 60}}]
    motion: {type: keyframes, after: loop, keys: [{t: 0}, {t: 0.5, xyz: [0, 0, 10]}, {t: 1}]}
  flap: {exists: [0.5, 1], pose: {xyz: [-200, 0, 30]}, shapes: [{mesh: plate}]}
pairs:
  margins: [{between: [tool, column], margin: 12}]
"""
PLATE = "v 0 0 0\nv 300 0 0\nv 0 300 0\nf 1 2 3\n"
"""An open mesh."""


@dataclass(frozen=True)
class Done:
    code: int
    out: str
    err: str


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Stand in a folder with a scene, on a wide terminal."""
    (tmp_path / "cell.yaml").write_text(CELL)
    (tmp_path / "plate.obj").write_text(PLATE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    handler = signal.getsignal(signal.SIGTERM)
    yield tmp_path
    signal.signal(signal.SIGTERM, handler)


@pytest.fixture
def run(folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    """Run the command in this process, where no time goes into starting it."""

    def done(*arguments: str) -> Done:
        monkeypatch.setattr(sys, "argv", ["closecall", *arguments])
        with pytest.raises(SystemExit) as left:
            main()
        printed = capsys.readouterr()
        assert "Traceback" not in printed.err
        return Done(int(left.value.code or 0), printed.out, printed.err)

    return done


def test_the_table_tells_every_body_the_pairs_and_the_times(run) -> None:
    done = run("check", "cell.yaml")
    assert done.code == 0
    rows = {line.split()[0]: line.split()[1:] for line in done.out.splitlines() if line.strip()}
    assert rows["body"] == ["parent", "motion", "shapes", "(triangles)", "size"]
    assert rows["bench"] == ["fixed", "1", "(12)", "600", "x", "400", "x", "20", "mm"]
    assert rows["carriage"] == ["harmonic,", "126", "mm/s"]
    assert rows["tool"] == ["carriage", "keyframes,", "20", "mm/s", "2", "60", "x", "60", "x", "70", "mm"]
    assert rows["flap"] == ["fixed", "1", "(1)", "300", "x", "300", "x", "0", "mm"]
    assert "\n5 bodies, 3 of 6 pairs to check; " in done.out
    assert rows["margins"] == ["4,", "12", "mm"]
    assert rows["from"] == ["0", "to", "2", "s,", "time", "resolution", "0.001", "s"]


def test_each_cavity_is_named_with_the_part_that_it_is_cut_from(run, folder: Path) -> None:
    write_obj(folder / "hollow.obj", together(cube(200), cube(50, (60, 0, 0), inwards=True), cube(20, (-90, 0, 0))))
    hollow = "{mesh: hollow, scale: 0.5, pose: {xyz: [0, 0, 900]}}"
    meshes = "  hollow: {file: hollow.obj, units: mm}\nbodies:\n  block: {shapes: [" + hollow + "]}"
    (folder / "cell.yaml").write_text(CELL.replace("bodies:", meshes))
    lines = run("check", "cell.yaml").out.splitlines()
    assert "mesh hollow: 2 solids, 1 cavity" in lines
    assert "mesh hollow: cavity of 50 x 50 x 50 mm in a solid of 200 x 200 x 200 mm" in lines
    assert "mesh plate: a surface that encloses no solid" in lines
    told = json.loads(run("check", "cell.yaml", "--json").out)["meshes"]
    assert [(mesh["name"], mesh["solids"]) for mesh in told] == [("hollow", 2), ("plate", 0)]
    assert told[0]["cavities"] == [{"size": pytest.approx([0.05] * 3), "around": pytest.approx([0.2] * 3)}]


def test_a_pipe_gets_a_line_for_each_body(folder: Path) -> None:
    path = "a_long_name_for_a_body_that_would_not_fit_beside_the_others_in_eighty_columns"
    (folder / "cell.yaml").write_text(CELL.replace("tool", path))
    environment = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    done = subprocess.run(command("check", "cell.yaml"), env=environment, capture_output=True, text=True, check=True)
    (row,) = [line for line in done.stdout.splitlines() if line.startswith(path)]
    assert row.rstrip().endswith(" mm")
    assert len(done.stdout.splitlines()) == 10


def test_one_pair_of_one_kind_is_told_in_the_singular(run, folder: Path) -> None:
    one = "{shapes: [{sphere: 1}]}"
    other = "{shapes: [{sphere: 1}], pose: {xyz: [9, 0, 0]}, motion: {type: constant, velocity: [1, 0, 0]}}"
    (folder / "s.yaml").write_text(f"{CELL.split('settings')[0]}bodies:\n  a: {one}\n  b: {other}\n")
    assert "\n2 bodies, 1 of 1 pair to check\n" in run("check", "s.yaml").out
    assert "\n1 pair over [0, 2] s: 1 clear\n" in run("run", "s.yaml", "-o", "out.mcap").out


def test_warnings_go_to_stderr_and_quiet_prints_nothing(run) -> None:
    done = run("check", "cell.yaml")
    assert done.err.startswith("warning: cell.yaml:6:17: meshes.plate.file: plate.obj is open")
    assert "warning" not in done.out
    quiet = run("check", "cell.yaml", "-q")
    assert quiet == Done(0, "", "")


def test_json_tells_the_same_in_si_for_programs(run, folder: Path) -> None:
    done = run("check", "cell.yaml", "--json")
    told = json.loads(done.out, parse_constant=pytest.fail)
    assert list(told) == [
        "time",
        "settings",
        "bodies",
        "pairs",
        "pairs_possible",
        "ignored",
        "margins",
        "meshes",
        "files",
        "warnings",
    ]
    assert told["time"] == [0.0, 2.0]
    defaults = {"time_resolution": 0.001, "contact_tolerance": 1e-6, "distance_tolerance": 0.01}
    assert told["settings"] == {**defaults, "margin": 0.004}
    bodies = {body["name"]: body for body in told["bodies"]}
    assert list(bodies) == ["bench", "column", "carriage", "tool", "flap"]
    assert bodies["bench"]["size"] == pytest.approx([0.6, 0.4, 0.02])
    assert bodies["carriage"].pop("top_speed") == pytest.approx(0.04 * pi)
    assert bodies["tool"]["parent"] == "carriage"
    assert bodies["carriage"] == {
        "name": "carriage", "parent": None, "motion": "harmonic", "recorded": None, "top_angular_speed": 0.0,
        "shapes": 0, "triangles": 0, "chord_error": 0.0,
        "size": None, "exists": None,
    }  # fmt: skip
    assert bodies["flap"]["exists"] == [0.5, 1.0]
    assert 0.0 < bodies["column"]["chord_error"] < 0.0001
    assert (told["pairs"], told["pairs_possible"], told["margins"]) == (3, 6, [0.004, 0.012])
    assert told["files"] == [{"name": "plate", "path": str((folder / "plate.obj").resolve())}]
    assert len(told["warnings"]) == 1


@pytest.mark.parametrize(
    ("motion", "name"),
    [
        ("{type: constant, velocity: [1, 0, 0]}", "constant"),
        ("{type: constant, velocity: [1, 0, 0], t0: 1}", "constant"),
        ("{type: ballistic, acceleration: [1, 0, 0]}", "ballistic"),
        ("{type: screw, axis: [1, 0, 0], rate: 1}", "screw"),
        ("{type: orbit, axis: [1, 0, 0], start: [0, 1, 0], radius: 1, rate: 1}", "orbit"),
        ("{type: swing, axis: [1, 0, 0], amplitude: 1, period: 1, t0: 1}", "swing"),
        ("{type: polynomial, coefficients: [[0, 0, 0]]}", "polynomial"),
        (
            "{type: profile, kind: slide, axis: [1, 0, 0], from: 0, to: 1, max_velocity: 1, max_acceleration: 1}",
            "profile",
        ),
        ("{type: keyframes, before: hold, after: loop, keys: [{t: 0}, {t: 1}]}", "keyframes"),
        ("{type: keyframes, before: hold, after: hold, keys: [{t: 0}, {t: 1}]}", "keyframes"),
        ("{type: file, file: path.csv, layout: csv, after: loop}", "file"),
    ],
)
def test_a_motion_is_called_what_the_scene_calls_it(run, folder: Path, motion: str, name: str) -> None:
    (folder / "path.csv").write_text("t,x,y,z\n0,0,0,0\n1,0,0,0\n")
    (folder / "s.yaml").write_text(CELL.split("settings")[0] + f"bodies: {{a: {{motion: {motion}}}}}\n")
    (body,) = json.loads(run("check", "s.yaml", "--json").out)["bodies"]
    assert body["motion"] == name


OVERLAPPING = """\
closecall: 1
units: {length: m, angle: deg}
time: {start: 0, end: 1}
bodies:
  base: {shapes: [{box: [1, 1, 1]}]}
  "arm: upper": {pose: {xyz: [0, 0, 0.75]}, shapes: [{box: [1, 1, 1]}], motion: {type: constant, velocity: [0, 0, 1]}}
  on: {parent: "arm: upper", shapes: [{sphere: 0.1}], motion: {type: swing, axis: [1, 0, 0], amplitude: 1, period: 1}}
  far: {pose: {xyz: [9, 0, 0]}, shapes: [{sphere: 0.1}], motion: {type: constant, velocity: [0, 0, 1]}}
  late: {exists: [0.5, 1], shapes: [{sphere: 0.1}], motion: {type: constant, velocity: [0, 0, 0.1]}}
"""


@pytest.mark.parametrize(
    ("motion", "speed", "turning"),
    [
        ("{type: swing, axis: [1, 0, 0], amplitude: 30, period: 0.5}", 0.0, 30 * 2 * pi / 0.5),
        ("{type: swing, axis: [1, 0, 0], point: [0, 50, 0], amplitude: 30, period: 0.5}", pi**2 / 30, 120 * pi),
        ("{type: ballistic, acceleration: [0, 0, -9810]}", 9.81 * 2, 0.0),
        ("{type: orbit, axis: [1, 0, 0], start: [0, 1, 0], radius: 500, rate: 180}", pi / 2, 0.0),
        ("{type: screw, axis: [1, 0, 0], rate: 360, pitch: 5}", 0.005, 360.0),
        (
            "{type: profile, kind: slide, axis: [1, 0, 0], from: 0, to: 9, max_velocity: 7, max_acceleration: 50}",
            0.007,
            0.0,
        ),
        ("{type: keyframes, keys: [{t: 0}, {t: 0.5, xyz: [3, 0, 4], rpy: [90, 0, 0]}, {t: 2}]}", 0.01, 180.0),
        ("{type: limits, max_speed: 1600}", 1.6, None),
        ("{type: keyframes, after: loop, keys: [{t: 0}, {t: 1e-5, xyz: [1, 0, 0]}]}", None, None),
    ],
)  # fmt: skip
def test_top_speeds_are_those_of_closed_forms(
    run, folder: Path, motion: str, speed: float | None, turning: float | None
) -> None:
    (folder / "s.yaml").write_text(CELL.split("settings")[0] + f"bodies: {{a: {{motion: {motion}}}}}\n")
    (body,) = json.loads(run("check", "s.yaml", "--json").out)["bodies"]
    told = body["top_angular_speed"]
    assert body["top_speed"] == (None if speed is None else pytest.approx(speed, rel=1e-9))
    assert told == (None if turning is None else pytest.approx(radians(turning), rel=1e-9))


def test_suggested_ignores_pasted_into_the_scene_make_the_touching_pairs_vanish(run, folder: Path) -> None:
    scene = folder / "s.yaml"
    scene.write_text(OVERLAPPING)
    suggested = run("check", "s.yaml", "--suggest-ignores")
    assert suggested.code == 0
    between = [entry["between"] for entry in yaml.safe_load(suggested.out)["pairs"]["ignore"]]
    assert between == [["base", "arm: upper"], ["base", "late"], ["arm: upper", "on"]]
    assert "touching at 0.5 s" in suggested.out
    before = json.loads(run("check", "s.yaml", "--json").out)["pairs"]
    scene.write_text(OVERLAPPING + suggested.out)
    assert json.loads(run("check", "s.yaml", "--json").out)["pairs"] == before - 3
    again = run("check", "s.yaml", "--suggest-ignores")
    assert again == Done(0, "", "no checked pair touches at the start\n")


def escaped(name: str) -> str:
    return '"' + "".join(f"\\U{ord(character):08X}" for character in name) + '"'


def test_names_that_yaml_would_take_for_something_else_survive_the_suggestion(run, folder: Path) -> None:
    plain = ["on", "1e3", "null", "- x", "a: b", "#c", "{d}", "&e", "%f", "0x1F", "a\\b"]
    names = [*plain, "ünï", "é" * 40, "\ufffe", "\u00a0x", "😀"]
    bodies = "".join(
        f"  {escaped(name)}: {{shapes: [{{sphere: 1}}], motion: {{type: constant, velocity: [{i}, 0, 0]}}}}\n"
        for i, name in enumerate(names)
    )
    scene = folder / "s.yaml"
    scene.write_text(OVERLAPPING.split("bodies:")[0] + f"bodies:\n{bodies}")
    suggested = run("check", "s.yaml", "--suggest-ignores")
    scene.write_text(scene.read_text() + suggested.out)
    done = run("check", "s.yaml", "--json")
    assert json.loads(done.out)["pairs"] == 0
    assert "nothing to check" in done.err


def test_a_narrow_terminal_folds_the_table_and_loses_nothing(
    run, monkeypatch: pytest.MonkeyPatch, folder: Path
) -> None:
    name = "a_rather_long_name_of_a_body_in_an_assembly_of_many_parts"
    (folder / "s.yaml").write_text(CELL.replace("tool", name))
    monkeypatch.setenv("COLUMNS", "60")
    done = run("check", "s.yaml")
    assert all(len(line) <= 60 for line in done.out.splitlines())
    column = "".join(line.split(" ")[0] for line in done.out.splitlines()[2:-4])
    assert name in column
    assert "5 bodies, 3 of 6 pairs to check" in done.out


@pytest.mark.parametrize("columns", [30, 45, 50, 74, 80])
def test_every_figure_of_the_table_is_there_at_any_width(run, monkeypatch: pytest.MonkeyPatch, columns: int) -> None:
    scene = str(SAMPLES / "asteroids" / "scene.yaml")
    monkeypatch.setenv("COLUMNS", "200")
    wide = run("check", scene).out
    monkeypatch.setenv("COLUMNS", str(columns))
    narrow = run("check", scene).out
    assert max(map(len, narrow.splitlines())) <= columns
    headless = wide.partition("\n")[2] if columns < 60 else wide  # a list has the columns' names on each line instead
    lost = Counter("".join(headless.split())) - Counter("".join(narrow.split()))
    assert not lost


def test_names_that_look_like_markup_are_printed_as_they_are(run, folder: Path) -> None:
    (folder / "s.yaml").write_text(CELL.replace("bench:", "'(red)bench :smile:':"))
    assert "(red)bench :smile:" in run("check", "s.yaml").out


def test_a_scene_of_many_bodies_is_told_in_part(run, folder: Path) -> None:
    bodies = "".join(f"  b{i}: {{shapes: [{{sphere: 1}}]}}\n" for i in range(60))
    (folder / "s.yaml").write_text(CELL.split("settings")[0] + f"bodies:\n{bodies}")
    done = run("check", "s.yaml")
    assert "... and 20 more bodies" in done.out
    assert "60 bodies, 0 of 1770 pairs to check" in done.out


def test_faults_are_told_in_lines_and_exit_2(run, folder: Path) -> None:
    (folder / "s.yaml").write_text(CELL.replace("sphere: 30", "sphere: -30").replace("amplitude", "amplitud"))
    done = run("check", "s.yaml")
    assert (done.code, done.out) == (2, "")
    assert [line.split(": ")[:2] for line in done.err.splitlines()] == [
        ["s.yaml:10:14", "bodies.carriage.motion"],
        ["s.yaml:10:61", "bodies.carriage.motion"],
        ["s.yaml:14:23", "bodies.tool.shapes[0].sphere"],
    ]
    assert run("check", "none.yaml").err == (
        "none.yaml:1:1: scene: the file cannot be read: No such file or directory\n"
    )


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize(
    ("options", "phrase"),
    [
        (["--strict"], "cell.yaml:6:17: meshes.plate.file: plate.obj is open"),
        (["--max-pairs", "2"], "cell.yaml:1:1: scene: more than 2 pairs, ignore some or raise --max-pairs"),
        (["--max-bytes", "100"], "cell.yaml:1:1: scene: the file is larger than 100 bytes"),
    ],
)
def test_a_limit_that_is_passed_exits_2_and_writes_nothing(
    run, folder: Path, command: str, options: list[str], phrase: str
) -> None:
    before = sorted(folder.iterdir())
    output = ["-o", "out.mcap"] if command == "run" else []
    done = run(command, "cell.yaml", *output, *options)
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith(phrase)
    assert done.err.count("\n") == 1
    assert sorted(folder.iterdir()) == before


def test_limits_that_are_just_met_are_no_fault(run, folder: Path) -> None:
    assert run("check", "cell.yaml", "--max-pairs", "3", "--max-bytes", str(len(CELL)), "-q").code == 0
    (folder / "plate.obj").write_text(PLATE + "v 0 0 300\nf 1 4 2\nf 1 3 4\nf 2 4 3\n")
    assert run("check", "cell.yaml", "--strict", "-q").err == ""


def test_nothing_to_check_is_a_warning_and_under_strict_a_fault(run, folder: Path) -> None:
    (folder / "s.yaml").write_text(CELL.split("settings")[0] + "bodies: {a: {shapes: [{sphere: 1}]}, b: {}}\n")
    done = run("check", "s.yaml")
    assert done.code == 0
    nothing = "nothing to check: no two checked bodies move relative to each other"
    assert done.err == f"warning: s.yaml:1:1: scene: {nothing}\n"
    strict = run("check", "s.yaml", "--strict")
    assert (strict.code, strict.err) == (2, f"s.yaml:1:1: scene: {nothing} (a warning, refused under --strict)\n")


def test_several_scenes_are_checked_in_turn_and_a_fault_does_not_stop_the_rest(run, folder: Path) -> None:
    (folder / "bad.yaml").write_text("closecall: 1\n")
    done = run("check", "cell.yaml", "bad.yaml", "cell.yaml")
    assert done.code == 2
    assert [line.split(":")[0] for line in done.err.splitlines()] == ["warning", *["bad.yaml"] * 3, "warning"]
    assert done.out.count("cell.yaml\n") == 2
    assert done.out.count(" pairs to check") == 2
    assert run("check", "cell.yaml", "cell.yaml", "-q").code == 0

    many = json.loads(run("check", "cell.yaml", "bad.yaml", "--json").out)["scenes"]
    assert [(one["scene"], one["exit"]) for one in many] == [("cell.yaml", 0), ("bad.yaml", 2)]
    assert many[0]["understood"] == json.loads(run("check", "cell.yaml", "--json").out)
    assert many[1]["understood"] is None


def test_files_may_come_from_a_named_root(run, folder: Path) -> None:
    inside = folder / "inside"
    inside.mkdir()
    (inside / "s.yaml").write_text(CELL.replace("file: plate.obj", "file: ../plate.obj"))
    assert "name its root" in run("check", "inside/s.yaml").err
    assert run("check", "inside/s.yaml", "--mesh-root", ".", "-q").code == 0


@pytest.mark.parametrize("options", [["--max-pairs", "0"], ["--max-bytes", "few"], ["--no-such"], []])
def test_a_wrong_command_line_exits_2_without_a_traceback(run, options: list[str]) -> None:
    done = run("check", *(["cell.yaml"] if options else []), *options)
    assert done.code == 2
    assert "check [OPTIONS] SCENE" in done.err
    assert "Error: " in done.err


def test_check_of_a_process_of_its_own(folder: Path) -> None:
    done = closecall("check", "cell.yaml", "--json", cwd=folder)
    assert done.returncode == 0
    assert json.loads(done.stdout)["pairs"] == 3
    assert done.stderr.count("\n") == 1
