"""Samples of mechanisms: gears, a spinning bar, balls in shells, a door and a drawer, an engine's valves."""

from __future__ import annotations

import subprocess
import sys
from math import acos, asin, atan2, cos, degrees, hypot, pi, radians, sin, sqrt, tan
from pathlib import Path

import numpy as np
import pytest
from sample_runs import (
    FOLDER,
    changes,
    crossing,
    has_contacts,
    is_bracketed,
    is_enclosed,
    least_distance,
    least_value,
    sample_of,
)

from oracle.rigid import METRES, FloatArray

INCH = METRES["in"]


def outline(path: Path, bore: float) -> FloatArray:
    """Return the teeth (n, 2) mm of a gear's mesh in order: the corners of its upper side outside the bore."""
    rows = [line.split()[1:] for line in path.read_text(encoding="ascii").splitlines() if line.startswith("v ")]
    points = np.array(rows, dtype=float)
    return points[(points[:, 2] > 0.0) & (np.hypot(points[:, 0], points[:, 1]) > bore + 1.0), :2]


def corners_from_sides(corners: FloatArray, sides: FloatArray) -> float:
    """Return the least distance between corners (n, 2) and sides (m, 2, 2)."""
    along = sides[:, 1] - sides[:, 0]
    from_start = corners[:, None] - sides[:, 0]
    share = np.clip((from_start * along).sum(axis=2) / (along**2).sum(axis=1), 0.0, 1.0)
    return float(np.linalg.norm(from_start - share[..., None] * along, axis=2).min())


def gear_distance(pinion: FloatArray, wheel: FloatArray, time: float) -> float:
    """Return how far apart, mm, the outlines are at a time, s, looking only where they can be near."""
    near = []
    for points, angle, centre, reach in (
        (pinion, 36.0 * time, 0.0, 46.0),
        (wheel, 6.0 - 24.0 * time, 100.0, 66.0),
    ):
        turn = radians(angle)
        placed = points @ np.array([[cos(turn), sin(turn)], [-sin(turn), cos(turn)]]) + [centre, 0.0]
        sides = np.stack([placed, np.roll(placed, -1, axis=0)], axis=1)
        # A point of one gear is within 2 mm of the other only inside the other's tip circle and 2 mm about it.
        other = 100.0 - centre, 112.0 - reach
        near.append(sides[(np.hypot(sides[..., 0] - other[0], sides[..., 1]) < other[1] + 3.0).any(axis=1)])
    one, two = near
    return min(corners_from_sides(one.reshape(-1, 2), two), corners_from_sides(two.reshape(-1, 2), one))


def test_the_gears_never_touch_and_come_as_near_as_sampled_outlines_do() -> None:
    gears = sample_of("near_gears")
    folder = gears.path.parent
    pinion, wheel = outline(folder / "pinion.obj", 12.0), outline(folder / "wheel.obj", 20.0)
    times = np.arange(0.0, 0.5, 5e-4)
    distances = np.array([gear_distance(pinion, wheel, time) for time in times])
    best = times[distances.argmin()]
    closer = np.linspace(best - 5e-4, best + 5e-4, 401)
    near = np.array([gear_distance(pinion, wheel, time) for time in closer])
    least, when = float(near.min()), float(closer[near.argmin()])
    assert gears.says(f"the least is {least:.6f} mm, at {when:.4f} s and again every 0.5 s")
    assert distances.max() < 0.140
    assert gear_distance(pinion, wheel, when + 1.0) == pytest.approx(least, abs=2e-6)
    assert 0.12 <= least <= 0.121
    assert gears.pairs_with("clear") == {"pinion|wheel"}
    assert gears.pairs_with("contact") == set()
    assert is_enclosed(gears.pair("pinion|wheel"), 1e-3 * least)


def test_the_flanks_of_the_gears_are_involutes_a_play_of_a_few_hundredths_of_a_module_apart() -> None:
    """On its pitch circle a pair of teeth fills the pitch but for the play, 0.12 mm a side along the line of action."""
    thicknesses = []
    for name, teeth in (("pinion", 20), ("wheel", 30)):
        points = outline(FOLDER / "near_gears" / f"{name}.obj", 12.0 if teeth == 20 else 20.0)
        base = 2.0 * teeth * cos(radians(20.0))
        flank = points[np.hypot(*points.T) > base - 1e-5][:8]
        roll = np.sqrt(np.maximum((np.hypot(*flank.T) / base) ** 2 - 1.0, 0.0))
        half = np.abs(np.arctan2(flank[:, 1], flank[:, 0])) + roll - np.arctan(roll)
        assert np.ptp(half) < 1e-5  # an involute starts at one angle from its base circle
        thicknesses.append(2.0 * 2.0 * teeth * (half.mean() - (tan(radians(20.0)) - radians(20.0))))
    play = (pi * 4.0 - sum(thicknesses)) * cos(radians(20.0))
    assert play == pytest.approx(2.0 * 0.12, abs=1e-4)


def bar_times() -> tuple[float, float]:
    """Return when, s, the bar meets the outer cubes and leaves them; its turn in rad is the time."""
    x, y = 9.5 * cos(0.12), 9.5 * sin(0.12)
    near, far = (x + 0.1, y - 0.1), (x - 0.1, y + 0.1)
    return (
        atan2(near[1], near[0]) - asin(0.1 / hypot(*near)),
        atan2(far[1], far[0]) + asin(0.1 / hypot(*far)),
    )


def test_the_spinning_bar_meets_and_leaves_the_outer_cubes_when_the_closed_form_says() -> None:
    bar = sample_of("spinning_bar")
    begin, end = bar_times()
    assert bar.says(f"contact from {begin:.8f} s to {end:.8f} s")
    (contact,) = bar.pair("bar|posts")["contacts"]
    assert is_bracketed(contact["begin"], begin)
    assert is_bracketed(contact["end"], end)
    assert changes(bar.truth, ("bar", "posts"), np.linspace(0.0, 0.5, 1001)) == pytest.approx([begin, end], abs=1e-12)


def literal_sleep(distance: float, speed: float, acceleration: float) -> float:
    """Return the lecture's formula as it is printed, s."""
    return (sqrt(speed**2 + 2.0 * acceleration * distance) - speed) / acceleration


def test_the_literal_formula_sleeps_past_the_strike_of_the_spinning_bar() -> None:
    bar = sample_of("spinning_bar")
    begin, end = bar_times()
    distance = float(bar.truth.signed("bar", "posts", np.zeros(1))[0])
    assert distance == pytest.approx(0.5)
    slow, fast = 0.1, hypot(0.1, 0.1)
    assert bar.says(f"d / v = {distance / slow:.0f} s ({distance / fast:.2f} s)")
    early, late = sorted(literal_sleep(distance, speed, 10.0) for speed in (slow, fast))
    assert bar.says(f"{late:.4f} s ({early:.4f} s)")
    assert end < early
    awake = bar.truth.signed("bar", "posts", np.array([early, late]))
    assert [f"{clear:.2f}" for clear in awake] == ["0.44", "0.44"]
    assert bar.says("wakes 0.44 m clear")
    tip = hypot(10.0, 0.1)
    sound = literal_sleep(distance, tip, tip)
    assert bar.says(f"at {tip:.4f} m/s")
    assert bar.says(f"sleeps for {sound:.4f} s")
    assert sound < begin


def test_the_swallowed_ball_is_contained_though_its_surface_stays_far_from_the_casings() -> None:
    shell = sample_of("ball_in_shell")
    pair = "solid_casing", "swallowed_ball"
    assert shell.pairs_with("contact") == {"|".join(pair)}
    assert shell.pair("|".join(pair))["contacts"] == [{"begin": [0.0, 0.0], "end": None, "keys": {}}]
    (begin,) = shell.log.of("collisions")
    assert (begin["pair"], begin["phase"], begin["kind"]) == ("|".join(pair), "BEGIN", "CONTAINED")
    times = np.linspace(0.0, 4.0, 401)
    assert shell.says("never come within 62 mm")
    assert shell.truth.surface_distance(*pair, times).min() > 0.062
    assert shell.truth.signed(*pair, times).max() < 0.0


def test_the_rattling_ball_comes_within_two_millimetres_of_the_pocket_and_is_clear() -> None:
    shell = sample_of("ball_in_shell")
    least = 50.0 - 20.0 - 0.8 * 35.0
    assert shell.says(f"50 - 28 - 20 = {least:.0f} mm")
    assert shell.says("At 0.5, 1.5, 2.5 and 3.5 s")
    pair = "hollow_casing", "rattling_ball"
    assert shell.pair("|".join(pair))["verdict"] == "clear"
    assert is_enclosed(shell.pair("|".join(pair)), 1e-3 * least)
    sampled = shell.truth.signed(*pair, np.array([0.5, 1.5, 2.5, 3.5]))
    np.testing.assert_allclose(sampled, 1e-3 * least, rtol=0.0, atol=1e-12)
    assert shell.truth.signed(*pair, np.linspace(0.0, 4.0, 401)).min() >= 1e-3 * least - 1e-12


def test_the_knob_knocks_the_bumper_while_their_middles_are_two_inches_apart_or_less() -> None:
    kitchen = sample_of("door_and_drawer")
    radius, pair = hypot(1.5, 21.5), ("door", "bumper")
    assert kitchen.says(f"sqrt(1.5^2 + 21.5^2) = {radius:.3f} in, on which the bumper's middle lies at 98.5 degrees")
    turn = np.exp(-1j * radians(98.5)) * (-1.5 - 21.5j)
    assert kitchen.truth.scene["bodies"]["bumper"]["shapes"][0]["pose"]["xyz"] == pytest.approx(
        [34.0 + turn.real, 25.0 + turn.imag, 15.0], abs=1e-6
    )
    angle = 98.5 - degrees(2.0 * asin(1.0 / radius))
    assert kitchen.says(f"2 in or less: from {angle:.3f} degrees on")
    begin = acos(1.0 - angle / 48.0) / pi  # the door is open by 48 (1 - cos(pi t)) degrees
    assert kitchen.says(f"door and bumper: three contacts, from {begin:.6f} s to {2.0 - begin:.6f} s and every 2 s")
    expected = [(begin + 2.0 * k, 2.0 - begin + 2.0 * k) for k in range(3)]
    found = changes(kitchen.truth, pair, np.linspace(0.0, 6.0, 601))
    assert found == pytest.approx([time for contact in expected for time in contact], abs=1e-7)
    assert has_contacts(kitchen.pair("door|bumper"), [(found[k], found[k + 1]) for k in (0, 2, 4)])


def test_the_drawer_strikes_the_bin_whenever_it_is_out_far_enough() -> None:
    kitchen = sample_of("door_and_drawer")
    out = 17.5 - 1.9
    assert kitchen.says("is 1.9 in before the drawer's, the bin 17.5 in before the shut drawer: they touch while the")
    assert kitchen.says(f"drawer is {out:.1f} in out or more")
    begin = 1.5 * acos(1.0 - out / 9.0) / (2.0 * pi)  # it is out by 9 (1 - cos(2 pi t / 1.5)) in
    assert kitchen.says(f"drawer and bin: four contacts, from {begin:.6f} s to {1.5 - begin:.6f} s and every 1.5 s")
    expected = [(begin + 1.5 * k, 1.5 - begin + 1.5 * k) for k in range(4)]
    assert has_contacts(kitchen.pair("drawer|bin"), expected)
    found = changes(kitchen.truth, ("drawer", "bin"), np.linspace(0.0, 6.0, 601))
    assert found == pytest.approx([time for contact in expected for time in contact], abs=1e-9)


def test_the_drawer_and_the_door_meet_four_times_when_sampling_says() -> None:
    kitchen = sample_of("door_and_drawer")
    found = changes(kitchen.truth, ("drawer", "door"), np.linspace(0.0, 6.0, 601))
    (first, *others), last = [(found[i], found[i + 1]) for i in range(0, 6, 2)], found[6:]
    said = ", ".join(f"{begin:.6f} s to {end:.6f} s" for begin, end in [first, *others])
    assert kitchen.says(f"drawer and door: four contacts, from {said} and {last[0]:.6f} s to {last[1]:.6f} s")
    assert has_contacts(kitchen.pair("drawer|door"), [first, *others, (last[0], last[1])])


def test_the_door_passes_the_bin_and_the_wall() -> None:
    kitchen = sample_of("door_and_drawer")
    beside = 26.0 - hypot(24.0, 1.25)
    assert kitchen.says(f"bin and door: clear, by {beside:.5f} in. The bin's side is 26 in from the hinge")
    assert kitchen.says("the door's far edge sqrt(24^2 + 1.25^2) in")
    sampled, _ = least_distance(kitchen.truth, ("bin", "door"), 0.0, 2.0, 201)
    assert sampled == pytest.approx(beside * INCH, abs=1e-9)
    assert is_enclosed(kitchen.pair("bin|door"), beside * INCH)
    behind, when = least_distance(kitchen.truth, ("door", "wall"), 0.0, 2.0, 201)
    assert kitchen.says(f"door and wall: clear, by {behind / INCH:.5f} in at {when:.0f} s")
    assert is_enclosed(kitchen.pair("door|wall"), behind)
    touching = {"door|bumper", "drawer|bin", "drawer|door"}
    assert (kitchen.pairs_with("contact"), kitchen.pairs_with("breach")) == (touching, set())


CRANK, ROD = 43.0, 145.0
"""mm: the crank's radius and the rod's length."""


def pin(time: float) -> float:
    """Return how high (mm) the piston's pin is above the crank's axis at a time, ms: 10 degrees of crank each."""
    turn = radians(10.0 * time)
    return CRANK * cos(turn) + sqrt(ROD**2 - (CRANK * sin(turn)) ** 2)


def valve_distance(time: float, shut: float, wide: float) -> float:
    """Return how far (mm) a valve is from the piston at a time, ms, given when it is shut and when wide open."""
    u = min(max((time - shut) / (wide - shut), 0.0), 1.0)
    return 219.0 - 9.0 * u**2 * (3.0 - 2.0 * u) - (pin(time) + 29.0)


def intake(time: float) -> float:
    return valve_distance(time, 33.5, 46.0)


def exhaust(time: float) -> float:
    return valve_distance(time, 37.2, 25.2)


def test_the_intake_valve_breaches_its_margin_when_the_crank_drive_says() -> None:
    engine, pair = sample_of("piston_crank"), ("intake_valve", "piston")
    assert engine.says("219 - lift - (pin + 29) mm, where the pin is 43 cos a + sqrt(145^2 - (43 sin a)^2) mm")
    assert engine.says("the lift goes from 0 to 9 mm as 9 u^2 (3 - 2 u)")
    least, when = least_value(intake, 35.0, 37.5)
    begin, end = crossing(intake, 36.0, when, 1.0), crossing(intake, when, 38.0, 1.0)
    assert engine.says(f"breach of the margin of 1 mm from {begin:.3f} ms to {end:.3f} ms")
    assert engine.says(f"that is {10 * begin - 360:.1f} to {10 * end - 360:.1f} degrees after top dead centre")
    assert engine.says(f"The least distance is {least:.3f} mm, at {when:.2f} ms. They do not touch")
    found = changes(engine.truth, pair, np.linspace(0.0355, 0.0375, 41), 1e-3)
    nearest, then = least_distance(engine.truth, pair, 0.0355, 0.0375, 41)
    assert (f"{1e3 * found[0]:.3f}", f"{1e3 * found[1]:.3f}") == (f"{begin:.3f}", f"{end:.3f}")
    assert (f"{1e3 * nearest:.3f}", f"{1e3 * then:.2f}") == (f"{least:.3f}", f"{when:.2f}")
    told = engine.pair("|".join(pair))
    assert (told["verdict"], told["contacts"]) == ("breach", [])
    assert told["breaches"] == [pytest.approx(found, abs=1e-9)]
    assert is_enclosed(told, nearest)
    assert engine.pairs_with("breach") == {"|".join(pair)}


def test_the_exhaust_valve_and_the_head_keep_their_margins_from_the_piston() -> None:
    engine = sample_of("piston_crank")
    least, when = least_value(exhaust, 35.0, 37.0)
    assert engine.says(f"exhaust_valve and piston: clear, by {least:.3f} mm at {when:.2f} ms; the margin is 1.5 mm")
    nearest, then = least_distance(engine.truth, ("exhaust_valve", "piston"), 0.0345, 0.0375, 41)
    assert (f"{1e3 * nearest:.3f}", f"{1e3 * then:.2f}") == (f"{least:.3f}", f"{when:.2f}")
    assert is_enclosed(engine.pair("exhaust_valve|piston"), nearest)
    top = 219.0 - (CRANK + ROD + 30.0)
    assert engine.says(f"head and piston: clear, by exactly {top:.0f} mm at each top dead centre; the margin is 0.8 mm")
    tops = engine.truth.signed("head", "piston", np.array([0.0, 0.036, 0.072]))
    np.testing.assert_allclose(tops, 1e-3 * top, rtol=0.0, atol=1e-12)
    assert is_enclosed(engine.pair("head|piston"), 1e-3 * top)
    assert not engine.pairs_with("contact")


def test_the_oil_jet_and_the_counterweights_are_passed_as_near_as_sampling_says() -> None:
    engine = sample_of("piston_crank")
    jet, when = least_distance(engine.truth, ("oil_jet", "rod"), 0.004, 0.009, 26)
    again, later = least_distance(engine.truth, ("oil_jet", "rod"), 0.040, 0.045, 26)
    assert engine.says(f"oil_jet and rod: clear, by {1e3 * jet:.4f} mm at {1e3 * when:.3f} ms and again one turn later")
    assert engine.says("; the margin is 2 mm")
    assert (again, later) == pytest.approx((jet, when + 0.036), abs=1e-9)
    assert is_enclosed(engine.pair("oil_jet|rod"), jet)
    web, then = least_distance(engine.truth, ("crank", "piston"), 0.019, 0.023, 26)
    other, before = least_distance(engine.truth, ("crank", "piston"), 0.013, 0.017, 26)
    assert engine.says(
        f"crank and piston: clear, by {1e3 * web:.4f} mm at {1e3 * before:.3f} ms and {1e3 * then:.3f} ms"
    )
    assert other == pytest.approx(web, abs=1e-9)
    assert is_enclosed(engine.pair("crank|piston"), web)
    for pair, least in ((("oil_jet", "rod"), jet), (("crank", "piston"), web)):
        assert engine.truth.signed(*pair, np.linspace(0.0, 0.072, 361)).min() >= least - 1e-12


def test_the_keys_of_piston_and_rod_are_those_of_the_closed_form_and_close_to_it_in_between() -> None:
    engine = sample_of("piston_crank")
    printed = subprocess.run(
        [sys.executable, str(engine.path.parent / "make_keys.py")], capture_output=True, text=True, check=True
    ).stdout
    for rows in printed.split("# rod"):
        assert rows.replace("# piston", "").strip() in engine.path.read_text(encoding="utf-8")
    times = np.linspace(0.0, 0.036, 3601)
    heights = 1e3 * engine.truth.kinematics.local("piston", times)[:, 2, 3]
    turns = np.degrees(np.arctan2(*np.moveaxis(engine.truth.kinematics.local("rod", times)[:, [0, 2], 2], 0, 1)))
    turned = np.degrees(-np.arcsin(CRANK * np.sin(np.radians(1e4 * times)) / ROD))
    assert engine.says("In between, the piston is within 0.00022 mm of it, and the rod within 0.068 degrees")
    assert 0.00021 < np.abs(heights - [pin(1e3 * time) for time in times]).max() <= 0.00022
    assert 0.067 < np.abs(turns - turned).max() <= 0.068
