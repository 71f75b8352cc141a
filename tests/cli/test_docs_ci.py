"""The recipe for CI jobs, run as it is printed: the shell's commands, the workflow's steps, the tests."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from cli_process import closecall_inside
from diff_logs import SCENE, write_scene
from places import ROOT, SAMPLES
from plugin_runs import run_pytest

pytest_plugins = ["pytester"]

NUMBER = re.compile(r"\d+\.?\d*")

DOCUMENT = (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.+?)^```", DOCUMENT, re.MULTILINE | re.DOTALL)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    for name in ("cell", "gate"):
        write_scene(tmp_path / "scenes" / name)
    (tmp_path / "bin").mkdir()
    command = tmp_path / "bin" / "closecall"
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m closecall "$@"\n')
    command.chmod(0o755)
    return tmp_path


def shell(script: str, folder: Path, tools: Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PATH": f"{tools / 'bin'}{os.pathsep}{os.environ['PATH']}"}
    command = ["bash", "-euo", "pipefail", "-c", script]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120)


def test_the_shell_recipe_and_the_workflow_run_as_printed(project):
    goldens, job = blocks("sh")
    made = shell(goldens, project, project)
    assert made.returncode == 0, made.stderr
    assert sorted(path.name for path in (project / "goldens").iterdir()) == ["cell.mcap", "gate.mcap"]
    assert shell(job, project, project).returncode == 0

    (project / "compare.sh").write_text(job)
    (workflow,) = (yaml.safe_load(text) for text in blocks("yaml"))
    steps = [step["run"] for step in workflow["jobs"]["compare"]["steps"] if "run" in step]
    assert steps == ["pip install ./closecall", "sh compare.sh"]
    write_scene(project / "scenes" / "gate", SCENE.replace("t: 1,", "t: 1.0032,"))
    failed = shell(steps[1], project, project)
    assert failed.returncode == 1
    assert "contact begin moved: 1" in failed.stdout
    assert "<failure" in (project / "reports" / "gate.xml").read_text()
    assert "<failure" not in (project / "reports" / "cell.xml").read_text()


def test_the_shell_recipe_notices_scenes_and_goldens_that_stand_alone(project):
    goldens, job = blocks("sh")
    assert shell(goldens, project, project).returncode == 0
    (project / "reports").mkdir()
    (project / "reports" / "long_gone.xml").write_text("<?xml")
    (project / "goldens" / "gate.mcap").unlink()
    done = shell(job, project, project)
    assert done.returncode == 2
    assert "scenes/gate has no golden log" in done.stderr
    assert [path.name for path in (project / "reports").iterdir()] == ["cell.xml"]

    (project / "goldens" / "old.mcap").write_bytes((project / "goldens" / "cell.mcap").read_bytes())
    (project / "goldens" / "gate.mcap").write_bytes((project / "goldens" / "cell.mcap").read_bytes())
    done = shell(job, project, project)
    assert done.returncode == 2
    assert "goldens/old.mcap has no scene" in done.stderr


def test_the_tests_run_as_printed(pytester):
    write_scene(pytester.path / "scenes" / "cell")
    (pytester.path / "test_cell.py").write_text(blocks("python")[0])
    assert run_pytest(pytester, "--closecall-update").returncode == 0
    assert (pytester.path / "test_cell" / "test_the_cell_is_as_it_was.mcap").exists()
    assert "test_cell/test_the_cell_is_as_it_was.mcap" in DOCUMENT


def test_readme_prints_what_its_comparison_prints(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    (tmp_path / "sample_scenes").symlink_to(SAMPLES)
    section = README.split("## Comparing logs")[1]
    script = section.split("```sh\n")[1].split("```")[0]
    shown = section.split("ends in\n\n```\n")[1].split("```")[0]
    done = None
    for line in script.splitlines():
        program, *words = shlex.split(line, comments=True)
        if program == "closecall":
            done = closecall_inside(*words, cwd=tmp_path)
        else:
            subprocess.run(["sh", "-c", line], cwd=tmp_path, check=True)
    assert done is not None
    assert done.returncode == 1
    assert NUMBER.sub("#", done.stdout).split() == NUMBER.sub("#", shown).split()
    told, printed = (list(map(float, NUMBER.findall(text))) for text in (done.stdout, shown))
    assert told == pytest.approx(printed, abs=3e-6), "to what the brackets of both contacts leave open"


def test_the_scene_that_readme_shows_runs_as_printed(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    shutil.copytree(SAMPLES / "near_gears", tmp_path / "sample_scenes" / "near_gears")
    section = README.split("## A scene")[1]
    (tmp_path / "cell.yaml").write_text(section.split("```yaml\n")[1].split("```")[0])
    ran = section.split("`closecall run ")[1].split("`")[0]
    shown = section.split("prints\n\n```\n")[1].split("```")[0]
    done = closecall_inside("run", *shlex.split(ran), "--log", "certificate", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split() == shown.split()
