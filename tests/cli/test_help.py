"""Help: every command's examples run as printed. Completion: in the shells themselves."""

from __future__ import annotations

import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
from cli_process import closecall_inside
from diff_logs import run_scene, write_scene
from places import SAMPLES

from closecall.cli.group import COMMANDS, group
from closecall.cli.main import main


def examples(name: str) -> list[str]:
    """Return the examples in a command's help, or in that of closecall itself for no name."""
    command = import_module(f"closecall.cli.commands.{name}").command if name else group
    text = (command.help or "").partition("Examples:\n")[2]
    return [line.strip() for line in text.split("\n\n")[0].splitlines() if line.strip()]


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with what the examples name: a scene, its logs, the samples."""
    folder = tmp_path_factory.mktemp("examples")
    run_scene(write_scene(folder), folder / "out.mcap", "--log", "full")
    for name in ("golden", "new", "bar"):
        shutil.copy(folder / "out.mcap", folder / f"{name}.mcap")
    (folder / "sample_scenes").symlink_to(SAMPLES)
    return folder


@pytest.fixture
def folder(prepared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    shutil.copytree(prepared, tmp_path, symlinks=True, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    handler = signal.getsignal(signal.SIGTERM)
    yield tmp_path
    signal.signal(signal.SIGTERM, handler)


@pytest.mark.parametrize("name", ["", *COMMANDS])
def test_the_examples_of_a_help_run_as_printed(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsysbinary: pytest.CaptureFixture[bytes]
) -> None:
    lines = [line for line in examples(name) if not line.startswith("eval")]
    assert lines, "every help has an example"
    for line in lines:
        words, _, target = line.partition(" > ")
        monkeypatch.setattr(sys, "argv", shlex.split(words))
        with pytest.raises(SystemExit) as left:
            main()
        printed = capsysbinary.readouterr()
        assert left.value.code in ((0, 1) if "--fail-on" in line else (0, None)), (line, printed.err)
        assert b"rror" not in printed.err, line
        if target:
            Path(target).write_bytes(printed.out)
            assert printed.out


@pytest.mark.parametrize("name", ["", *COMMANDS])
def test_examples_are_not_broken_over_lines(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    shown = closecall_inside(*([name] if name else []), "--help", cwd=folder).stdout
    for line in examples(name):
        assert any(line == printed.strip() for printed in shown.splitlines()), line


COMPLETED = {
    "closecall su": {"summary"},
    "closecall summary --so": {"--sort"},
    "closecall summary --sort dis": {"distance"},
    "closecall completion f": {"fish"},
}


@pytest.mark.parametrize("line", COMPLETED)
def test_bash_completes(line: str, folder: Path) -> None:
    words = shlex.split(line)
    script = (
        f'closecall() {{ {sys.executable} -m closecall "$@"; }}; env() {{ command env "$@"; }}\n'
        'eval "$(closecall completion bash)"\n'
        f"COMP_WORDS=({line}) COMP_CWORD={len(words) - 1}\n"
        f"_closecall_completion ./closecall\n"
        'printf "%s\\n" "${COMPREPLY[@]}"'
    )
    (folder / "closecall").write_text(f'#!/bin/sh\nexec {sys.executable} -m closecall "$@"\n')
    (folder / "closecall").chmod(0o755)
    done = subprocess.run(["bash", "-c", script], cwd=folder, capture_output=True, text=True, timeout=60)
    assert set(done.stdout.split()) == COMPLETED[line], done.stderr


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_complete_too(shell: str, folder: Path) -> None:
    if shutil.which(shell) is None:
        pytest.skip(f"there is no {shell} here")
    script = folder / "script"
    script.write_text(closecall_inside("completion", shell, cwd=folder).stdout)
    assert subprocess.run([shell, "-n", script], capture_output=True, timeout=60).returncode == 0
    if shell == "fish":
        (folder / "closecall").write_text(f'#!/bin/sh\nexec {sys.executable} -m closecall "$@"\n')
        (folder / "closecall").chmod(0o755)
        asked = 'set -x PATH . $PATH; source script; complete -C "closecall su"'
        done = subprocess.run([shell, "-c", asked], cwd=folder, capture_output=True, text=True, timeout=60)
        assert done.stdout.startswith("summary"), done.stderr
