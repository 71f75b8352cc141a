"""Polygons cut into triangles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ..limits import FAN_TOLERANCE, FLAT_TOLERANCE
from ..text.errors import counted
from .ears import ears
from .surface import MeasuredWarning, MeshError, Surface

_MOST_STARTS = 256
"""Corners from which a fan is tried. A polygon of more that is hollow seldom has one, and a million would not end."""


_MOST_EAR_TESTS = 300_000
"""Squares of corners added up over the polygons of a file that are cut ear by ear: a few seconds' work."""

CLIPPED = -1
"""Stands for the hub of a polygon whose triangles are no fan."""


@dataclass(frozen=True, slots=True, eq=False)
class Triangulation:
    """Polygons as triangles.

    Attributes:
        triangles: (m, 3) indices of vertices, in the polygons' order.
        hubs: (n,) the corner of each polygon from which its fan goes out, from 0; CLIPPED where it is no fan.
        heights: (n,) how far its corners lie off one plane at most.
        excesses: (n,) how far its triangles may reach beyond it, an upper bound, 0 where they cover it and no more.
    """

    triangles: IntArray
    hubs: IntArray
    heights: FloatArray
    excesses: FloatArray


def polygon_surface(
    vertices: FloatArray, corners: IntArray, sizes: IntArray, warnings: Sequence[str], lines: Sequence[int] = ()
) -> Surface:
    """Return the surface of polygons, with warnings of those that triangles do not tell all of.

    Args:
        vertices: (n, 3) finite.
        corners: indices of vertices, polygon after polygon.
        sizes: corners of each polygon, >= 3 each.
        warnings: what else is doubtful in the file.
        lines: of each polygon, empty if the file has none.
    """
    cut = triangulated(vertices, corners, sizes)
    flat = FLAT_TOLERANCE * np.abs(vertices[corners]).max()
    folded = cut.excesses > 0.0
    bent = (cut.heights > flat) & ~folded

    def worst(lengths: FloatArray) -> str:
        index = int(np.argmax(lengths))
        face = f"the face in line {lines[index]}" if len(lines) else f"face {index + 1} of {len(sizes)}"
        hub = "ear by ear" if cut.hubs[index] == CLIPPED else f"from its corner {cut.hubs[index] + 1} of {sizes[index]}"
        return f"{face}, cut {hub}"

    measured = []
    if folded.any():
        text = (
            f"holds {counted(int(folded.sum()), 'polygon')} that no triangles fit, as where an outline crosses itself"
        )
        beyond = "what is checked reaches beyond them by up to about {length}"
        measured.append(MeasuredWarning(f"{text}: {beyond} ({worst(cut.excesses)})", float(cut.excesses.max())))
    if bent.any():
        heights = np.where(bent, cut.heights, 0.0)
        text = f"holds {counted(int(bent.sum()), 'polygon')} whose corners are not in one plane"
        off = "they lie up to about {length} off it, and other triangles than those taken would differ"
        measured.append(MeasuredWarning(f"{text}: {off} ({worst(heights)})", float(heights.max())))
    return Surface(vertices, cut.triangles, tuple(warnings), measured=tuple(measured))


def refuse_unfit(corners: IntArray, sizes: IntArray, lines: Sequence[int], count: int) -> None:
    """Refuse polygons that are none, or have a corner beyond the file's vertices, which count from 0.

    Args:
        corners: of polygon after polygon.
        sizes: corners of each polygon.
        lines: of each polygon, empty if the file has none.
        count: of the file's vertices.

    Raises:
        MeshError: with the first such polygon's line.
    """
    small = np.flatnonzero(sizes < 3)
    if len(small):
        face = int(small[0])
        message = f"expected at least 3 corners, face {face + 1} of {len(sizes)} has {sizes[face]}"
        raise MeshError(message, *lines[face : face + 1])
    stray = first_stray(corners, sizes, count)
    if stray is not None:
        face, corner = stray
        expected = f"expected 0 to {count - 1}" if count else "the file has none"
        message = f"face {face + 1} of {len(sizes)} refers to vertex {corner}, {expected}"
        raise MeshError(message, *lines[face : face + 1])


def first_stray(corners: IntArray, sizes: IntArray, count: int) -> tuple[int, int] | None:
    """Return the first polygon with a corner outside 0 ... count - 1, and that corner; None if there is none."""
    strays = np.flatnonzero((corners < 0) | (corners >= count))
    if not len(strays):
        return None
    return int(np.searchsorted(np.cumsum(sizes), strays[0], side="right")), int(corners[strays[0]])


def triangulated(vertices: FloatArray, corners: IntArray, sizes: IntArray) -> Triangulation:
    """Return polygons as triangles: the fan from the first corner whose fan fits, else those cut off ear by ear.

    Triangles fit when none of them turns against the polygon, whose direction is the sum of theirs: then they cover a
    flat polygon and nothing else. Where none are found that fit, the fan of the first corner is taken. It covers every
    point around which the outline goes, and more: the wrong way for contacts, the safe way for clearance.

    Args:
        vertices: (n, 3) finite.
        corners: indices of vertices, polygon after polygon.
        sizes: corners of each polygon, >= 3 each.
    """
    starts = np.cumsum(sizes) - sizes
    firsts = np.cumsum(sizes - 2) - (sizes - 2)
    triangles = np.empty((int(np.sum(sizes - 2)), 3), dtype=np.int64)
    hubs, heights, excesses = np.zeros(len(sizes), dtype=np.int64), np.zeros(len(sizes)), np.zeros(len(sizes))
    for size in np.unique(sizes):
        chosen = np.flatnonzero(sizes == size)
        polygons = corners[starts[chosen][:, None] + np.arange(size)]
        with np.errstate(all="ignore"):  # coordinates whose products overflow are refused where the mesh is used
            cut = _fans(vertices, polygons)
        triangles[firsts[chosen][:, None] + np.arange(size - 2)] = cut.triangles
        hubs[chosen], heights[chosen], excesses[chosen] = cut.hubs, cut.heights, cut.excesses
    tests_left = _MOST_EAR_TESTS
    for index in np.flatnonzero(excesses > 0.0).tolist():
        size = int(sizes[index])
        tests_left -= size**2
        if tests_left < 0:
            break
        polygon = corners[starts[index] : starts[index] + size]
        clipped = ears(vertices[polygon], FAN_TOLERANCE)
        if clipped is not None:
            triangles[firsts[index] : firsts[index] + size - 2] = polygon[clipped]
            hubs[index], excesses[index] = CLIPPED, 0.0
    return Triangulation(triangles, hubs, heights, excesses)


def _fans(vertices: FloatArray, polygons: IntArray) -> Triangulation:
    """Return k polygons of one size, their triangles as (k, size - 2, 3)."""
    count, size = polygons.shape
    best, hubs, zeros = _fan(polygons), np.zeros(count, dtype=np.int64), np.zeros(count)
    if size == 3:
        return Triangulation(best, hubs, zeros, zeros)
    whole = _normals(vertices, best)
    normals = whole.sum(axis=1)
    squares = np.einsum("kj,kj->k", normals, normals)
    areas = np.linalg.norm(whole, axis=2).sum(axis=1)
    directed = np.sqrt(squares) > FAN_TOLERANCE * areas
    misfits = np.arange(count)
    for start in range(min(size, _MOST_STARTS)):
        fans = _fan(np.roll(polygons[misfits], -start, axis=1))
        turns = np.einsum("kij,kj->ki", _normals(vertices, fans), normals[misfits])
        fits = (turns >= -FAN_TOLERANCE * squares[misfits, None]).all(axis=1) & directed[misfits]
        best[misfits[fits]], hubs[misfits[fits]] = fans[fits], start
        misfits = misfits[~fits]
        if not len(misfits):
            break
    farthest = _farthest(vertices, polygons)
    nothing = FAN_TOLERANCE * farthest**2  # the area of a mere line, which has no plane
    heights = np.where(np.sqrt(squares) > nothing, _heights(vertices, polygons, normals), 0.0)
    excesses = np.where(areas > nothing, 0.5 * farthest, 0.0)
    excesses[np.setdiff1d(np.arange(count), misfits)] = 0.0
    return Triangulation(best, hubs, heights, excesses)


def _heights(vertices: FloatArray, polygons: IntArray, normals: FloatArray) -> FloatArray:
    """Return how far the corners of each polygon lie from the plane through their mean across its normal (k, 3)."""
    lengths = np.linalg.norm(normals, axis=1)
    units = normals / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    corners = vertices[polygons]
    heights: FloatArray = np.abs(np.einsum("kij,kj->ki", corners - corners.mean(axis=1)[:, None], units)).max(axis=1)
    return heights


def _farthest(vertices: FloatArray, polygons: IntArray) -> FloatArray:
    """Return how far (k,) a corner of each polygon lies from its first one, at most.

    No point of the fan from there is farther than half of it from the outline: it lies on a line from the hub to the
    edge across, and both ends of that line belong to the outline.
    """
    corners = vertices[polygons]
    farthest: FloatArray = np.linalg.norm(corners - corners[:, :1], axis=2).max(axis=1, initial=0.0)
    return farthest


def _fan(polygons: IntArray) -> IntArray:
    """Return the (k, size - 2, 3) triangles from the first corner of each polygon."""
    hub = np.broadcast_to(polygons[:, :1], polygons[:, 2:].shape)
    return np.stack((hub, polygons[:, 1:-1], polygons[:, 2:]), axis=2)


def _normals(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return (..., 3) normals of (..., 3) triangles, as long as twice their area."""
    a, b, c = np.moveaxis(vertices[triangles], -2, 0)
    normals: FloatArray = np.cross(b - a, c - a)
    return normals
