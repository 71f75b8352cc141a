"""Meshes as placed shapes of the narrow phase, and their distance by brute force."""

import numpy as np
from scipy.spatial.transform import Rotation

from closecall.scheduler.model.scene import Body, Mesh, Shape
from closecall.scheduler.motions import Fixed
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from oracle.triangles import separation

EYE = np.eye(4)
TRIANGLE = np.array([[0, 1, 2]])
POINT = Mesh("point", np.zeros((1, 3)), np.array([[0, 0, 0]]), False)
SEGMENT = Mesh("segment", np.array([[0.0, 0, -1], [0, 0, 1]]), np.array([[0, 1, 1]]), False)


def box_mesh(x, y, z) -> Mesh:
    vertices = np.array([[i, j, k] for i in (-x, x) for j in (-y, y) for k in (-z, z)]) / 2.0
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return Mesh("box", vertices, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]), True)


def soup(rng, triangles, size=1.0) -> Mesh:
    return Mesh("soup", rng.normal(size=(3 * triangles, 3)) * size, np.arange(3 * triangles).reshape(-1, 3), False)


def phase_of(*shapes: Shape | Mesh) -> NarrowPhase:
    placed = [shape if isinstance(shape, Shape) else Shape(shape, 0.0, EYE) for shape in shapes]
    return NarrowPhase(tuple(Body(str(i), None, EYE, Fixed(), (shape,)) for i, shape in enumerate(placed)))


def placed(rng, x=0.0, y=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(rng=rng).as_matrix() if rng is not None else np.eye(3)
    pose[:3, 3] = (x, y, z)
    return pose


def brute_force(one: Mesh, other: Mesh, pose_a, pose_b) -> float:
    a, b = (
        (mesh.vertices @ pose[:3, :3].T + pose[:3, 3])[mesh.triangles]
        for mesh, pose in ((one, pose_a), (other, pose_b))
    )
    i, j = (index.ravel() for index in np.indices((len(a), len(b))))
    return float(max(0.0, np.min(separation(np.moveaxis(a[i], 2, 0), np.moveaxis(b[j], 2, 0)))))
