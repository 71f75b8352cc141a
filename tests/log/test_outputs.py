"""Where an output cannot go: one line that says why and what to do, nothing written, no hint that misleads."""

import os
from pathlib import Path

import pytest
from cli_process import SPHERES, closecall_inside

LONG = "n" * 248
WRITING = {
    "run": ["run", "scene.yaml", "-q", "--log", "certificate", "-o"],
    "report": ["report", "log.mcap", "-o"],
    "extract, a part": ["extract", "log.mcap", "--to", "1", "-o"],
    "extract, a file": ["extract", "log.mcap", "scene", "-o"],
    "diff": ["diff", "log.mcap", "log.mcap", "--junit"],
}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a scene, its log, and all that an output should not be."""
    folder = tmp_path_factory.mktemp("outputs")
    (folder / "scene.yaml").write_text(SPHERES)
    assert closecall_inside("run", "scene.yaml", "-o", "log.mcap", "-q", cwd=folder).returncode == 0
    (folder / "folder").mkdir()
    (folder / "taken.partial").mkdir()
    (folder / "queue.partial").symlink_to("queue")
    (folder / "plain").touch()
    (folder / "loop").symlink_to("loop")
    os.mkfifo(folder / "queue")
    (folder / "scene.yaml.partial").hardlink_to(folder / "plain")
    return folder


def refused(arguments: list[str], folder: Path) -> str:
    """Run a command that is refused; return its one line, with nothing new in the folder."""
    before = sorted(folder.rglob("*"))
    done = closecall_inside(*arguments, cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    line = done.stderr.splitlines()[-1]
    assert line.isprintable()
    assert "so far" not in line
    assert "Traceback" not in done.stderr
    assert sorted(folder.rglob("*")) == before
    return line


@pytest.mark.parametrize("command", WRITING)
def test_an_output_that_cannot_be_is_refused_in_a_line_that_says_what_to_do(made, command):
    for name, told in (
        (LONG, f"the name has 248 bytes, but at most 247 fit.*{'--junit' if command == 'diff' else '-o'}"),
        ("é" * 124, "248 bytes"),
        ("x" * 5000, "name"),
        (f"{LONG}{LONG}/x", "File name too long"),
        ("folder", "is a folder"),
        (".", "is a folder"),
        ("/", "is a folder"),
        ("taken", "taken.partial, the place of the unfinished file, is a folder; remove that"),
        ("queue", "not a plain file"),
        ("/dev/full", "not a plain file"),
        ("nowhere/x", "there is no folder nowhere; create it"),
        ("plain/x", "there is no folder plain"),
        ("loop/x", "there is no folder loop"),
        ("", "expected a name, got an empty one"),
    ):
        line = refused([*WRITING[command], name], made)
        assert all(part in line for part in told.split(".*")), (name, line)


@pytest.mark.parametrize("command", WRITING)
def test_the_longest_name_and_a_link_to_itself_are_written(made, command):
    for name in ("n" * 247, "ring"):
        (made / "ring").symlink_to("ring")
        assert closecall_inside(*WRITING[command], name, cwd=made).returncode == 0
        assert (made / name).is_file()
        (made / name).unlink()
        (made / "ring").unlink(missing_ok=True)


def test_an_input_that_is_where_the_partial_would_be_is_not_said_to_be_the_log(made):
    (made / "out.partial").write_text(SPHERES)
    line = refused(["run", "out.partial", "-o", "out"], made)
    assert "out: would overwrite the input out.partial through out.partial" in line
    assert (made / "out.partial").read_text() == SPHERES


def test_tables_are_written_like_all_outputs(made):
    for name, told in (
        ("plain", "plain: is not a folder"),
        ("queue", "is not a folder"),
        ("plain/x", "cannot be created: Not a directory"),
        (LONG + LONG, "File name too long"),
        ("", "expected a name"),
    ):
        assert told in refused(["export", "log.mcap", "-o", name], made)
    (made / "tables" / "spans.csv.partial").mkdir(parents=True)
    assert "is a folder; remove that" in refused(["export", "log.mcap", "-o", "tables"], made)


def test_folders_of_logs_are_refused_likewise(made):
    run = ["run", "scene.yaml", "-q", "--log", "certificate", "--out-dir"]
    for name, told in (("plain", "File exists"), ("plain/x", "Not a directory"), ("", "expected a name")):
        assert told in refused([*run, name], made)
    long = f"{'n' * 245}.yaml"
    (made / long).write_text(SPHERES)
    assert "the name has 250 bytes" in refused(["run", long, "-q", "--out-dir", "folder"], made)
    (made / "scene.json").symlink_to("scene.json")
    assert "scene.json:1:1" in refused(["run", "scene.json", "-q", "--out-dir", "folder"], made)


@pytest.mark.parametrize("name", ["x" * 300, "x" * 5000, ".", "/", "..", "folder", "queue", "loop", "/dev/zero", ""])
def test_inputs_of_any_name_are_refused_in_a_line(made, name):
    for arguments in (
        ["run", name, "-o", "new.mcap"],
        ["check", name],
        ["summary", name],
        ["report", name],
        ["export", name, "-o", "new"],
        ["extract", name],
        ["diff", name, "log.mcap", "--json"],
    ):
        if not (arguments[0] in ("run", "check") and name in ("queue", "/dev/zero")):
            refused(arguments, made)
