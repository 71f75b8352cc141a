"""Random values in the ways the scene file can write them: lengths, angles, poses, shapes, mesh files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .mesh_formats import WRITERS
from .rigid import METRES, RADIANS, FloatArray
from .solids import random_solid, write_mesh

SHAPES = ("mesh", "mesh", "mesh", "box", "box", "sphere", "capsule", "cylinder", "cone", "ellipsoid")
CRISP = ("mesh", "box", "sphere", "capsule")
"""Shapes that the tool measures as what they are."""


def random_rotation(rng: np.random.Generator) -> Rotation:
    """Return a rotation, all equally likely."""
    return Rotation.from_quat(rng.standard_normal(4))


@dataclass
class Draw:
    """One scene's random source and units.

    Attributes:
        size: m, how large things are about.
        start, end: s, the time range.
        meshes: the scene's section of that name, as drawn so far.
        files: how many trajectory files have been written.
        surface: what draws the triangles (n, 3, 3) of a mesh file, within about 1 of its origin.
    """

    seed: int
    folder: Path
    rng: np.random.Generator
    length: str
    angle: str
    size: float
    start: float
    end: float
    meshes: dict[str, Any] = field(default_factory=dict)
    files: int = 0
    surface: Callable[[np.random.Generator], FloatArray] = random_solid

    def __post_init__(self) -> None:
        self._other: np.random.Generator | None = np.random.default_rng([self.seed, 1])

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Draw from another source: what a seed draws outside stays as it is, whether more or less is drawn inside."""
        if self._other is None:  # already aside
            yield
            return
        main, self.rng, self._other = self.rng, self._other, None
        try:
            yield
        finally:
            self.rng, self._other = main, self.rng

    def chance(self, probability: float) -> bool:
        return bool(self.rng.random() < probability)

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def pick(self, *options: Any) -> Any:
        return options[int(self.rng.integers(len(options)))]

    def direction(self) -> FloatArray:
        """Return a random unit vector (3,)."""
        vector = self.rng.standard_normal(3)
        return vector / np.linalg.norm(vector)

    def axis(self, direction: FloatArray | None = None) -> Any:
        """Write a direction, random if none is given, in any length: of some the squares are 0 in floats."""
        vector = self.direction() if direction is None else direction
        return (vector * self.between(0.5, 3.0) * self.pick(1.0, 1.0, 1.0, 1e12, 1e-61, 1e-170)).tolist()

    def metres(self, value: FloatArray | float) -> Any:
        """Write lengths given in m in the file's unit."""
        return (np.asarray(value) / METRES[self.length]).tolist()

    def radians(self, value: FloatArray | float) -> Any:
        """Write angles given in rad in the file's unit."""
        return (np.asarray(value) / RADIANS[self.angle]).tolist()

    def turn(self, rotation: Rotation) -> dict[str, Any]:
        """Write a rotation in one of the ways a pose has."""
        way = self.pick("quat_wxyz", "quat_xyzw", "rpy", "axis_angle")
        x, y, z, w = rotation.as_quat().tolist()
        if way == "quat_wxyz":
            return {way: [w, x, y, z]}
        if way == "quat_xyzw":
            return {way: [x, y, z, w]}
        if way == "rpy":
            return {way: self.radians(rotation.as_euler("xyz"))}
        vector = rotation.as_rotvec()
        angle = float(np.linalg.norm(vector))
        return {way: {"axis": self.axis(vector / angle), "angle": self.radians(angle)}}

    def pose(self, place: FloatArray, rotation: Rotation | None) -> dict[str, Any]:
        """Write a pose: a place (3,) m and perhaps a rotation."""
        if rotation is None:
            return {"xyz": self.metres(place)}
        if self.chance(0.2):
            return {"matrix": self.matrix(place, rotation)}
        return {"xyz": self.metres(place), **self.turn(rotation)}

    def matrix(self, place: FloatArray, rotation: Rotation) -> list[list[float]]:
        """Write the 4x4 matrix of a pose: a place (3,) m and a rotation, which some write to six decimals."""
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = rotation.as_matrix(), self.metres(place)
        with self.aside():
            if self.chance(0.5):
                matrix[:3, :3] = np.round(matrix[:3, :3], 6)
        return list(matrix.tolist())

    def random_pose(self, reach: float) -> dict[str, Any]:
        """Write a pose anywhere within `reach` sizes along each axis."""
        rotation = random_rotation(self.rng) if self.chance(0.75) else None
        return self.pose(self.rng.uniform(-reach, reach, 3) * self.size, rotation)

    def shape(self, size: float, kinds: tuple[str, ...] = SHAPES) -> Any:
        """Write a shape of about `size` m from its origin to its tips, without a pose."""
        kind = self.pick(*kinds)
        if kind == "mesh":
            out: dict[str, Any] = {"mesh": self.mesh(size)}
            if self.chance(0.3):
                out["scale"] = self.between(0.6, 1.2) if self.chance(0.5) else self.rng.uniform(0.5, 1.3, 3).tolist()
            return out
        if kind == "box":
            return {"box": self.metres(self.rng.uniform(0.4, 1.4, 3) * size)}
        if kind == "sphere":
            return {"sphere": self.metres(self.between(0.3, 0.9) * size)}
        if kind == "ellipsoid":
            return {"ellipsoid": self.metres(self.rng.uniform(0.15, 1.0, 3) * size)}
        thin = 0.4 if kind == "capsule" else 0.8
        radius, length = self.between(0.15, thin) * size, self.between(0.4, 1.4) * size
        return {kind: {"radius": self.metres(radius), "length": self.metres(length)}}

    def mesh(self, size: float) -> str:
        """Write a mesh file of a random solid, or reuse one, and return its name."""
        if self.meshes and self.chance(0.2):
            return str(self.rng.choice(sorted(self.meshes)))
        name = f"mesh_{len(self.meshes)}"
        suffix, unit = self.pick(".obj", ".stl"), self.pick(*METRES)
        triangles = self.surface(self.rng) * size / METRES[unit]
        up = "y" if self.chance(0.15) else ""
        with self.aside():
            if self.chance(0.3):
                suffix = self.pick(*WRITERS)
            if self.chance(0.1):
                up = up or "z"
        write_mesh(self.folder / (name + suffix), triangles, self.seed, unit)
        entry: dict[str, Any] = {"file": name + suffix, "units": unit, **({"up": up} if up else {})}
        self.meshes[name] = entry
        return name
