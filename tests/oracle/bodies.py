"""A body's surface as the oracle sees it: triangles with rounding radii, round shapes, connected parts, solids."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .enclosed import Solid, solids_of
from .meshes import read_triangles, topology
from .motions import Units, known
from .poses import units_of
from .rigid import METRES, FloatArray, IntArray, numbers, pose_of
from .rounds import Round, round_of

Z_UP_FROM_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
BOX_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
BOX_TRIANGLES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)


@dataclass(frozen=True, eq=False)
class Surface:
    """The triangles of a body in its own frame, in m.

    A point is the triangle (p, p, p), a segment (a, b, b). The body is all points within `radii` of its triangle,
    all points inside its solids, and its round shapes, of which the triangles are a coarse mesh inside.

    Attributes:
        triangles: (n, 3, 3) m.
        radii: (n,) m, the rounding radius of each triangle's shape.
        probes: (k, 3) m, one corner of each connected part of each shape.
        solids: what the shapes enclose.
        rounds: cylinders, cones and ellipsoids.
        owners: (n,) which of `rounds` each triangle belongs to, -1 for none; None: all belong to none.
    """

    triangles: FloatArray
    radii: FloatArray
    probes: FloatArray
    solids: tuple[Solid, ...]
    rounds: tuple[Round, ...] = ()
    owners: IntArray | None = None

    @cached_property
    def round_of(self) -> IntArray:
        """(n,) which of `rounds` each triangle belongs to, -1 for none."""
        return np.full(len(self.triangles), -1) if self.owners is None else self.owners

    @cached_property
    def slack(self) -> FloatArray:
        """(n,) m: how far points of a triangle's round shape may lie from the shape's triangles; 0 if it has none."""
        return np.array([*(one.slack for one in self.rounds), 0.0])[self.round_of]

    @cached_property
    def extent(self) -> float:
        """The largest distance (m) of a point of the body from its frame's origin."""
        if not len(self.triangles):
            return 0.0
        return float((np.linalg.norm(self.triangles, axis=2) + (self.radii + self.slack)[:, None]).max())

    @cached_property
    def chord_limit(self) -> float:
        """The most (m) that what the tool measures may stand out from the body."""
        return max((one.chord_limit for one in self.rounds), default=0.0)

    @cached_property
    def groups(self) -> tuple[NDArray[np.int64], ...]:
        """Indices of near triangles, at most 8 a group, by halving along the longest side; round shapes apart."""
        centres = self.triangles.mean(axis=1)
        parts = [np.flatnonzero(self.round_of == owner) for owner in range(-1, len(self.rounds))]
        return tuple(group for part in parts for group in halved(centres, part))

    def lowest(self) -> FloatArray:
        """Return (3,) m: the body's point of least z."""
        tips = self.triangles.reshape(-1, 3) - np.array([0.0, 0.0, 1.0]) * np.repeat(self.radii, 3)[:, None]
        down = np.array([[0.0, 0.0, -1.0]])
        tips = np.concatenate([tips, *(one.support(down) for one in self.rounds)])
        return tips[tips[:, 2].argmin()]


def halved(centres: FloatArray, indices: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Split indices of centres (n, 3) into groups of at most 8, at the median of the widest axis."""
    if len(indices) <= 8:
        return [indices] if len(indices) else []
    points = centres[indices]
    order = indices[np.argsort(points[:, np.argmax(np.ptp(points, axis=0))], kind="stable")]
    middle = len(order) // 2
    return halved(centres, order[:middle]) + halved(centres, order[middle:])


@dataclass(frozen=True, eq=False)
class Core:
    """One shape in its body: triangles (n, 3, 3) m, a rounding radius in m, the round shape that it is, if any."""

    triangles: FloatArray
    radius: float = 0.0
    round: Round | None = None


def surface_of(scene: Mapping[str, Any], name: str, folder: Path) -> Surface:
    """Build a body's surface; mesh files are found relative to the scene's folder."""
    units = units_of(scene)
    shapes = ((scene["bodies"][name] or {}).get("shapes")) or []
    cores = [core_of(scene, shape, folder, units) for shape in shapes]
    kinds = [topology(core.triangles) for core in cores]
    probes = [core.triangles[kind.parts, 0] for core, kind in zip(cores, kinds, strict=True)]
    rounds = [core.round for core in cores if core.round is not None]
    owners = [
        np.full(len(core.triangles), -1 if core.round is None else rounds.index(core.round), dtype=np.int64)
        for core in cores
    ]
    return Surface(
        np.concatenate([np.zeros((0, 3, 3)), *(core.triangles for core in cores)]),
        np.concatenate([np.zeros(0), *(np.full(len(core.triangles), core.radius) for core in cores)]),
        np.concatenate([np.zeros((0, 3)), *probes]),
        tuple(solid for core in cores for solid in solids_of(core.triangles)),
        tuple(rounds),
        np.concatenate([np.zeros(0, dtype=np.int64), *owners]),
    )


def core_of(scene: Mapping[str, Any], shape: Mapping[str, Any], folder: Path, units: Units) -> Core:
    """Return a shape in its body's frame."""
    pose = pose_of(shape.get("pose"), units.metres, units.radians)
    whole = round_of(shape, units.metres, pose)
    if whole is not None:
        return Core(whole.mesh, 0.0, whole)
    radius = 0.0
    if "mesh" in shape:
        core = mesh_core(scene["meshes"][shape["mesh"]], folder) * numbers(shape.get("scale", 1.0))
    elif "box" in shape:
        core = (BOX_CORNERS * numbers(shape["box"]) * units.metres)[BOX_TRIANGLES]
    elif "sphere" in shape:
        core, radius = np.zeros((1, 3, 3)), float(shape["sphere"]) * units.metres
    elif "capsule" in shape:
        radius = float(shape["capsule"]["radius"]) * units.metres
        half = 0.5 * float(shape["capsule"]["length"]) * units.metres
        core = np.array([[[0.0, 0.0, -half], [0.0, 0.0, half], [0.0, 0.0, half]]])
    else:
        raise NotImplementedError(f"the oracle does not know shape {sorted(shape)}")
    return Core(core @ pose[:3, :3].T + pose[:3, 3], radius)


def mesh_core(mesh: Mapping[str, Any], folder: Path) -> FloatArray:
    """Return a mesh file's triangles (n, 3, 3) in m, z up."""
    triangles = read_triangles(folder / mesh["file"]) * METRES[mesh["units"]]
    return triangles @ Z_UP_FROM_Y_UP.T if known(mesh.get("up", "z"), "z", "y") == "y" else triangles
