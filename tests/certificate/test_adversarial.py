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


UNIX_TIME = 1_700_000_000
SPACING = 2.0**-22
"""s, of floats at that time."""

KEYS = "keys: [{t: 1700000000.5}, {t: 1700000001.5, xyz: [2, 0, 0]}, {t: 1700000002.5}]"
ONE_METRE = {  # (motion along x from 0, when it is at 1 m for the first time)
    "constant": ("{type: constant, velocity: [0.3, 0, 0], t0: %d}", 1 / 0.3),
    "ballistic": (
        "{type: ballistic, velocity: [0.1, 0, 0], acceleration: [0.2, 0, 0], t0: %d}",
        math.sqrt(10.25) - 0.5,
    ),
    "screw": ("{type: screw, axis: [1, 0, 0], rate: 1, pitch: 3, t0: %d}", 2 * math.pi / 3),
    "orbit": ("{type: orbit, axis: [0, 0, 1], start: [0, -1, 0], radius: 2, rate: 0.3, t0: %d}", math.asin(0.5) / 0.3),
    "harmonic": ("{type: harmonic, direction: [1, 0, 0], amplitude: 2, period: 20, t0: %d}", 20 / 12),
    "polynomial": (
        "{type: polynomial, coefficients: [[0, 0, 0], [0.1, 0, 0], [0.1, 0, 0]], t0: %d}",
        math.sqrt(10.25) - 0.5,
    ),
    "profile": (
        "{type: profile, kind: slide, axis: [1, 0, 0], from: 0, to: 2, max_velocity: 9, max_acceleration: 0.5, t0: %d}",
        2.0,
    ),
}


def unix_scene(motion: str, wall: float) -> str:
    """Return 4 s in Unix time, a ball that moves and a wall whose face is at first `wall` m off its surface."""
    bodies = (
        f"  ball: {{shapes: [{{sphere: 0.5}}], motion: {motion}}}\n"
        f"  wall: {{pose: {{xyz: [{wall + 1.0}, 0, 0]}}, shapes: [{{box: [1, 9, 9]}}]}}\n"
    )
    return scene(bodies, start=UNIX_TIME, end=UNIX_TIME + 4, extra="settings: {contact_tolerance: 2e-5}")


def assert_touches_at(events: list[dict[str, Any]], seconds: float) -> None:
    begin = next(event for event in events if event["phase"] == "BEGIN")
    assert begin["time_clear"] - UNIX_TIME - SPACING <= seconds <= begin["time_touching"] - UNIX_TIME + SPACING


@pytest.mark.parametrize("kind", ONE_METRE)
def test_a_motion_with_a_clock_of_its_own_touches_in_unix_time_when_it_truly_does(tmp_path, kind):
    motion, seconds = ONE_METRE[kind]
    assert_touches_at(run(unix_scene(motion % UNIX_TIME, 1.0), tmp_path), seconds)


@pytest.mark.parametrize("kind", ONE_METRE)
def test_bodies_ten_metres_apart_are_clear_in_unix_time(tmp_path, kind):
    """Rounding was once taken as if the motion's own clock had run since 1970."""
    assert run(unix_scene(ONE_METRE[kind][0] % UNIX_TIME, 10.0), tmp_path) == []
    assert verdicts(tmp_path) == {"CLEAR"}


def test_keyframes_in_unix_time_touch_when_they_truly_do(tmp_path):
    found = run(unix_scene(f"{{type: keyframes, {KEYS}, before: hold, after: hold}}", 1.0), tmp_path)
    assert_touches_at(found, 1.0)


def test_a_loop_in_unix_time_touches_each_time_as_well_as_its_ends_are_floats(tmp_path):
    motion = f"{{type: keyframes, {KEYS}, before: hold, after: loop}}"
    (tmp_path / "scene.yaml").write_text(unix_scene(motion, 1.0))
    assert closecall("run", "scene.yaml", "-o", "out.mcap", cwd=tmp_path).returncode == 0
    found = [event["time_touching"] - UNIX_TIME for event in read_log(tmp_path / "out.mcap").of("collisions")]
    assert found == pytest.approx([1.0, 2.0, 3.0], abs=2e-5 + 2 * SPACING)
