"""How far FCL's mesh distance is from brute force, relative to size: the measurement behind DISTANCE_ERROR.

Run from the project's folder: python -m benchmarks.narrow_phase_error [PAIRS] [SEED]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from closecall.scheduler.motions import Fixed
from closecall.scheduler.narrow_phase import DISTANCE_ERROR, NarrowPhase
from closecall.scheduler.scene import Body, Mesh, Shape

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from oracle.triangles import separation


def random_mesh(rng: np.random.Generator, thin: float) -> Mesh:
    """Return two random triangles, squeezed to slivers by `thin`."""
    return Mesh("t", rng.normal(size=(6, 3)) * (1.0, thin, 1.0), np.arange(6).reshape(2, 3), False)


def random_pose(rng: np.random.Generator, spread: float) -> np.ndarray:
    """Return a random rotation near the identity or far from it, and a translation of about `spread` m."""
    turn, _ = np.linalg.qr(np.eye(3) + rng.normal(size=(3, 3)) * 10.0 ** rng.uniform(-9, 1))
    pose = np.eye(4)
    pose[:3, :3] = turn * np.sign(np.linalg.det(turn))
    pose[:3, 3] = rng.normal(size=3) * spread
    return pose


def error(rng: np.random.Generator) -> float:
    """Return |FCL - brute force| over size for one random near pair."""
    thin = 10.0 ** rng.uniform(-7, 0)
    one, other = random_mesh(rng, thin), random_mesh(rng, thin)
    pose = random_pose(rng, 10.0 ** rng.uniform(-3, 0.5))
    here = np.eye(4)
    bodies = tuple(Body(m.name, None, here, Fixed(), (Shape(m, 0.0, here),)) for m in (one, other))
    phase = NarrowPhase(bodies)
    a = one.vertices[one.triangles]
    b = (other.vertices @ pose[:3, :3].T + pose[:3, 3])[other.triangles]
    i, j = (index.ravel() for index in np.indices((2, 2)))
    truth = max(0.0, float(np.min(separation(np.moveaxis(a[i], 2, 0), np.moveaxis(b[j], 2, 0)))))
    return abs(phase.nearest(0, 1, here, pose).distance - truth) / phase.size(0, 1)


def main(pairs: int = 20000, seed: int = 1) -> None:
    """Print the largest error and where the constant stands."""
    rng = np.random.default_rng(seed)
    errors = np.array([error(rng) for _ in range(pairs)])
    print(f"{pairs} near pairs, seed {seed}: |FCL - brute force| / size: median {np.median(errors):.2g}, ", end="")
    print(f"99.9% {np.quantile(errors, 0.999):.2g}, largest {errors.max():.2g}; the constant is {DISTANCE_ERROR:.2g}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
