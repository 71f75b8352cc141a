"""The door for Python: the runs and options of the command line, without any of its libraries."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import fields
from fractions import Fraction
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from cli_process import SPHERES, closecall_inside

from closecall import api
from closecall.cli.application.options import CHOICES
from closecall.cli.application.run import log_options
from closecall.cli.application.watcher import Events, Watcher
from closecall.cli.options import options_of, run_options
from closecall.formats.log.viewer.viewer import ViewerOptions
from closecall.formats.log.writer import LogOptions
from closecall.scheduler.model.scene import Scene, Settings

TOUCH = 2.0 - 0.75 * 0.9165151389911680 / 2.0
"""s, when spheres of 0.5 m and 0.25 m, 4 m and 0.3 m apart, meet at 2 m/s: 0.9165... is the root of 1 - 0.4^2."""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "spheres.yaml"
    path.write_text(SPHERES)
    return path


def test_a_scene_runs_from_python_and_its_log_opens_without_the_libraries_of_the_command_line(scene: Path) -> None:
    code = (
        "import sys\n"
        "from closecall import api\n"
        "result = api.run('spheres.yaml', 'out.mcap', log='certificate')\n"
        "found = api.open_log('out.mcap')\n"
        "assert found.summary == result.summary and found.loss is None\n"
        "print(*{name.partition('.')[0] for name in sys.modules})\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=scene.parent, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert not {"click", "rich", "pytest"} & set(done.stdout.split())
    assert sorted(path.name for path in scene.parent.iterdir()) == ["out.mcap", "spheres.yaml"]


def test_a_result_tells_what_the_spheres_do_and_the_log_says_the_same(scene: Path, tmp_path: Path) -> None:
    result = api.run(str(scene), str(tmp_path / "out.mcap"))
    (pair,) = result.summary["pairs"]
    clear, touching = pair["contacts"][0]["begin"]
    assert clear <= TOUCH <= touching
    assert result.finds(["contact"])
    assert not result.finds(["breach", "unresolved"])
    assert (result.warnings, result.note) == ((), None)
    assert set(result.seconds) == {"load", "schedule", "fcl", "log", "total"}
    assert api.open_log(tmp_path / "out.mcap").summary == result.summary


@pytest.mark.parametrize("words", [[], ["--margin", "0.25", "--epoch", "7", "--rate", "2"], ["--jobs", "2"]])
def test_the_command_and_python_write_the_same_bytes(scene: Path, tmp_path: Path, words: list[str]) -> None:
    done = closecall_inside("run", scene, "-o", "command.mcap", "-q", *words, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    api.run(scene, tmp_path / "python.mcap", options_of(words))
    assert (tmp_path / "python.mcap").read_bytes() == (tmp_path / "command.mcap").read_bytes()


def test_a_loaded_scene_runs_again_and_again_to_the_same_bytes(scene: Path, tmp_path: Path) -> None:
    loaded = api.load(scene)
    logs = [tmp_path / "first.mcap", tmp_path / "second.mcap", tmp_path / "file.mcap"]
    for log, source in zip(logs, (loaded, loaded, scene), strict=True):
        api.run(source, log)
    assert len({log.read_bytes() for log in logs}) == 1


def test_changes_go_over_the_options_that_are_given(scene: Path, tmp_path: Path) -> None:
    options = api.RunOptions(margin=0.25, log="certificate")
    result = api.run(scene, tmp_path / "out.mcap", options, margin=np.float32(0.5))
    assert result.summary["settings"]["margin"] == 0.5
    assert options == api.RunOptions(margin=0.25, log="certificate")


def test_the_defaults_of_python_are_those_that_the_command_takes_and_its_help_prints() -> None:
    assert options_of([]) == api.RunOptions()
    command = run_options(click.Command("run"))
    with click.Context(command) as context:
        shown = {option.name: option.get_help_record(context) for option in command.params}
    assert set(shown) == {field.name for field in fields(api.RunOptions)}
    for option in fields(api.RunOptions):
        record = shown[option.name]
        assert record is not None
        if isinstance(option.default, int | str) and not isinstance(option.default, bool):
            assert f"[default: {option.default}" in record[1], option.name
        if option.name in CHOICES:
            assert f"[{'|'.join(CHOICES[option.name])}]" in record[0]
    distance = shown["distance_tolerance"]
    assert distance is not None
    assert f"[default: {Settings().distance_tolerance}]" in distance[1]


def test_a_log_holds_by_default_what_its_writer_puts_there_by_default() -> None:
    assert log_options(api.RunOptions()) == LogOptions(viewer=ViewerOptions())
    assert log_options(api.RunOptions(log="certificate")) == LogOptions()


WRONG = [
    ("margin", -1.0, "expected 0 m or more, got -1"),
    ("margin", float("nan"), "expected 0 m or more, got nan"),
    ("margin", 10**400, "expected 0 m or more, got "),
    ("margin", True, "expected 0 m or more, got true"),
    ("time_resolution", float("inf"), "expected a number of seconds, got inf"),
    ("time_resolution", 0.0, "expected at least 5.68e-14 s, got 0.0"),
    ("contact_tolerance", -1.0, "expected at least 5.68e-14 s, got -1.0"),
    ("distance_tolerance", 1.0, "expected none or a fraction from 1e-06 to 1, got 1"),
    ("distance_tolerance", "all", "expected none or a fraction from 1e-06 to 1, got 'all'"),
    ("epoch", 1.5, "expected a whole number of nanoseconds, got 1.5"),
    ("compression", "gzip", "expected one of zstd, lz4, none, got 'gzip'"),
    ("broad_phase", "of", "expected one of auto, on, off, got 'of'"),
    ("log", "none", "expected one of full, certificate, got 'none'"),
    ("topics", "two", "expected one of single, body, got 'two'"),
    ("jobs", 0, "expected auto, or 1 to 1024, got 0"),
    ("jobs", "many", "expected auto, or 1 to 1024, got 'many'"),
    ("rate", -1.0, "expected 0 to 1e+06 Hz, got -1"),
    ("rate", 999_999.0, "999999 Hz over 5 s would take 4,999,995 snapshots; the limit is 1,000,000, which is 2e+05 Hz"),
    ("viz_pairs", 1001, "expected 1 to 1000, got 1001"),
    ("viz_triangles", -1, "expected 0 or more, got -1"),
    ("max_bytes", 0, "expected 1 or more, got 0"),
    ("max_pairs", 2.5, "expected 1 or more, got 2.5"),
    ("strict", "no", "expected true or false, got 'no'"),
    ("attach_meshes", 1, "expected true or false, got 1"),
    ("cluster", 8786, "expected an address, got 8786"),
    ("mesh_roots", "parts", "expected a list of folders, got 'parts'"),
    ("margni", 1.0, "a run has no such option (did you mean 'margin'?)"),
    ("fail_on", "contact", "a run has no such option"),
]


@pytest.mark.parametrize(("name", "value", "problem"), WRONG)
def test_an_option_that_cannot_be_is_an_exception_that_names_it(
    scene: Path, tmp_path: Path, name: str, value: object, problem: str
) -> None:
    changes: dict[str, Any] = {name: value}
    with pytest.raises(api.OptionError) as caught:
        api.run(scene, tmp_path / "out.mcap", **changes)
    assert caught.value.option == name
    assert caught.value.problem.startswith(problem)
    assert str(caught.value) == f"{name}: {caught.value.problem}"
    assert isinstance(caught.value, ValueError)
    assert [path.name for path in tmp_path.iterdir()] == ["spheres.yaml"]


@pytest.mark.parametrize(
    ("word", "line"),
    [
        ("--margin=inf", "'--margin': expected 0 m or more, got inf."),
        ("--time-resolution=0", "'--time-resolution': expected at least 5.68e-14 s, got 0.0."),
        ("--contact-tolerance=nan", "'--contact-tolerance': expected a number of seconds, got nan."),
        ("--distance-tolerance=all", "'--distance-tolerance': expected none or a fraction from 1e-06 to 1, got 'all'."),
        ("--distance-tolerance=1", "'--distance-tolerance': expected none or a fraction from 1e-06 to 1, got 1."),
        ("--jobs=many", "'-j' / '--jobs': expected auto, or 1 to 1024, got 'many'."),
        ("--jobs=0", "'-j' / '--jobs': expected auto, or 1 to 1024, got 0."),
        ("--jobs=" + 5000 * "9", "'-j' / '--jobs': expected auto, or 1 to 1024, got '999"),
        ("--rate=-1", "'--rate': expected 0 to 1e+06 Hz, got -1."),
        (
            "--rate=999999",
            "'--rate': 999999 Hz over 5 s would take 4,999,995 snapshots; the limit is 1,000,000",
        ),
        ("--compression=gzip", "'--compression': 'gzip' is not one of 'zstd', 'lz4', 'none'."),
        ("--viz-pairs=1001", "'--viz-pairs': 1001 is not in the range 1<=x<=1000."),
    ],
)
def test_such_an_option_on_the_command_line_is_one_line_that_names_it_as_typed(
    scene: Path, tmp_path: Path, word: str, line: str
) -> None:
    done = closecall_inside("run", scene, "-o", "out.mcap", word, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    (error,) = (told for told in done.stderr.splitlines() if told.startswith("Error:"))
    assert error.startswith(f"Error: Invalid value for {line}")
    assert "Traceback" not in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["spheres.yaml"]


def test_jobs_and_a_cluster_exclude_each_other(scene: Path) -> None:
    for jobs in (2, "auto"):
        with pytest.raises(api.OptionError, match="cluster: give either jobs or a cluster, not both"):
            api.RunOptions(jobs=jobs, cluster="tcp://127.0.0.1:9")  # type: ignore[arg-type]


def test_numbers_of_other_types_are_taken_as_floats_and_ints() -> None:
    options = api.RunOptions(margin=Fraction(1, 4), epoch=np.int64(5), rate=np.float32(2), mesh_roots=["a"])  # type: ignore[arg-type]
    assert options == api.RunOptions(margin=0.25, epoch=5, rate=2.0, mesh_roots=(Path("a"),))
    assert json.dumps([options.margin, options.epoch, options.rate]) == "[0.25, 5, 2.0]"
    assert hash(options) == hash(api.RunOptions(margin=0.25, epoch=5, rate=2.0, mesh_roots=(Path("a"),)))


def test_faults_of_files_are_exceptions_that_carry_place_and_remedy(scene: Path, tmp_path: Path) -> None:
    scene.write_text(SPHERES.replace("bodies:", "bodeis:"))
    with pytest.raises(api.SceneError) as wrong:
        api.load(scene)
    assert (wrong.value.faults[0].line, wrong.value.faults[0].column) == (1, 1)
    with pytest.raises(api.LogError) as missing:
        api.open_log(str(tmp_path / "none.mcap"))
    assert missing.value.path == tmp_path / "none.mcap"
    assert missing.value.remedy


def test_one_scene_that_forbids_an_option_does_not_stop_the_others(scene: Path, tmp_path: Path) -> None:
    late = SPHERES.replace("{start: 0, end: 5}", "{start: 0, end: 2000000}")
    (tmp_path / "late.yaml").write_text(late.replace("velocity: [1, 0, 0]", "velocity: [-1e-3, 0, 0]"))
    words = ("--out-dir", "logs", "--rate", "10", "--time-resolution", "1e-12", "--contact-tolerance", "1e-9", "--json")
    done = closecall_inside("run", tmp_path / "late.yaml", scene, *words, cwd=tmp_path)
    assert done.returncode == 2
    assert [run["exit"] for run in json.loads(done.stdout)["scenes"]] == [2, 0]
    line, *others = done.stderr.splitlines()
    assert line.startswith(f"{tmp_path}/late.yaml: Invalid value for '--time-resolution': expected at least ")
    assert not [other for other in others if "late.yaml" in other]
    assert [path.name for path in (tmp_path / "logs").iterdir()] == ["spheres.mcap"]


def test_a_watcher_sees_every_event_after_the_scene_is_read(scene: Path, tmp_path: Path) -> None:
    class Recorder(Watcher):
        def __init__(self) -> None:
            self.seen: list[str] = []

        def ready(self) -> None:
            self.seen.append("ready")
            assert not (tmp_path / "out.mcap.partial").exists()

        def events(self, events: Events, scene: Scene, told: bool) -> Events:
            for event in events:
                self.seen.append(type(event).__name__)
                yield event

    recorder = Recorder()
    result = api.run(scene, tmp_path / "out.mcap", watcher=recorder)
    assert recorder.seen[0] == "ready"
    assert recorder.seen.count("Wakeup") == sum(pair["wakeups"] for pair in result.summary["pairs"])
