"""Motions along poses at times: keyframes, and trajectory files read from scratch."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .motions import Spec, Units, known
from .rigid import METRES, FloatArray, IntArray, numbers, pose_of, rigid

PATHS = ("keyframes", "file")
OUTSIDE = ("error", "hold", "loop")

FOREVER = 1e300
"""s: the period of a single key."""


def exact_sum(a: FloatArray, b: float) -> tuple[FloatArray, FloatArray]:
    """Return a + b as it is rounded, and what the rounding takes off (Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@dataclass(frozen=True, eq=False)
class KeyPath:
    """Poses at times, and what happens between and outside of them.

    Attributes:
        times: (n,) scene s.
        poses: (n, 4, 4).
        velocities: (n, 3) m/s at the keys, None if they are not stated.
        translation: linear, cubic or step.
        rotation: slerp or step.
        before, after: error, hold or loop.
        names: of the keys, "" for none.
    """

    times: FloatArray
    poses: FloatArray
    velocities: FloatArray | None
    translation: str
    rotation: str
    before: str
    after: str
    names: tuple[str, ...]

    def at(self, t: FloatArray) -> FloatArray:
        """Return (n, 4, 4) at times (n,): step holds the last key at or before t, else it blends towards the next."""
        at, poses, t = self.times, self.poses, self.wrapped(t)
        now = np.clip(np.searchsorted(at, t, side="right") - 1, 0, len(at) - 1)
        left = np.minimum(now, max(len(at) - 2, 0))
        right = np.minimum(left + 1, len(at) - 1)
        length = np.where(right > left, at[right] - at[left], 1.0)
        part = (t - at[left]) / length
        places = poses[:, :3, 3]
        if self.translation == "step":
            translation = places[now]
        elif self.translation == "cubic":
            translation = hermite(places, self.tangents(), left, right, part, length)
        else:
            translation = places[left] + part[:, None] * (places[right] - places[left])
        rotation = poses[now, :3, :3] if self.rotation == "step" else slerp(poses[:, :3, :3], left, right, part)
        return rigid(rotation, translation)

    def wrapped(self, t: FloatArray) -> FloatArray:
        """Bring times to where the keys are: looped where so stated, else held; the last key loops to the first."""
        first, last = self.times[0], self.times[-1]
        span = last - first
        looped = np.full_like(t, first)
        if span > 0.0:
            since, lost = exact_sum(t, -first)
            within = np.fmod(since, span)  # exact, of the sign of `since`
            later, taken = exact_sum(within, span)
            within, lost = np.where(within < 0.0, later, within), np.where(within < 0.0, lost + taken, lost)
            looped, rounded = exact_sum(within, first)
            before = lost + rounded < 0.0  # a float before a key must not be rounded onto it
            looped = np.where(before, np.nextafter(looped, -np.inf), looped)
            looped = np.where((within == 0.0) & (lost < 0.0), last, looped)
        looped = np.minimum(looped, np.nextafter(last, first))
        t = np.where((t < first) & (self.before == "loop"), looped, t)
        t = np.where((t >= last) & (self.after == "loop"), looped, t)
        return np.clip(t, first, last)

    def tangents(self) -> FloatArray:
        """Return the velocities (n, 3) m/s at the keys: stated, else non-uniform Catmull-Rom."""
        if self.velocities is not None or len(self.times) == 1:
            return np.zeros((1, 3)) if self.velocities is None else self.velocities
        steps = np.diff(self.times)[:, None]
        slopes = np.diff(self.poses[:, :3, 3], axis=0) / steps
        inner = (steps[1:] * slopes[:-1] + steps[:-1] * slopes[1:]) / (steps[:-1] + steps[1:])
        return np.concatenate([slopes[:1], inner, slopes[-1:]])

    def knots(self, start: float, end: float) -> FloatArray:
        """Return the times (s) of keys within [start, end], repeated where they loop."""
        first, last = float(self.times[0]), float(self.times[-1])
        span = last - first
        found = [self.times]
        if span > 0.0 and self.after == "loop":
            found += [self.times + k * span for k in range(1, int(max(0.0, end - first) // span) + 2)]
        if span > 0.0 and self.before == "loop":
            found += [self.times - k * span for k in range(1, int(max(0.0, last - start) // span) + 2)]
        knots = np.unique(np.concatenate(found))
        return knots[(knots >= start) & (knots <= end)]

    def named_around(self, time: float) -> tuple[str, str]:
        """Return the names of the last named key at or before a time (s) and of the first after it.

        Where the keys repeat, those of the loops next to the time's own count too; a single key repeats once for ever.
        """
        first = float(self.times[0])
        period = float(self.times[-1]) - first or FOREVER
        least, most = -np.inf if self.before == "loop" else 0.0, np.inf if self.after == "loop" else 0.0
        loops = np.unique(np.clip((time - first) // period + np.arange(-1.0, 2.0), least, most)).tolist()
        keys = [(float(t), name) for t, name in zip(self.times, self.names, strict=True) if name]
        named = [(t + loop * period, name) for loop in loops for t, name in keys]
        earlier = [name for t, name in named if t <= time]
        later = [name for t, name in named if t > time]
        return (earlier[-1] if earlier else "", later[0] if later else "")


def path_of(spec: Spec, units: Units, folder: Path) -> KeyPath:
    """Read a motion along keys or a file."""
    shift = float(spec.get("t0", 0.0))
    ways = spec.get("interpolation", {})
    rest = (
        known(ways.get("translation", "linear"), "linear", "cubic", "step"),
        known(ways.get("rotation", "slerp"), "slerp", "step"),
        known(spec.get("before", "error"), *OUTSIDE),
        known(spec.get("after", "error"), *OUTSIDE),
    )
    if spec["type"] == "file":
        times, poses = read_trajectory(spec, units, folder)
        return KeyPath(times + shift, poses, None, *rest, names=("",) * len(times))
    keys = spec["keys"]
    stated = [numbers(key["velocity"]) * units.metres for key in keys if "velocity" in key]
    return KeyPath(
        numbers([key["t"] for key in keys]) + shift,
        np.array([pose_of(key, units.metres, units.radians) for key in keys]),
        np.array(stated) if stated else None,
        *rest,
        names=tuple(key.get("name", "") for key in keys),
    )


def read_trajectory(spec: Spec, units: Units, folder: Path) -> tuple[FloatArray, FloatArray]:
    """Return times (n,) s and poses (n, 4, 4) m of a file; times count from where `time_origin` says."""
    lines = [line for line in (folder / spec["file"]).read_text(encoding="utf-8").splitlines() if line.strip()]
    lines = [line for line in lines if not line.startswith("#")]
    if spec["layout"] == "csv":
        rows: list[dict[str, Any]] = list(csv.DictReader(lines))
        metres = METRES[spec["units"]] if "units" in spec else units.metres
    else:
        rows = {"tum": tum_rows, "euroc": euroc_rows, "kitti": kitti_rows}[spec["layout"]](lines)
        metres = 1.0
    if "times" in spec:
        for row, time in zip(rows, (folder / spec["times"]).read_text(encoding="utf-8").split(), strict=True):
            row["t"] = time
    if "period" in spec:
        for number, row in enumerate(rows):
            row["t"] = Decimal(repr(spec["period"])) * number
    rows = without_duplicates(rows, known(spec.get("duplicates", "error"), "error", "first", "last"))
    clocks = [Decimal(row["t"]) for row in rows]
    origin = clocks[0] if known(spec.get("time_origin", "first"), "first", "zero") == "first" else Decimal(0)
    times = np.array([float(clock - origin) for clock in clocks])
    poses = np.array([pose_of(row_pose(row), metres, units.radians) for row in rows])
    return times, poses


def tum_rows(lines: list[str]) -> list[dict[str, Any]]:
    names = ["t", "x", "y", "z", "qx", "qy", "qz", "qw"]
    return [dict(zip(names, line.split(), strict=True)) for line in lines]


def euroc_rows(lines: list[str]) -> list[dict[str, Any]]:
    """Return the rows of a euroc file, their times in s."""
    names = ["t", "x", "y", "z", "qw", "qx", "qy", "qz"]
    rows = [dict(zip(names, line.split(","), strict=False)) for line in lines if not line.startswith("timestamp")]
    return [row | {"t": Decimal(row["t"]) / 10**9} for row in rows]


def kitti_rows(lines: list[str]) -> list[dict[str, Any]]:
    """Return the 4x4 matrices of a kitti file."""
    matrices = numbers([line.split() for line in lines]).reshape(-1, 3, 4)
    return [{"matrix": [*matrix.tolist(), [0.0, 0.0, 0.0, 1.0]]} for matrix in matrices]


def without_duplicates(rows: list[dict[str, Any]], duplicates: str) -> list[dict[str, Any]]:
    """Return the first or the last of the rows at each time."""
    at_time: dict[Decimal, list[dict[str, Any]]] = {}
    for row in rows:
        at_time.setdefault(Decimal(row["t"]), []).append(row)
    if duplicates == "error" and len(at_time) < len(rows):
        raise ValueError("two poses at one time")
    return [same[-1 if duplicates == "last" else 0] for same in at_time.values()]


def row_pose(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row of a trajectory as a scene file would write its pose."""
    if "matrix" in row:
        return {"matrix": row["matrix"]}
    pose: dict[str, Any] = {"xyz": [float(row[key]) for key in "xyz"]}
    if "qw" in row:
        pose["quat_wxyz"] = [float(row[key]) for key in ("qw", "qx", "qy", "qz")]
    elif "roll" in row:
        pose["rpy"] = [float(row[key]) for key in ("roll", "pitch", "yaw")]
    return pose


def slerp(turns: FloatArray, left: IntArray, right: IntArray, part: FloatArray) -> FloatArray:
    """Return (n, 3, 3): from turns[left] along the shortest turn to turns[right], `part` of the way."""
    first, second = Rotation.from_matrix(turns[left]), Rotation.from_matrix(turns[right])
    way = (first.inv() * second).as_rotvec()
    return (first * Rotation.from_rotvec(part[:, None] * way)).as_matrix()


def hermite(
    places: FloatArray,
    speeds: FloatArray,
    left: IntArray,
    right: IntArray,
    part: FloatArray,
    length: FloatArray,
) -> FloatArray:
    s, h = part[:, None], length[:, None]
    return (
        (1.0 + 2.0 * s) * (1.0 - s) ** 2 * places[left]
        + s * (1.0 - s) ** 2 * h * speeds[left]
        + s**2 * (3.0 - 2.0 * s) * places[right]
        + s**2 * (s - 1.0) * h * speeds[right]
    )
