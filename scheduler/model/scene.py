"""The scene as the scheduler sees it: frozen values in SI units, checked once when they are made."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, isqrt, ulp
from typing import TypeVar

import numpy as np

from ..geometry.arrays import FloatArray, IntArray
from ..geometry.round_solid import RoundSolid
from ..motions import Interval, Motion

ALWAYS: Interval = (-inf, inf)


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """The inside of one closed skin of a mesh, but for its cavities.

    Attributes:
        skin: (k, 3) vertex indices, normals outwards.
        cavities: the skins (k, 3) of what is cut from it.
        crossed: whether the skin crosses itself, so that it encloses a point only if no way leads out; None if unknown.
    """

    skin: IntArray
    cavities: tuple[IntArray, ...]
    crossed: bool | None


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """A triangle mesh in its own frame, shared by every shape that shows it.

    Attributes:
        name: as in the scene file, or a description of the generated shape.
        vertices: (n, 3) m, finite, read-only.
        triangles: (m, 3) vertex indices, m >= 1, read-only. A point is the triangle (p, p, p), a segment (a, b, b).
        solid: whether the surface is closed: every edge joins two triangles.
        solids: what it encloses; none stated of a closed surface: one solid, of all its triangles.
    """

    name: str
    vertices: FloatArray
    triangles: IntArray
    solid: bool
    solids: tuple[Solid, ...] = ()

    @property
    def encloses(self) -> bool:
        """Whether what lies inside it is inside the body."""
        return self.solid or bool(self.solids)


def used_vertices(mesh: Mesh) -> FloatArray:
    """Return the vertices (k, 3) m that the mesh's triangles have, in order."""
    used = np.zeros(len(mesh.vertices), dtype=bool)
    used[mesh.triangles] = True
    found: FloatArray = mesh.vertices if used.all() else mesh.vertices[used]
    return found


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """All points within `radius` (m) of a mesh, its core, placed in the body by `pose` (4x4, body_from_mesh).

    Attributes:
        chord_error: m, no point of the mesh is farther than this from the true shape, which it encloses; 0 where the
            mesh is the shape itself.
        solid: that shape in the mesh's frame; None where the mesh is the shape itself.
    """

    mesh: Mesh
    radius: float
    pose: FloatArray
    chord_error: float = 0.0
    solid: RoundSolid | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A rigid body, or a mere frame when it has no shapes.

    world_from_body(t) = world_from_parent(t) @ pose @ motion.pose(t).

    Attributes:
        exists: s, from and to: when its shapes are there. Its frame always is.
    """

    name: str
    parent: int | None
    pose: FloatArray
    motion: Motion
    shapes: tuple[Shape, ...]
    exists: Interval = ALWAYS

    @property
    def chord_error(self) -> float:
        """The farthest (m) that any of its meshes stands out from the true shape."""
        return max((shape.chord_error for shape in self.shapes), default=0.0)


@dataclass(frozen=True, slots=True)
class PairSet:
    """The pairs with one body in each of two sets."""

    one: frozenset[int]
    other: frozenset[int]

    def __contains__(self, pair: tuple[int, int]) -> bool:
        """Return whether the pair of bodies a, b is one of them, in either order."""
        a, b = pair
        return (a in self.one and b in self.other) or (b in self.one and a in self.other)

    def partners(self, body: int) -> frozenset[int]:
        """Return the bodies that a body is in one of them with."""
        nobody = frozenset[int]()
        return (self.other if body in self.one else nobody) | (self.one if body in self.other else nobody)


@dataclass(frozen=True, slots=True)
class PairRules:
    """Which pairs are checked, and the margins of some: `checked` overrides `ignored`, a later margin an earlier one.

    Attributes:
        default: whether pairs that are neither ignored nor checked by name are checked.
        margins: m.
    """

    ignored: tuple[PairSet, ...] = ()
    checked: tuple[PairSet, ...] = ()
    default: bool = True
    margins: tuple[tuple[PairSet, float], ...] = ()

    def allow(self, a: int, b: int) -> bool:
        """Return whether the pair of bodies a, b is checked."""
        if any((a, b) in pairs for pairs in self.checked):
            return True
        return self.default and not any((a, b) in pairs for pairs in self.ignored)

    def margin(self, a: int, b: int, default: float) -> float:
        """Return the pair's margin (m), `default` where no rule names the pair."""
        return next((margin for pairs, margin in reversed(self.margins) if (a, b) in pairs), default)


@dataclass(frozen=True, slots=True)
class Settings:
    """What the run may be asked to do.

    Attributes:
        time_resolution: s, the lecture's t_min, the least step of the main loop.
        contact_tolerance: s, the widest bracket that a contact's begin or end may keep.
        margin: m, a pair nearer than this is in breach, unless a rule of the scene gives it a margin of its own.
        distance_tolerance: of a pair's least distance, how far its certified bound may lie below the measured one, but
            for 1e-6 m; None leaves it as the sleeps have it.
    """

    time_resolution: float = 1e-3
    contact_tolerance: float = 1e-6
    margin: float = 0.0
    distance_tolerance: float | None = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Bodies in document order (a parent may stand after its child) and the time range [start, end] in s."""

    bodies: tuple[Body, ...]
    start: float
    end: float
    rules: PairRules

    def shared_time(self, a: int, b: int) -> Interval:
        """Return when both bodies exist within the scene's time, s; from >= to where they never meet."""
        (a_from, a_to), (b_from, b_to) = self.bodies[a].exists, self.bodies[b].exists
        return max(self.start, a_from, b_from), min(self.end, a_to, b_to)


def least_duration(start: float, end: float) -> float:
    """Return the shortest resolution or tolerance (s) that times in [start, end] can express: 64 spacings of floats."""
    return 64.0 * ulp(max(abs(start), abs(end)))


Number = TypeVar("Number", int, IntArray)


def pair_id(a: Number, b: Number, bodies: int) -> Number:
    """Return the rank of the pair a < b among all pairs of `bodies` bodies, in document order."""
    return a * (2 * bodies - a - 1) // 2 + b - a - 1


def bodies_of_pair(rank: int, bodies: int) -> tuple[int, int]:
    """Return the pair a < b of this rank among all pairs of `bodies` bodies."""
    twice = 2 * bodies - 1
    a = (twice - isqrt(twice * twice - 8 * rank)) // 2
    if pair_id(a, a + 1, bodies) > rank:  # the root was rounded down
        a -= 1
    return a, rank - pair_id(a, a + 1, bodies) + a + 1


def all_pairs(bodies: int) -> Iterator[tuple[int, int]]:
    """Yield every pair a < b of body indices in the order of `pair_id`."""
    return ((a, b) for a in range(bodies) for b in range(a + 1, bodies))
