"""Where every body of a scene file is at given times."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from .motions import Units, motion_at
from .paths import PATHS, KeyPath, path_of
from .rigid import METRES, RADIANS, FloatArray, inverse, numbers, pose_of, rigid


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
        paths: by body, the keys or the file that it moves by.
    """

    def __init__(self, scene: Mapping[str, Any], folder: Path = Path()) -> None:
        """Take a scene document, and the folder that its files lie in."""
        self.bodies: dict[str, Mapping[str, Any]] = {name: body or {} for name, body in scene["bodies"].items()}
        self.units = units_of(scene)
        self.paths: dict[str, KeyPath] = {
            name: path_of(body["motion"], self.units, folder)
            for name, body in self.bodies.items()
            if (body.get("motion") or {}).get("type") in PATHS
        }

    def world_from_body(self, name: str, times: FloatArray) -> FloatArray:
        """Return (n, 4, 4) at scene times (n,) s; translations in m."""
        parent = self.bodies[name].get("parent")
        local = self.local(name, times)
        return local if parent is None else self.world_from_body(parent, times) @ local

    def local(self, name: str, times: FloatArray) -> FloatArray:
        """Return (n, 4, 4): the body in its parent."""
        spec = self.bodies[name].get("motion")
        if name in self.paths:
            moved = self.paths[name].at(times)
        elif spec is None:
            moved = rigid(None, np.zeros((len(times), 3)))
        else:
            moved = motion_at(spec, times, self.units)
        return self.rest_pose(name) @ moved

    def relative(self, a: str, b: str, times: FloatArray) -> FloatArray:
        """Return (n, 4, 4): the pose of body b in the frame of body a, by the way of the nearest common ancestor."""
        above = self.lineage(a)
        common = next((name for name in self.lineage(b) if name in above), None)
        return inverse(self.within(a, common, times)) @ self.within(b, common, times)

    def within(self, name: str, ancestor: str | None, times: FloatArray) -> FloatArray:
        """Return (n, 4, 4): the body in one of its ancestors or itself, None: in the world."""
        out = rigid(None, np.zeros((len(times), 3)))
        for one in self.lineage(name):
            if one == ancestor:
                break
            out = self.local(one, times) @ out
        return out

    def lineage(self, name: str) -> list[str]:
        """Return the body, its parent, and so on."""
        found, current = [], name
        while current is not None:
            found.append(current)
            current = self.bodies[current].get("parent")
        return found

    def rest_pose(self, name: str) -> FloatArray:
        """Return the body's own `pose`, 4x4 in its parent's frame."""
        return pose_of(self.bodies[name].get("pose"), self.units.metres, self.units.radians)

    def anchor(self, name: str) -> str:
        """Return the body or 'world' that this body is rigidly fixed to: the nearest that has a motion."""
        return next((one for one in self.lineage(name) if self.bodies[one].get("motion") is not None), "world")

    def knots(self, *names: str, start: float, end: float) -> FloatArray:
        """Return the scene times (s, sorted) within [start, end] of the keys of these bodies and their ancestors."""
        moving = {one for name in names for one in self.lineage(name) if one in self.paths}
        return np.unique(np.concatenate([np.zeros(0), *(self.paths[one].knots(start, end) for one in moving)]))

    def named_around(self, name: str, time: float) -> tuple[str, str]:
        """Return the named keys, "" for none, around a time (s): of the nearest of body and ancestors with any."""
        for one in self.lineage(name):
            if one in self.paths and any(self.paths[one].names):
                return self.paths[one].named_around(time)
        return "", ""

    def exists(self, name: str) -> tuple[float, float]:
        """Return the times (s) between which the body exists, infinite where unlimited."""
        begin, end = numbers(self.bodies[name].get("exists", (-np.inf, np.inf)))
        return float(begin), float(end)
