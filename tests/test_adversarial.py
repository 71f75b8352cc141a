"""Scenes that once broke the certificate or were made to: each held against its closed form and the oracle."""

import math
from pathlib import Path
from typing import Any

import pytest
from cli_process import closecall

from oracle.check import check_log
from oracle.logs import read_log

HEAD = "closecall: 1\nunits: {length: %s, angle: rad}\ntime: {start: %s, end: %s}\n%s\nbodies:\n"
BOX = "shapes: [{box: [1, 1, 1]}]"


def scene(bodies: str, start: float = 0, end: float = 1, length: str = "m", extra: str = "") -> str:
    return HEAD % (length, start, end, extra) + bodies


def run(text: str, folder: Path) -> list[dict[str, Any]]:
    """Run a scene, hold its log against the oracle, and return its collisions."""
    (folder / "scene.yaml").write_text(text)
    done = closecall("run", "scene.yaml", "-o", "out.mcap", "--log", "certificate", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert check_log(folder / "scene.yaml", folder / "out.mcap") == []
    return list(read_log(folder / "out.mcap").of("collisions"))


def begins(collisions: list[dict[str, Any]]) -> list[float]:
    return [event["time_touching"] for event in collisions if event["phase"] == "BEGIN"]


def verdicts(folder: Path) -> set[str]:
    return {span["verdict"] for span in read_log(folder / "out.mcap").of("spans")}


def test_a_bead_dipping_into_a_tenth_of_a_millimetre_block_is_not_missed(tmp_path):
    """FCL skips the faces of such small triangles unless it is given larger lengths."""
    bodies = (
        "  block: {shapes: [{box: [0.1, 0.1, 0.1]}]}\n"
        "  bead: {pose: {xyz: [-0.01, 0.03, 0.1]}, shapes: [{sphere: 0.01}], "
        "motion: {type: harmonic, direction: [0, 0, 1], amplitude: 0.0425, period: 0.3}}\n"
    )
    first = (math.pi + math.asin(0.04 / 0.0425)) / (2 * math.pi) * 0.3
    assert begins(run(scene(bodies, length="mm"), tmp_path)) == pytest.approx(
        [first, first + 0.3, first + 0.6], abs=1e-6
    )


def test_a_glitch_of_a_nanosecond_does_not_make_a_body_at_rest_touch(tmp_path):
    keys = "[{t: 0}, {t: 1000}, {t: 1000.000000001, xyz: [1, 0, 0]}, {t: 1001, xyz: [1, 0, 0]}]"
    bodies = (
        f"  robot: {{shapes: [{{box: [0.01, 0.01, 0.01]}}], motion: {{type: keyframes, keys: {keys}}}}}\n"
        "  wall: {pose: {xyz: [0, 0.011, 0]}, shapes: [{box: [0.01, 0.01, 0.01]}]}\n"
    )
    assert run(scene(bodies, end=1001, extra="settings: {time_resolution: 1}"), tmp_path) == []


def test_a_glitch_after_the_end_changes_nothing(tmp_path):
    keys = "[{t: 0}, {t: 3600}, {t: 3600.000000001, xyz: [1000, 0, 0]}]"
    bodies = (
        f"  robot: {{{BOX}, motion: {{type: keyframes, keys: {keys}}}}}\n  wall: {{pose: {{xyz: [0, 3, 0]}}, {BOX}}}\n"
    )
    assert run(scene(bodies, end=3600, extra="settings: {time_resolution: 1}"), tmp_path) == []
    assert verdicts(tmp_path) == {"CLEAR"}


def test_boxes_face_to_face_that_slide_apart_part_where_their_edges_pass(tmp_path):
    bodies = f"  a: {{{BOX}}}\n  b: {{{BOX}, motion: {{type: constant, velocity: [0, 0, 0.5]}}}}\n"
    (begin, end) = run(scene(bodies, end=4), tmp_path)
    assert begin["time_touching"] == 0.0
    assert end["time_touching"] == pytest.approx(2.0, abs=1e-6)


@pytest.mark.parametrize("offset", [1e6, 5e6])
def test_a_contact_far_from_the_origin_is_bracketed_like_one_near_it(tmp_path, offset):
    bodies = (
        f"  a: {{pose: {{xyz: [{offset}, {offset}, 0]}}, {BOX}, motion: {{type: constant, velocity: [1, 0, 0]}}}}\n"
        f"  b: {{pose: {{xyz: [{offset + 3}, {offset}, 0]}}, {BOX}}}\n"
    )
    assert begins(run(scene(bodies, end=3), tmp_path)) == pytest.approx([2.0], abs=1e-6)


def test_counter_rotating_parent_and_child_leave_the_child_at_rest_in_the_world(tmp_path):
    bodies = (
        "  arm: {shapes: [{box: [4, 0.1, 0.1]}], motion: {type: constant, angular_velocity: [0, 0, 3]}}\n"
        f"  tool: {{parent: arm, pose: {{xyz: [2, 0, 1]}}, {BOX}, "
        "motion: {type: constant, angular_velocity: [0, 0, -3]}}\n"
        f"  post: {{pose: {{xyz: [-2, 0, 1]}}, {BOX}}}\n"
    )
    # The tool keeps its orientation on a circle of radius 2; past x = -1 it meets the post when 2 sin(angle) = 1.
    found = run(scene(bodies, end=1.2), tmp_path)
    first = next(event for event in found if event["pair"] == "tool|post")
    assert first["time_touching"] == pytest.approx((math.pi - math.asin(0.5)) / 3, abs=1e-6)


def test_a_chattering_contact_costs_no_more_wakeups_than_its_brackets_need(tmp_path):
    bodies = (
        "  fan: {shapes: [{sphere: 0.01, pose: {xyz: [1, 0, 0]}}], "
        "motion: {type: constant, angular_velocity: [0, 0, 2500]}}\n"
        "  wall: {pose: {xyz: [1.05, 0, 0]}, shapes: [{box: [0.1, 0.5, 0.5]}]}\n"
    )
    found = run(scene(bodies, end=0.2), tmp_path)
    wakeups = len(list(read_log(tmp_path / "out.mcap").of("wakeups")))
    assert len(begins(found)) > 50
    assert wakeups / len(found) < 100
