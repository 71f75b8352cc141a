"""Times so large that floats of them are coarse: the default contact tolerance is coarser then, and notes say so."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from cli_process import closecall
from scene_files import HEAD, fault, load

from oracle.check import check_log
from oracle.logs import read_log

UNIX_TIME = 1_700_000_000
TOLERANCE = 64 * 2.0**-22
"""s: floats between 2^30 and 2^31 are 2^-22 apart."""

NOTE = (
    "begins and ends of contacts are known to within 1.53e-05 s, "
    "because floating-point times near 1700000004 s are 2.4e-07 s apart"
)


def scene(folder: Path, settings: str = "") -> Path:
    """Write a ball that meets a block at 1/3 s after the start in Unix seconds, and leaves it never."""
    path = folder / "s.yaml"
    path.write_text(
        "closecall: 1\nunits: {length: m, angle: rad}\n"
        f"time: {{start: {UNIX_TIME}, end: {UNIX_TIME + 4}}}\n{settings}bodies:\n"
        f"  ball: {{shapes: [{{sphere: 0.25}}], motion: {{type: constant, t0: {UNIX_TIME}, velocity: [3, 0, 0]}}}}\n"
        "  wall: {pose: {xyz: [51.25, 0, 0]}, shapes: [{box: [100, 9, 9]}]}\n"
    )
    return path


@pytest.mark.parametrize(
    ("start", "end", "tolerance"),
    [
        (0, 1, 1e-6),
        (0, 1e8, 1e-6),
        (0, 2.0**27, 64 * 2.0**-25),
        (UNIX_TIME, UNIX_TIME + 1, TOLERANCE),
        (-UNIX_TIME, 0, TOLERANCE),
    ],
)
def test_the_usual_tolerance_is_a_microsecond_or_64_floats_of_time(
    tmp_path: Path, start: float, end: float, tolerance: float
) -> None:
    read = load(tmp_path, HEAD.replace("start: 0, end: 1", f"start: {start}, end: {end}") + "bodies: {}\n")
    assert read.settings.contact_tolerance == tolerance
    assert read.settings.contact_tolerance >= 64 * np.spacing(max(abs(start), abs(end)))
    assert read.warnings == ()


def test_a_tolerance_that_is_asked_for_too_fine_is_refused(tmp_path: Path) -> None:
    head = HEAD.replace("start: 0, end: 1", f"start: {UNIX_TIME}, end: {UNIX_TIME + 1}")
    line = fault(tmp_path, head + "settings: {contact_tolerance: 1e-6}\nbodies: {}\n")
    assert line.startswith("4:31: settings.contact_tolerance: contact_tolerance 1e-06 s is too short for times near ")
    assert line.endswith("expected at least 1.52587890625e-05 s")
    done = closecall("run", str(scene(tmp_path)), "-o", "s.mcap", "--contact-tolerance", "1e-6", cwd=tmp_path)
    assert done.returncode == 2
    assert "expected at least 1.53e-05 s" in done.stderr


def test_unix_seconds_run_under_strict_and_every_table_notes_the_tolerance(tmp_path: Path) -> None:
    path = scene(tmp_path)
    done = closecall("run", "s.yaml", "-o", "s.mcap", "--log", "certificate", "--strict", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[-2] == f"note: {NOTE}"
    assert check_log(path, tmp_path / "s.mcap") == []
    (begin,) = read_log(tmp_path / "s.mcap").of("collisions")
    touch = UNIX_TIME + Fraction(1, 3)
    assert Fraction(begin["time_clear"]) <= touch <= Fraction(begin["time_touching"])
    assert begin["time_touching"] - begin["time_clear"] <= TOLERANCE
    summary = closecall("summary", "s.mcap", cwd=tmp_path)
    assert summary.stdout.splitlines()[-2] == f"note: {NOTE}"
    told = json.loads(closecall("summary", "s.mcap", "--json", cwd=tmp_path).stdout)
    assert told["settings"]["contact_tolerance"] == TOLERANCE
    checked = closecall("check", "s.yaml", "--strict", cwd=tmp_path)
    assert (checked.returncode, checked.stdout.splitlines()[-1]) == (0, f"note: {NOTE}")
    exported = closecall("export", "s.mcap", "--topic", "/log", "--format", "ndjson", cwd=tmp_path)
    assert NOTE in exported.stdout


def test_a_tolerance_that_was_asked_for_is_not_noted(tmp_path: Path) -> None:
    scene(tmp_path, "settings: {contact_tolerance: 1e-4}\n")
    for words in (("check", "s.yaml"), ("run", "s.yaml", "-o", "s.mcap", "--log", "certificate")):
        assert "note" not in closecall(*words, cwd=tmp_path).stdout
