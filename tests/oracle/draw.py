"""Random values in the ways the scene file can write them: lengths, angles, poses, motions, shapes, mesh files."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .rigid import METRES, RADIANS, FloatArray
from .solids import random_solid, write_mesh

TICK = 1.0 / 64.0
"""s: keys stand on multiples of this, so that a step's instant is the same number whoever adds `t0`."""

MOTIONS = ("constant", "ballistic", "screw", "harmonic", "swing", "keyframes", "keyframes")


def random_rotation(rng: np.random.Generator) -> Rotation:
    """Return a rotation, all equally likely."""
    return Rotation.from_quat(rng.standard_normal(4))


@dataclass
class Draw:
    """One scene's random source and units.

    Attributes:
        size: m, how large things are about.
        start, end: s, the time range.
        without: what the scene shall not use: t0, scale, hold.
    """

    seed: int
    folder: Path
    rng: np.random.Generator
    length: str
    angle: str
    size: float
    start: float
    end: float
    without: frozenset[str]
    meshes: dict[str, Any] = field(default_factory=dict)

    def chance(self, probability: float) -> bool:
        return bool(self.rng.random() < probability)

    def may(self, feature: str, probability: float) -> bool:
        """Draw whether to use a feature; never where the scene is to do without it."""
        return self.chance(probability) and feature not in self.without

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def pick(self, *options: Any) -> Any:
        return options[int(self.rng.integers(len(options)))]

    def direction(self) -> FloatArray:
        """Return a random unit vector (3,)."""
        vector = self.rng.standard_normal(3)
        return vector / np.linalg.norm(vector)

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
        return {way: {"axis": (vector / angle).tolist(), "angle": self.radians(angle)}}

    def pose(self, place: FloatArray, rotation: Rotation | None) -> dict[str, Any]:
        """Write a pose: a place (3,) m and perhaps a rotation."""
        if rotation is None:
            return {"xyz": self.metres(place)}
        if self.chance(0.2):
            matrix = np.eye(4)
            matrix[:3, :3], matrix[:3, 3] = rotation.as_matrix(), self.metres(place)
            return {"matrix": matrix.tolist()}
        return {"xyz": self.metres(place), **self.turn(rotation)}

    def random_pose(self, reach: float) -> dict[str, Any]:
        """Write a pose anywhere within `reach` sizes along each axis."""
        rotation = random_rotation(self.rng) if self.chance(0.75) else None
        return self.pose(self.rng.uniform(-reach, reach, 3) * self.size, rotation)

    def shape(self, size: float, kinds: tuple[str, ...] = ("mesh", "mesh", "box", "sphere", "capsule")) -> Any:
        """Write a shape of about `size` m from its origin to its tips, without a pose."""
        kind = self.pick(*kinds)
        if kind == "mesh":
            out: dict[str, Any] = {"mesh": self.mesh(size)}
            return out | {"scale": self.between(0.6, 1.2)} if self.may("scale", 0.2) else out
        if kind == "box":
            return {"box": self.metres(self.rng.uniform(0.4, 1.4, 3) * size)}
        if kind == "sphere":
            return {"sphere": self.metres(self.between(0.3, 0.9) * size)}
        radius, length = self.between(0.15, 0.4) * size, self.between(0.4, 1.4) * size
        return {"capsule": {"radius": self.metres(radius), "length": self.metres(length)}}

    def mesh(self, size: float) -> str:
        """Write a mesh file of a random solid, or reuse one, and return its name."""
        if self.meshes and self.chance(0.2):
            return str(self.rng.choice(sorted(self.meshes)))
        name = f"mesh_{len(self.meshes)}"
        file, unit = name + self.pick(".obj", ".stl"), self.pick(*METRES)
        entry: dict[str, Any] = {"file": file, "units": unit}
        write_mesh(self.folder / file, random_solid(self.rng) * size / METRES[unit], self.seed)
        if self.chance(0.15):
            entry["up"] = "y"
        self.meshes[name] = entry
        return name

    def motion(self, kind: str | None = None, vigour: float = 1.0) -> dict[str, Any]:
        """Write a random motion that moves by about `vigour` sizes a second or turns by about a radian."""
        kind = kind or self.pick(*MOTIONS)
        spec = {"type": kind, **getattr(self, f"_{kind}")(vigour * self.size)}
        if kind != "keyframes" and self.may("t0", 0.3):
            spec["t0"] = self.between(-1.0, 2.0)
        return spec

    def velocity(self, speed: float) -> Any:
        return self.metres(self.direction() * speed * self.between(0.3, 1.5))

    def spin(self) -> Any:
        return self.radians(self.direction() * self.between(0.3, 4.0))

    def _constant(self, reach: float) -> dict[str, Any]:
        out = {"velocity": self.velocity(reach), "angular_velocity": self.spin()}
        if self.chance(0.4):
            out.pop(self.pick("velocity", "angular_velocity"))
        return out

    def _ballistic(self, reach: float) -> dict[str, Any]:
        out = {"velocity": self.velocity(1.5 * reach), "acceleration": self.velocity(1.5 * reach)}
        return out | {"angular_velocity": self.spin()} if self.chance(0.6) else out

    def _screw(self, reach: float) -> dict[str, Any]:
        out = {"axis": self.direction().tolist(), "rate": self.radians(self.between(-5.0, 5.0))}
        if self.chance(0.7):
            out["pitch"] = self.metres(self.between(-1.0, 1.0) * reach)
        return out | {"point": self.metres(self.rng.uniform(-0.7, 0.7, 3) * self.size)}

    def _harmonic(self, reach: float) -> dict[str, Any]:
        return {
            "direction": (self.direction() * self.between(0.5, 3.0)).tolist(),
            "amplitude": self.metres(self.between(0.2, 1.2) * reach),
            "period": self.between(0.15, 3.0),
            "phase": self.radians(self.between(-3.0, 3.0)),
        }

    def _swing(self, _reach: float) -> dict[str, Any]:
        return {
            "axis": self.direction().tolist(),
            "point": self.metres(self.rng.uniform(-0.7, 0.7, 3) * self.size),
            "amplitude": self.radians(self.between(0.3, 3.0)),
            "period": self.between(0.2, 3.0),
            "phase": self.radians(self.between(-3.0, 3.0)),
        }

    def _keyframes(self, reach: float) -> dict[str, Any]:
        """Write 2 to 6 keys on ticks: over the whole range, or less of it and held or looped."""
        begin, end = round(self.start / TICK), round(self.end / TICK)
        short = self.may("hold", 0.35)
        if short:
            middle = (begin + end) // 2
            begin, end = begin + int(self.rng.integers(0, 20)), middle + int(self.rng.integers(5, 40))
        inner = self.rng.choice(np.arange(begin + 1, end), int(self.rng.integers(0, 5)), replace=False)
        ticks = [begin, *sorted(inner.tolist()), end]
        shift = int(self.rng.integers(-40, 40)) if self.may("t0", 0.3) else 0
        out: dict[str, Any] = {"keys": self._keys([tick - shift for tick in ticks], reach)}
        if shift:
            out["t0"] = shift * TICK
        ways = {"translation": self.pick("linear", "linear", "step"), "rotation": self.pick("slerp", "slerp", "step")}
        if ways != {"translation": "linear", "rotation": "slerp"} or self.chance(0.5):
            out["interpolation"] = ways
        return out | {"before": "hold", "after": self.pick("hold", "loop")} if short else out

    def _keys(self, ticks: list[int], reach: float) -> list[dict[str, Any]]:
        """Write keys at these ticks that wander by about `reach` and turn by less than 150 degrees each."""
        place, rotation = self.rng.uniform(-0.5, 0.5, 3) * reach, Rotation.identity()
        turning = self.chance(0.7)
        keys = []
        for tick in ticks:
            turn = self.turn(rotation) if turning and rotation.magnitude() > 0.0 else {}
            keys.append({"t": tick * TICK, "xyz": self.metres(place), **turn})
            place = place + self.rng.uniform(-0.7, 0.7, 3) * reach
            rotation = Rotation.from_rotvec(self.direction() * self.between(0.1, 2.5)) * rotation
        return keys
