"""Samples of what flies: asteroids, satellites, a drone on a recorded path."""

from __future__ import annotations

import runpy
from itertools import combinations, product
from math import acos, cos, degrees, radians, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from sample_runs import changes, is_bracketed, is_enclosed, least_distance, sample_of
from scene_files import load

from oracle.rigid import FloatArray

ROCKS_IN_CONTACT = {
    ("rock_02", "rock_07"): (7.839678, 12.207831),
    ("rock_05", "rock_08"): (6.484187, 12.059900),
    ("rock_06", "rock_11"): (7.008282, 11.571490),
}
"""s, as sampling gives them here."""


def test_three_pairs_of_asteroids_collide_when_sampling_says() -> None:
    rocks = sample_of("asteroids")
    assert rocks.pairs_with("contact") == {"|".join(pair) for pair in ROCKS_IN_CONTACT}
    for pair, (begin, end) in ROCKS_IN_CONTACT.items():
        assert rocks.says(f"{pair[0]} and {pair[1]} in contact from {begin:.6f} s to {end:.6f} s")
        times = np.linspace(begin - 0.5, end + 0.5, 300)
        sampled = changes(rocks.truth, pair, times)
        assert sampled == pytest.approx([begin, end], abs=6e-7)
        (contact,) = rocks.pair("|".join(pair))["contacts"]
        assert is_bracketed(contact["begin"], sampled[0])
        assert is_bracketed(contact["end"], sampled[1])


def test_two_near_misses_of_asteroids_are_the_nearest_of_all_clear_pairs() -> None:
    rocks = sample_of("asteroids")
    nearest, when = least_distance(rocks.truth, ("rock_01", "rock_09"), 7.0, 8.0, 51)
    second, then = least_distance(rocks.truth, ("rock_07", "rock_10"), 16.5, 18.0, 51)
    assert rocks.says(f"by {nearest:.5f} m at {when:.4f} s")
    assert rocks.says(f"by {second:.3f} m at {then:.3f} s")
    assert is_enclosed(rocks.pair("rock_01|rock_09"), nearest)
    assert is_enclosed(rocks.pair("rock_07|rock_10"), second)
    times = np.linspace(0.0, 20.0, 1001)
    for pair in combinations(rocks.truth.names, 2):
        if pair in ROCKS_IN_CONTACT:
            continue
        assert rocks.pair("|".join(pair))["verdict"] == "clear"
        poses = rocks.truth.kinematics.relative(*pair, times)
        reach = sum(rocks.truth.surfaces[name].extent for name in pair)
        step = float(rocks.truth.steps(*pair, poses).max())
        near = np.linalg.norm(poses[:, :3, 3], axis=1) < reach + second + step
        least = {("rock_01", "rock_09"): nearest}.get(pair, second)
        if near.any():
            assert rocks.truth.signed(*pair, times[near]).min() >= least


ORBIT, HALF_ANGLE, AHEAD = 7000e3, radians(12.0), radians(0.03)
"""Of mapper and weather: the radius (m), half the angle between their planes, and how far one is ahead, rad."""

CROSSING_RATE = radians(0.06176529)
"""rad/s of both."""


def centres_apart(s: FloatArray | float) -> FloatArray:
    """Return how far (m) the centres of mapper and weather are apart, s (rad) as in the header."""
    return np.sqrt(
        2.0 * ORBIT**2 * (1.0 - cos(HALF_ANGLE) ** 2 * cos(AHEAD) - sin(HALF_ANGLE) ** 2 * np.cos(np.asarray(s)))
    )


def test_two_satellites_break_the_keep_out_distance_when_the_closed_form_says() -> None:
    sky, pair = sample_of("satellites"), ("mapper", "weather")
    assert sky.says("sqrt(2 r^2 (1 - cos(i/2)^2 cos e - sin(i/2)^2 cos s)) apart, s = 2 n t less the 140.03 degrees")
    assert sky.says("planes i = 98 - 74 = 24 degrees apart, and one is e = 0.03 degrees ahead of the other")
    times = np.linspace(1100.0, 1160.0, 601)
    apart = centres_apart(2.0 * CROSSING_RATE * times - radians(140.03)) - 20.0
    np.testing.assert_allclose(sky.truth.signed(*pair, times), apart, rtol=0.0, atol=0.05)  # axes have 9 digits
    least = 2.0 * ORBIT * cos(HALF_ANGLE) * sin(AHEAD / 2.0) - 20.0
    assert sky.says("this is least at s = 0, as 2 r cos(i/2) sin(e/2), from which the two radii of 10 m go off")
    when = radians(140.03) / (2.0 * CROSSING_RATE)
    rest = 1.0 - cos(HALF_ANGLE) ** 2 * cos(AHEAD) - 5020.0**2 / (2.0 * ORBIT**2)
    half = acos(rest / sin(HALF_ANGLE) ** 2) / (2.0 * CROSSING_RATE)
    assert sky.says(f"breach of the 5 km from {when - half:.4f} s to {when + half:.4f} s")
    assert sky.says(f"the least distance {least:.2f} m at {when:.4f} s")
    assert sky.says("which two of them break for two seconds")
    told = sky.pair("|".join(pair))
    assert (told["verdict"], told["contacts"]) == ("breach", [])
    found = changes(sky.truth, pair, times, 5000.0)
    assert found == pytest.approx([when - half, when + half], abs=1e-5)
    assert told["breaches"] == [pytest.approx(found, abs=1e-8)]
    assert is_enclosed(told, least_distance(sky.truth, pair, 1133.0, 1134.0, 51)[0])
    assert sky.pairs_with("breach") == {"|".join(pair)}
    assert not sky.pairs_with("contact")


def test_the_relay_passes_both_by_kilometres() -> None:
    sky = sample_of("satellites")
    for name, other in (("mapper", "relay"), ("weather", "relay")):
        least, when = least_distance(sky.truth, (name, other), 1100.0, 1160.0, 601)
        assert sky.says(f"{name} and {other}: clear, by {1e-3 * least:.3f} km at {when:.3f} s")
        assert is_enclosed(sky.pair(f"{name}|{other}"), least)


def test_the_cubesat_is_let_go_fifty_metres_below_the_station_and_checked_from_then_on() -> None:
    sky, pair = sample_of("satellites"), ("station", "cubesat")
    least = 60 - 5 - 5
    assert sky.says(f"station and cubesat: clear, by {least} m when the cubesat is let go at 1120 s")
    sampled = sky.truth.signed(*pair, np.linspace(1120.0, 1160.0, 401))
    assert sampled.min() == pytest.approx(least, abs=1e-7)
    assert sampled.argmin() == 0 or sampled[0] == pytest.approx(sampled.min(), abs=1e-7)
    assert sky.pair("|".join(pair))["verdict"] == "clear"
    assert is_enclosed(sky.pair("|".join(pair)), float(sampled.min()))
    assert min(span["start"] for span in sky.log.by_pair("spans")["|".join(pair)]) == 1120.0


def test_the_station_is_on_the_other_side_of_the_earth() -> None:
    sky, now = sample_of("satellites"), np.array([1130.0])
    assert sky.says("all other pairs clear: the station is on the other side of the Earth")
    for one, other in product(("station", "cubesat"), ("mapper", "weather", "relay")):
        assert sky.pair(f"{one}|{other}")["verdict"] == "clear"
        assert sky.truth.signed(one, other, now)[0] > 6.371e6


def test_each_satellite_flies_as_gravity_sets() -> None:
    sky = sample_of("satellites")
    assert sky.says("the rate that gravity sets for its radius (398600.44 km^3/s^2)")
    for body in sky.truth.scene["bodies"].values():
        orbit = body["motion"]
        rate = degrees(sqrt(398600.44e9 / orbit["radius"] ** 3))
        assert orbit["rate"] == pytest.approx(rate, abs=6e-9)
        assert orbit["start"] == [1, 0, 0]
        assert orbit["radius"] - 6378e3 > 400e3
    assert sky.says("The Earth is left out: all fly more than 400 km above it")


def test_the_satellites_are_as_small_as_goes_without_a_warning(tmp_path: Path) -> None:
    sky = sample_of("satellites")
    assert sky.says("floating point has 1e-9 m left there. Anything below 7 m in size would be warned of")
    assert np.spacing(7e6) == pytest.approx(1e-9, rel=0.1)
    text = sky.path.read_text(encoding="utf-8")
    assert load(tmp_path, text).warnings == ()
    (warned,) = load(tmp_path, text.replace("shapes: [{sphere: 10}]", "shapes: [{sphere: 3.4}]", 1)).warnings
    assert "times its smallest shape" in warned


POLES = (("pole_1", 1.0, 2.0), ("pole_2", 4.0, 5.0), ("window", 5.5, 6.5), ("floor", 3.0, 4.5), ("pole_3", 7.0, 8.0))
"""What the drone passes, and between which times, s."""


def test_the_drone_passes_poles_window_and_floor_as_near_as_sampling_says() -> None:
    flight = sample_of("drone_from_tum")
    assert flight.says("The margin is 0.3 m")
    for name, low, high in POLES:
        least, when = least_distance(flight.truth, ("drone", name), low, high, 101)
        digits = 4 if name == "floor" else 5
        if name == "pole_3":
            assert flight.says(f"the least distance {least:.5f} m at {when:.3f} s; no contact")
        else:
            assert flight.says(f"drone and {name}: clear, by {least:.{digits}f} m at {when:.3f} s")
            assert flight.pair(f"drone|{name}")["verdict"] == "clear"
        assert is_enclosed(flight.pair(f"drone|{name}"), least)
        assert flight.truth.signed("drone", name, np.linspace(0.0, 10.0, 201)).min() >= least


def test_the_drone_breaches_its_margin_beside_the_last_pole_a_tenth_of_a_millisecond_early() -> None:
    flight, pair = sample_of("drone_from_tum"), ("drone", "pole_3")
    begin, end = changes(flight.truth, pair, np.linspace(7.0, 8.0, 51), 0.3)
    assert flight.says(f"drone and pole_3: breach, from {begin:.4f} s to {end:.4f} s")
    told = flight.pair("|".join(pair))
    assert (told["verdict"], told["contacts"]) == ("breach", [])
    ((early, late),) = told["breaches"]
    assert flight.says(f"closecall is up to {1e3 * told['chord_error']:.2f} mm on the safe side")
    assert flight.says(f"and so begins the breach {1e3 * (begin - early):.1f} ms early")
    assert early < begin < end < late
    assert late - end == pytest.approx(begin - early, abs=1e-5)
    assert flight.pairs_with("breach") == {"|".join(pair)}
    assert not flight.pairs_with("contact")


def test_the_path_between_the_drones_poses_is_near_the_formulas_that_they_come_from() -> None:
    flight = sample_of("drone_from_tum")
    rows = (flight.path.parent / "slalom.tum").read_text(encoding="ascii").splitlines()[1:]
    assert flight.says(f"slalom.tum has {len(rows)} poses, 20 a second")
    place = runpy.run_path(str(flight.path.parent / "make_trajectory.py"))["place"]
    times = np.linspace(0.0, 10.0, 4001)
    path = flight.truth.kinematics.local("drone", times)[:, :3, 3]
    off = np.linalg.norm(path - [place(time) for time in times], axis=1).max()
    assert flight.says(f"the interpolated one is within {1e3 * off:.2f} mm of it")
