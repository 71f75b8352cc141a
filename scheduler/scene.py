"""The scene as the scheduler sees it: frozen values in SI units, checked at the door and never again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ulp

import numpy as np
from numpy.typing import NDArray

from .motions import Motion

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """A triangle mesh in its own frame, shared by every shape that shows it.

    Attributes:
        name: as in the scene file, or a description of the generated shape.
        vertices: (n, 3) m, finite, read-only.
        triangles: (m, 3) vertex indices, m >= 1, read-only. A point is the triangle (p, p, p), a segment (a, b, b).
        solid: whether the surface is closed, so that what lies inside it is inside the body.
    """

    name: str
    vertices: FloatArray
    triangles: IntArray
    solid: bool


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """All points within `radius` (m) of a mesh, its core, placed in the body by `pose` (4x4, body_from_mesh)."""

    mesh: Mesh
    radius: float
    pose: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A rigid body, or a mere frame when it has no shapes.

    world_from_body(t) = world_from_parent(t) @ pose @ motion.pose(t).
    """

    name: str
    parent: int | None
    pose: FloatArray
    motion: Motion
    shapes: tuple[Shape, ...]


@dataclass(frozen=True, slots=True)
class PairRule:
    """Whether pairs with one body in each set are checked. A rule that checks overrides one that ignores."""

    one: frozenset[int]
    other: frozenset[int]
    check: bool

    def matches(self, a: int, b: int) -> bool:
        """Tell whether the rule speaks of the pair of bodies a, b, in either order."""
        return (a in self.one and b in self.other) or (b in self.one and a in self.other)


@dataclass(frozen=True, slots=True)
class Settings:
    """What the run may be asked to do, all in seconds.

    Attributes:
        time_resolution: the lecture's t_min, the least step of the main loop.
        contact_tolerance: the widest bracket that a contact's begin or end may keep.
    """

    time_resolution: float = 1e-3
    contact_tolerance: float = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Bodies in document order (a parent may stand after its child) and the time range [start, end] in s."""

    bodies: tuple[Body, ...]
    start: float
    end: float
    rules: tuple[PairRule, ...]

    def allows(self, a: int, b: int) -> bool:
        """Tell whether the rules let the pair of bodies a, b be checked."""
        matching = [rule.check for rule in self.rules if rule.matches(a, b)]
        return any(matching) or not matching


def least_duration(start: float, end: float) -> float:
    """Return the shortest resolution or tolerance (s) that times in [start, end] can express: 64 spacings of floats."""
    return 64.0 * ulp(max(abs(start), abs(end)))


def pair_id(a: int, b: int, bodies: int) -> int:
    """Return the rank of the pair a < b among all pairs of `bodies` bodies, in document order."""
    return a * (2 * bodies - a - 1) // 2 + b - a - 1


def all_pairs(bodies: int) -> Iterator[tuple[int, int]]:
    """Yield every pair a < b of body indices in the order of `pair_id`."""
    return ((a, b) for a in range(bodies) for b in range(a + 1, bodies))
