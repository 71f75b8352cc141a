"""The inside of a mesh: its closed parts, each with the cavities that are cut from it.

A part is the triangles that join across edges that exactly two share. A closed part encloses everything that its
triangles, turned alike, wind around. A part wound the other way that lies wholly inside another, smallest one is its
cavity, unless that is a cavity itself. Equal triangles count once.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .rigid import FloatArray
from .triangles import cross, dot

BATCH_CELLS = 200_000
"""Points times triangles evaluated in one go."""

WHOLLY = 1e-6
"""How far a winding number may be from 1 of what is wholly inside."""


def winding(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Return (n,) winding numbers of the triangles (m, 3, 3) about points (n, 3): 1 inside a closed surface.

    The sum of the signed solid angles over 4 pi (Van Oosterom and Strackee, 1983).
    """
    step = max(1, BATCH_CELLS // len(triangles))
    parts = [solid_angles(points[i : i + step], triangles) for i in range(0, len(points), step)]
    return np.concatenate([np.zeros(0), *parts]) / (4.0 * np.pi)


def solid_angles(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Return (n,) sr: the signed solid angles of the triangles (m, 3, 3) summed, seen from points (n, 3)."""
    corners = [np.moveaxis(triangles[None, :, k] - points[:, None], 2, 0) for k in range(3)]
    a, b, c = corners
    la, lb, lc = (np.sqrt(dot(corner, corner)) for corner in corners)
    above = dot(a, cross(b, c))
    below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
    return (2.0 * np.arctan2(above, below)).sum(axis=1)


@dataclass(frozen=True, eq=False)
class Solid:
    """A closed part and its cavities: skin (m, 3, 3) m and cavities (k, 3, 3) m each, triangles turned alike."""

    skin: FloatArray
    cavities: tuple[FloatArray, ...] = ()

    def holds(self, points: FloatArray) -> NDArray[np.bool_]:
        """Tell which points (n, 3) are inside; none may lie on a surface."""
        held = np.abs(winding(points, self.skin)) > 0.5
        for cavity in self.cavities:
            held[held] = np.abs(winding(points[held], cavity)) < 0.5
        return held

    @property
    def surface(self) -> FloatArray:
        """(n, 3, 3) m: all triangles around it."""
        return np.concatenate([self.skin, *self.cavities])


@dataclass(frozen=True, eq=False)
class Part:
    """A closed part: triangles (m, 3, 3), outward; 1 if the file has them so, -1 if turned over, 0 if some are."""

    triangles: FloatArray
    winding: int
    volume: float


def solids_of(triangles: FloatArray) -> tuple[Solid, ...]:
    """Return what triangles (n, 3, 3) enclose."""
    parts = sorted(closed_parts(triangles), key=lambda part: -part.volume)
    hosts: dict[int, list[int]] = {}
    for index, part in enumerate(parts):
        corners = part.triangles.reshape(-1, 3)
        around = [i for i in range(index) if (winding(corners, parts[i].triangles) > 1.0 - WHOLLY).all()]
        if around and around[-1] in hosts and part.winding * parts[around[-1]].winding < 0:
            hosts[around[-1]].append(index)
        else:
            hosts[index] = []
    return tuple(
        Solid(parts[host].triangles, tuple(parts[i].triangles for i in cavities)) for host, cavities in hosts.items()
    )


def closed_parts(triangles: FloatArray) -> list[Part]:
    """Return the closed parts of triangles (n, 3, 3), those with two equal corners left out."""
    _, flat = np.unique(triangles.reshape(-1, 3) + 0.0, axis=0, return_inverse=True)
    seen: dict[frozenset[int], int] = {}
    for index, corners in enumerate(flat.reshape(-1, 3).tolist()):
        if len(set(corners)) == 3:
            seen.setdefault(frozenset(corners), index)
    corners_of = {index: flat.reshape(-1, 3)[index].tolist() for index in seen.values()}
    uses: dict[frozenset[int], list[int]] = defaultdict(list)
    for index, (a, b, c) in corners_of.items():
        for edge in ((a, b), (b, c), (c, a)):
            uses[frozenset(edge)].append(index)
    parts, left = [], set(corners_of)
    while left:
        turned = turned_alike(min(left), corners_of, uses)
        left -= set(turned)
        if all(sum(index in turned for index in users) % 2 == 0 for users in uses.values()):
            parts.append(part_of(triangles, turned))
    return parts


def turned_alike(
    first: int, corners_of: dict[int, list[int]], uses: dict[frozenset[int], list[int]]
) -> dict[int, bool]:
    """Return the triangles of the first one's part, and whether each is to be turned over to lie as the first does."""
    turned, waiting = {first: False}, [first]
    while waiting:
        index = waiting.pop()
        corners = corners_of[index]
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            users = uses[frozenset((a, b))]
            other = users[0] if users[0] != index else users[-1]
            if len(users) == 2 and other not in turned:
                place = corners_of[other].index(a)
                alike = corners_of[other][(place + 1) % 3] != b
                turned[other] = turned[index] ^ (not alike)
                waiting.append(other)
    return turned


def part_of(triangles: FloatArray, turned: dict[int, bool]) -> Part:
    """Return the part of these triangles, outward."""
    indices, turns = np.array(list(turned)), np.array(list(turned.values()))
    own = triangles[indices].copy()
    own[turns] = own[turns][:, ::-1]
    centred = own - own.mean(axis=(0, 1))
    volume = float(np.linalg.det(centred).sum()) / 6.0
    if volume < 0.0:
        own, turns = own[:, ::-1], ~turns
    return Part(own, -1 if turns.all() else 0 if turns.any() else 1, abs(volume))
