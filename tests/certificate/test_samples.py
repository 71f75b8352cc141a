"""What holds of every sample scene; what each of them must find is in the test_sample_*.py beside this."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from shutil import copy

import numpy as np
import pytest
import yaml
from sample_runs import FOLDER, NAMES, Sample, sample_of

from closecall.formats.log.result import fold, read_summary
from oracle.check import check_log
from oracle.meshes import read_triangles, topology
from oracle.sampling import Effort

LARGEST_MESHES = 300_000
"""bytes of all mesh files together, so that a checkout stays small."""


@pytest.fixture(params=NAMES)
def sample(request: pytest.FixtureRequest) -> Sample:
    return sample_of(request.param)


def test_a_samples_facts_fold_into_the_summary_that_its_log_carries(sample: Sample) -> None:
    found = fold(sample.logs[0])
    carried = read_summary(sample.logs[0])
    assert (found.loss, found.lost) == (None, {})
    for pair, again in zip(carried["pairs"], found.summary["pairs"], strict=True):
        time, told = pair["distance"].pop("time"), again["distance"].pop("time")  # type: ignore[misc]
        assert told == (None if time is None else pytest.approx(time, rel=1e-15, abs=1e-9)), "to the nanosecond"
    assert found.summary == carried


def test_there_are_a_dozen_samples() -> None:
    assert len(NAMES) >= 12


def test_all_meshes_together_are_small() -> None:
    assert sum(path.stat().st_size for path in FOLDER.glob("*/*") if path.suffix in (".obj", ".stl")) < LARGEST_MESHES


@pytest.mark.parametrize("name", NAMES)
def test_a_samples_scripts_write_every_file_that_it_names_byte_for_byte(name: str, tmp_path: Path) -> None:
    scene = yaml.safe_load((FOLDER / name / "scene.yaml").read_text(encoding="utf-8"))
    moved = [body["motion"] for body in scene["bodies"].values() if "motion" in body]
    named = {one["file"] for one in [*scene.get("meshes", {}).values(), *moved] if "file" in one}
    scripts = [Path(copy(path, tmp_path)) for path in (FOLDER / name).glob("make_*.py")]
    assert {path.name for path in (FOLDER / name).iterdir()} == {"scene.yaml", *named, *(s.name for s in scripts)}
    for script in scripts:
        subprocess.run([sys.executable, str(script)], check=True, cwd=FOLDER, stdout=subprocess.DEVNULL)
    made = {path.name: path.read_bytes() for path in tmp_path.iterdir() if path not in scripts}
    assert made == {file: (FOLDER / name / file).read_bytes() for file in named}


def test_every_mesh_of_a_sample_is_closed_and_faces_outward() -> None:
    for path in FOLDER.glob("*/*"):
        if path.suffix in (".obj", ".stl"):
            triangles = read_triangles(path)
            assert topology(triangles).closed, path
            assert np.linalg.det(triangles).sum() > 0.0, path


def test_two_hash_seeds_give_a_sample_the_same_bytes(sample: Sample) -> None:
    one, other = (log.read_bytes() for log in sample.logs)
    assert one == other


def test_no_sample_is_warned_of(sample: Sample) -> None:
    assert sample.warnings == ""


def test_nothing_in_a_sample_stays_unresolved(sample: Sample) -> None:
    assert sample.summary["pairs"]
    assert not [pair["pair"] for pair in sample.summary["pairs"] if pair["unresolved"]]
    assert not sample.pairs_with("unresolved")
    assert "UNRESOLVED" not in {span["verdict"] for span in sample.log.of("spans")}


def test_the_log_of_a_sample_is_true(sample: Sample) -> None:
    effort = Effort(uniform=24, scattered=8, ends=16, knots=8, minima=1, messages=4)
    faults = check_log(sample.path, sample.logs[0], effort=effort)
    assert not faults, "\n".join(faults)
