"""Polygons are cut into triangles that cover them; warnings tell by how far those of doubtful polygons are off."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from mesh_files import ascii_ply, binary_ply, off
from scene_files import HEAD, warnings
from scipy.spatial.transform import Rotation

from closecall.formats.scene.mesh_files.obj import read_obj
from closecall.formats.scene.mesh_files.off import read_off
from closecall.formats.scene.mesh_files.ply import read_ply
from closecall.formats.scene.mesh_files.polygons import triangulated
from closecall.formats.scene.mesh_files.surface import Surface

SQUARE = ((0, 0), (2, 0), (2, 2), (0, 2))
CHEVRON = ((0, 0), (2, 0), (1, 1), (2, 2), (0, 2))
COMB = ((0, 0), (7, 0), (7, 3), (6, 3), (6, 1), (4, 1), (4, 3), (3, 3), (3, 1), (1, 1), (1, 3), (0, 3))
BOWTIE = ((0, 0), (2, 2), (2, 0), (0, 2))
LOPSIDED_BOWTIE = ((0, 0), (2, 2), (2, 0), (0, 1))
PENTAGRAM = tuple((np.cos(4 * np.pi * k / 5), np.sin(4 * np.pi * k / 5)) for k in range(5))
KEYHOLE = ((0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1))
SPIRAL = ((0, 0), (6, 0), (6, 5), (1, 5), (1, 2), (4, 2), (4, 3), (2, 3), (2, 4), (5, 4), (5, 1), (0, 1))
TWO_LOBES = ((0, 0), (1, 0), (1, 1), (0, 0), (-1, 0), (-1, -1))
REPEATED = ((0, 0), (2, 0), (2, 0), (2, 2), (0, 2), (0, 2))
LINE = ((0, 0), (1, 1), (3, 3), (2, 2))


def outline(corners: tuple[tuple[float, float], ...], seed: int = 0) -> np.ndarray:
    """Return a polygon of the plane, somewhere in space: (n, 3)."""
    flat = np.column_stack((np.array(corners, dtype=float), np.zeros(len(corners))))
    if not seed:
        return flat
    rng = np.random.default_rng(seed)
    return flat @ Rotation.random(rng=rng).as_matrix().T + rng.normal(size=3)


def cut(points: np.ndarray):
    return triangulated(points, np.arange(len(points)), np.array([len(points)]))


def winding(point: np.ndarray, corners: np.ndarray) -> int:
    """Return how often a polygon of the plane goes around a point that is not on it."""
    steps = np.roll(corners, -1, axis=0) - point, corners - point
    angles = np.arctan2(steps[1][:, 0] * steps[0][:, 1] - steps[1][:, 1] * steps[0][:, 0], (steps[0] * steps[1]).sum(1))
    return round(float(angles.sum()) / (2 * np.pi))


def inside_a_triangle(point: np.ndarray, triangles: np.ndarray) -> bool:
    return any(winding(point, triangle) for triangle in triangles)


def distance_to_outline(point: np.ndarray, corners: np.ndarray) -> float:
    ends = np.roll(corners, -1, axis=0)
    steps = ends - corners
    lengths = np.maximum((steps**2).sum(1), 1e-300)
    along = np.clip(((point - corners) * steps).sum(1) / lengths, 0, 1)
    return float(np.linalg.norm(corners + along[:, None] * steps - point, axis=1).min())


def crosses_itself(corners: np.ndarray) -> bool:
    """Tell whether two sides of a polygon of the plane cross, in exact fractions."""
    exact = [(Fraction(x), Fraction(y)) for x, y in corners.tolist()]
    sides = list(zip(exact, exact[1:] + exact[:1], strict=True))

    def left(a, b, c) -> bool:
        return (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0])

    return any(
        left(*one, other[0]) != left(*one, other[1]) and left(*other, one[0]) != left(*other, one[1])
        for one, other in combinations(sides, 2)
        if not set(one) & set(other)
    )


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("corners", [SQUARE, CHEVRON, TWO_LOBES, REPEATED, COMB, KEYHOLE, SPIRAL])
def test_triangles_that_fit_cover_the_polygon_and_nothing_else(corners, seed: int) -> None:
    points = outline(corners, seed)
    found = cut(points)
    assert found.excesses.tolist() == [0.0]
    assert found.heights[0] < 1e-14
    sides = points[found.triangles]
    areas = np.linalg.norm(np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0]), axis=1) / 2
    x, y = np.array(corners, dtype=float).T
    assert areas.sum() == pytest.approx(abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2)


@pytest.mark.parametrize("corners", [BOWTIE, LOPSIDED_BOWTIE, PENTAGRAM])
def test_where_no_triangles_fit_all_that_the_outline_goes_around_is_covered_and_the_excess_is_bounded(corners) -> None:
    flat = np.array(corners, dtype=float)
    found = cut(outline(corners))
    triangles = flat[found.triangles]
    assert found.excesses[0] > 0.0
    assert found.hubs.tolist() == [0]
    beyond = 0.0
    rng = np.random.default_rng(1)
    for point in rng.uniform(flat.min(axis=0), flat.max(axis=0), (800, 2)):
        covered = inside_a_triangle(point, triangles)
        if winding(point, flat):
            assert covered
        elif covered:
            beyond = max(beyond, distance_to_outline(point, flat))
    assert beyond <= found.excesses[0]
    turned = cut(outline(corners, 3))
    assert turned.excesses == pytest.approx(found.excesses)


@pytest.mark.parametrize("seed", range(16))
def test_random_hollow_polygons_are_cut_into_triangles_that_cover_them_and_no_more(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(8, 40))
    angles = np.sort(rng.uniform(0, 2 * np.pi, count)) + rng.uniform(0, 9)
    radii = rng.uniform(0.02, 1.0, count)
    centre = rng.uniform(-0.3, 0.3, 2)
    star = np.column_stack((radii * np.cos(angles), radii * np.sin(angles)))
    corners = np.column_stack((star[:, 0] + star[:, 1] ** 2, star[:, 1])) + centre  # bent, so that no corner sees all
    found = cut(outline(tuple(map(tuple, corners))))
    triangles = corners[found.triangles]
    if found.excesses[0]:
        assert crosses_itself(corners)
    for point in rng.uniform(corners.min(axis=0), corners.max(axis=0), (120, 2)):
        covered = sum(winding(point, triangle) for triangle in triangles)
        assert covered == winding(point, corners)
        assert found.excesses[0] or covered == sum(abs(winding(point, triangle)) for triangle in triangles)


@pytest.mark.parametrize("seed", range(6))
def test_a_polygon_without_area_is_no_fold(seed: int) -> None:
    found = cut(outline(LINE, seed))
    assert found.excesses.tolist() == [0.0]
    assert found.heights[0] < 1e-14


def test_corners_off_their_plane_are_measured_from_it() -> None:
    bent = np.array([[0, 0, 0], [2, 0, 0.1], [2, 2, 0], [0, 2, 0.1]], dtype=float)
    assert cut(bent).heights.tolist() == pytest.approx([0.05])
    assert cut(bent[[0, 1, 2]]).heights.tolist() == [0.0]


BENT = ((0, 0, 0), (2, 0, 0.1), (2, 2, 0), (0, 2, 0.1))
ROWS = "0 0 0\n2 0 0.1\n2 2 0\n0 2 0.1\n"
FACES = "3 0 1 2\n4 0 1 2 3\n"


@pytest.mark.parametrize(
    ("surface", "place"),
    [
        (lambda: read_obj(b"v 0 0 0\nv 2 0 0.1\nv 2 2 0\nv 0 2 0.1\nf 1 2 3\nf 1 2 3 4\n"), "the face in line 6"),
        (lambda: read_obj(b"v 0 0 0\nv 2 0 0.1\nv 2 2 0\nv 0 2 0.1\nf 1 2 3\nf -4 -3 \\\n3 4\n"), "the face in line 6"),
        (lambda: read_off(off(FACES, "OFF\n4 2 0\n", ROWS)), "the face in line 8"),
        (lambda: read_ply(ascii_ply(FACES, 2, ROWS)), "the face in line 16"),
        (
            lambda: read_ply(binary_ply(((0, 1, 2), (0, 1, 2, 3)), vertices=BENT)),
            "face 2 of 2",
        ),
    ],
)
def test_a_bent_polygon_is_told_at_its_line_or_number(surface, place: str) -> None:
    read: Surface = surface()
    (told,) = read.measured
    assert told.text.startswith(
        "holds 1 polygon whose corners are not in one plane: they lie up to about {length} off it"
    )
    assert told.text.endswith(f"({place}, cut from its corner 1 of 4)")
    assert told.length == pytest.approx(0.05)


def test_of_many_the_worst_is_told() -> None:
    rows = "".join(f"v {x} {y} {z}\n" for k in (1, 3, 2) for x, y, z in ((0, 0, 0), (1, 0, k), (1, 1, 0), (0, 1, k)))
    (told,) = read_obj((rows + "f 1 2 3 4\nf 5 6 7 8\nf 9 10 11 12\n").encode()).measured
    assert told.text.startswith("holds 3 polygons")
    assert "(the face in line 14, " in told.text
    assert told.length == pytest.approx(1.5)


def test_what_a_files_digits_explain_is_not_told() -> None:
    for height, count in ((1.9e-5, 0), (2.5e-5, 1)):
        text = f"v 0 0 0\nv 1 0 {height}\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
        assert len(read_obj(text.encode()).measured) == count * (height / 4 > 1e-5)
    far = "v 1000 0 0\nv 1001 0 0.02\nv 1001 1 0\nv 1000 1 0\nf 1 2 3 4\n"
    assert read_obj(far.encode()).measured == ()


def test_a_scene_warns_of_folded_and_bent_polygons_in_its_own_unit(tmp_path: Path) -> None:
    house = "v -500 0 500\nv 500 0 500\nv 500 0 -500\nv -500 0 -500\nv 0 500 -500\n"
    (tmp_path / "m.obj").write_text(
        house + "v 0 0 900\nv 200 200 900\nv 200 0 900\nv 0 200 900\nf 1 2 3 4 5\nf 6 7 8 9\n"
    )
    told = warnings(
        tmp_path, f"{HEAD}meshes: {{m: {{file: m.obj, units: cm}}}}\nbodies: {{a: {{shapes: [{{mesh: m}}]}}}}"
    )
    folded, bent = (line.partition(" m.obj ")[2] for line in told if "polygon" in line)
    assert folded == (
        "holds 1 polygon that no triangles fit, as where an outline crosses itself: "
        "what is checked reaches beyond them by up to about 1.41e+03 mm "
        "(the face in line 11, cut from its corner 1 of 4)"
    )
    assert bent.startswith("holds 1 polygon whose corners are not in one plane: they lie up to about ")
    assert bent.endswith(" mm off it, and other triangles than those taken would differ "
                         "(the face in line 10, cut from its corner 3 of 5)")  # fmt: skip
