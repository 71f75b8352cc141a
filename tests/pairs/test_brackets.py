"""Brackets of least distances that are wide say so everywhere, with why and what helps; those that hold are tight."""

from __future__ import annotations

import json
import re
from math import cos, hypot, pi, sin
from pathlib import Path

import numpy as np
import pytest
from cli_process import closecall_inside
from rewritten_logs import rewrite

from benchmarks.mechanisms import Mechanism, engine, geneva
from closecall.formats.log import messages_pb2 as pb
from closecall.scheduler.geometry.round_solid import RoundSolid
from closecall.scheduler.pairs import least_distance as minimum


def told_of(mechanism: Mechanism, folder: Path) -> tuple[dict, str]:
    """Run a mechanism; return by pair what its summary tells of joints, and the table."""
    done = closecall_inside("run", mechanism.scene, "-o", "out.mcap", "--log", "certificate", cwd=folder)
    assert done.returncode == 0, done.stderr
    summary = json.loads(closecall_inside("summary", "out.mcap", "--json", cwd=folder).stdout)
    return {pair["pair"]: pair for pair in summary["pairs"] if pair["pair"] in mechanism.apart}, done.stdout


def test_the_joints_of_an_engine_keep_their_gaps_and_that_is_known_to_one_hundredth(tmp_path):
    mechanism = engine(tmp_path, 1, 0.01)
    told, _ = told_of(mechanism, tmp_path)
    assert told.keys() == mechanism.apart.keys()
    for name, apart in mechanism.apart.items():
        distance = told[name]["distance"]
        assert told[name]["verdict"] == "clear"
        assert distance["bracket"] == "tight"
        assert distance["lower"] <= apart
        assert distance["upper"] == pytest.approx(apart, abs=2e-6)  # straight between keys


def test_a_geneva_pin_whose_least_distance_is_not_found_says_so_in_every_output(tmp_path, monkeypatch):
    monkeypatch.setattr(minimum, "MOST_MEASUREMENTS", 60)
    monkeypatch.setattr(minimum, "RESERVE", 40)
    mechanism = geneva(tmp_path, 0.4)
    told, table = told_of(mechanism, tmp_path)
    distance, apart = told["driver|wheel"]["distance"], mechanism.apart["driver|wheel"]
    assert 0.0 < distance["lower"] <= apart <= distance["upper"] * (1.0 + 1e-9)
    assert distance["upper"] - distance["lower"] > 0.01 * distance["upper"]
    assert (distance["bracket"], distance["why"]) == ("wide", "search")
    assert distance["help"]
    why = "the search needs more measurements than a pair may take"
    assert re.search(r"^driver \| wheel +clear +\S+ \.\. \S+ m at \S+ s, wide +$", table, re.MULTILINE)
    assert f"wide: the bracket is wider than 1% or 1e-6 m: {why}; {distance['help']}" in table
    closecall_inside("report", "out.mcap", "-o", "page.html", cwd=tmp_path)
    page = (tmp_path / "page.html").read_text()
    assert page.count(f"ide bracket: {why}; {distance['help']}") == 2


def test_a_least_distance_that_is_known_is_not_called_wide(tmp_path):
    mechanism = geneva(tmp_path, 0.39)
    told, table = told_of(mechanism, tmp_path)
    distance, apart = told["driver|wheel"]["distance"], mechanism.apart["driver|wheel"]
    assert distance["bracket"] == "tight"
    assert 0.99 * apart - 1e-6 <= distance["lower"] <= apart
    assert "wide" not in table.replace("wheel", "")


EDGE = pi / 64.0
"""rad: there two facets of the polyhedron around a cylinder meet."""

DISC = """\
closecall: 1
units: {length: m, angle: rad}
time: {start: 0, end: 1}
bodies:
  disc: {shapes: [{cylinder: {radius: 1, length: 0.2}}, {box: [0.1, 0.1, 2]}]}
"""


@pytest.mark.parametrize(
    ("place", "direction", "least", "stands_out"),
    [
        ((0.3, 0.0, 0.2), (0.0, 0.0, 1.0), 0.02, 0.0),  # above the flat face
        ((0.15, 0.0, 0.6), (1.0, 0.0, 0.0), 0.02, 0.0),  # beside the box, far from the cylinder
        ((1.15, 0.0, 0.0), (1.0, 0.0, 0.0), 0.07, 0.0),  # beside the middle of a facet
        ((1.02 * cos(EDGE), 1.02 * sin(EDGE), 0.2), (0.0, 0.0, 1.0), None, 1.3e-3),  # above an edge of two
        ((1.08 * cos(EDGE), 1.08 * sin(EDGE), 0.0), (0.0, 0.0, 1.0), 0.03, 1.3e-3),  # beside an edge of two
    ],
)
def test_only_a_round_shape_that_is_near_widens_the_bracket_and_by_no_more_than_it_stands_out(
    tmp_path, place, direction, least, stands_out
):
    """A ball of 0.05 m goes to and fro by 0.03 m beside a disc with a box through its middle."""
    ball = (
        f"  ball: {{pose: {{xyz: {list(place)}}}, shapes: [{{sphere: 0.05}}], "
        f"motion: {{type: harmonic, direction: {list(direction)}, amplitude: 0.03, period: 1}}}}\n"
    )
    (tmp_path / "scene.yaml").write_text(DISC + ball)
    closecall_inside("run", "scene.yaml", "-o", "out.mcap", "--log", "certificate", cwd=tmp_path)
    (pair,) = json.loads(closecall_inside("summary", "out.mcap", "--json", cwd=tmp_path).stdout)["pairs"]
    distance = pair["distance"]
    if least is None:  # the ball comes down to 0.07 m above the rim
        least = hypot(0.02, 0.07) - 0.05
    assert distance["lower"] <= least <= distance["upper"] + 1e-12
    assert least - distance["lower"] <= stands_out + 0.01 * least
    assert distance["upper"] - least <= 0.01 * least + 1e-6
    assert (distance["bracket"], distance["why"]) == (("wide", "polyhedra") if stands_out else ("tight", None))


BALLS = """closecall: 1
units: {length: m, angle: deg}
time: {start: 0, end: 0.5}
bodies:
  one: {shapes: [{ellipsoid: [1, 1, 1]}]}
  other:
    pose: {xyz: [2.02, 0.1, 0.05]}
    shapes: [{ellipsoid: [1, 1, 1]}]
    motion: {type: harmonic, direction: [0, 1, 0], amplitude: 0.01, period: 1}
"""


def older(channel, message):
    """Leave out of a message what logs did not say before."""
    kinds = {"/distances": (pb.Distance, "excess"), "/spans": (pb.Span, "error")}
    if channel.topic in kinds:
        kind, name = kinds[channel.topic]
        said = kind.FromString(message.data)
        said.ClearField(name)
        message.data = said.SerializeToString()
    return [message]


def test_what_an_older_log_says_of_round_bodies_is_not_read_as_less_than_they_are_apart(tmp_path):
    (tmp_path / "scene.yaml").write_text(BALLS)
    closecall_inside("run", "scene.yaml", "-o", "new.mcap", "--log", "certificate", cwd=tmp_path)
    rewrite(tmp_path / "new.mcap", tmp_path / "old.mcap", older, attachments=False)
    apart = hypot(2.02, 0.1, 0.05) - 2.0
    for log in ("new.mcap", "old.mcap"):
        (pair,) = json.loads(closecall_inside("summary", log, "--json", cwd=tmp_path).stdout)["pairs"]
        distance = pair["distance"]
        assert distance["lower"] <= apart <= distance["upper"] <= apart + pair["chord_error"]
        assert (distance["bracket"], distance["why"]) == ("wide", "polyhedra")


def test_a_point_that_a_round_solid_holds_is_inside_by_its_own_equation():
    rng = np.random.default_rng(1)
    for _ in range(300):
        a, b, c = rng.uniform(0.1, 2.0, 3).tolist()
        point = tuple((rng.normal(size=3) * rng.choice((0.1, 1.0, 3.0))).tolist())
        x, y, z = RoundSolid(axes=(a, b, c)).held(point)
        assert (x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2 <= 1.0 + 1e-15 * 8
        for low, high in ((a, a), (a, 0.0)):
            x, y, z = RoundSolid((low, high), c).held(point)
            assert abs(z) <= c
            assert np.hypot(x, y) <= (low * (c - z) + high * (c + z)) / (2.0 * c) + 1e-15
    inside = (0.1 * sin(pi / 3), 0.05, -0.02)
    assert RoundSolid((1.0, 1.0), 0.5).held(inside) == inside
    assert RoundSolid(axes=(1.0, 1.0, 0.5)).held(inside) == inside
