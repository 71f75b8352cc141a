"""The skins of a triangle mesh: the closed surfaces around the spaces that it encloses.

Every triangle has two sides. Around an edge, each side faces a side of the next triangle. Sides that face each other,
from edge to edge, look into one space. The triangles of a space are its skin, but those that have both sides in it. A
skin is closed: at every edge its sides come in pairs, turned against each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cmp_to_key
from typing import NamedTuple

import numpy as np

from ..geometry.arrays import BoolArray, FloatArray, IntArray
from .components import components

#: rad: triangles around an edge that are nearer than this to each other are put in order by exact arithmetic.
NEAR_ANGLES = 1e-6
#: By this share of the tetrahedra between a skin and a point of the mesh its volume may be wrong: its sign is unknown.
FLAT = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class Skin:
    """A closed surface around a space.

    Attributes:
        triangles: (k, 3) vertex indices, normals out of the space.
        sources: (k,) which triangles of the mesh they are.
        winding: 1 if the mesh's normals point out of the space, -1 if they point into it, 0 if some do.
        walls: the share of its triangles that also bound another space, if neither is of mixed orientation.
        volume: m^3, of the space with all that lies in it.
        flat: whether that volume is 0, as far as rounding shows.
        low, high: (3,) m, the box around it.
    """

    triangles: IntArray
    sources: IntArray
    winding: int
    walls: float
    volume: float
    flat: bool
    low: FloatArray
    high: FloatArray


class Edges(NamedTuple):
    """Where triangles join: the uses of an edge by those of one piece, or else of several, in turn about the edge.

    Attributes:
        triangles: (h,) which triangle uses it.
        forward: (h,) whether it runs from the lower to the higher end there.
        starts: (joints,) where the uses at each begin.
        counts: (joints,) how many there are.
    """

    triangles: IntArray
    forward: BoolArray
    starts: IntArray
    counts: IntArray

    @property
    def ahead(self) -> IntArray:
        """(h,) The use that follows each one in turn."""
        following = np.arange(1, len(self.triangles) + 1)
        following[self.starts + self.counts - 1] = self.starts
        return following


def twins_of(triangles: IntArray) -> IntArray:
    """Return (m,) for each triangle the number of its set of corners if another one has the same, else -1."""
    ordered = np.sort(triangles, axis=1)
    mixed = ordered @ np.array([0x4F1BBCDCBFA53E0A, 0x2545F4914F6CDD1D, 1])  # wraps around
    order = np.argsort(mixed, kind="stable")
    like = mixed[order[1:]] == mixed[order[:-1]]
    sets: dict[tuple[int, ...], list[int]] = {}
    for place in np.sort(order[np.append(False, like) | np.append(like, False)]).tolist():
        sets.setdefault(tuple(ordered[place].tolist()), []).append(place)
    number = np.full(len(triangles), -1)
    for index, members in enumerate(members for members in sets.values() if len(members) > 1):
        number[members] = index
    return number


def edges_of(vertices: FloatArray, triangles: IntArray) -> Edges:
    """Return where triangles (m, 3), each with three corners, join.

    A piece is the triangles that join across edges of two. At an edge of more, a piece that has it twice, or four
    times, joins itself alone; the rest joins all together.
    """
    begins, ends = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    keys = np.minimum(begins, ends) * len(vertices) + np.maximum(begins, ends)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    new = np.ones(len(keys), dtype=bool)
    new[1:] = keys[1:] != keys[:-1]
    starts = np.flatnonzero(new)
    counts = np.diff(np.append(starts, len(keys)))
    of, forward = order // 3, (begins < ends)[order]
    pairs = starts[counts == 2]
    crowded = np.flatnonzero(counts > 2)
    pieces = components(len(triangles), of[pairs], of[pairs + 1]) if len(crowded) else of[:0]
    for begin, count in zip(starts[crowded].tolist(), counts[crowded].tolist(), strict=True):
        uses = np.arange(begin, begin + count)
        lower, higher = divmod(int(keys[begin]), len(vertices))
        joints = []
        for joint in _joints(pieces[of[uses]]):
            corners = triangles[of[uses[joint]]]
            opposite = vertices[corners[(corners != lower) & (corners != higher)]]
            turn = _turn(vertices[[lower, higher]], opposite, forward[uses[joint]], of[uses[joint]])
            joints.append(uses[joint][turn])
        new[np.cumsum([begin, *map(len, joints[:-1])])] = True
        of[uses], forward[uses] = of[np.concatenate(joints)], forward[np.concatenate(joints)]
    starts = np.flatnonzero(new)
    return Edges(of, forward, starts, np.diff(np.append(starts, len(keys))))


def _joints(pieces: IntArray) -> list[IntArray]:
    """Return which uses of an edge join each other, by the pieces (k,) that they are of."""
    counts = {int(piece): int((pieces == piece).sum()) for piece in pieces}
    alone = [np.flatnonzero(pieces == piece) for piece, count in counts.items() if count % 2 == 0]
    rest = np.flatnonzero([counts[int(piece)] % 2 == 1 for piece in pieces])
    return [*alone, rest] if len(rest) else alone


def _turn(ends: FloatArray, points: FloatArray, forward: BoolArray, triangles: IntArray) -> list[int]:
    """Return the order of triangles about their common edge (2, 3), by their third corners (k, 3)."""
    axis = ends[1] - ends[0]
    rays = points - ends[0]
    if len(points) < 3:
        return list(range(len(points)))
    across = np.cross(axis, rays)
    reference = int(np.linalg.norm(across, axis=1).argmax())
    first = across[reference]
    angles = np.arctan2(np.cross(first, across) @ axis / np.linalg.norm(axis), across @ first) % (2.0 * np.pi)
    order = sorted(range(len(points)), key=angles.__getitem__)
    gaps = np.diff(np.append(angles[order], angles[order[0]] + 2.0 * np.pi))
    if np.isfinite(gaps).all() and gaps.min() > NEAR_ANGLES:
        return order
    places = [_exact_place(ends, points[reference], point) for point in points]

    def compared(i: int, j: int) -> int:
        (half, x, y), (other_half, other_x, other_y) = places[i], places[j]
        turn = x * other_y - other_x * y
        return half - other_half or (-1 if turn > 0 else int(turn < 0))

    order = sorted(np.argsort(triangles, kind="stable").tolist(), key=cmp_to_key(compared))
    begins = [k for k, one in enumerate(order) if k == 0 or compared(order[k - 1], one)]
    return _through([order[i:j] for i, j in zip(begins, [*begins[1:], len(order)], strict=True)], forward)


def _through(groups: list[list[int]], forward: BoolArray) -> list[int]:
    """Return the order in which one goes through triangles about an edge, those at one angle as groups in file order.

    A forward triangle leads out of matter, another one into it. Of those that lie on each other, first all go that lead
    to where one is not; of those that lead the same way, the later lies within the earlier.
    """
    plain = (k for k, group in enumerate(groups) if len(set(forward[group].tolist())) == 1)
    begin = next(plain, 0)
    within, found = True, []
    for group in groups[begin:] + groups[:begin]:
        leave = [one for one in reversed(group) if forward[one]]
        enter = [one for one in group if not forward[one]]
        found += leave + enter if within else enter + leave
        within = not forward[found[-1]]
    return found


def _exact_place(ends: FloatArray, first: FloatArray, point: FloatArray) -> tuple[int, Fraction, Fraction]:
    """Return in which half turn from the first point about the edge a point lies, and where as seen along the edge."""
    axis = _exact(ends[0], ends[1])
    ray, zero = _exact(ends[0], point), _exact(ends[0], first)
    across, zero_across = _cross(axis, ray), _cross(axis, zero)
    x, y = _dot(across, zero_across), _dot(axis, _cross(zero, ray))
    return int(y < 0 or (y == 0 and x < 0)), x, y


Exact = tuple[Fraction, Fraction, Fraction]


def _exact(origin: FloatArray, point: FloatArray) -> Exact:
    x, y, z = (Fraction(float(b)) - Fraction(float(a)) for a, b in zip(origin, point, strict=True))
    return x, y, z


def _cross(a: Exact, b: Exact) -> Exact:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _dot(a: Exact, b: Exact) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def sides_of(edges: Edges, count: int) -> IntArray:
    """Return (count, 2) for the front and the back of each triangle which space it looks into, by a number."""
    ahead = edges.ahead
    plain = np.zeros(len(ahead), dtype=bool)  # neighbours wound alike, alone at their edge: front faces front
    pairs = edges.starts[edges.counts == 2]
    pairs = pairs[edges.forward[pairs] != edges.forward[pairs + 1]]
    plain[pairs] = plain[pairs + 1] = True
    pieces = components(count, edges.triangles[pairs], edges.triangles[pairs + 1])
    rest = np.flatnonzero(~plain)
    behind, before = 2 * pieces[edges.triangles[rest]], 2 * pieces[edges.triangles[ahead[rest]]]
    spaces = components(2 * count, behind + ~edges.forward[rest], before + edges.forward[ahead[rest]])
    sides: IntArray = spaces[2 * pieces[:, None] + np.arange(2)]
    return sides


def skins_of(vertices: FloatArray, triangles: IntArray, kept: IntArray, twins: IntArray, sides: IntArray) -> list[Skin]:
    """Return the skins of a mesh, the largest first.

    Args:
        vertices: (n, 3) m, no two of them equal.
        triangles: (m, 3) of the mesh.
        kept: (k,) its triangles with three corners.
        twins: (k,) the number of a triangle's set of corners if another one has the same, else -1.
        sides: (k, 2) the spaces that they look into.
    """
    parting = sides[:, 0] != sides[:, 1]
    sources, sides, twins = kept[parting], sides[parting], twins[parting]
    if not len(sources):
        return []
    looks = _renumbered(sides.T.reshape(-1))
    spaces = int(looks.max()) + 1
    order = np.argsort(looks, kind="stable")
    starts = np.searchsorted(looks[order], np.arange(spaces + 1))
    corners = vertices[triangles[sources]]
    origins = corners[order[starts[:-1]] % len(sources), 0]  # on each skin: from afar a small one is lost in rounding
    front, back = (_sixths(corners - origins[own][:, None]) for own in np.split(looks, 2))
    sixths = np.concatenate((-front, back))
    volumes, sizes = (np.bincount(looks, weights) for weights in (sixths, np.abs(sixths)))
    enclosed = volumes >= -FLAT * sizes  # both sides of a skin whose volumes cancel
    fronts, backs = (np.bincount(own, minlength=spaces) for own in np.split(looks, 2))
    plain = (volumes > FLAT * sizes) & ((fronts == 0) | (backs == 0))
    walled = np.logical_and(*np.split(plain[looks], 2))
    columns = np.ascontiguousarray(vertices.T)
    found = []
    for space in np.flatnonzero(enclosed):
        members = order[starts[space] : starts[space + 1]]
        own, turned = members % len(sources), members < len(sources)
        outward = triangles[sources[own]]
        outward[turned] = outward[turned][:, ::-1]
        left = _uncancelled(outward, twins[own])
        if not left.all():
            own, turned, outward = own[left], turned[left], outward[left]
        if not len(own):
            continue
        points = columns[:, outward.reshape(-1)]
        winding = -1 if turned.all() else 0 if turned.any() else 1
        box = points.min(axis=1), points.max(axis=1)
        volume, flat = float(volumes[space]), bool(volumes[space] <= FLAT * sizes[space])
        found.append(Skin(outward, sources[own], winding, float(walled[own].mean()), volume, flat, *box))
    return sorted(found, key=lambda skin: (-skin.volume, skin.sources[0]))


def _sixths(corners: FloatArray) -> FloatArray:
    """Return the volumes (m,) m^3 of the tetrahedra from the origin to triangles (m, 3, 3) m, by orientation."""
    volumes: FloatArray = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    return volumes


def _renumbered(numbers: IntArray) -> IntArray:
    """Return the numbers with those that are there counted from 0, in order."""
    there = np.zeros(int(numbers.max()) + 1, dtype=np.int64)
    there[numbers] = 1
    renumbered: IntArray = (np.cumsum(there) - 1)[numbers]
    return renumbered


def _uncancelled(outward: IntArray, twins: IntArray) -> BoolArray:
    """Return which triangles of a space are left when those go that lie on each other, turned against each other."""
    left = np.ones(len(outward), dtype=bool)
    open_twins: dict[tuple[int, bool], list[int]] = {}
    for place in np.flatnonzero(twins >= 0).tolist():
        corners = outward[place].tolist()
        least = corners.index(min(corners))
        rising = corners[(least + 1) % 3] < corners[(least + 2) % 3]
        if others := open_twins.get((int(twins[place]), not rising)):
            left[[place, others.pop()]] = False
        else:
            open_twins.setdefault((int(twins[place]), rising), []).append(place)
    return left
