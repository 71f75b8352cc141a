"""Lengths in tables and messages are in the unit of the scene; JSON and logs stay in metres."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from cli_process import closecall_inside

from closecall.formats.log.reader import LogReader

BALLS = """\
closecall: 1
units: {{length: {unit}, angle: deg}}
time: {{start: 0, end: 4}}
settings: {{margin: 2}}
bodies:
  runs: {{pose: {{xyz: [-20, {way}, 0]}}, shapes: [{{sphere: 5}}], motion: {{type: constant, velocity: [10, 0, 0]}}}}
  still: {{shapes: [{{sphere: 2.5}}]}}
  far: {{pose: {{xyz: [0, 900, 0]}}, shapes: [{{box: [30, 20, 10]}}]}}
"""
SIZE = {"mm": 0.001, "in": 0.0254, "m": 1.0}


@pytest.fixture(params=list(SIZE))
def unit(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def said(folder: Path, *arguments: object, code: int = 0) -> str:
    done = closecall_inside(*arguments, cwd=folder)
    assert done.returncode == code, done.stderr
    return done.stdout


def test_every_table_has_the_unit_of_the_scene_and_json_has_metres(tmp_path: Path, unit: str) -> None:
    """Spheres of radius 5 and 2.5 pass at a distance of 10 between their centres: 2.5 apart at 2 s."""
    (tmp_path / "s.yaml").write_text(BALLS.format(unit=unit, way=10))
    (tmp_path / "nearer.yaml").write_text(BALLS.format(unit=unit, way=9.9))
    table = said(tmp_path, "run", "s.yaml", "-o", "o.mcap", "--log", "certificate")
    (row,) = [line for line in table.splitlines() if line.startswith("runs | still")]
    assert f" .. 2.5 {unit} at 2 s" in row
    assert said(tmp_path, "summary", "o.mcap") == table
    pairs = {pair["pair"]: pair for pair in json.loads(said(tmp_path, "summary", "o.mcap", "--json"))["pairs"]}
    assert pairs["runs|still"]["distance"]["upper"] == pytest.approx(2.5 * SIZE[unit])
    with LogReader(tmp_path / "o.mcap") as log:
        assert log.identity.length_unit == unit
    checked = said(tmp_path, "check", "s.yaml")
    assert f"constant, 10 {unit}/s" in checked
    assert f"30 x 20 x 10 {unit}" in checked
    assert f"margins 2 {unit}\n" in checked
    assert json.loads(said(tmp_path, "check", "s.yaml", "--json"))["margins"] == [2 * SIZE[unit]]
    said(tmp_path, "run", "nearer.yaml", "-o", "n.mcap", "--log", "certificate", "-q")
    changed = said(tmp_path, "diff", "o.mcap", "n.mcap", "--ignore", "far", code=1)
    assert f"by 0.1 {unit}: 2.5 {unit} -> 2.4 {unit}" in changed
    (other,) = json.loads(said(tmp_path, "diff", "o.mcap", "n.mcap", "--ignore", "far", "--json", code=1))[
        "differences"
    ]
    assert other["change"] == pytest.approx(-0.1 * SIZE[unit])
    assert said(tmp_path, "diff", "o.mcap", "n.mcap", "--distance-tol", f"1{unit}") == "no differences: 2 pairs\n"
    page = said(tmp_path, "report", "o.mcap", "-o", "-")
    assert f"measured 2.5 {unit} apart at" in page
    assert f"<dt>margin</dt><dd><bdi>2 {unit}</bdi></dd>" in page


def test_a_margin_with_a_unit_gives_the_bytes_of_the_same_margin_in_metres(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(BALLS.format(unit="mm", way=10))
    logs = []
    for margin in ("3mm", "3 mm", "0.003", "0.3cm", "3000um"):
        said(tmp_path, "run", "s.yaml", "-o", "o.mcap", "--log", "certificate", "-q", "--margin", margin)
        logs.append((tmp_path / "o.mcap").read_bytes())
    assert set(logs) == {logs[0]}
    assert json.loads(said(tmp_path, "summary", "o.mcap", "--json"))["settings"]["margin"] == 0.003


@pytest.mark.parametrize("margin", ["3furlongs", "mm", "", "nan", "-1mm", "-1", "inf", "1e999mm"])
def test_a_bad_margin_is_refused_in_one_line(tmp_path: Path, margin: str) -> None:
    (tmp_path / "s.yaml").write_text(BALLS.format(unit="mm", way=10))
    done = closecall_inside("run", "s.yaml", "-o", "o.mcap", "--margin", margin, cwd=tmp_path)
    assert done.returncode == 2
    (error,) = [line for line in done.stderr.splitlines() if line.startswith("Error: ")]
    assert "--margin" in error
    assert not (tmp_path / "o.mcap").exists()
