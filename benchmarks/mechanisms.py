"""Joints that keep a small gap while they move: an engine, a Geneva drive and a pair of gears.

`python -m benchmarks.mechanisms` runs them and prints what each took, and how well the least distance of each joint is
known, beside its true one. `--quick` takes a fraction of a turn.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from math import asin, atan2, cos, pi, sin
from pathlib import Path
from shutil import copy
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import trimesh

from .command import run_command
from .scene_file import write_scene_file
from .table import HEAD, Row

GEARS = Path(__file__).parents[1] / "sample_scenes" / "near_gears" / "scene.yaml"
GEARS_APART = 0.120575e-3
"""m, found by sampling the two outlines in the plane; see the sample's comment."""

THROW, ROD, RATE = 0.04, 0.13, 20.0 * pi
"""m, of the crank's pin and between a rod's ends; rad/s, 600 turns a minute."""
PISTON, PISTON_GAP = 0.04, 50e-6
PIN, PIN_GAP = 0.015, 30e-6
FACETS = 24
BETWEEN_CYLINDERS = 0.1

WHEEL_APART, SLOT_GAP, FOLLOWER = 0.1, 50e-6, 0.006
"""m, between the axes of a Geneva drive with four slots; between its pin and a slot's wall; the pin's radius."""

Bodies = dict[str, dict[str, Any]]


class Mechanism(NamedTuple):
    """A scene, and the true least distance (m) of its joints by their pairs' names."""

    scene: Path
    apart: dict[str, float]


def prism(radius: float, length: float, bore: float = 0.0) -> trimesh.Trimesh:
    """Return a regular prism along x about the origin, m, with a bore of the same facets; radii are those of edges."""
    angles = 2.0 * pi * np.arange(FACETS) / FACETS
    ring = np.column_stack((np.zeros(FACETS), np.cos(angles), np.sin(angles)))
    here, there = np.arange(FACETS), np.roll(np.arange(FACETS), -1)
    end = np.array((length / 2, 0.0, 0.0))
    corners = np.vstack([ring * size + side for size in (radius, bore) for side in (-end, end)])
    quads = [(0, 1), (1, 3), (3, 2), (2, 0)] if bore else [(0, 1), (1, 3), (2, 0)]
    faces = []
    for one, other in quads:
        a, b, c, d = here + one * FACETS, there + one * FACETS, there + other * FACETS, here + other * FACETS
        faces += [np.column_stack((a, b, c)), np.column_stack((a, c, d))]
    made = trimesh.Trimesh(corners, np.vstack(faces), process=True)
    made.update_faces(made.nondegenerate_faces())
    return made


def engine(folder: Path, cylinders: int, turns: float, keys: int = 360) -> Mechanism:
    """Write an engine: rods on one crank, whose pistons run in cylinders without ever touching.

    Pistons and rods go by `keys` keys a turn, straight from each to the next.
    """
    edge = 1.0 / cos(pi / FACETS)
    prism(PISTON * edge, 0.05).export(folder / "piston.stl")
    prism(0.05, 0.2, (PISTON + PISTON_GAP) * edge).export(folder / "cylinder.stl")
    prism(0.03, 0.02, (PIN + PIN_GAP) * edge).export(folder / "eye.stl")
    seconds = turns * 2.0 * pi / RATE
    times = np.arange(int(np.ceil(turns * keys)) + 2) * (2.0 * pi / RATE / keys)
    pins, block, apart = [], [], {}
    bodies: Bodies = {"crank": {"motion": {"type": "constant", "angular_velocity": [0, 0, RATE]}}}
    for index in range(cylinders):
        z, phase, name = index * BETWEEN_CYLINDERS, index * pi, f"_{index}"
        at = [THROW * cos(phase), THROW * sin(phase), z]
        pins.append({"capsule": {"radius": PIN, "length": 0.03}, "pose": {"xyz": at}})
        block.append({"mesh": "cylinder", "pose": {"xyz": [ROD, 0, z]}})
        ways = [_crank(RATE * time + phase) for time in times.tolist()]
        bodies["piston" + name] = {
            "shapes": [{"mesh": "piston"}],
            "motion": {
                "type": "keyframes",
                "keys": [{"t": t, "xyz": [x, 0, z]} for t, (x, _) in zip(times.tolist(), ways, strict=True)],
            },
        }
        bodies["rod" + name] = {
            "shapes": [
                {"mesh": "eye", "pose": {"rpy": [0, pi / 2, 0]}},
                {"box": [0.05, 0.012, 0.012], "pose": {"xyz": [0.055, 0, 0]}},
            ],
            "motion": {"type": "keyframes", "keys": _rod_keys(times, phase, z)},
        }
        apart |= {f"piston{name}|block": PISTON_GAP, f"crank|rod{name}": PIN_GAP}
    bodies["crank"]["shapes"] = pins
    bodies["block"] = {"shapes": block}
    meshes = {name: {"file": f"{name}.stl"} for name in ("piston", "cylinder", "eye")}
    return Mechanism(write_scene_file(folder / "engine.json", seconds, meshes, bodies), apart)


def _crank(angle: float) -> tuple[float, float]:
    """Return how far (m) from the crank's axis a piston is, and how its rod leans (rad), at an angle of the crank."""
    lean = asin(-THROW * sin(angle) / ROD)
    return THROW * cos(angle) + ROD * cos(lean), lean


def _rod_keys(times: np.ndarray, phase: float, z: float) -> list[dict[str, Any]]:
    """Return the keys of a rod, whose origin is the middle of its crank pin."""
    keys = []
    for time in times.tolist():
        angle = RATE * time + phase
        at = [THROW * cos(angle), THROW * sin(angle), z]
        keys.append({"t": time, "xyz": at, "rpy": [0, 0, _crank(angle)[1]]})
    return keys


def geneva(folder: Path, turns: float, keys: int = 400) -> Mechanism:
    """Write a Geneva drive: a turning pin that moves a wheel on by its slots, a quarter each turn, without touching.

    The wheel goes by `keys` keys a turn.
    """
    reach, wall = WHEEL_APART * sin(pi / 4), 0.01
    offset = FOLLOWER + SLOT_GAP + wall / 2
    walls = [
        {"box": [0.05, wall, 0.02], "pose": {"xyz": _turned(0.043, side * offset, slot), "rpy": [0, 0, slot]}}
        for slot in np.arange(4) * pi / 2
        for side in (-1, 1)
    ]
    times = np.arange(int(np.ceil(turns * keys)) + 2) / keys
    angles = [_wheel(time, reach) for time in times.tolist()]
    pin = {"capsule": {"radius": FOLLOWER, "length": 0.014}, "pose": {"xyz": [-reach, 0, 0]}}
    bodies: Bodies = {
        "driver": {"shapes": [pin], "motion": {"type": "constant", "angular_velocity": [0, 0, 2.0 * pi]}},
        "wheel": {
            "pose": {"xyz": [WHEEL_APART, 0, 0]},
            "shapes": walls,
            "motion": {
                "type": "keyframes",
                "keys": [{"t": t, "rpy": [0, 0, angle]} for t, angle in zip(times.tolist(), angles, strict=True)],
            },
        },
    }
    scene = write_scene_file(folder / "geneva.json", turns, {}, bodies)
    return Mechanism(scene, {"driver|wheel": _slot_gap(times, angles, turns, reach)})


def _turned(x: float, y: float, angle: float) -> list[float]:
    return [x * cos(angle) - y * sin(angle), x * sin(angle) + y * cos(angle), 0.0]


def _wheel(turns: float, reach: float) -> float:
    """Return the wheel's angle (rad) after so many turns of the driver, whose pin begins on the side away from it."""
    whole, part = divmod(turns, 1.0)
    angle = 2.0 * pi * part - pi  # of the pin, from the line to the wheel's axis
    turned = pi / 4 if angle > 0.0 else -pi / 4
    if abs(angle) < pi / 4:
        turned = atan2(reach * sin(angle), WHEEL_APART - reach * cos(angle))
    return -turned - whole * pi / 2


def _slot_gap(times: np.ndarray, angles: list[float], turns: float, reach: float) -> float:
    """Return the least gap (m) between the pin and a slot's walls, sampled densely between the keys."""
    time = np.linspace(0.0, turns, 400_001)
    angle = 2.0 * pi * (time % 1.0) - pi
    inside = np.abs(angle) <= pi / 4
    x, y = reach * np.cos(angle[inside]) - WHEEL_APART, reach * np.sin(angle[inside])
    wheel = np.interp(time[inside], times, angles)
    across = y * np.cos(wheel) - x * np.sin(wheel)
    along = x * np.cos(wheel) + y * np.sin(wheel)
    across = np.where(np.abs(across) < np.abs(along), across, along)
    return float(SLOT_GAP - np.abs(across).max())


def gears(folder: Path, share: float) -> Mechanism:
    """Take the gears of the sample, for a share of their time."""
    text = GEARS.read_text().replace("end: 1.5", f"end: {1.5 * share}")
    for name in ("pinion.obj", "wheel.obj"):
        copy(GEARS.parent / name, folder)
    (folder / "gears.yaml").write_text(text)
    return Mechanism(folder / "gears.yaml", {"pinion|wheel": GEARS_APART})


def rows(share: float) -> Iterator[Row]:
    """Yield a row for each mechanism, run for a share of a turn (of the gears' 1.5 s)."""
    made: dict[str, Callable[[Path], Mechanism]] = {
        "engine": lambda folder: engine(folder, 2, share),
        "Geneva drive": lambda folder: geneva(folder, share),
        "gears": lambda folder: gears(folder, share),
    }
    for name, make in made.items():
        with TemporaryDirectory() as folder:
            mechanism = make(Path(folder))
            ran = run_command(mechanism.scene, Path(folder) / "log.mcap", "--log", "certificate", "-q")
        totals = ran.told["totals"]
        took = f"{ran.cpu:.1f} CPU s, {totals['wakeups']} wakeups, {totals['queries']['mesh']} exact queries"
        yield Row(name, took)
        for pair in ran.told["pairs"]:
            if pair["pair"] in mechanism.apart:
                distance, true = pair["distance"], mechanism.apart[pair["pair"]]
                told = f"{distance['lower']:.3g} .. {distance['upper']:.6g} m, truly {true:.6g}"
                yield Row(
                    f"{name}: `{pair['pair']}`",
                    f"{told}, {distance['bracket']}",
                    "tight",
                    distance["bracket"] == "tight",
                )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mechanisms", description=__doc__)
    parser.add_argument("--quick", action="store_true")
    print(HEAD)
    for row in rows(0.05 if parser.parse_args().quick else 1.0):
        print(row.markdown(), flush=True)


if __name__ == "__main__":
    main()
