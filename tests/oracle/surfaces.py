"""Meshes of up to 300 triangles: closed solids, and open ones of which only the surface counts."""

from __future__ import annotations

import numpy as np

from .rigid import FloatArray
from .solids import quads, random_solid, ring

LARGE = (12, 12)
"""Quads around and across a large torus: 288 triangles."""


def random_surface(rng: np.random.Generator) -> FloatArray:
    """Return triangles (n, 3, 3), n <= 300, within about 1 of their origin: two in three closed."""
    kind = rng.choice(["solid", "solid", "solid", "large", "torn", "sheet"])
    if kind == "large":
        return ring(rng, *LARGE)
    if kind == "torn":
        return torn(rng, random_solid(rng))
    if kind == "sheet":
        return sheet(rng)
    return random_solid(rng)


def torn(rng: np.random.Generator, triangles: FloatArray) -> FloatArray:
    """Return the triangles (n, 3, 3) without a tenth to a half of them, on one side."""
    heights = triangles.mean(axis=1) @ rng.standard_normal(3)
    return triangles[heights < np.quantile(heights, rng.uniform(0.5, 0.9))]


def sheet(rng: np.random.Generator) -> FloatArray:
    """Return a bumpy sheet of 2 to 12 by 2 to 12 quads, open at its rim."""
    steps = [np.linspace(-0.7, 0.7, int(count) + 1) for count in rng.integers(2, 13, 2)]
    x, y = np.meshgrid(*steps, indexing="ij")
    grid = np.stack([x, y, rng.uniform(0.0, 0.3) * rng.uniform(-1.0, 1.0, x.shape)], axis=2)
    corners = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    return quads(*(corner.reshape(-1, 3) for corner in corners))
