"""Polygons cut into triangles."""

from __future__ import annotations

import numpy as np

from ...scheduler.scene import FloatArray, IntArray
from .limits import FAN_TOLERANCE


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
    misfits = np.arange(len(polygons))
    for start in range(polygons.shape[1]):
        fans = _fan(np.roll(polygons[misfits], -start, axis=1))
        turns = np.einsum("kij,kj->ki", _normals(vertices, fans), normals[misfits])
        squares = np.einsum("kj,kj->k", normals[misfits], normals[misfits])
        fits = (turns >= -FAN_TOLERANCE * squares[:, None]).all(axis=1)
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
