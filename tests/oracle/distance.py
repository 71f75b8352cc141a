"""The exact distance of two bodies at many relative poses: spheres rule triangle pairs out, brute force does the rest.

Round shapes are looked for by the coarse meshes inside them and then measured as what they are.

Signed distance, here: positive = the distance (m) of the two bodies; negative = they overlap, and every motion of
less than its magnitude leaves them overlapping (some such depth, not the largest).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .bodies import Surface
from .elements import ElementPairs
from .inside import Containment
from .rigid import FloatArray, IntArray, inverse
from .triangles import separation

BATCH = 16_000
"""Triangle pairs evaluated in one go: more leave the processor's cache."""

ROUNDS = (3, 9, 27, 81, 1 << 40)
"""How many candidates of an instant have been evaluated after each round; each round sharpens the cut for the next."""

FEW = 1_000
"""Candidates that are evaluated in one go, whatever their rank."""

CHUNK_CELLS = 2_000_000
"""Instants times group pairs bounded in one go."""

SURE = 1e-9
"""m: an overlap deeper than this is not looked at further."""


SLIVER = 1e-6
"""A triangle whose sides at a corner turn by less, in radians, bounds nothing by its plane."""


class PairDistance:
    """Distances of body b from body a, given poses of b in the frame of a."""

    def __init__(self, a: Surface, b: Surface) -> None:
        self.a, self.b = Cover(a), Cover(b)
        self.inside = (Containment(b, a), Containment(a, b))
        self.elements = ElementPairs(a, b) if a.rounds or b.rounds else None

    def lower_bounds(self, poses: FloatArray) -> FloatArray:
        """Return (n,) m: cheap lower bounds on the distance of the surfaces at poses (n, 4, 4)."""
        step = max(1, CHUNK_CELLS // (len(self.a.group_radii) * len(self.b.group_radii)))
        parts = [self._group_bounds(poses[i : i + step]).min(axis=(1, 2)) for i in range(0, len(poses), step)]
        return np.concatenate([np.zeros(0), *parts])

    def signed(self, poses: FloatArray) -> FloatArray:
        """Return (n,) m: signed distances of the bodies, solids included, at poses (n, 4, 4)."""
        contained = self.contained(poses)
        out = np.zeros(len(poses))
        out[contained] = self.lower_bounds(poses[contained])
        exact = out <= SURE
        out[exact] = self._in_steps(poses[exact], whole=True)
        out = np.where(contained & (out > 0.0), -out, out)
        return out if self.elements is None else self._deepened(out, poses, contained)

    def _deepened(self, out: FloatArray, poses: FloatArray, contained: NDArray[np.bool_]) -> FloatArray:
        """Return signed distances (n,) m with the depths that round shapes' inner meshes show, where these are more."""
        held = np.flatnonzero(out <= 0.0)
        meshes = self.surfaces(poses[held])
        deep = np.where(meshes < 0.0, meshes, np.where(contained[held], -meshes, 0.0))
        out[held] = np.minimum(out[held], deep)
        return out

    def contained(self, poses: FloatArray) -> NDArray[np.bool_]:
        """Tell at which poses (n, 4, 4) a part of one body has a corner inside a solid of the other: an overlap."""
        return self.inside[0].any_inside(poses) | self.inside[1].any_inside(inverse(poses))

    def surfaces(self, poses: FloatArray) -> FloatArray:
        """Return (n,) m: signed distances of the surfaces alone, blind to containment; of inner meshes."""
        return self._in_steps(poses, whole=False)

    def _in_steps(self, poses: FloatArray, whole: bool) -> FloatArray:
        step = max(1, CHUNK_CELLS // (len(self.a.group_radii) * len(self.b.group_radii)))
        parts = [self._surfaces(poses[i : i + step], whole) for i in range(0, len(poses), step)]
        return np.concatenate([np.zeros(0), *parts])

    def _surfaces(self, poses: FloatArray, whole: bool) -> FloatArray:
        placed = Placed(poses, self.a, self.b)
        groups = self._group_bounds(poses)
        best = np.full(len(poses), np.inf)
        if whole and self.elements is not None:
            groups[:, self.a.round_groups[:, None] & self.b.round_groups] = np.inf
        flat = groups.reshape(len(poses), -1)
        nearest = np.unravel_index(flat.argmin(axis=1), groups.shape[1:])
        self._improve(placed, best, np.arange(len(poses)), nearest[0], nearest[1])
        open_ = (groups < best[:, None, None]) & (best > -SURE)[:, None, None]
        open_[np.arange(len(poses)), nearest[0], nearest[1]] = False
        self._improve(placed, best, *np.nonzero(open_))
        if whole and self.elements is not None:
            self._measure_rounds(self.elements, placed, best, groups)
            self.elements.lower_by_rounds(best, poses)
        return best

    def _measure_rounds(self, elements: ElementPairs, placed: Placed, best: FloatArray, groups: FloatArray) -> None:
        """Lower `best` (n,), taken between meshes, by the round shapes themselves wherever one may be nearer."""
        at, group_a, group_b = np.nonzero((groups < best[:, None, None]) & (best > -SURE)[:, None, None])
        at, i, j, _ = self._candidates(placed, best, at, group_a, group_b)
        slack = self.a.slack[i] + self.b.slack[j]
        keep = slack > 0.0
        at, i, j, slack = at[keep], i[keep], j[keep], slack[keep]
        found = [self._separations(placed.poses[at[part]], i[part], j[part]) for part in batches(len(at))]
        keep = np.concatenate([np.zeros(0), *found]) - slack < best[at]
        elements.lower(best, placed.poses, at[keep], i[keep], j[keep])

    def _group_bounds(self, poses: FloatArray) -> FloatArray:
        """Return (n, groups of a, groups of b) m: bounds from the groups' spheres and boxes."""
        a, b = self.a, self.b
        back = inverse(poses)
        in_a = (b.group_centres @ np.swapaxes(poses[:, :3, :3], 1, 2) + poses[:, None, :3, 3])[:, None]
        in_b = (a.group_centres @ np.swapaxes(back[:, :3, :3], 1, 2) + back[:, None, :3, 3])[:, :, None]
        over_a = box_gap(in_a, a.group_lows[:, None], a.group_highs[:, None]) - b.group_radii
        over_b = box_gap(in_b, b.group_lows, b.group_highs) - a.group_radii[:, None]
        return np.maximum(over_a, over_b)

    def _improve(self, placed: Placed, best: FloatArray, at: IntArray, group_a: IntArray, group_b: IntArray) -> None:
        """Lower `best` (n,) by all triangle pairs of the given pairs of groups, nearest candidates first."""
        at, i, j, bounds = self._candidates(placed, best, at, group_a, group_b)
        order = np.lexsort((bounds, at))
        at, i, j, bounds = at[order], i[order], j[order], bounds[order]
        rank = np.arange(len(at)) - np.searchsorted(at, at, side="left")
        done = 0
        for until in ROUNDS:
            todo = np.flatnonzero((rank >= done) & (bounds < best[at]) & (best[at] > -SURE))
            whole = len(todo) <= FEW
            todo = todo if whole else todo[rank[todo] < until]
            for part in (todo[batch] for batch in batches(len(todo))):
                found = self._separations(placed.poses[at[part]], i[part], j[part])
                np.minimum.at(best, at[part], found)
            if whole:
                return
            done = until

    def _candidates(
        self, placed: Placed, best: FloatArray, at: IntArray, group_a: IntArray, group_b: IntArray
    ) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
        """Return instants, triangles of a and b, and their lower bounds (m), where these are below `best`."""
        i = np.repeat(self.a.members[group_a], self.b.members.shape[1], axis=1)
        j = np.tile(self.b.members[group_b], (1, self.a.members.shape[1]))
        keep = (i >= 0) & (j >= 0)
        at, i, j = np.broadcast_to(at[:, None], i.shape)[keep], i[keep], j[keep]
        bounds = self._sphere_bounds(placed, at, i, j)
        keep = bounds < best[at]
        at, i, j = at[keep], i[keep], j[keep]
        bounds = np.maximum(bounds[keep], self._box_bounds(placed, at, i, j))
        keep = bounds < best[at]
        at, i, j = at[keep], i[keep], j[keep]
        bounds = np.maximum(bounds[keep], self._plane_bounds(placed, at, i, j))
        keep = bounds < best[at]
        return at[keep], i[keep], j[keep], bounds[keep]

    def _sphere_bounds(self, placed: Placed, at: IntArray, i: IntArray, j: IntArray) -> FloatArray:
        """Return lower bounds (m) on the distances of triangles i of a and j of b from their spheres."""
        between = placed.centres_b[at, j] - self.a.centres[i]
        gaps = np.sqrt(np.einsum("nk,nk->n", between, between))
        return gaps - (self.a.reach + self.a.outer)[i] - (self.b.reach + self.b.outer)[j]

    def _box_bounds(self, placed: Placed, at: IntArray, i: IntArray, j: IntArray) -> FloatArray:
        """Return lower bounds (m) from the box of one triangle against the sphere of the other, both ways."""
        a, b = self.a, self.b
        over_a = box_gap(placed.centres_b[at, j], a.lows[i], a.highs[i]) - b.reach[j]
        over_b = box_gap(placed.centres_a[at, i], b.lows[j], b.highs[j]) - a.reach[i]
        return np.maximum(over_a, over_b) - a.outer[i] - b.outer[j]

    def _plane_bounds(self, placed: Placed, at: IntArray, i: IntArray, j: IntArray) -> FloatArray:
        """Return lower bounds (m) from how far one triangle lies on one side of the other's plane, both ways."""
        a, b = self.a, self.b
        over_a = plane_gap(placed.turns[at], placed.places[at], a.normals[i], a.heights[i], b.corners[j])
        over_b = plane_gap(placed.turns_back[at], placed.places_back[at], b.normals[j], b.heights[j], a.corners[i])
        return np.maximum(over_a, over_b) - a.outer[i] - b.outer[j]

    def _separations(self, poses: FloatArray, i: IntArray, j: IntArray) -> FloatArray:
        """Return the signed distances (m) of triangles i of a and j of b, rounding radii off."""
        a = self.a.corner_first[:, i]
        b = self.b.corner_first[:, j]
        moved = np.einsum("nxy,ynk->xnk", poses[:, :3, :3], b) + poses[:, :3, 3].T[:, :, None]
        return separation(a, np.ascontiguousarray(moved)) - self.a.radii[i] - self.b.radii[j]


class Placed:
    """Where the spheres about the triangles are at poses (n, 4, 4) of b in a: each body's in the other's frame."""

    def __init__(self, poses: FloatArray, a: Cover, b: Cover) -> None:
        back = inverse(poses)
        self.poses = poses
        self.turns, self.places = (np.ascontiguousarray(part) for part in (poses[:, :3, :3], poses[:, :3, 3]))
        self.turns_back, self.places_back = np.ascontiguousarray(back[:, :3, :3]), np.ascontiguousarray(back[:, :3, 3])
        self.centres_b = b.centres @ np.swapaxes(poses[:, :3, :3], 1, 2) + poses[:, None, :3, 3]
        self.centres_a = a.centres @ np.swapaxes(back[:, :3, :3], 1, 2) + back[:, None, :3, 3]


class Cover:
    """A surface's triangles with what encloses them: spheres and boxes of triangles, spheres of groups.

    Attributes:
        centres, reach: (n, 3) m, (n,) m, a sphere about each triangle without its rounding radius.
        lows, highs: (n, 3) m, the axis-aligned box of each triangle.
        corners: (n, 3, 3) m, of the triangles.
        normals, heights: (n, 3), (n,) m, unit normals, 0 of what has no face, and the planes' heights along them.
        slack, outer: (n,) m, how far its round shape stands out from a triangle; with the rounding radius.
        members: (g, 8) triangle indices of each group, -1 where it has fewer.
        round_groups: (g,) whether a group's triangles are those inside a round shape.
        group_centres, group_radii: (g, 3) m, (g,) m, spheres about the groups with rounding radii.
        group_lows, group_highs: (g, 3) m, boxes about the groups with rounding radii.
    """

    def __init__(self, surface: Surface) -> None:
        triangles = surface.triangles
        self.radii = surface.radii
        self.slack = surface.slack
        self.outer = surface.radii + surface.slack
        self.corner_first = np.ascontiguousarray(np.moveaxis(triangles, 2, 0))
        self.corners = np.ascontiguousarray(triangles)
        self.lows, self.highs = triangles.min(axis=1), triangles.max(axis=1)
        self.normals = unit_normals(triangles)
        self.heights = np.einsum("nx,nx->n", self.normals, triangles[:, 0])
        self.centres = sphere_centres(triangles)
        self.reach = np.linalg.norm(triangles - self.centres[:, None], axis=2).max(axis=1)
        self.round_groups = np.array([bool(surface.round_of[group[0]] >= 0) for group in surface.groups], dtype=bool)
        self.members = np.full((len(surface.groups), 8), -1)
        self.group_centres = np.zeros((len(surface.groups), 3))
        self.group_lows, self.group_highs = np.zeros_like(self.group_centres), np.zeros_like(self.group_centres)
        self.group_radii = np.zeros(len(surface.groups))
        for index, group in enumerate(surface.groups):
            self.members[index, : len(group)] = group
            corners = triangles[group].reshape(-1, 3)
            rounding = self.outer[group].max()
            self.group_lows[index], self.group_highs[index] = corners.min(axis=0), corners.max(axis=0)
            self.group_centres[index] = 0.5 * (self.group_lows[index] + self.group_highs[index])
            self.group_lows[index] -= rounding
            self.group_highs[index] += rounding
            gaps = np.linalg.norm(triangles[group] - self.group_centres[index], axis=2).max(axis=1)
            self.group_radii[index] = (gaps + self.outer[group]).max()


def batches(count: int) -> Iterator[slice]:
    """Yield slices that cover `count` items, none longer than a batch."""
    return (slice(first, first + BATCH) for first in range(0, count, BATCH))


def box_gap(points: FloatArray, lows: FloatArray, highs: FloatArray) -> FloatArray:
    """Return (...) m: distances of points (..., 3) to axis-aligned boxes."""
    squares: FloatArray = np.zeros(())
    for low, high, at in zip(*(np.moveaxis(one, -1, 0) for one in (lows, highs, points)), strict=True):
        squares = squares + np.maximum(np.maximum(low - at, at - high), 0.0) ** 2
    return np.sqrt(squares)


def plane_gap(
    turns: FloatArray, places: FloatArray, normals: FloatArray, heights: FloatArray, corners: FloatArray
) -> FloatArray:
    """Return (n,) m: how far the corners (n, 3, 3) of triangles lie on one side of planes, below 0 if on both.

    Args:
        turns, places: (n, 3, 3), (n, 3) m, from the triangles' frame to the planes'.
        normals, heights: (n, 3), (n,) m, of the planes.
    """
    turned = np.einsum("nx,nxy->ny", normals, turns)
    base = np.einsum("nx,nx->n", normals, places) - heights
    first, second, third = (np.einsum("nx,nx->n", turned, corners[:, k]) for k in range(3))
    lowest = np.minimum(np.minimum(first, second), third)
    highest = np.maximum(np.maximum(first, second), third)
    return np.maximum(lowest + base, -base - highest)


def unit_normals(triangles: FloatArray) -> FloatArray:
    """Return (n, 3): the unit normals of triangles (n, 3, 3), 0 where one is a point or a segment, or nearly so."""
    one, other = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    normals = np.cross(one, other)
    lengths = np.linalg.norm(normals, axis=1)
    flat = lengths <= SLIVER * np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    return np.where(flat[:, None], 0.0, normals / np.where(flat, 1.0, lengths)[:, None])


def sphere_centres(triangles: FloatArray) -> FloatArray:
    """Return (n, 3) m: centres of small spheres about triangles: mid of the longest edge if obtuse, else centroid."""
    opposite = np.linalg.norm(np.roll(triangles, -1, axis=1) - np.roll(triangles, -2, axis=1), axis=2)
    longest = opposite.argmax(axis=1)
    squares = opposite**2
    rows = np.arange(len(triangles))
    obtuse = 2.0 * squares[rows, longest] >= squares.sum(axis=1)
    middles = 0.5 * (triangles.sum(axis=1) - triangles[rows, longest])
    return np.where(obtuse[:, None], middles, triangles.mean(axis=1))
