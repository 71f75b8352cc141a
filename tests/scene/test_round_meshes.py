"""Round shapes become polyhedra that hold all of them, and stand out from them no farther than they say."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import hypot

import numpy as np
import pytest

from closecall.formats.scene.build.meshes import MeshFolder
from closecall.formats.scene.build.primitive_meshes import box_mesh, scaled_mesh
from closecall.formats.scene.build.round_meshes import RoundMesh, cone_mesh, cylinder_mesh, ellipsoid_mesh
from closecall.formats.scene.mesh_files.surface import topology

Sizes = tuple[float, ...]
Exact = tuple[Fraction, Fraction, Fraction]

BUILD: dict[str, Callable[..., RoundMesh]] = {
    "cylinder": cylinder_mesh,
    "cone": cone_mesh,
    "ellipsoid": ellipsoid_mesh,
}
TRIANGLES = {"cylinder": 256, "cone": 128, "ellipsoid": 1280}


def proportions(kind: str, count: int, decades: float, seed: int) -> list[Sizes]:
    """Return random sizes, each 10**(-decades/2 ... decades/2) m, the first few as unlike as can be."""
    rng = np.random.default_rng(seed)
    width = 3 if kind == "ellipsoid" else 2
    far = 10.0 ** (decades / 2)
    corners = [(far, 1 / far, 1 / far)[:width], (1 / far, far, far)[:width], (1.0, 1.0, 1.0)[:width]]
    return corners + [tuple(row) for row in (10 ** rng.uniform(-decades / 2, decades / 2, (count, width))).tolist()]


def cases(count: int, decades: float, seed: int = 1) -> list[tuple[str, Sizes]]:
    return [(kind, sizes) for kind in BUILD for sizes in proportions(kind, count, decades, seed)]


def holds(kind: str, sizes: Sizes, normal: Exact, offset: Fraction) -> bool:
    """Tell, in exact arithmetic, whether all of the true solid has normal . point <= offset."""
    x, y, z = normal
    if kind == "ellipsoid":
        reach = sum((Fraction(size) * part) ** 2 for size, part in zip(sizes, normal, strict=True))
        return offset > 0 and reach <= offset**2
    radius, half = Fraction(sizes[0]), Fraction(sizes[1]) / 2
    if kind == "cone" and half * z > offset:
        return False
    room = offset + half * z if kind == "cone" else offset - half * abs(z)
    return room >= 0 and radius**2 * (x * x + y * y) <= room**2


def surface_points(kind: str, sizes: Sizes, count: int) -> np.ndarray:
    """Return random points of the true surface, (count, 3) m."""
    rng = np.random.default_rng(3)
    if kind == "ellipsoid":
        directions = rng.normal(size=(count, 3))
        return directions / np.linalg.norm(directions, axis=1)[:, None] * sizes
    height = rng.uniform(0, 1, count)
    width = 1 - height if kind == "cone" else 1.0
    angle = rng.uniform(0, 2 * np.pi, count)
    radius = sizes[0] * width
    return np.column_stack((radius * np.cos(angle), radius * np.sin(angle), sizes[1] * (height - 0.5)))


def distances(kind: str, sizes: Sizes, points: np.ndarray) -> np.ndarray:
    """Return how far (m) points lie from the true solid."""
    if kind == "ellipsoid":
        return ellipsoid_distances(np.array(sizes), np.abs(points))
    radius, half = sizes[0], sizes[1] / 2
    rho, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    if kind == "cylinder":
        return np.hypot(np.maximum(rho - radius, 0), np.maximum(np.abs(z) - half, 0))
    slant = hypot(radius, 2 * half)
    along = ((radius - rho) * radius + (z + half) * 2 * half) / slant**2  # from the rim (0) to the apex (1)
    place = np.clip(along, 0, 1)
    beyond = np.hypot(rho - radius * (1 - place), z + half - 2 * half * place)
    inside = (z >= -half) & (rho * 2 * half + z * radius <= radius * half)
    return np.where(inside, 0, np.where(z < -half, np.hypot(np.maximum(rho - radius, 0), z + half), beyond))


def ellipsoid_distances(axes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the distances of points outside, in the first octant: the nearest p has p_i = a_i^2 y_i / (t + a_i^2)."""
    low, high = np.zeros(len(points)), np.full(len(points), axes.max()) * np.linalg.norm(points, axis=1)
    for _ in range(200):
        middle = (low + high) / 2
        outside = ((axes * points / (middle[:, None] + axes**2)) ** 2).sum(axis=1) > 1
        low, high = np.where(outside, middle, low), np.where(outside, high, middle)
    return np.linalg.norm(low[:, None] * points / (low[:, None] + axes**2), axis=1)


@pytest.mark.parametrize(("kind", "sizes"), cases(5, 8))
def test_no_face_cuts_into_the_true_solid_by_exact_arithmetic(kind: str, sizes: Sizes) -> None:
    mesh = BUILD[kind](*sizes).mesh
    corners = [tuple(map(Fraction, vertex)) for vertex in mesh.vertices.tolist()]
    for i, j, k in mesh.triangles.tolist():
        a, u, v = corners[i], difference(corners[j], corners[i]), difference(corners[k], corners[i])
        normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        assert holds(kind, sizes, normal, sum((n * x for n, x in zip(normal, a, strict=True)), Fraction()))


def difference(p: Exact, q: Exact) -> Exact:
    return p[0] - q[0], p[1] - q[1], p[2] - q[2]


@pytest.mark.parametrize(("kind", "sizes"), cases(5, 4))
def test_points_of_the_true_surface_are_behind_every_face(kind: str, sizes: Sizes) -> None:
    mesh = BUILD[kind](*sizes).mesh
    a, b, c = (mesh.vertices[mesh.triangles] / max(sizes)).swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    points = surface_points(kind, sizes, 5000) / max(sizes)
    room = np.einsum("ij,ij->i", normals, a) - points @ normals.T
    assert room.min() > -1e-15
    assert room.min() < 1e-4


@pytest.mark.parametrize(("kind", "sizes"), cases(40, 8, seed=2))
def test_the_chord_error_is_the_farthest_vertex_and_a_little_more(kind: str, sizes: Sizes) -> None:
    """The distance to a convex solid is convex, so that over a polyhedron it is greatest at a vertex."""
    made = BUILD[kind](*sizes)
    farthest = distances(kind, sizes, made.mesh.vertices).max()
    assert farthest <= made.chord_error * (1 + 1e-12)
    assert made.chord_error <= 1.001 * farthest
    assert made.chord_error <= (0.005 * max(sizes) if kind == "ellipsoid" else 0.002 * sizes[0])


@pytest.mark.parametrize(("kind", "sizes"), cases(3, 8))
def test_round_meshes_are_closed_and_face_outward(kind: str, sizes: Sizes) -> None:
    mesh = BUILD[kind](*sizes).mesh
    found = topology(mesh.vertices, mesh.triangles)
    assert mesh.solid
    assert found.solid
    assert (found.twisted_edges, found.flat_triangles) == (0, 0)
    assert len(mesh.triangles) == TRIANGLES[kind]
    a, b, c = mesh.vertices[mesh.triangles].swapaxes(0, 1)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    shape = {"cylinder": np.pi, "cone": np.pi / 3, "ellipsoid": 4 / 3 * np.pi}[kind]
    true = shape * (np.prod(sizes) if kind == "ellipsoid" else sizes[0] ** 2 * sizes[1])
    assert true < volume < 1.014 * true


@pytest.mark.parametrize(("kind", "sizes"), cases(20, 2))
def test_round_meshes_of_usual_proportions_have_no_slivers(kind: str, sizes: Sizes) -> None:
    mesh = BUILD[kind](*sizes).mesh
    corners = mesh.vertices[mesh.triangles]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    doubled = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    assert (doubled / longest**2).min() > 1e-4


def test_round_shapes_lie_along_z_about_the_origin_and_the_apex_is_above() -> None:
    for made in (cylinder_mesh(2.0, 6.0), cone_mesh(2.0, 6.0)):
        np.testing.assert_allclose(made.mesh.vertices.max(axis=0), [2, 2, 3], rtol=1e-13)
        np.testing.assert_allclose(made.mesh.vertices.min(axis=0), [-2, -2, -3], rtol=1e-13)
    assert [0, 0, 3] in cone_mesh(2.0, 6.0).mesh.vertices.tolist()
    extent = ellipsoid_mesh(1.0, 2.0, 3.0)
    np.testing.assert_allclose(extent.mesh.vertices.max(axis=0), np.array([1, 2, 3]) * (1 + extent.chord_error / 3))


@pytest.mark.parametrize("kind", BUILD)
def test_equal_round_shapes_are_one_mesh(kind: str) -> None:
    sizes = (1.0, 2.0, 3.0)[: 3 if kind == "ellipsoid" else 2]
    assert BUILD[kind](*sizes).mesh is BUILD[kind](*sizes).mesh
    assert BUILD[kind](*sizes[::-1]).mesh is not BUILD[kind](*sizes).mesh


def test_a_scaled_mesh_is_read_only_and_shares_its_triangles() -> None:
    box = box_mesh(2.0, 4.0, 6.0)
    scaled = scaled_mesh(box, (2.0, 0.5, 3.0))
    assert scaled.vertices.max(axis=0).tolist() == [2, 1, 9]
    assert not scaled.vertices.flags.writeable
    assert scaled.triangles is box.triangles
    assert (scaled.name, scaled.solid) == (box.name, box.solid)
    assert scaled_mesh(box, (1.0, 1.0, 1.0)) is box


def test_one_mesh_with_equal_scales_is_one_mesh(tmp_path) -> None:
    folder, box, other = MeshFolder(tmp_path, ()), box_mesh(1.0, 2.0, 3.0), box_mesh(1.0, 2.0, 4.0)
    doubled = folder.scaled(box, (2.0, 2.0, 2.0))
    assert folder.scaled(box, (2.0, 2.0, 2.0)) is doubled
    assert folder.scaled(box, (2.0, 2.0, 1.0)) is not doubled
    assert folder.scaled(other, (2.0, 2.0, 2.0)) is not doubled
