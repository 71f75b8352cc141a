"""Where every body of a scene file is at given times."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from .motions import Units, motion_at
from .rigid import METRES, RADIANS, FloatArray, inverse, numbers, pose_of


def read_scene(path: Path) -> dict[str, Any]:
    """Return the scene document, read with the plain JSON or YAML library."""
    text = path.read_text(encoding="utf-8")
    return json.loads(text) if path.suffix == ".json" else yaml.safe_load(text)


def units_of(scene: Mapping[str, Any]) -> Units:
    """Return what the file's units are in m and rad."""
    return Units(METRES[scene["units"]["length"]], RADIANS[scene["units"]["angle"]])


class Kinematics:
    """World poses of a scene's bodies, by name, at any times.

    Attributes:
        bodies: the scene's bodies, in document order.
        units: of the scene file.
    """

    def __init__(self, scene: Mapping[str, Any]) -> None:
        self.bodies: dict[str, Mapping[str, Any]] = {name: body or {} for name, body in scene["bodies"].items()}
        self.units = units_of(scene)

    def world_from_body(self, name: str, times: FloatArray) -> FloatArray:
        """Return (n, 4, 4) at scene times (n,) s; translations in m."""
        body = self.bodies[name]
        local = self.rest_pose(name) @ motion_at(body.get("motion"), times, self.units)
        parent = body.get("parent")
        return local if parent is None else self.world_from_body(parent, times) @ local

    def relative(self, a: str, b: str, times: FloatArray) -> FloatArray:
        """Return (n, 4, 4): the pose of body b in the frame of body a."""
        return inverse(self.world_from_body(a, times)) @ self.world_from_body(b, times)

    def rest_pose(self, name: str) -> FloatArray:
        """Return the body's own `pose`, 4x4 in its parent's frame."""
        return pose_of(self.bodies[name].get("pose"), self.units.metres, self.units.radians)

    def anchor(self, name: str) -> str:
        """Return the body or 'world' that this body is rigidly fixed to: the nearest that has a motion."""
        body = self.bodies[name]
        while body.get("motion") is None:
            if body.get("parent") is None:
                return "world"
            name = body["parent"]
            body = self.bodies[name]
        return name

    def knots(self, *names: str) -> FloatArray:
        """Return the scene times (s, sorted) of the keys of these bodies and their ancestors."""
        found: set[float] = set()
        for name in names:
            current: str | None = name
            while current is not None:
                body = self.bodies[current]
                spec = body.get("motion") or {}
                shift = float(spec.get("t0", 0.0))
                found.update(shift + float(key["t"]) for key in spec.get("keys", ()))
                current = body.get("parent")
        return np.array(sorted(found))

    def exists(self, name: str) -> tuple[float, float]:
        """Return the times (s) between which the body exists, infinite where unlimited."""
        begin, end = numbers(self.bodies[name].get("exists", (-np.inf, np.inf)))
        return float(begin), float(end)
