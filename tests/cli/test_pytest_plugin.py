"""The pytest plugin, in a project of its own: goldens beside the test, written, compared, updated."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from diff_logs import SCENE, write_scene
from places import ROOT
from plugin_runs import PLUGIN, run_pytest

pytest_plugins = ["pytester"]

TEST = """\
import pytest

def test_cell(closecall_golden):
    closecall_golden.check("scene.yaml")

class TestMargins:
    @pytest.mark.parametrize("margin", ["0.001"])
    def test_cell(self, closecall_golden, margin):
        closecall_golden.check("scene.yaml", "--margin", margin, ignore=["rail"], time_tol=0.01)
"""


@pytest.fixture
def project(pytester: pytest.Pytester) -> Path:
    write_scene(pytester.path)
    (pytester.path / "test_scenes.py").write_text(TEST)
    return pytester.path


def test_goldens_are_written_when_asked_for_then_compared_and_updated_where_they_differ(project, pytester):
    missing = run_pytest(pytester)
    assert missing.returncode == 1
    assert "does not exist" in missing.stdout
    assert "--closecall-update" in missing.stdout
    assert not (project / "test_scenes").exists()

    assert run_pytest(pytester, "--closecall-update").returncode == 0
    goldens = {path.name: path.read_bytes() for path in (project / "test_scenes").iterdir()}
    assert sorted(goldens) == ["TestMargins-test_cell_0.001.mcap", "test_cell.mcap"]
    assert run_pytest(pytester).returncode == 0

    write_scene(project, SCENE.replace("t: 1,", "t: 1.0032,"))
    differs = run_pytest(pytester)
    assert "1 failed, 1 passed" in differs.stdout, "the other tolerates it"
    assert "arm | wall: contact begin moved 3.04 ms later" in differs.stdout
    assert "Traceback" not in differs.stdout
    assert "pytest_plugin.py" not in differs.stdout, "no lines of the plugin's own"

    assert run_pytest(pytester, "--closecall-update").returncode == 0
    changed = {name for name, data in goldens.items() if (project / "test_scenes" / name).read_bytes() != data}
    assert changed == {"test_cell.mcap"}


def test_what_is_wrong_with_a_scene_or_an_option_is_a_line(project, pytester):
    (project / "test_scenes.py").write_text(TEST.replace('"--margin"', '"--margni"'))
    write_scene(project, SCENE.replace("bodies:", "bodeis:"))
    failed = run_pytest(pytester).stdout
    assert "unknown key 'bodeis'" in failed
    assert "No such option '--margni'" in failed
    assert "Traceback" not in failed


@pytest.mark.parametrize("word", ["--fail-on=contact", "--json", "--output=other.mcap", "--verbose"])
def test_an_option_that_could_do_nothing_in_a_test_is_refused(project, pytester, word):
    (project / "test_scenes.py").write_text(TEST.replace('"scene.yaml")', f'"scene.yaml", "{word}")'))
    failed = run_pytest(pytester, "--closecall-update").stdout
    assert f"No such option '{word.partition('=')[0]}'" in failed
    assert "1 failed, 1 passed" in failed


def test_the_plugin_costs_nothing_until_it_is_asked_for():
    setup = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert setup["project"]["entry-points"]["pytest11"] == {"closecall": PLUGIN}
    code = f"import {PLUGIN}, sys; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {name.split(".")[0] for name in loaded} & {"numpy", "mcap", "google", "rich", "click", "trimesh"}
