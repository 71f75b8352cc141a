"""Families of scenes made to break a certificate, run through the tool, their logs held against the oracle.

By hand, from tests/: `python -m oracle fast_spin:7 FOLDER` writes the scene of a family and a number, and
`python -m oracle SCENE LOG` checks a log of it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from certified_runs import DEEP, QUICK, logged

from closecall.formats.scene.reader import read_scene
from closecall.formats.scene.text.errors import SceneError
from oracle.check import check_log
from oracle.families import FAMILIES, write_family
from oracle.families.wound import joined_boxes
from oracle.sampling import Effort
from oracle.solids import write_mesh

DEEP_SCENES = int(os.environ.get("CLOSECALL_DEEP_FAMILY_SCENES", "50"))
"""How many scenes of each family the deep test takes; CLOSECALL_DEEP_FAMILY_FIRST is the number of the first."""

DEEP_FIRST = int(os.environ.get("CLOSECALL_DEEP_FAMILY_FIRST", "0"))


def faults_of(family: str, numbers: Iterable[int], folder: Path, effort: dict[str, int], *options: str) -> list[str]:
    """Return what is wrong with the logs of a family's scenes, each line with the scene."""
    failed: list[str] = []
    for number in numbers:
        place = folder / str(number)
        place.mkdir()
        scene = write_family(family, number, place)
        faults = check_log(scene, logged(scene, "--log", "certificate", *options), effort=Effort(seed=number, **effort))
        failed += [f"{family}:{number}: {fault}" for fault in faults]
        print(*failed, sep="\n", end="", flush=True)
    return failed


@pytest.mark.parametrize("family", FAMILIES)
def test_the_log_of_an_adversarial_scene_is_true(family: str, tmp_path: Path) -> None:
    faults = faults_of(family, range(1), tmp_path, QUICK)
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize("family", FAMILIES)
def test_the_log_of_an_adversarial_scene_whose_pairs_come_and_go_is_true(family: str, tmp_path: Path) -> None:
    faults = faults_of(family, range(1, 2), tmp_path, QUICK, "--broad-phase", "on")
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize(
    ("family", "number"),
    [
        ("parallel_sliding", 41),  # a contact ends and the next begins at one instant that measured clear
        ("knots_with_jumps", 11),  # a float before a loop's key
    ],
)
def test_the_log_of_a_scene_that_once_was_faulty_is_true(family: str, number: int, tmp_path: Path) -> None:
    faults = faults_of(family, [number], tmp_path, QUICK)
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize("shift", [(0.5, 0.0, 0.0), (0.5, 0.05, 0.1), (0.3, 0.6, 0.2)])
def test_a_part_that_crosses_itself_inside_out_is_refused_with_two_triangles(
    shift: tuple[float, ...], tmp_path: Path
) -> None:
    """The overlap of two boxes of one part has winding number 0 if the second is wound inwards."""
    write_mesh(tmp_path / "m.obj", joined_boxes(np.array(shift), inwards=True), 0)
    bodies = {"a": {"shapes": [{"mesh": "m"}]}, "b": {"shapes": [{"sphere": 0.05}]}}
    head = {"closecall": 1, "units": {"length": "m", "angle": "rad"}, "time": {"start": 0, "end": 1}}
    scene = {**head, "meshes": {"m": {"file": "m.obj", "units": "m"}}, "bodies": bodies}
    (tmp_path / "s.json").write_text(json.dumps(scene))
    with pytest.raises(SceneError, match=r"m\.obj: .* crosses itself .* at triangles \d+ and \d+ of 60"):
        read_scene(tmp_path / "s.json")


@pytest.mark.deep
@pytest.mark.parametrize("family", FAMILIES)
def test_the_logs_of_many_adversarial_scenes_are_true(family: str, tmp_path: Path) -> None:
    faults = faults_of(family, range(DEEP_FIRST, DEEP_FIRST + DEEP_SCENES), tmp_path, DEEP)
    assert not faults, "\n".join(faults)
