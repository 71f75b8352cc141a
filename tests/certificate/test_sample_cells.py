"""Samples of machines at work: an arm, a gripper of many shapes, a conveyor's gate, a gantry mill."""

from __future__ import annotations

import subprocess
import sys
from itertools import combinations, pairwise
from math import cos, hypot, radians, sqrt
from pathlib import Path

import numpy as np
import pytest
from sample_runs import (
    changes,
    has_contacts,
    is_bracketed,
    is_enclosed,
    least_distance,
    least_value,
    sample_of,
)


def test_the_fingers_grip_the_part_when_their_closing_speed_says() -> None:
    arm = sample_of("arm_pick")
    grip = 3.0 + (32.0 - 20.0) / 25.0
    assert arm.says(f"3 + (32 - 20) / 25 = {grip:.2f} s")
    assert arm.pairs_with("contact") == {"part|left_finger", "part|right_finger"}
    for finger in ("left_finger", "right_finger"):
        (contact,) = arm.pair(f"part|{finger}")["contacts"]
        assert is_bracketed(contact["begin"], grip)
        assert contact["end"] is None
        assert changes(arm.truth, ("part", finger), np.linspace(3.0, 3.6, 301)) == pytest.approx([grip], abs=1e-12)


def test_the_fingers_pass_over_the_bracket_by_the_height_of_the_wrist_over_it() -> None:
    arm = sample_of("arm_pick")
    wrist = 200.0 + 400.0 + 400.0 * cos(radians(120.0))
    least = 1e-3 * (wrist - 140.0 - 252.0)
    assert arm.says(f"400 cos 120 = {wrist:.0f} mm")
    assert arm.says(f"by exactly {1e3 * least:.0f} mm")
    for finger in ("left_finger", "right_finger"):
        pair = "bracket", finger
        assert arm.pair("|".join(pair))["verdict"] == "clear"
        assert is_enclosed(arm.pair("|".join(pair)), least)
        assert least_distance(arm.truth, pair, 0.0, 3.6, 721)[0] == pytest.approx(least, abs=1e-12)


def test_the_forearm_passes_under_the_hanger_as_near_as_sampling_says() -> None:
    arm = sample_of("arm_pick")
    least, when = least_distance(arm.truth, ("hanger", "forearm"), 0.0, 3.6, 721)
    assert arm.says(f"by {1e3 * least:.3f} mm at {when:.4f} s")
    assert arm.pair("hanger|forearm")["verdict"] == "clear"
    assert is_enclosed(arm.pair("hanger|forearm"), least)


def test_only_pairs_at_a_joint_are_ignored_each_with_its_reason() -> None:
    arm = sample_of("arm_pick")
    assert all(rule["reason"] for rule in arm.truth.scene["pairs"]["ignore"])
    moving = ["base", "turret", "upper_arm", "forearm", "gripper"]
    joints = [*pairwise(moving), ("gripper", "left_finger"), ("gripper", "right_finger")]
    fixed = ["table", "base", "bracket", "pallet", "part"]
    every = set(combinations(arm.truth.names, 2)) - set(combinations(fixed, 2)) - set(joints)
    assert {pair["pair"] for pair in arm.summary["pairs"]} == {"|".join(pair) for pair in every}


def test_the_gripper_touches_two_pegs_each_with_the_shape_that_the_header_names() -> None:
    gripper = sample_of("compound_gripper")
    reach = sqrt(11.0**2 - 9.0**2)
    assert gripper.says("with radii of 6 and 5 mm, and the peg is 9 mm beside the finger's way")
    assert gripper.says("they touch within sqrt(11^2 - 9^2) mm of x = 300")
    side = (300.0 - reach) / 200.0, (300.0 + reach) / 200.0
    assert gripper.says(f"side_peg: contact from {side[0]:.6f} s to {side[1]:.6f} s, shape 2, the left finger")
    assert gripper.says(
        f"Its tip is {136 - 120} mm below the peg's top, where the cone's radius is 10 x 16 / 40 = 4 mm"
    )
    assert gripper.says("the peg reaches from x = 490 to 510")
    square = (490.0 - 4.0) / 200.0, (510.0 + 4.0) / 200.0
    assert gripper.says(f"square_peg: contact from {square[0]:.2f} s to {square[1]:.2f} s, shape 4, the probe")
    assert gripper.pairs_with("contact") == {"gripper|side_peg", "gripper|square_peg"}
    for peg, times, shape in (("side_peg", side, 2), ("square_peg", square, 4)):
        assert has_contacts(gripper.pair(f"gripper|{peg}"), [times])
        sampled = changes(gripper.truth, ("gripper", peg), np.linspace(0.0, 5.0, 501))
        assert sampled == pytest.approx(times, abs=1e-9)
        told = gripper.log.by_pair("collisions")[f"gripper|{peg}"]
        assert [event["phase"] for event in told] == ["BEGIN", "END"]
        assert {event["shape_a"] for event in told} == {shape}


def test_the_gripper_passes_the_other_pegs_and_the_rack_as_near_as_their_sizes_say() -> None:
    gripper = sample_of("compound_gripper")
    beside, under, below = 58 - 40 - 6 - 5, (200 - 80) - (56 + 46 + 8), 200 - 75 - 35 - 6
    assert gripper.says(f"far_peg: clear, by exactly {beside} mm, as the right finger goes by: 58 - 40 - 6 - 5")
    assert gripper.says(f"low_peg: clear, by exactly {under} mm at {150 / 200:.2f} s, from the probe's tip")
    assert gripper.says(f"rack: clear, by {below} mm, below the fingers")
    for body, least in (("far_peg", beside), ("low_peg", under), ("rack", below)):
        assert gripper.pair(f"gripper|{body}")["verdict"] == "clear"
        assert is_enclosed(gripper.pair(f"gripper|{body}"), 1e-3 * least)
        sampled = gripper.truth.signed("gripper", body, np.linspace(0.0, 5.0, 201))
        assert sampled.min() == pytest.approx(1e-3 * least, abs=1e-12)


def test_the_gripper_is_one_object_to_the_scheduler_however_many_shapes_it_has() -> None:
    gripper = sample_of("compound_gripper")
    assert gripper.says("A gripper of five shapes")
    assert len(gripper.truth.scene["bodies"]["gripper"]["shapes"]) == 5
    others = [name for name in gripper.truth.names if name != "gripper"]
    assert [pair["pair"] for pair in gripper.summary["pairs"]] == [f"gripper|{name}" for name in others]


GATE = ("gate", "parcel_2")


def shut_by(since: float) -> float:
    """Return how far (mm) the gate has come down some time (s) after it starts."""
    acceleration, speed, way = 6400.0, 1600.0, 640.0
    ramp = speed / acceleration
    whole = way / speed + ramp
    since = min(max(since, 0.0), whole)
    if since < ramp:
        return 0.5 * acceleration * since**2
    if since > whole - ramp:
        return way - 0.5 * acceleration * (whole - since) ** 2
    return speed * (since - 0.5 * ramp)


def gate_distance(time: float, start: float) -> float:
    """Return how far (mm) the gate's lower edge is from the parcel's upper one, given when the gate starts (s)."""
    return hypot(max(500.0 * time - 1760.0, 0.0), max(450.0 - shut_by(time - start), 0.0))


def gate_least(start: float) -> tuple[float, float]:
    """Return the least distance (mm) of gate and parcel, and its time, s."""
    return least_value(lambda time: gate_distance(time, start), 3.52, 3.9)


def test_the_gate_comes_down_behind_the_parcel_as_near_as_its_profile_says() -> None:
    belt = sample_of("conveyor_gate")
    assert belt.says("500 t - 1760 mm apart along the belt and 450 - s mm in height")
    assert belt.says("starts at 3.24 s, speeds up by 6400 mm/s^2 to 1600 mm/s and stops after 640 mm")
    least, when = gate_least(3.24)
    assert belt.says(f"gate and parcel_2: {least:.3f} mm at {when:.4f} s is the least")
    sampled, then = least_distance(belt.truth, GATE, 0.0, 6.0, 601)
    assert (1e3 * sampled, then) == (pytest.approx(least, abs=1e-6), pytest.approx(when, abs=1e-6))
    assert is_enclosed(belt.pair("|".join(GATE)), 1e-3 * least)


def test_the_gate_may_start_no_earlier_than_the_header_says(tmp_path: Path) -> None:
    belt = sample_of("conveyor_gate")
    text = belt.path.read_text(encoding="utf-8")
    assert text.count("      t0: 3.24\n") == 1
    sooner, soonest = gate_least(3.22)[0], gate_least(3.20)[0]
    assert belt.says(f"At 3.22 s it would still keep the margin, with {sooner:.3f} mm; at 3.20 s it would come to")
    assert belt.says(f"{soonest:.3f} mm, and the run would say breach")
    for start, code in (("3.22", 0), ("3.20", 1)):
        scene = tmp_path / f"{start}.yaml"
        scene.write_text(text.replace("t0: 3.24", f"t0: {start}"), encoding="utf-8")
        options = ["--log", "certificate", "--fail-on", "breach", "-q", "-o", str(tmp_path / f"{start}.mcap")]
        done = subprocess.run([sys.executable, "-m", "closecall", "run", str(scene), *options], check=False)
        assert done.returncode == code


def test_the_parcels_pass_what_stands_beside_the_belt_and_keep_their_distance() -> None:
    belt = sample_of("conveyor_gate")
    assert belt.says("`--fail-on breach,contact,unresolved` exits with 0")
    assert {pair["verdict"] for pair in belt.summary["pairs"]} == {"clear"}
    eye = 330 - 20 - 30 - 150, 330 - 15 - 220
    posts = 370 - 30 - 150, 370 - 30 - 220
    assert belt.says(f"photo_eye and parcels: {eye[0]} and {eye[1]} mm, exactly, as each goes by")
    assert belt.says(f"gate_posts and parcels: {posts[0]} and {posts[1]} mm")
    for body, distances in (("photo_eye", eye), ("gate_posts", posts)):
        for parcel, least in zip(("parcel_1", "parcel_2"), distances, strict=True):
            assert is_enclosed(belt.pair(f"{body}|{parcel}"), 1e-3 * least)
            sampled = belt.truth.signed(body, parcel, np.linspace(0.0, 6.0, 301)).min()
            assert sampled == pytest.approx(1e-3 * least, abs=1e-12)


def test_two_parcels_on_one_belt_sleep_through() -> None:
    belt, pair = sample_of("conveyor_gate"), "parcel_1|parcel_2"
    apart = (600 - 200) - (-100 + 150)
    assert belt.says(f"parcel_1 and parcel_2: {apart} mm at all times")
    assert belt.says("is measured at the start and at the end, and sleeps in between")
    sampled = belt.truth.signed("parcel_1", "parcel_2", np.linspace(0.0, 6.0, 61))
    np.testing.assert_allclose(sampled, 1e-3 * apart, rtol=0.0, atol=1e-12)
    assert belt.pair(pair)["wakeups"] == 2
    assert [(one["reason"], one["sleep"]) for one in belt.log.by_pair("wakeups")[pair]] == [
        ("START", 6.0),
        ("END", 0.0),
    ]


def test_the_tool_is_in_contact_from_the_works_edge_until_it_is_lifted_out() -> None:
    mill, pair = sample_of("gantry"), ("workpiece", "tool")
    assert mill.says("has 32 mm to the workpiece: 0.1 s and 5 mm to speed up, then 27 mm at 100 mm/s")
    assert (550 - 110) - (400 + 8) == 32
    begin = 1.6 + 100.0 / 1000.0 + (32.0 - 0.5 * 1000.0 * 0.1**2) / 100.0
    end = 3.7 + sqrt(2.0 * 6.0 / 3000.0)
    assert mill.says(f"workpiece and tool: contact from {begin:.2f} s to {end:.6f} s. The tool, 8 mm in radius")
    assert mill.says("after 6 mm upwards, sqrt(2 x 6 / 3000) s after 3.7 s")
    assert has_contacts(mill.pair("|".join(pair)), [(begin, end)])
    times = np.concatenate([np.linspace(0.0, 1.99, 200), np.linspace(3.74, 5.0, 127)])
    assert changes(mill.truth, pair, times) == pytest.approx([begin, end], abs=1e-9)
    assert mill.pairs_with("contact") == {"|".join(pair)}
    assert mill.says("one contact, the cut, and no breach, so that `--fail-on breach,unresolved` exits with 0")
    assert mill.pairs_with("clear") == {one["pair"] for one in mill.summary["pairs"]} - {"|".join(pair)}


def test_tool_and_holder_pass_between_and_over_the_clamps_by_seven_millimetres() -> None:
    mill = sample_of("gantry")
    between, over = 15 - 8, 95 - 88
    assert mill.says(f"clamps and tool: clear, by exactly {between} mm on either side: 15 - 8")
    assert mill.says(f"clamps and quill: clear, by exactly {over} mm, from the bolts' heads at z = 88 to the tool")
    assert (75 + 5 + 8, 200 - 150 + 67.5 - 22.5) == (88, 95)
    for body, least in (("tool", between), ("quill", over)):
        assert is_enclosed(mill.pair(f"clamps|{body}"), 1e-3 * least)
        sampled, _ = least_distance(mill.truth, ("clamps", body), 0.0, 5.0, 101)
        assert sampled == pytest.approx(1e-3 * least, abs=1e-10)


def rest_to_rest(since: float, acceleration: float, speed: float) -> float:
    """Return how far (mm) an axis is some time (s) after it starts, before it brakes."""
    ramp = speed / acceleration
    return 0.5 * acceleration * since**2 if since < ramp else speed * (since - 0.5 * ramp)


def jaw_distance(time: float) -> float:
    """Return how far (mm) the rising tool's end is from the jaw's edge at a time, s, until the tool is over it."""
    back, up = rest_to_rest(time - 3.8, 2500.0, 500.0), rest_to_rest(time - 3.7, 3000.0, 300.0)
    return hypot(max(92.0 - back, 0.0), 90.0 - up)


def test_the_tool_clears_the_jaw_on_its_way_back_as_near_as_the_profiles_say() -> None:
    mill = sample_of("gantry")
    assert mill.says("When y has come back by s and z up by h, these are 92 - s mm apart in y and 90 - h mm in z")
    assert (200 - 8 - (80 + 20), 140 - (200 - 150)) == (92, 90)
    least, at = least_value(jaw_distance, 3.95, 4.1)
    assert mill.says(f"stop and tool: clear, by {least:.4f} mm at {at:.4f} s")
    sampled, when = least_distance(mill.truth, ("stop", "tool"), 0.0, 5.0, 201)
    assert (1e3 * sampled, when) == (pytest.approx(least, abs=1e-6), pytest.approx(at, abs=1e-6))
    assert is_enclosed(mill.pair("stop|tool"), 1e-3 * least)
    risen = 3.7 + 150.0 / 300.0 + 300.0 / 3000.0
    assert mill.says("3.8 s y back, before z has come up: this saves half a second")
    assert risen - 3.8 == pytest.approx(0.5)
