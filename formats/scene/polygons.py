"""Polygons cut into triangles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...scheduler.scene import FloatArray, IntArray
from .errors import counted
from .limits import FAN_TOLERANCE
from .surface import MeshError, Surface

_MOST_STARTS = 256
"""Corners from which a fan is tried. A polygon of more that is hollow seldom has one, and a million would not end."""


def polygon_surface(vertices: FloatArray, corners: IntArray, sizes: IntArray, warnings: Sequence[str]) -> Surface:
    """Return the surface of polygons, with one more warning if no fan of triangles fits some; see `triangulated`."""
    triangles, folded = triangulated(vertices, corners, sizes)
    text = f"holds {counted(folded, 'polygon')} that no fan of triangles fits: what is checked covers more than they do"
    return Surface(vertices, triangles, (*warnings, text) if folded else tuple(warnings))


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


def triangulated(vertices: FloatArray, corners: IntArray, sizes: IntArray) -> tuple[IntArray, int]:
    """Return polygons as fans of triangles, and how many polygons no fan fits.

    A fan fits when none of its triangles turns against the polygon. One that does not still covers the whole of
    the polygon, and more: the wrong way for contacts, the safe way for clearance.

    Args:
        vertices: (n, 3) finite.
        corners: indices of vertices, polygon after polygon.
        sizes: corners of each polygon, >= 3 each.

    Returns:
        (m, 3) indices of vertices, in the polygons' order.
    """
    starts = np.cumsum(sizes) - sizes
    firsts = np.cumsum(sizes - 2) - (sizes - 2)
    triangles = np.empty((int(np.sum(sizes - 2)), 3), dtype=np.int64)
    folded = 0
    for size in np.unique(sizes):
        chosen = np.flatnonzero(sizes == size)
        polygons = corners[starts[chosen][:, None] + np.arange(size)]
        with np.errstate(all="ignore"):  # coordinates whose products overflow are refused where the mesh is used
            fanned, misfits = _fans(vertices, polygons)
        triangles[firsts[chosen][:, None] + np.arange(size - 2)] = fanned
        folded += misfits
    return triangles, folded


def _fans(vertices: FloatArray, polygons: IntArray) -> tuple[IntArray, int]:
    """Return (k, size - 2, 3) triangles of k polygons of one size, each from its first corner that fits."""
    best = _fan(polygons)
    if polygons.shape[1] == 3:
        return best, 0
    normals = _normals(vertices, best).sum(axis=1)
    squares = np.einsum("kj,kj->k", normals, normals)
    misfits = np.arange(len(polygons))
    for start in range(min(polygons.shape[1], _MOST_STARTS)):
        fans = _fan(np.roll(polygons[misfits], -start, axis=1))
        turns = np.einsum("kij,kj->ki", _normals(vertices, fans), normals[misfits])
        fits = (turns >= -FAN_TOLERANCE * squares[misfits, None]).all(axis=1)
        best[misfits[fits]] = fans[fits]
        misfits = misfits[~fits]
        if not len(misfits):
            break
    return best, len(misfits)


def _fan(polygons: IntArray) -> IntArray:
    """Return the (k, size - 2, 3) triangles from the first corner of each polygon."""
    hub = np.broadcast_to(polygons[:, :1], polygons[:, 2:].shape)
    return np.stack((hub, polygons[:, 1:-1], polygons[:, 2:]), axis=2)


def _normals(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return (..., 3) normals of (..., 3) triangles, as long as twice their area."""
    a, b, c = np.moveaxis(vertices[triangles], -2, 0)
    normals: FloatArray = np.cross(b - a, c - a)
    return normals
