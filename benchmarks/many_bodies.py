"""How a run grows with the number of bodies: rocks 2 m wide of 320 triangles (4 models), at one density, for 5 s.

`python -m benchmarks.many_bodies 100 1000 10000` writes each scene, runs the installed command on it with `--rate 0`,
and prints what the child took, what it found, and the exponents of growth between the first scene and the last.
`--apart M` says how much room a rock has: a cube of so many metres, 10 if not given. What else is given goes to the
command: `python -m benchmarks.many_bodies 1000 --broad-phase off`.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import log
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import trimesh
from mcap.reader import make_reader

from .command import run_command
from .scene_file import write_scene_file
from .table import Row

SECONDS = 5.0
MODELS = 4


def motion(rng: np.random.Generator) -> dict[str, Any]:
    """Return one of five laws, at about 1 m/s."""
    velocity, other, turning = (vector.round(6).tolist() for vector in rng.normal(0.0, 0.6, (3, 3)))
    kind = int(rng.integers(5))
    if kind == 0:
        return {"type": "constant", "velocity": velocity, "angular_velocity": turning}
    if kind == 1:
        return {"type": "ballistic", "velocity": velocity, "acceleration": (0.2 * np.array(other)).tolist()}
    if kind == 2:
        return {"type": "harmonic", "direction": velocity, "amplitude": 1.0, "period": round(rng.uniform(4, 8), 6)}
    if kind == 3:
        return {"type": "orbit", "axis": [0, 0, 1], "start": [1, 0, 0], "radius": 2.0, "rate": round(rng.normal(), 6)}
    places = np.cumsum(rng.normal(0.0, 0.6, (6, 3)), axis=0).round(6).tolist()
    return {"type": "keyframes", "keys": [{"t": float(t), "xyz": place} for t, place in enumerate(places)]}


def write_scene(bodies: int, folder: Path, apart: float) -> Path:
    """Write a scene of so many rocks, the same each time, in a cube of constant density; return its file."""
    rng = np.random.default_rng(0)
    for model in range(MODELS):
        ball = trimesh.creation.icosphere(subdivisions=2)
        ball.vertices *= rng.uniform(0.7, 1.0, (len(ball.vertices), 1))
        ball.export(folder / f"rock_{model}.stl")
    half = 0.5 * apart * bodies ** (1.0 / 3.0)
    rocks = {}
    for index in range(bodies):
        place = rng.uniform(-half, half, 3).round(6).tolist()
        shapes = [{"mesh": f"rock_{index % MODELS}"}]
        rocks[f"rock_{index}"] = {"pose": {"xyz": place}, "shapes": shapes, "motion": motion(rng)}
    meshes = {f"rock_{model}": {"file": f"rock_{model}.stl"} for model in range(MODELS)}
    return write_scene_file(folder / "scene.json", SECONDS, meshes, rocks)


@dataclass(frozen=True, slots=True)
class Cost:
    """What a run took: CPU and wall-clock seconds, peak memory in MB; and what it did and found."""

    bodies: int
    cpu: float
    wall: float
    memory: float
    counts: dict[str, int]
    verdicts: dict[str, int]
    seconds: dict[str, float]


def run(bodies: int, apart: float, options: list[str]) -> Cost:
    """Run a scene in a child of its own."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        scene, out = write_scene(bodies, folder, apart), folder / "out.mcap"
        ran = run_command(scene, out, "--rate", "0", "--max-bytes", str(2**30), *options)
        with out.open("rb") as log_file:
            metadata = {record.name: record.metadata for record in make_reader(log_file).iter_metadata()}
    counts = {topic: int(metadata["closecall"].get(f"count/{topic}", 0)) for topic in ("wakeups", "windows", "spans")}
    told = ran.told
    counts["examined"] = len(told["pairs"])
    return Cost(bodies, ran.cpu, ran.wall, ran.memory, counts, told["totals"]["pairs"], told["seconds"])


def exponent(first: Cost, last: Cost, name: str) -> float:
    """Return the power of the number of bodies that a cost grows with."""
    return float(log(getattr(last, name) / getattr(first, name)) / log(last.bodies / first.bodies))


def rows(sizes: list[int], apart: float) -> Iterator[Row]:
    """Yield the rows of the table: how CPU time and memory grow, and what the largest may take."""
    costs = [run(size, apart, []) for size in sizes]
    case = f"rocks of 320 triangles, {apart:g} m apart, {SECONDS:g} s"
    for cost in costs:
        target, met = "", None
        if cost.bodies == 10_000:
            target, met = "within 60 s", cost.cpu <= 60.0
        elif cost.bodies == 100_000:
            target, met = "within 16 GiB", cost.memory <= 16 * 2**30 / 1e6
        yield Row(f"{cost.bodies} {case}", f"{cost.cpu:.1f} CPU s, {cost.memory:.0f} MB", target, met)
    for name, most in (("cpu", 1.15), ("memory", 1.05)):
        grows = fitted(costs, name)
        yield Row(f"{sizes[0]} to {sizes[-1]} {case}: {name}", f"n^{grows:.2f}", f"n^{most} at most", grows <= most)


def fitted(costs: list[Cost], name: str) -> float:
    """Return the power of the number of bodies that a cost grows with, by least squares over all of them."""
    sizes, values = ([log(getattr(cost, kind)) for cost in costs] for kind in ("bodies", name))
    return float(np.polyfit(sizes, values, 1)[0])


def main() -> None:
    """Print a row a scene."""
    parser = argparse.ArgumentParser()
    parser.add_argument("bodies", type=int, nargs="*", default=[100, 1000, 10000])
    parser.add_argument("--apart", type=float, default=10.0)
    given, options = parser.parse_known_args()
    costs = []
    for size in given.bodies:
        cost = run(size, given.apart, options)
        costs.append(cost)
        done = ", ".join(f"{count} {name}" for name, count in cost.counts.items())
        found = ", ".join(f"{count} {verdict}" for verdict, count in cost.verdicts.items() if count)
        parts = ", ".join(f"{part} {seconds:.1f}" for part, seconds in cost.seconds.items())
        print(f"{size} bodies: {cost.cpu:.2f} s CPU, {cost.wall:.2f} s wall ({parts}), {cost.memory:.0f} MB")
        print(f"    {done}; {found}", flush=True)
    for first, last in pairwise(costs):
        grown = ", ".join(f"{name} n^{exponent(first, last, name):.2f}" for name in ("cpu", "memory"))
        print(f"{first.bodies} to {last.bodies}: {grown}")


if __name__ == "__main__":
    main()
