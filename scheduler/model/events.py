"""The events of a run: frozen values. Times are in scene seconds, lengths in m, points in the world frame."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import FloatArray

Point = tuple[float, float, float]


class Reason(Enum):
    """Why a pair woke."""

    START = 1
    TIME_BOUND = 2
    TIME_RESOLUTION = 3
    KNOT = 4
    WINDOW = 5
    CONTACT = 6
    REFINE = 7
    END = 8
    MINIMUM = 9


class Level(Enum):
    """What measured the clearance: bounding spheres, or the exact meshes."""

    SPHERE = 1
    MESH = 3


class Bound(Enum):
    """Which bound set the sleep that follows a wakeup."""

    NONE = ""
    SPEED_ACCELERATION = "speed_acceleration"
    DISPLACEMENT = "displacement"
    SPHERE_SLABS = "sphere_slabs"
    BODY_SLAB = "body_slab"
    TRIANGLE_SLABS = "triangle_slabs"
    INSCRIBED_SPHERES = "inscribed_spheres"
    TRIANGLE_OVERLAP = "triangle_overlap"
    TIME_RESOLUTION = "time_resolution"
    CONTACT_TOLERANCE = "contact_tolerance"
    WINDOWS = "windows"


class FeatureKind(Enum):
    """Where on a triangle a witness point lies."""

    VERTEX = 1
    EDGE = 2
    FACE = 3


class Phase(Enum):
    """Which end of a contact."""

    BEGIN = 1
    END = 2


class ContactKind(Enum):
    """Whether the surfaces meet, or one solid lies wholly inside the other."""

    SURFACE = 1
    CONTAINED = 2


class Verdict(Enum):
    """What is proved of a pair over a span."""

    CLEAR = 1
    BREACH = 2
    CONTACT = 3
    UNRESOLVED = 4
    POSSIBLE = 5


@dataclass(frozen=True, slots=True)
class PairKey:
    """A pair of bodies by index, a < b, and its `pair_id`, which breaks ties."""

    id: int
    a: int
    b: int


@dataclass(frozen=True, slots=True)
class Feature:
    """The vertex, edge or face of a triangle that holds a witness point.

    Attributes:
        shape: index of the shape in its body.
        triangle: index of the triangle in the shape's mesh.
        index: of the corner (0..2), or of the edge from corner `index` to the next; 0 for a face.
    """

    kind: FeatureKind
    shape: int
    triangle: int
    index: int


@dataclass(frozen=True, slots=True)
class Wakeup:
    """A pair woke, was measured at `level` and sleeps again.

    Attributes:
        clearance: m, certified lower bound on the distance of the solids at `time`, 0 in contact.
        sleep: s until the next wakeup of the pair, or for which windows clear it at least; 0 at the end.
    """

    time: float
    pair: PairKey
    reason: Reason
    level: Level
    bound: Bound
    clearance: float
    sleep: float


@dataclass(frozen=True, slots=True)
class Distance:
    """An exact distance of the two solids (rounding radii off), 0 in contact, and where it was taken.

    Attributes:
        excess: m, how much farther apart the bodies may be than the polyhedra around their round shapes.
    """

    time: float
    pair: PairKey
    distance: float
    witness_a: Point
    witness_b: Point
    feature_a: Feature
    feature_b: Feature
    excess: float = 0.0


@dataclass(frozen=True, slots=True)
class Collision:
    """A contact begins or ends inside the bracket: clear at `time_clear`, touching at `time_touching`."""

    pair: PairKey
    phase: Phase
    time_clear: float
    time_touching: float
    kind: ContactKind
    feature_a: Feature
    feature_b: Feature
    point: Point

    @property
    def time(self) -> float:
        """The fact's own time, s."""
        return self.time_touching


@dataclass(frozen=True, slots=True)
class Span:
    """One verdict over [start, end].

    Attributes:
        clearance: m, certified lower bound on the distance inside; 0 where touching is not excluded. Above 0 in an
            UNRESOLVED span, it is the margin that is neither kept nor breached for certain.
        depth_limit: m, no point of one solid is deeper than this in the other, inside an UNRESOLVED span; 0 when
            CLEAR or BREACH, nan when CONTACT.
        error: m, by how much distances measured between the two may be wrong; it is off the clearance already.
    """

    pair: PairKey
    verdict: Verdict
    start: float
    end: float
    clearance: float
    depth_limit: float
    error: float = 0.0

    @property
    def time(self) -> float:
        """The fact's own time, s."""
        return self.end


@dataclass(frozen=True, slots=True)
class Window:
    """A box along the world's axes, from `low` to `high`, that the body of this index does not leave over [start, end].

    The next window of the body begins at `end`, or, where it jumps, at the next float.
    """

    body: int
    start: float
    end: float
    low: Point
    high: Point

    @property
    def time(self) -> float:
        """The fact's own time, s."""
        return self.start


@dataclass(frozen=True, slots=True)
class Nearness:
    """How near a pair is at the instant of a snapshot, measured exactly.

    Attributes:
        verdict: CONTACT where the solids touch (distance 0), BREACH below the margin, else CLEAR; of the instant alone.
            Where a path is unknown, POSSIBLE where they may touch, or be below the margin.
        witness_a, witness_b: the nearest points, in the world.
    """

    pair: PairKey
    distance: float
    verdict: Verdict
    witness_a: Point
    witness_b: Point


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """The whole scene at one instant, for people to look at; no part of the certificate.

    Attributes:
        poses: (n, 4, 4) world_from_body of every body, in document order.
        there: (n,) which bodies exist.
        nearest: the nearest pairs, nearest first (ties by pair id); the first holds the least distance of all.
        contacts: how many pairs are in contact.
        trigger: the collision it was taken for, None for a tick.
    """

    time: float
    poses: FloatArray
    there: NDArray[np.bool_]
    nearest: tuple[Nearness, ...]
    contacts: int
    trigger: Collision | None


Event = Wakeup | Distance | Collision | Span | Window | Snapshot
