"""Whatever a scene file holds, reading it gives a scene or located faults, soon and in little memory.

`pytest -m deep` reads CLOSECALL_FUZZ_INPUTS of them, 100,000 if that is not set.
"""

from __future__ import annotations

import os
import resource
from itertools import pairwise
from pathlib import Path
from random import Random
from time import process_time

import numpy as np
import pytest
from drawn_scenes import SPLINTERS, drawn_text, mangled, write_files
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from closecall.formats.scene.errors import SceneError
from closecall.formats.scene.loaded import LoadedScene
from closecall.formats.scene.reader import read_scene

MOST_SECONDS = 2.0
"""CPU s that the reading of any of these files may take."""

MOST_MEGABYTES = 500
"""By which the process may grow while it reads all of them."""

FEW = settings(max_examples=300, derandomize=True, deadline=None, suppress_health_check=list(HealthCheck))
MANY = settings(FEW, max_examples=int(os.environ.get("CLOSECALL_FUZZ_INPUTS", "100000")), database=None)


SEEDS = st.integers(0, 2**64 - 1)
"""Of random.Random: drawing each choice through hypothesis would take ten times as long."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fuzz")
    write_files(folder)
    return folder


def megabytes() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def check_reading(folder: Path, name: str, data: bytes) -> None:
    """Read a file and hold the reader to its contract."""
    path = folder / name
    path.write_bytes(data)
    before, began = megabytes(), process_time()
    try:
        loaded = read_scene(path)
    except SceneError as error:
        check_faults(error)
    else:
        check_scene(loaded)
    assert process_time() - began < MOST_SECONDS
    assert megabytes() - before < MOST_MEGABYTES


def check_faults(error: SceneError) -> None:
    assert error.faults
    for fault in error.faults:
        assert str(fault).isprintable()
        assert fault.line >= 1
        assert fault.column >= 1
        assert fault.place
        assert fault.message
    assert all((one.line, one.column) <= (other.line, other.column) for one, other in pairwise(error.faults))


def check_scene(loaded: LoadedScene) -> None:
    """Check that the scene is finite wherever the scheduler may look."""
    scene = loaded.scene
    assert all(warning.isprintable() for warning in loaded.warnings)
    assert scene.start < scene.end
    times = scene.start, scene.end
    for body in scene.bodies:
        assert np.isfinite(body.pose).all()
        for time in (scene.start, 0.5 * scene.start + 0.5 * scene.end, scene.end):
            assert np.isfinite(body.motion.pose(time)).all()
            assert np.isfinite(body.motion.velocities(time)).all()
        assert np.isfinite(body.motion.extent(times))
        assert np.isfinite(body.motion.rounding_scale(times, 1.0))
        for shape in body.shapes:
            assert np.isfinite(shape.mesh.vertices).all()
            assert np.isfinite((shape.radius, shape.chord_error)).all()
    for index, names in loaded.key_names.items():
        assert 0 <= index < len(scene.bodies)
        assert all(isinstance(name, str) for name in names.around(scene.start))


def check_drawn(folder: Path, seed: int) -> None:
    text, name = drawn_text(Random(seed))
    check_reading(folder, name, text.encode(errors="surrogatepass"))


@FEW
@given(seed=SEEDS)
def test_nothing_but_scenes_and_located_faults_come_of_drawn_documents(folder: Path, seed: int) -> None:
    check_drawn(folder, seed)


@FEW
@given(data=st.binary(max_size=200), name=st.sampled_from(["s.yaml", "s.json"]))
def test_nothing_but_located_faults_comes_of_random_bytes(folder: Path, data: bytes, name: str) -> None:
    check_reading(folder, name, data)


YAML_TEXT = st.lists(
    st.sampled_from([*SPLINTERS, "bodies:", "closecall: 1", "\n", "  ", "a", "é", "\U0001f600"]) | st.text(max_size=5),
    max_size=20,
).map("".join)


@FEW
@given(text=YAML_TEXT, name=st.sampled_from(["s.yaml", "s.json"]))
def test_nothing_but_located_faults_comes_of_random_text(folder: Path, text: str, name: str) -> None:
    check_reading(folder, name, text.encode(errors="surrogatepass"))


SAMPLES = sorted((Path(__file__).parents[1] / "sample_scenes").glob("*/scene.yaml"))


@FEW
@given(seed=SEEDS, sample=st.sampled_from(SAMPLES))
def test_nothing_but_scenes_and_located_faults_come_of_mangled_samples(folder: Path, seed: int, sample: Path) -> None:
    text = mangled(Random(seed), sample.read_text(encoding="utf-8"))
    check_reading(folder, "sample.yaml", text.encode(errors="surrogatepass"))


@pytest.mark.deep
@MANY
@given(seed=SEEDS, data=st.binary(max_size=40), text=YAML_TEXT)
def test_nothing_but_scenes_and_located_faults_come_of_a_hundred_thousand_inputs(
    folder: Path, seed: int, data: bytes, text: str
) -> None:
    check_drawn(folder, seed)
    if seed % 8 == 0:
        check_reading(folder, "s.yaml", data)
        check_reading(folder, "s.json", text.encode(errors="surrogatepass"))
        check_reading(folder, "t.yaml", text.encode(errors="surrogatepass"))
