"""The first contact of bodies that only translate, against the continuous collision detection of the IPC Toolkit.

Its `TightInclusionCCD` (Wang et al. 2021) is conservative: the time it returns is never after the first contact, and
elements are then within its `tolerance` of each other, in each coordinate, on top of the part of their first distance
that `conservative_rescaling` keeps free (at most 1e-4). It sees surfaces, so pairs that start apart are compared.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from certified_runs import logged

from oracle.logs import Log, read_log
from oracle.translations import start_apart, straight_pieces, welded, write_translations
from oracle.truth import Pair, Truth

ipctk = pytest.importorskip("ipctk", reason="the IPC Toolkit is not installed: pip install 'ipctk>=1.6'")

DEEP_PAIRS = int(os.environ.get("CLOSECALL_DEEP_FIRST_CONTACTS", "400"))
"""How many pairs the deep test takes; CLOSECALL_DEEP_FIRST_CONTACTS_FIRST is the number of the first scene."""

DEEP_FIRST = int(os.environ.get("CLOSECALL_DEEP_FIRST_CONTACTS_FIRST", "0"))

TOLERANCE = 1e-6
"""m, of the toolkit: its default and what it advises."""

KEPT_FREE = 1e-6
"""Share of two elements' first distance that the toolkit keeps free, its conservative_rescaling less than 1."""

BACK = 1e-5
"""s: over so long the closing speed is taken."""


@dataclass
class Compared:
    """How many pairs were compared, met by both programs, by neither, and only grazed; the largest difference, s."""

    pairs: int = 0
    met: int = 0
    apart: int = 0
    grazed: int = 0
    largest: float = 0.0


def toolkit_time(truth: Truth, pair: Pair) -> float | None:
    """Return the scene time (s) of the first contact by the toolkit, None for none."""
    ccd = ipctk.TightInclusionCCD(tolerance=TOLERANCE, conservative_rescaling=1.0 - KEPT_FREE)
    for begin, end in straight_pieces(truth, pair):
        (before, owners, faces), (after, _, _) = welded(truth, pair, begin), welded(truth, pair, end)
        faces = faces.astype(np.int32)
        mesh = ipctk.CollisionMesh(before, ipctk.edges(faces), faces)
        mesh.can_collide = ipctk.make_vertex_patches_filter(owners.astype(np.int32))
        part = ipctk.compute_collision_free_stepsize(mesh, before, after, narrow_phase_ccd=ccd)
        if part < 1.0:
            return begin + part * (end - begin)
    return None


def compare(truth: Truth, log: Log, pair: Pair, so_far: Compared) -> str | None:
    """Return how the log's first contact of a pair differs from the toolkit's, None if it does not."""
    name = "|".join(pair)
    begins = [one for one in log.by_pair("collisions").get(name, ()) if one["phase"] == "BEGIN"]
    told = min((one["time_touching"] for one in begins), default=None)
    found = toolkit_time(truth, pair)
    so_far.pairs += 1
    if found is None:
        so_far.apart += told is None
        return None if told is None else f"{name}: contact at {told} s, the toolkit has none"
    width = 2.0 * (TOLERANCE + KEPT_FREE * 2.0 * truth.spread)
    gaps = truth.signed(*pair, np.array([max(found - BACK, truth.start), found]))
    if gaps[1] > width:
        return f"{name}: the toolkit's contact at {found} s is {gaps[1]} m apart"
    closing = max((gaps[0] - gaps[1]) / BACK, 1e-9)
    late = truth.contact_tolerance + width / closing
    if told is None:
        so_far.grazed += 1
        deep = truth.signed(*pair, np.array([min(found + late, truth.end)]))[0] < -truth.sure_depth
        return f"{name}: the toolkit has a contact at {found} s, none is told" if deep else None
    so_far.met += 1
    so_far.largest = max(so_far.largest, told - found)
    if not -1e-9 <= told - found <= late:
        return f"{name}: contact at {told} s, the toolkit's at {found} s, closing at {closing} m/s"
    return None


def faults_of(numbers: range, pairs: int, folder: Path) -> list[str]:
    """Compare pairs of scenes until there were so many, and return the differences, each with its scene."""
    so_far, faults = Compared(), list[str]()
    for number in numbers:
        place = folder / str(number)
        place.mkdir()
        scene = write_translations(number, place)
        log, truth = read_log(logged(scene, "--log", "certificate")), Truth(scene)
        for pair in truth.pairs():
            if start_apart(truth, pair) and so_far.pairs < pairs:
                fault = compare(truth, log, pair, so_far)
                faults += [] if fault is None else [f"translations:{number}: {fault}"]
        if so_far.pairs >= pairs:
            break
    print(so_far, *faults, sep="\n", flush=True)
    return faults


def test_some_first_contacts_are_those_of_another_program(tmp_path: Path) -> None:
    assert not faults_of(range(10), 15, tmp_path)


def later(event: dict[str, Any]) -> None:
    event["time_touching"] += 1e-3


def hidden(event: dict[str, Any]) -> None:
    event["phase"] = "END"


def test_a_spoiled_first_contact_is_objected_to(tmp_path: Path) -> None:
    scene = write_translations(0, tmp_path)
    truth, path = Truth(scene), logged(scene, "--log", "certificate")
    name = read_log(path).of("collisions")[0]["pair"]
    a, b = name.split("|")
    assert start_apart(truth, (a, b))
    assert compare(truth, read_log(path), (a, b), Compared()) is None
    for spoil in (later, hidden):
        log = read_log(path)
        for event in log.by_pair("collisions")[name]:
            spoil(event)
        assert compare(truth, log, (a, b), Compared()) is not None


@pytest.mark.deep
def test_many_first_contacts_are_those_of_another_program(tmp_path: Path) -> None:
    assert not faults_of(range(DEEP_FIRST, DEEP_FIRST + DEEP_PAIRS), DEEP_PAIRS, tmp_path)
