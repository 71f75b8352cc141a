"""What is true of a scene at an instant, for the checks to hold a log against."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from .bodies import Surface, surface_of
from .distance import PairDistance
from .motions import known
from .poses import Kinematics, read_scene
from .rigid import METRES, FloatArray, inverse, rigid

NANOSECOND = 1e-9
"""s: log times are rounded to this."""

ROUNDINGS = 64.0
"""By how many spacings of floats coordinates may be off."""

Pair = tuple[str, str]

POINT = Surface(np.zeros((1, 3, 3)), np.zeros(1), np.zeros((1, 3)), ())


class Truth:
    """A scene file with its meshes, and brute-force answers about it.

    Attributes:
        scene: the document, as read.
        names: of the bodies, in document order.
        start, end: s.
    """

    def __init__(self, path: Path) -> None:
        self.scene: dict[str, Any] = read_scene(path)
        self.kinematics = Kinematics(self.scene, path.parent)
        self.names = list(self.kinematics.bodies)
        self.start, self.end = float(self.scene["time"]["start"]), float(self.scene["time"]["end"])
        self.surfaces = {name: surface_of(self.scene, name, path.parent) for name in self.names}
        self._distances: dict[Pair, PairDistance] = {}  # of a body and "": from points

    @cached_property
    def _reached(self) -> tuple[FloatArray, FloatArray]:
        """Where each body's origin is at 50 instants, (bodies, 50, 3) m, and its extent, (bodies,) m."""
        times = np.linspace(self.start, self.end, 50)
        places = np.array([self.kinematics.world_from_body(name, times)[:, :3, 3] for name in self.names])
        return places, np.array([self.surfaces[name].extent for name in self.names])

    @cached_property
    def size(self) -> float:
        """The largest coordinate (m) that any body reaches, from 50 instants: what rounding errors scale with."""
        places, extents = self._reached
        return float((np.linalg.norm(places, axis=2) + extents[:, None]).max())

    @cached_property
    def spread(self) -> float:
        """The largest distance (m) that any body reaches from the middle of all, from 50 instants."""
        places, extents = self._reached
        middle = 0.5 * (places.min(axis=(0, 1)) + places.max(axis=(0, 1)))
        return float((np.linalg.norm(places - middle, axis=2) + extents[:, None]).max())

    @property
    def tolerance(self) -> float:
        """m: two correct programs may differ by this in a distance: 1e-9 of the bodies, and rounding far from 0."""
        return 1e-9 * (1.0 + self.spread) + ROUNDINGS * np.finfo(float).eps * self.size

    @property
    def sure_depth(self) -> float:
        """m: an overlap this deep is no rounding error of either program (they err by about 1e-15 of size)."""
        return 0.1 * self.tolerance

    @property
    def time_resolution(self) -> float:
        """s, the scene's own setting, else the default."""
        return float(self.scene.get("settings", {}).get("time_resolution", 1e-3))

    @property
    def contact_tolerance(self) -> float:
        """s, the widest bracket of a contact's begin or end that may be left.

        The scene's own setting, or 1e-6, or 64 floats of time where those are more.
        """
        usual = max(1e-6, 64.0 * float(np.spacing(max(abs(self.start), abs(self.end)))))
        return float(self.scene.get("settings", {}).get("contact_tolerance", usual))

    def pairs(self) -> list[Pair]:
        """Return every pair to watch: with shapes, there at one time, in relative motion, allowed by the rules."""
        return [(a, b) for i, a in enumerate(self.names) for b in self.names[i + 1 :] if self.may_meet(a, b)]

    def may_meet(self, a: str, b: str) -> bool:
        """Tell whether a pair must be watched."""
        begin, end = self.interval(a, b)
        return begin < end and self.moves(a, b) and self.allows(a, b) and self.has_shapes(a) and self.has_shapes(b)

    def has_shapes(self, name: str) -> bool:
        return len(self.surfaces[name].triangles) > 0

    def moves(self, a: str, b: str) -> bool:
        """Tell whether a motion stands between two bodies: fixed ones, or ones fixed together, never meet anew."""
        return self.kinematics.anchor(a) != self.kinematics.anchor(b)

    def unknown(self, a: str, b: str) -> bool:
        """Tell whether a path between two bodies is unknown, so that what is told of them is only a bound."""
        return self._limited(set(self.kinematics.lineage(a)) ^ set(self.kinematics.lineage(b)))

    def unplaced(self, name: str) -> bool:
        """Tell whether a body's place in the world is unknown, though another's may be known from it."""
        return self._limited(self.kinematics.lineage(name))

    def _limited(self, names: Iterable[str]) -> bool:
        return any(self.scene["bodies"][name].get("motion", {}).get("type") == "limits" for name in names)

    def allows(self, a: str, b: str) -> bool:
        """Tell whether the `pairs` section lets a pair be checked: `check` overrides `ignore`, which the default."""
        rules = self.scene.get("pairs", {})
        if any(self._names(rule, a, b) for rule in rules.get("check", ())):
            return True
        if any(self._names(rule, a, b) for rule in rules.get("ignore", ())):
            return False
        return known(rules.get("default", "check"), "check", "ignore") == "check"

    def margin(self, a: str, b: str) -> float:
        """Return m: the pair's margin, by the last rule that names it, else the scene's."""
        metres = METRES[self.scene["units"]["length"]]
        margin = self.scene.get("settings", {}).get("margin", 0.0)
        for rule in self.scene.get("pairs", {}).get("margins", ()):
            margin = rule["margin"] if self._names(rule, a, b) else margin
        return float(margin) * metres

    def _names(self, rule: Mapping[str, Any], a: str, b: str) -> bool:
        one, other = rule["between"]
        return (self._is(one, a) and self._is(other, b)) or (self._is(one, b) and self._is(other, a))

    def _is(self, word: str, name: str) -> bool:
        return fnmatchcase(name, word) or word in self.kinematics.bodies[name].get("groups", ())

    def pair_id(self, a: str, b: str) -> int:
        """Return the pair's rank among all pairs a < b of bodies in document order."""
        n, i, j = len(self.names), self.names.index(a), self.names.index(b)
        return i * (2 * n - i - 1) // 2 + j - i - 1

    def interval(self, a: str, b: str) -> tuple[float, float]:
        """Return the times (s) in which both bodies exist."""
        one, other = self.kinematics.exists(a), self.kinematics.exists(b)
        return max(self.start, one[0], other[0]), min(self.end, one[1], other[1])

    def pair(self, a: str, b: str) -> PairDistance:
        """Return the pair's distances, prepared once."""
        if (a, b) not in self._distances:
            self._distances[a, b] = PairDistance(self.surfaces[a], self.surfaces[b])
        return self._distances[a, b]

    def signed(self, a: str, b: str, times: FloatArray) -> FloatArray:
        """Return (n,) m: the signed distances of two bodies at times (n,) s."""
        return self.pair(a, b).signed(self.kinematics.relative(a, b, times))

    def surface_distance(self, a: str, b: str, times: FloatArray) -> FloatArray:
        """Return (n,) m: the signed distances of their surfaces, blind to containment."""
        return self.pair(a, b).surfaces(self.kinematics.relative(a, b, times))

    def from_points(self, name: str, times: FloatArray, points: FloatArray) -> FloatArray:
        """Return (n,) m: signed distances of world points (n, 3) from a body at times (n,) s; negative inside."""
        if (name, "") not in self._distances:
            self._distances[name, ""] = PairDistance(self.surfaces[name], POINT)
        world = self.kinematics.world_from_body(name, times)
        return self._distances[name, ""].signed(inverse(world) @ rigid(None, points))

    def chord_limit(self, a: str, b: str) -> float:
        """Return the most (m) that what the tool measures of two bodies may be nearer than they are."""
        return self.surfaces[a].chord_limit + self.surfaces[b].chord_limit

    def slack(self, a: str, b: str) -> float:
        """Return how far (m) the distance of two bodies may be below that of the meshes inside their round shapes."""
        return sum(float(self.surfaces[name].slack.max(initial=0.0)) for name in (a, b))

    def blur(self, name: str, times: FloatArray) -> FloatArray:
        """Return (n,) m: how far points of a body move within 1 ns of times (n,), as logged times are rounded so."""
        before = self.kinematics.world_from_body(name, times - NANOSECOND)
        after = self.kinematics.world_from_body(name, times + NANOSECOND)
        return moved(before, after, self.surfaces[name].extent)

    def pair_blur(self, a: str, b: str, times: FloatArray) -> FloatArray:
        """Return (n,) m: how far points of b move in a's frame within 1 ns of times (n,)."""
        before, after = (self.kinematics.relative(a, b, times + shift) for shift in (-NANOSECOND, NANOSECOND))
        return moved(before, after, self.surfaces[b].extent)

    def creep(self, a: str, b: str, times: FloatArray) -> FloatArray:
        """Return (n,) m: the same to the one side of times (n,) to which they move less: no jump is spread."""
        now = self.kinematics.relative(a, b, times)
        poses = [self.kinematics.relative(a, b, times + shift) for shift in (-NANOSECOND, NANOSECOND)]
        return np.minimum(*(moved(now, one, self.surfaces[b].extent) for one in poses))

    def steps(self, a: str, b: str, poses: FloatArray) -> FloatArray:
        """Return (n - 1,) m: how far, at most, points of b move in a's frame from each pose (n, 4, 4) to the next."""
        return moved(poses[:-1], poses[1:], self.surfaces[b].extent)


def moved(before: FloatArray, after: FloatArray, extent: float) -> FloatArray:
    """Return (n,) m: how far, at most, points within `extent` m of the origin are moved from pose to pose (n, 4, 4)."""
    turned = np.linalg.norm(after[:, :3, :3] - before[:, :3, :3], axis=(1, 2))
    return np.linalg.norm(after[:, :3, 3] - before[:, :3, 3], axis=1) + turned * extent


def seconds(message: Mapping[str, Any], epoch: int) -> float:
    """Return a message's own time in scene seconds, from its timestamp (ns) and the run's epoch (ns).

    The float nearest to it: where floats are farther apart than 1 ns, the very one that was written.
    """
    return (int(message["timestamp"]) - epoch) / 10**9


def point(value: Mapping[str, float]) -> tuple[float, float, float]:
    """Return a point's coordinates (m); nan where the log leaves it out."""
    return (value.get("x", math.nan), value.get("y", math.nan), value.get("z", math.nan))
