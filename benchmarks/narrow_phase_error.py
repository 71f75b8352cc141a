"""How far the narrow phase's distance is from the truth: the measurement behind its error constants.

Random near pairs of two triangles each, 1 fm to 1 Tm large, down to the thinnest that are measured as triangles; the
truth by brute force in extended precision. `--unscaled` shows what FCL does with the same pairs as they are.

Run from the project's folder: python -m benchmarks.narrow_phase_error [PAIRS] [SEED] [--unscaled]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from closecall.scheduler.model.scene import Body, Mesh, Shape
from closecall.scheduler.motions import Fixed
from closecall.scheduler.narrow import fcl_shape as placed
from closecall.scheduler.narrow.narrow_phase import DISTANCE_ERROR, NarrowPhase
from closecall.scheduler.narrow.slivers import EPSILON, NORMAL_ERROR, THINNEST

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from oracle.triangles import separation


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    """Return a rotation, near the identity or far from it, (3, 3)."""
    turn, _ = np.linalg.qr(np.eye(3) + rng.normal(size=(3, 3)) * 10.0 ** rng.uniform(-9, 1))
    return np.asarray(turn * np.sign(np.linalg.det(turn)))


def random_mesh(rng: np.random.Generator, size: float, thin: float) -> Mesh:
    """Return two random triangles of about `size` m, `thin` times as wide as long, in any direction."""
    corners = rng.normal(size=(6, 3)) * (size, thin * size, thin * size) @ random_rotation(rng)
    return Mesh("t", corners, np.arange(6).reshape(2, 3), False)


def thinness(mesh: Mesh) -> float:
    """Return the greatest eps * side^2 / height of the mesh's triangles, m."""
    corners = mesh.vertices[mesh.triangles]
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return float(np.max(EPSILON * sides**3 / areas))


def errors(rng: np.random.Generator, thin: float) -> tuple[float, float, float]:
    """Return for one random near pair its error (m), its size (m) and its thinness (m)."""
    size = 10.0 ** rng.uniform(-15, 12)
    one, other = random_mesh(rng, size, thin), random_mesh(rng, size, 1.0)
    pose = np.eye(4)
    pose[:3, :3] = random_rotation(rng)
    touched = rng.dirichlet(np.ones(3)) @ one.vertices[:3]
    away = rng.normal(size=3) * size * 10.0 ** rng.uniform(-9, 0)
    pose[:3, 3] = touched - pose[:3, :3] @ other.vertices[0] + away
    here = np.eye(4)
    bodies = tuple(Body(mesh.name, None, here, Fixed(), (Shape(mesh, 0.0, here),)) for mesh in (one, other))
    phase = NarrowPhase(bodies)
    wide = np.longdouble
    a = one.vertices.astype(wide)[one.triangles]
    b = (other.vertices.astype(wide) @ pose[:3, :3].T.astype(wide) + pose[:3, 3].astype(wide))[other.triangles]
    i, j = (index.ravel() for index in np.indices((2, 2)))
    truth = max(wide(0.0), np.min(separation(np.moveaxis(a[i], 2, 0), np.moveaxis(b[j], 2, 0))))
    found = phase.nearest(0, 1, here, pose).distance
    reach = max(np.linalg.norm(mesh.vertices, axis=1).max() for mesh in (one, other))
    return float(abs(found - truth)), 2.0 * float(reach), max(thinness(one), thinness(other))


def main(pairs: int = 20000, seed: int = 1) -> None:
    """Print the largest errors, and where the constants stand."""
    rng = np.random.default_rng(seed)
    plump = np.array([errors(rng, 1.0) for _ in range(pairs)])
    plump = plump[plump[:, 2] < 1e3 * EPSILON * plump[:, 1]]
    relative = plump[:, 0] / plump[:, 1]
    print(
        f"{len(plump)} near pairs without thin triangles, seed {seed}: error / size at most {relative.max():.2g}",
        end="",
    )
    print(f" (99.9%: {np.quantile(relative, 0.999):.2g}); the constant is {DISTANCE_ERROR:.2g}")
    thin = np.array([errors(rng, 10.0 ** rng.uniform(np.log10(THINNEST) + 0.5, -2)) for _ in range(pairs)])
    share = (thin[:, 0] - DISTANCE_ERROR * thin[:, 1]) / thin[:, 2]
    print(
        f"{pairs} near pairs of thin ones: error above that / (eps side^2 / height) at most {share.max():.2g}", end=""
    )
    print(f" (99.9%: {np.quantile(share, 0.999):.2g}); the constant is {NORMAL_ERROR:.2g}")


if __name__ == "__main__":
    if "--unscaled" in sys.argv:
        placed.SCALE = 1.0
    main(*(int(argument) for argument in sys.argv[1:] if not argument.startswith("-")))
