"""Bodies of a micrometre and less, places 5e6 m away, orbits, Unix time: true verdicts, or refused in one line.

Each scene is run by the command line and held against the oracle and against its closed form in exact fractions of the
numbers as floats, or in extended precision.
"""

from fractions import Fraction
from math import isqrt
from pathlib import Path

import numpy as np
import pytest
from cli_process import closecall

from oracle.check import check_log
from oracle.logs import Log, read_log

HEAD = "closecall: 1\nunits: {length: m, angle: rad}\ntime: {start: %r, end: %r}\n%sbodies:\n"
FAR = 5e6
UNIX_TIME = 1_700_000_000
WIDE = np.longdouble


def run(folder: Path, bodies: str, start: float = 0, end: float = 2, settings: str = "") -> Log:
    """Run a scene, hold its log against the oracle, and return it."""
    (folder / "scene.yaml").write_text(HEAD % (start, end, settings) + bodies)
    done = closecall("run", "scene.yaml", "-o", "out.mcap", "--log", "certificate", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert check_log(folder / "scene.yaml", folder / "out.mcap") == []
    return read_log(folder / "out.mcap")


def refusal(folder: Path, bodies: str, start: float = 0, end: float = 2, settings: str = "") -> str:
    """Return the one line that refuses a scene."""
    (folder / "scene.yaml").write_text(HEAD % (start, end, settings) + bodies)
    done = closecall("run", "scene.yaml", "-o", "out.mcap", cwd=folder)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert not (folder / "out.mcap").exists()
    return line


def verdicts(log: Log) -> list[str]:
    return [span["verdict"] for span in log.of("spans")]


def nearest(log: Log) -> float:
    return min(distance["distance"] for distance in log.of("distances"))


def assert_clear(log: Log, truth: float, error: float) -> None:
    """Hold a pair that is always clear to its true least distance (m), known to within `error` (m)."""
    assert verdicts(log) == ["CLEAR"]
    (span,) = log.of("spans")
    assert 0.0 < span["clearance"] <= truth
    assert truth - error <= nearest(log)


def root(square: Fraction) -> Fraction:
    """Return a square root, to 1e-40."""
    return Fraction(isqrt(int(square * 10**80)), 10**40)


class Passing:
    """Two spheres of one radius, one at rest, one that passes by along z; their closed form."""

    def __init__(self, radius: float, gap: float, speed: float, far: float = 0.0, parent: str = "") -> None:
        self.radius, self.speed = radius, speed
        beside, self.below = far + (2 * radius + gap), -speed
        self.offset = Fraction(beside) - Fraction(far)
        shapes, above = f"shapes: [{{sphere: {radius!r}}}]", f"parent: {parent}, " if parent else ""
        self.bodies = (
            f"  a: {{{above}pose: {{xyz: [{far!r}, {far!r}, {self.below!r}]}}, {shapes}, "
            f"motion: {{type: constant, velocity: [0, 0, {speed!r}]}}}}\n"
            f"  b: {{{above}pose: {{xyz: [{beside!r}, {far!r}, 0]}}, {shapes}}}\n"
        )

    @property
    def gap(self) -> float:
        """The least distance, m."""
        return float(self.offset - 2 * Fraction(self.radius))

    def touch(self, error: float) -> Fraction:
        """Return when the distance first is `error`, s."""
        square = (2 * Fraction(self.radius) + Fraction(error)) ** 2 - self.offset**2
        return (-Fraction(self.below) - root(square)) / Fraction(self.speed)


@pytest.mark.parametrize(
    ("radius", "gap", "speed"),
    [(5e-7, 1e-7, 1e-4), (5e-10, 1e-10, 1e-7), (5e-15, 1e-15, 1e-12), (5e-7, 1e-12, 1e-4), (5e6, 1e-6, 1e3)],
)
def test_spheres_of_any_size_that_pass_apart_are_clear(tmp_path, radius, gap, speed):
    passing = Passing(radius, gap, speed)
    assert_clear(run(tmp_path, passing.bodies), passing.gap, 4e-14 * radius)


def test_micrometre_spheres_that_pass_apart_at_five_thousand_kilometres_are_clear(tmp_path):
    passing = Passing(5e-7, 1e-7, 1e-4, FAR)
    assert_clear(run(tmp_path, passing.bodies), passing.gap, 1e-7)


@pytest.mark.parametrize("gap", [-1e-7, -9e-7])
def test_micrometre_spheres_touch_when_they_do_to_what_the_place_is_known_to(tmp_path, gap):
    """At 5e6 m the error is below 1e-7 m, and what is told as the time of contact is that of such a gap at most."""
    passing = Passing(5e-7, gap, 1e-4, FAR)
    log = run(tmp_path, passing.bodies)
    assert verdicts(log) == ["CLEAR", "CONTACT", "CLEAR"]
    begin = next(event for event in log.of("collisions") if event["phase"] == "BEGIN")
    assert passing.touch(1e-7) <= Fraction(begin["time_touching"])
    assert Fraction(begin["time_clear"]) <= passing.touch(0.0)


EARTH = (
    "  earth: {pose: {xyz: [5.0e+6, -5.0e+6, 5.0e+6], rpy: [0.3, 0.2, 0.1]}, "
    "motion: {type: constant, velocity: [465, 0, 0], angular_velocity: [0, 0, 1]}}\n"
)


@pytest.mark.parametrize("gap", [1e-7, 1e-12])
def test_a_far_common_parent_costs_nothing(tmp_path, gap):
    passing = Passing(5e-7, gap, 1e-4, parent="earth")
    assert_clear(run(tmp_path, EARTH + passing.bodies), passing.gap, 1e-19)


def test_under_a_far_common_parent_a_contact_is_bracketed_by_the_tolerance(tmp_path):
    passing = Passing(5e-7, -1e-9, 1e-4, parent="earth")
    log = run(tmp_path, EARTH + passing.bodies)
    begin = next(event for event in log.of("collisions") if event["phase"] == "BEGIN")
    assert Fraction(begin["time_clear"]) <= passing.touch(0.0) <= Fraction(begin["time_touching"])


BEAD = (
    "  slab: {shapes: [{box: [1.0e+6, 1.0e+6, 1.0e+6]}]}\n"
    "  bead: {pose: {xyz: [1000.123, 2000.7, %r]}, shapes: [{%s}], motion: {type: constant, velocity: [%r, 0, %r]}}\n"
)


@pytest.mark.parametrize("shape", ["sphere: 5.0e-7", "box: [1.0e-6, 1.0e-6, 1.0e-6]"])
def test_a_micrometre_over_a_slab_of_a_thousand_kilometres_is_clear(tmp_path, shape):
    height = 500000.0000006
    truth = float(Fraction(height) - 500_000 - Fraction(5e-7))
    log = run(tmp_path, BEAD % (height, shape, 1.0, 0.0))
    assert_clear(log, truth, 2e-8)
    assert log.of("spans")[0]["clearance"] > truth - 1e-7


def test_a_micrometre_lands_on_a_slab_of_a_thousand_kilometres_when_it_does(tmp_path):
    height, speed = 500000.0001, -1e-4
    log = run(tmp_path, BEAD % (height, "sphere: 5.0e-7", 1.0, speed))
    gap = Fraction(height) - 500_000 - Fraction(5e-7)
    begin = next(event for event in log.of("collisions") if event["phase"] == "BEGIN")
    assert (gap - Fraction(1e-7)) / Fraction(-speed) <= Fraction(begin["time_touching"])
    assert Fraction(begin["time_clear"]) <= gap / Fraction(-speed)


def test_boxes_a_tenth_of_a_picometre_large_are_measured_like_others(tmp_path):
    """FCL skips their faces unless it is given larger lengths still."""
    log = run(
        tmp_path,
        "  block: {shapes: [{box: [1.0e-13, 1.0e-13, 1.0e-13]}]}\n"
        "  bead: {pose: {xyz: [-1.0e-14, 3.0e-14, 1.0e-13]}, shapes: [{sphere: 1.0e-14}], "
        "motion: {type: harmonic, direction: [0, 0, 1], amplitude: 4.25e-14, period: 0.3}}\n",
        end=0.3,
    )
    first = (np.pi + np.arcsin(0.04 / 0.0425)) / (2 * np.pi) * 0.3
    assert [event["time_touching"] for event in log.of("collisions") if event["phase"] == "BEGIN"] == [
        pytest.approx(first, abs=1e-6)
    ]


RADIUS, RATE = 7e6, 1.078e-3
SATELLITE = (
    "  %s: {shapes: [{%s}], motion: {type: orbit, axis: [%s], start: [1, 0, 0], radius: 7.0e+6, rate: 1.078e-3%s}}\n"
)


def apart(lag: float) -> np.longdouble:
    """Return the least distance (m) of the middles of satellites on orbits at a right angle, `lag` rad behind.

    cos(angle) = cos(u) cos(u + lag), which is greatest half-way, where both are lag / 2 from the node.
    """
    cosine_gap = 1 - np.cos(WIDE(lag) / 2) ** 2
    return WIDE(RADIUS) * np.sqrt(2 * cosine_gap)


@pytest.mark.parametrize("shape", ["sphere: 1", "sphere: 0.05"])
def test_satellites_whose_orbits_cross_pass_as_near_as_they_do(tmp_path, shape):
    lag = 5e-7
    bodies = SATELLITE % ("a", shape, "0, 0, 1", "") + SATELLITE % ("b", shape, "0, 1, 0", f", phase: {lag!r}")
    truth = float(apart(lag)) - 2 * float(shape.split()[1])
    log = run(tmp_path, bodies, end=6000)
    assert_clear(log, truth, 1e-6)
    assert log.of("spans")[0]["clearance"] > 0.97 * truth


def test_satellites_whose_orbits_cross_touch_when_they_do(tmp_path):
    """Half a metre deep, for 0.3 ms around each node."""
    lag, shape = 5e-7, "sphere: 1.5"
    bodies = SATELLITE % ("a", shape, "0, 0, 1", "") + SATELLITE % ("b", shape, "0, 1, 0", f", phase: {lag!r}")
    log = run(tmp_path, bodies, end=6000)
    touch = np.sqrt(WIDE(9) - apart(lag) ** 2) / (np.sqrt(WIDE(2)) * RADIUS * WIDE(RATE))
    for event in log.of("collisions"):
        node = round((event["time_touching"] * RATE + lag / 2) / np.pi) * np.pi
        middle = (WIDE(node) - WIDE(lag) / 2) / WIDE(RATE)
        begin = middle + (touch if event["phase"] == "END" else -touch)
        low, high = sorted((event["time_clear"], event["time_touching"]))
        assert low - 1e-9 <= begin <= high + 1e-9
    assert len(log.of("collisions")) == 4


def keyed(beside: float, shape: str) -> str:
    keys = ", ".join(f"{{t: {UNIX_TIME + t}, xyz: [{FAR + 2.5 * t!r}, {FAR!r}, 0]}}" for t in (0, 4))
    return (
        f"  a: {{shapes: [{{{shape}}}], motion: {{type: keyframes, keys: [{keys}]}}}}\n"
        f"  b: {{pose: {{xyz: [{FAR + 5.0!r}, {FAR + beside!r}, 0]}}, shapes: [{{{shape}}}]}}\n"
    )


@pytest.mark.parametrize("size", [0.1, 1.0, 10.0])
def test_keyed_boxes_far_away_in_unix_time_pass_as_near_as_they_do(tmp_path, size):
    beside = size + 1e-4
    truth = float(Fraction(FAR + beside) - Fraction(FAR) - Fraction(size))
    tolerances = "settings: {contact_tolerance: 2.0e-5, distance_tolerance: 0.1}\n"
    log = run(tmp_path, keyed(beside, f"box: [{size}, {size}, {size}]"), UNIX_TIME, UNIX_TIME + 4, tolerances)
    assert_clear(log, truth, 1e-7)


def test_keyed_boxes_far_away_in_unix_time_touch_when_they_do(tmp_path):
    """The one has 4 m to go to the other at 2.5 m/s, and leaves it after two boxes."""
    log = run(tmp_path, keyed(0.9, "box: [1, 1, 1]"), UNIX_TIME, UNIX_TIME + 4)
    assert verdicts(log) == ["CLEAR", "CONTACT", "CLEAR"]
    for event, seconds in zip(log.of("collisions"), (1.6, 2.4), strict=True):
        low, high = sorted((event["time_clear"], event["time_touching"]))
        assert low - UNIX_TIME - 1e-6 <= seconds <= high - UNIX_TIME + 1e-6


def test_spheres_smaller_than_what_their_place_is_known_to_are_refused(tmp_path):
    line = refusal(tmp_path, Passing(5e-10, 1e-10, 1e-7, FAR).bodies)
    assert line.startswith("scene.yaml:5:")
    assert ": bodies.a.shapes: rounding may misplace it by " in line
    assert line.endswith(
        " m, more than its size, 1e-09 m: move the origin, or let a parent lie near it (and 1 more body)"
    )


def test_a_parabola_that_has_been_falling_since_1970_is_refused(tmp_path):
    """So far from the origin of its time, a place is known to 75 km."""
    bodies = (
        "  a: {shapes: [{sphere: 1}], motion: {type: ballistic, acceleration: [0, 0, -9.81]}}\n"
        "  b: {pose: {xyz: [0, 0, 1000]}, shapes: [{sphere: 1}]}\n"
    )
    line = refusal(tmp_path, bodies, UNIX_TIME, UNIX_TIME + 4)
    assert ": bodies.a.motion: rounding may misplace it by 7.55e+04 m, more than its size, 2 m: " in line
    assert line.endswith("let times and t0 be nearer to 0")


def test_the_table_tells_unix_time_to_the_microsecond(tmp_path):
    (tmp_path / "scene.yaml").write_text(
        HEAD % (UNIX_TIME, UNIX_TIME + 4, "") + keyed(0.9, "sphere: 0.5").replace(f"{FAR + 5.0!r}", f"{FAR + 4.9!r}")
    )
    told = closecall("run", "scene.yaml", "-o", "out.mcap", cwd=tmp_path).stdout
    assert "1 pair over [1700000000, 1700000004] s" in told
    assert "1700000001.785" in told  # (4.9 - sqrt(1 - 0.9^2)) / 2.5 = 1.7856
