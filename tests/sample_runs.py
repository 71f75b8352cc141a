"""Runs of the sample scenes, kept for all tests, and what the tests ask of their summaries and of the oracle."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from decimal import Decimal
from functools import cache, cached_property
from itertools import count
from math import cos, pi
from pathlib import Path
from shutil import copy
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from oracle.poses import read_scene
from oracle.rigid import METRES, FloatArray, numbers
from oracle.solids import icosahedron, write_mesh
from oracle.truth import Truth

FOLDER = Path(__file__).parents[1] / "sample_scenes"

HASH_SEEDS = ("1", "2")

SLACK = 1e-9
"""s or m: rounding allowed between a closed form and the tool."""

FACETS = 64
"""Around the polyhedra that stand for cylinders and cones."""

_scratch = TemporaryDirectory(prefix="closecall-samples-")


@dataclass(frozen=True)
class Sample:
    """A sample after two runs, one for each hash seed."""

    name: str
    logs: tuple[Path, ...]
    summary: dict[str, Any]
    warnings: str

    @property
    def path(self) -> Path:
        return FOLDER / self.name / "scene.yaml"

    @cached_property
    def plain_path(self) -> Path:
        """The same scene for the oracle: round shapes as polyhedra, recorded paths as keyframes."""
        return plain_copy(self.path, Path(_scratch.name) / f"{self.name}_plain")

    @cached_property
    def truth(self) -> Truth:
        return Truth(self.plain_path)

    @cached_property
    def header(self) -> str:
        """The comment above the scene, in one line."""
        lines = self.path.read_text(encoding="utf-8").split("closecall: 1")[0].splitlines()
        return " ".join(" ".join(line.removeprefix("#") for line in lines).split())

    def pair(self, name: str) -> dict[str, Any]:
        return next(pair for pair in self.summary["pairs"] if pair["pair"] == name)

    def pairs_with(self, verdict: str) -> set[str]:
        return {pair["pair"] for pair in self.summary["pairs"] if pair["verdict"] == verdict}


@cache
def sample_of(name: str) -> Sample:
    """Return a sample that was run once with each hash seed, both at a time."""
    logs = tuple(Path(_scratch.name) / f"{name}_{seed}.mcap" for seed in HASH_SEEDS)
    command = [sys.executable, "-m", "closecall", "run", str(FOLDER / name / "scene.yaml"), "--json", "-o"]
    runs = [
        subprocess.Popen(
            [*command, str(log)],
            env=os.environ | {"PYTHONHASHSEED": seed},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for seed, log in zip(HASH_SEEDS, logs, strict=True)
    ]
    said = [run.communicate() for run in runs]
    assert [run.returncode for run in runs] == [0, 0], said
    return Sample(name, logs, json.loads(said[0][0]), said[0][1])


def plain_copy(path: Path, folder: Path) -> Path:
    """Write a scene anew with meshes for round shapes and keyframes for recorded paths; return where."""
    scene = read_scene(path)
    folder.mkdir()
    for mesh in scene.get("meshes", {}).values():
        copy(path.parent / mesh["file"], folder)
    metres, serial = METRES[scene["units"]["length"]], count()
    for body in scene["bodies"].values():
        for shape in body.get("shapes", ()):
            triangles = polyhedron(shape)
            if triangles is not None:
                name = f"round_{next(serial)}"
                write_mesh(folder / f"{name}.obj", triangles * metres, 0)
                scene.setdefault("meshes", {})[name] = {"file": f"{name}.obj", "units": "m"}
                shape["mesh"] = name
        if body.get("motion", {}).get("type") == "file":
            body["motion"] = {"type": "keyframes", "keys": tum_keys(path.parent / body["motion"]["file"], metres)}
    out = folder / "scene.json"
    out.write_text(json.dumps(scene), encoding="utf-8")
    return out


def polyhedron(shape: dict[str, Any]) -> FloatArray | None:
    """Return triangles (n, 3, 3) around a cylinder, a cone or an ellipsoid in the file's unit, taking its key."""
    if "ellipsoid" in shape:
        return ball_around() * numbers(shape.pop("ellipsoid"))
    if "cylinder" in shape:
        return prism(**shape.pop("cylinder"))
    if "cone" in shape:
        return prism(**shape.pop("cone"), top=0.0)
    return None


def prism(radius: float, length: float, top: float = 1.0) -> FloatArray:
    """Return a prism whose facets touch a cylinder, one of them towards +x; of `top` 0, a pyramid around a cone."""
    angles = (np.arange(FACETS) + 0.5) * 2.0 * pi / FACETS
    ring = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(FACETS)]) * radius / cos(pi / FACETS)
    low, high = ring - [0.0, 0.0, 0.5 * length], top * ring + [0.0, 0.0, 0.5 * length]
    next_low, next_high = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
    middle = np.tile([0.0, 0.0, 0.5 * length], (FACETS, 1))
    sides = [(low, next_low, next_high), (low, next_high, high), (next_low, low, -middle), (high, next_high, middle)]
    triangles = np.concatenate([np.stack(side, axis=1) for side in sides])
    sizes = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
    return triangles[sizes > 1e-12 * radius**2]


def ball_around() -> FloatArray:
    """Return the icosahedron with its edges halved three times, its nearest faces touching the unit ball."""
    triangles = icosahedron()
    triangles /= np.linalg.norm(triangles, axis=2, keepdims=True)
    for _ in range(3):
        a, b, c = np.moveaxis(triangles, 1, 0)
        ab, bc, ca = (middle / np.linalg.norm(middle, axis=1)[:, None] for middle in (a + b, b + c, c + a))
        quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = np.concatenate([np.stack(quarter, axis=1) for quarter in quarters])
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    depths = np.einsum("ij,ij->i", normals, triangles[:, 0]) / np.linalg.norm(normals, axis=1)
    return triangles / depths.min()


def tum_keys(path: Path, metres: float) -> list[dict[str, Any]]:
    """Return a TUM file's poses as keys, the first at 0 s."""
    rows = [line.split() for line in path.read_text(encoding="ascii").splitlines() if not line.startswith("#")]
    first = Decimal(rows[0][0])
    return [
        {
            "t": float(Decimal(row[0]) - first),
            "xyz": [float(value) / metres for value in row[1:4]],
            "quat_xyzw": [float(value) for value in row[4:8]],
        }
        for row in rows
    ]


def is_bracketed(times: list[float], time: float, slack: float = SLACK) -> bool:
    """Whether a contact's begin or end is told to a microsecond, around a time."""
    return min(times) - slack <= time <= max(times) + slack and abs(times[1] - times[0]) <= 1e-6


def is_enclosed(distance: dict[str, float], least: float, slack: float = SLACK) -> bool:
    """Whether a least distance, m, lies between its bounds."""
    return distance["lower"] <= least + slack and least <= distance["upper"] + slack


def least_distance(truth: Truth, pair: tuple[str, str], low: float, high: float, count: int) -> tuple[float, float]:
    """Return the least signed distance, m, and its time, s, by sampling [low, high] and then around the least."""
    distances, times = np.zeros(0), np.zeros(0)
    for _ in range(7):
        times = np.linspace(low, high, count)
        distances = truth.signed(*pair, times)
        best = int(distances.argmin())
        low, high, count = times[max(best - 1, 0)], times[min(best + 1, count - 1)], 25
    return float(distances.min()), float(times[distances.argmin()])


def changes(truth: Truth, pair: tuple[str, str], times: FloatArray, margin: float = 0.0) -> list[float]:
    """Return when, s, a pair comes as near as `margin` (m) or parts again, by bisection between the given times.

    At a margin of 0: when it begins or ceases to touch.
    """
    near = truth.signed(*pair, times) <= margin
    found = []
    for i in np.flatnonzero(near[1:] != near[:-1]):
        low, high = times[i], times[i + 1]
        for _ in range(40):
            middle = 0.5 * (low + high)
            if (truth.signed(*pair, np.array([middle]))[0] <= margin) == near[i]:
                low = middle
            else:
                high = middle
        found.append(float(low))
    return found
