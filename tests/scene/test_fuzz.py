"""Whatever a scene file holds, reading it gives a scene or located faults, soon and in little memory.

`pytest -m deep` reads CLOSECALL_FUZZ_INPUTS of them, 100,000 if that is not set, in some ten minutes. Their seeds begin
with CLOSECALL_FUZZ_FIRST, 0 if that is not set.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from random import Random
from shutil import copy
from time import process_time

import numpy as np
import pytest
from drawn_scenes import SPLINTERS, drawn_text, mangled, write_files
from guarded import memory_limited, time_limited
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from places import SAMPLES

from closecall.formats.scene.loaded import LoadedScene
from closecall.formats.scene.reader import read_scene
from closecall.formats.scene.text.errors import SceneError

SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much, HealthCheck.large_base_example]
FEW = settings(
    max_examples=300,
    derandomize=True,
    deadline=None,
    suppress_health_check=[*SLOW, HealthCheck.function_scoped_fixture],
)

SCENES = sorted(SAMPLES.glob("*/scene.yaml"))

SEEDS = st.integers(0, 2**64 - 1)
"""Of random.Random: drawing each choice through hypothesis would take ten times as long."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with the files that drawn scenes and the samples name, and a limit on memory."""
    folder = tmp_path_factory.mktemp("fuzz")
    write_files(folder)
    for file in (file for sample in SCENES for file in sample.parent.iterdir()):
        if file.suffix in (".obj", ".stl", ".tum"):
            copy(file, folder)
    with memory_limited():
        yield folder


def check_reading(folder: Path, name: str, data: bytes) -> bool:
    """Read a file and hold the reader to its contract; tell whether it is a scene."""
    path = folder / name
    path.write_bytes(data)
    try:
        with time_limited():
            loaded = read_scene(path)
    except SceneError as error:
        check_faults(error)
        return False
    check_scene(loaded)
    return True


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


def check_drawn(folder: Path, seed: int) -> bool:
    text, name = drawn_text(Random(seed))
    return check_reading(folder, name, text.encode(errors="surrogatepass"))


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


@FEW
@given(seed=SEEDS, sample=st.sampled_from(SCENES))
def test_nothing_but_scenes_and_located_faults_come_of_mangled_samples(folder: Path, seed: int, sample: Path) -> None:
    text = mangled(Random(seed), sample.read_text(encoding="utf-8"))
    check_reading(folder, "sample.yaml", text.encode(errors="surrogatepass"))


INPUTS = int(os.environ.get("CLOSECALL_FUZZ_INPUTS", "100000"))
FIRST = int(os.environ.get("CLOSECALL_FUZZ_FIRST", "0"))


def random_text(source: Random) -> bytes:
    """Return the bytes of words and characters that mean something to YAML or JSON, or of anything."""
    if source.random() < 0.2:
        return source.randbytes(source.randrange(40))
    words = (*SPLINTERS, "bodies:", "closecall: 1", "\n", "  ", "a", "é", "\U0001f600", chr(source.randrange(0x11000)))
    return "".join(source.choices(words, k=source.randrange(25))).encode(errors="surrogatepass")


def check_seed(folder: Path, seed: int, samples: list[str]) -> tuple[str, bool]:
    """Read the input of a seed; return what kind it is of, and whether it is a scene."""
    source = Random(seed)
    match seed % 8:
        case 6:
            text = mangled(source, source.choice(samples))
            return "mangled sample", check_reading(folder, "sample.yaml", text.encode(errors="surrogatepass"))
        case 7:
            name = source.choice(("s.yaml", "s.json"))
            return "random text", check_reading(folder, name, random_text(source))
    return "drawn document", check_drawn(folder, seed)


@pytest.mark.deep
def test_nothing_but_scenes_and_located_faults_come_of_a_hundred_thousand_inputs(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    samples = [sample.read_text(encoding="utf-8") for sample in SCENES]
    counts: Counter[tuple[str, bool]] = Counter()
    began = process_time()
    for done, seed in enumerate(range(FIRST, FIRST + INPUTS), start=1):
        try:
            counts[check_seed(folder, seed, samples)] += 1
        except BaseException as error:
            error.add_note(f"the input of seed {seed}")
            raise
        if done % 5000 == 0 or done == INPUTS:
            told = ", ".join(
                f"{n} {kind} {'read' if read else 'refused'}" for (kind, read), n in sorted(counts.items())
            )
            with capsys.disabled():
                print(f"\n{done} inputs in {process_time() - began:.0f} s: {told}", end="", flush=True)
    assert counts["drawn document", True] > INPUTS // 8
    assert counts["drawn document", False] > INPUTS // 8
