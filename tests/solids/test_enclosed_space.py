"""The inside of a mesh: outside joins to infinity, or lies in a cavity; a mesh that no rule decides is refused."""

from __future__ import annotations

import numpy as np
import pytest
from closed_meshes import Raw, box, cube, inside, joined_boxes, moved, together, turned, walls_between
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from closecall.scheduler.solids import enclosed_space as rule
from closecall.scheduler.solids.enclosed_space import UndecidedError, enclosed_by
from closecall.scheduler.solids.line_crossings import Surroundings
from closecall.scheduler.solids.triangle_crossings import apart, near_each_other
from closecall.scheduler.solids.winding import winding_numbers
from oracle.triangles import separation

ZERO = (0.0, 0.0, 0.0)
NOWHERE = (9.0, 9.0, 9.0)
HALF = turned(cube(1.0), np.arange(12) % 2 == 0)
FEW = turned(cube(1.0), np.arange(12) < 1)
OTHER_CUTS = (cube(1.0)[0] * (-1, 1, 1), turned(cube(1.0))[1])
"""A cube whose faces are cut along the other diagonals."""
POT = together(
    *(box(*ends) for ends in (((-3, -3, -3), (3, 3, -2)), ((-3, -3, -2.5), (-2, 3, 3)), ((2, -3, -2.5), (3, 3, 3)))),
    *(box(*ends) for ends in (((-3, -3, -2.5), (3, -2, 3)), ((-3, 2, -2.5), (3, 3, 3)), ((-3, -3, 2), (3, 3, 3)))),
)
"""A room of six slabs."""


DECIDED: dict[str, tuple[Raw, list[tuple[float, ...]], list[tuple[float, ...]]]] = {
    "a cube": (cube(1), [(0.5, 0.2, 0)], [(1.5, 0, 0)]),
    "a cube inside out": (cube(1, inwards=True), [(0.5, 0.2, 0)], [(1.5, 0, 0)]),
    "a cube with half of its faces turned": (HALF, [(0, 0, 0), (0.9, 0.9, 0.9)], [(1.1, 0, 0)]),
    "a cube with one face turned": (FEW, [(0, 0, 0), (-0.9, 0.9, 0.9)], [(1.1, 0, 0)]),
    "cubes that overlap": (together(cube(1), cube(1, (1, 0.1, 0.2))), [(0.5, 0, 0), (-0.5, 0, 0)], [(2.5, 0, 0)]),
    "cubes that overlap, one inwards": (
        together(cube(1), cube(1, (1, 0.1, 0.2), inwards=True)),
        [(0.5, 0, 0), (-0.5, 0, 0), (1.5, 0, 0)],
        [(2.5, 0, 0), (1.5, 0, -0.9)],
    ),
    "cubes that overlap face to face, one inwards": (
        together(cube(1), cube(1, (1, 0, 0), inwards=True)),
        [(0.5, 0, 0), (-0.5, 0, 0), (1.5, 0, 0)],
        [(2.5, 0, 0)],
    ),
    "overlapping cubes of one part": (
        joined_boxes((1, 0.1, 0.2), inwards=False),
        [(0.5, 0, 0), (-0.5, 0, 0), (1.5, 0, 0), (0, 0, 3)],
        [(0.5, 0, 3), (2.5, 0, 0), (-0.5, 0, 1.1), (0.5, 0.05, 1.5)],
    ),
    "a hollow": (together(cube(2), cube(1, inwards=True)), [(1.5, 0, 0)], [(0, 0, 0), (2.5, 0, 0)]),
    "a hollow inside out": (together(cube(2, inwards=True), cube(1)), [(1.5, 0, 0)], [(0, 0, 0), (2.5, 0, 0)]),
    "a hollow with skins wound alike": (together(cube(2), cube(1)), [(1.5, 0, 0), (0, 0, 0)], [(2.5, 0, 0)]),
    "a hollow with a face of the inner skin turned": (
        together(cube(2), turned(cube(1, inwards=True), np.arange(12) < 1)),
        [(1.5, 0, 0), (0, 0, 0)],
        [(2.5, 0, 0)],
    ),
    "an island in a cavity": (
        together(cube(3), cube(2, inwards=True), cube(1)),
        [(2.5, 0, 0), (0, 0, 0)],
        [(1.5, 0, 0), (3.5, 0, 0)],
    ),
    "a hollow island in a cavity": (
        together(cube(4), cube(3, inwards=True), cube(2), cube(1, inwards=True)),
        [(3.5, 0, 0), (1.5, 0, 0)],
        [(2.5, 0, 0), (0, 0, 0)],
    ),
    "a cavity in a cavity": (
        together(cube(3), cube(2, inwards=True), cube(1, inwards=True)),
        [(2.5, 0, 0), (0, 0, 0)],
        [(1.5, 0, 0)],
    ),
    "a cavity of a solid in a solid": (
        together(cube(3), cube(2), cube(1, inwards=True)),
        [(2.5, 0, 0), (1.5, 0, 0), (0, 0, 0)],
        [NOWHERE],
    ),
    "cavities that overlap": (
        together(cube(3), cube(1, (0.5, 0, 0), inwards=True), cube(1, (-0.5, 0.1, 0.2), inwards=True)),
        [(2.5, 0, 0), (0, 1.5, 0)],
        [(0, 0, 0), (1.2, 0, 0), (-1.2, 0, 0)],
    ),
    "cavities face to face": (
        together(cube(3), cube(1, (1, 0, 0), inwards=True), cube(1, (-1, 0, 0), inwards=True)),
        [(2.5, 0, 0), (0, 1.5, 0)],
        [(0.5, 0, 0), (-0.5, 0, 0)],
    ),
    "a cavity and a part that crosses it": (
        together(cube(3), cube(1, inwards=True), box((0.5, -0.5, -0.5), (4, 0.5, 0.5))),
        [(2.5, 0, 0), (0.7, 0, 0), (3.5, 0, 0)],
        [(0, 0, 0), (3.5, 1, 0)],
    ),
    "the same cube twice": (together(cube(1), cube(1)), [(0.5, 0.2, 0)], [(1.5, 0, 0)]),
    "the same cube twice, once inwards": (together(cube(1), cube(1, inwards=True)), [(0.5, 0.2, 0)], [(1.5, 0, 0)]),
    "the same cube cut in two ways": (together(cube(1), OTHER_CUTS), [(0.5, 0.2, 0)], [(1.5, 0, 0)]),
    "a hollow twice": (together(*2 * (cube(2), cube(1, inwards=True))), [(1.5, 0, 0)], [(0, 0, 0), (2.5, 0, 0)]),
    "cubes that share a face": (together(cube(1), cube(1, (2, 0, 0))), [(0, 0, 0), (2, 0, 0)], [(3.5, 0, 0)]),
    "cubes that share a face, one inwards": (
        together(cube(1), cube(1, (2, 0, 0), inwards=True)),
        [(0, 0, 0), (2, 0, 0)],
        [(3.5, 0, 0)],
    ),
    "cubes that share a face that is cut in two ways": (
        together(cube(1), (OTHER_CUTS[0] + (2, 0, 0), OTHER_CUTS[1])),
        [(0, 0, 0), (2, 0, 0)],
        [(3.5, 0, 0)],
    ),
    "cubes that share an edge": (
        together(cube(1), cube(1, (2, 2, 0))),
        [(0, 0, 0), (2, 2, 0)],
        [(2, 0, 0), (0, 2, 0), (4, 4, 0)],
    ),
    "cubes that share an edge, one inwards": (
        together(cube(1), cube(1, (2, 2, 0), inwards=True)),
        [(0, 0, 0), (2, 2, 0)],
        [(2, 0, 0), (0, 2, 0)],
    ),
    "cubes that share a corner, one inwards": (
        together(cube(1), cube(1, (2, 2, 2), inwards=True)),
        [(0, 0, 0), (2, 2, 2)],
        [(2, 0, 0)],
    ),
    "a cube with a fin": (
        together(cube(1), (np.array([(1, 1, -1), (1, 1, 1), (2, 2, 0.0)]), np.array([(0, 1, 2)]))),
        [(0, 0, 0)],
        [(1.5, 1.5, 0), (1.6, 1.4, 0)],
    ),
    "a cube and a sheet": (
        together(cube(1), (np.array([(3, 0, 0), (4, 0, 0), (3, 1, 0.0)]), np.array([(0, 1, 2)]))),
        [(0, 0, 0)],
        [(3.2, 0.2, 0.1)],
    ),
    "a cube without a triangle": ((cube(1)[0], cube(1)[1][1:]), [], [(0, 0, 0)]),
    "a room of slabs": (POT, [(2.5, 0, 0), (0, 0, -2.7)], [(0, 0, 0), (3.5, 0, 0)]),
}


@pytest.mark.parametrize("name", DECIDED)
def test_a_point_is_inside_or_not_whichever_way_the_mesh_lies_and_is_stored(name: str) -> None:
    mesh, within, without = DECIDED[name]
    points = np.array([*within, *without])
    expected = [True] * len(within) + [False] * len(without)
    rng = np.random.default_rng(len(name))
    rotation, mirror, shift = Rotation.random(rng=rng).as_matrix(), np.diag([-1.0, 1.0, 1.0]), np.array([0.1, 0.2, 0.3])
    order = rng.permutation(len(mesh[0]))
    assert inside(mesh, points) == expected
    assert inside(moved(mesh, rotation, shift), points @ rotation.T + shift) == expected
    assert inside(moved(mesh, mirror, ZERO), points @ mirror) == expected
    assert inside((mesh[0][order], np.argsort(order)[mesh[1]]), points) == expected


UNDECIDED: dict[str, tuple[Raw, str]] = {
    "a cavity flush with a face": (together(cube(2), cube(1, (1, 0, 0), inwards=True)), "touches or crosses"),
    "a cavity through a face": (together(cube(2), cube(1, (1.5, 0, 0), inwards=True)), "touches or crosses"),
    "a cavity of a mirrored hollow through a face": (
        together(cube(2, inwards=True), cube(1, (1.5, 0, 0))),
        "touches or crosses",
    ),
    "a cavity that shares a corner": (together(cube(2), cube(1, (1, 1, 1), inwards=True)), "touches or crosses"),
    "a cavity that shares an edge": (
        together(cube(2), turned((cube(1)[0] @ np.diag([1, 1, 2.0]) + (1, 1, 0), cube(1)[1]))),
        "lies on another|touches or crosses",
    ),
    "overlapping cubes of one part, one inwards": (joined_boxes((1, 0.1, 0.2), inwards=True), "both ways"),
    "overlapping cubes of one part, face to face": (joined_boxes((1, 0, 0), inwards=True), "both ways"),
    "a bow tie": (
        (
            np.array([(x, y, z) for z in (-1.0, 1.0) for x, y in ((-1, -1), (1, 1), (1, -1), (-1, 1))]),
            np.array(
                [t for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)) for t in ((a, b, b + 4), (a, b + 4, a + 4))]
                + [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7)]
            ),
        ),
        "both ways",
    ),
}


@pytest.mark.parametrize("name", UNDECIDED)
@pytest.mark.parametrize("turn", [False, True])
def test_what_no_rule_can_tell_is_refused_with_two_triangles(name: str, turn: bool) -> None:
    mesh, phrase = UNDECIDED[name]
    if turn and "edge" not in name:
        mesh = moved(mesh, Rotation.random(rng=np.random.default_rng(3)).as_matrix(), (0.1, 0.2, 0.3))
    with pytest.raises(UndecidedError, match=phrase) as refused:
        enclosed_by(*mesh)
    one, other = refused.value.triangles
    assert one != other
    assert min(one, other) >= 0
    assert max(one, other) < len(mesh[1])
    assert refused.value.remedy


def figure_eight(radius: float) -> Raw:
    """Return a tube around a figure of eight, which crosses itself in the middle."""
    u = np.linspace(0.0, 2.0 * np.pi, 96, endpoint=False)
    path = np.column_stack((6.0 * np.sin(u), 2.0 * np.sin(2.0 * u), 0.0 * u))
    along = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    across = np.cross(along, (0.0, 0.0, 1.0))
    across /= np.linalg.norm(across, axis=1)[:, None]
    w = np.linspace(0.0, 2.0 * np.pi, 10, endpoint=False)
    rings = path[:, None] + radius * (np.cos(w)[:, None] * across[:, None] + np.sin(w)[:, None] * (0.0, 0.0, 1.0))
    triangles = []
    for i in range(96):
        for k in range(10):
            a, b = i * 10 + k, i * 10 + (k + 1) % 10
            c, d = (i + 1) % 96 * 10 + (k + 1) % 10, (i + 1) % 96 * 10 + k
            triangles += [(a, b, c), (a, c, d)]
    return rings.reshape(-1, 3), np.array(triangles)


def test_a_tube_that_crosses_itself_is_solid_and_its_loops_are_free() -> None:
    mesh = figure_eight(0.3)
    (solid,) = enclosed_by(*mesh).solids
    assert solid.crossed
    points = [(0, 0, 0), (0.3, 0.2, 0), (3, 0, 0), (0, 0.6, 0)]
    assert inside(mesh, points) == [True, True, False, False]


def test_a_closed_one_sided_surface_is_refused() -> None:
    """A Klein bottle: a ring of figures of eight that turns half round."""
    a, b = np.meshgrid(np.arange(24), np.arange(16), indexing="ij")
    u, v = 2.0 * np.pi * a / 24, 2.0 * np.pi * b / 16
    r = 3.0 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    z = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    vertices = np.stack((r * np.cos(u), r * np.sin(u), z), axis=2).reshape(-1, 3)

    def at(i: int, k: int) -> int:
        return i * 16 + k % 16 if i < 24 else -k % 16

    triangles = []
    for i in range(24):
        for k in range(16):
            triangles += [(at(i, k), at(i + 1, k), at(i + 1, k + 1)), (at(i, k), at(i + 1, k + 1), at(i, k + 1))]
    with pytest.raises(UndecidedError, match="Moebius"):
        enclosed_by(vertices, np.array(triangles))


@pytest.mark.parametrize(
    ("mesh", "phrases"),
    [
        (together(cube(2), cube(1)), ["wound alike"]),
        (together(cube(2), turned(cube(1, inwards=True), np.arange(12) < 1)), ["of mixed orientation"]),
        (together(cube(1), cube(1, (1, 0.1, 0.2), inwards=True)), ["wound opposite ways"]),
        (together(cube(3), cube(2, inwards=True), cube(1, inwards=True)), ["wound alike"]),
        (together(cube(2), cube(1, inwards=True)), []),
        (together(cube(1), cube(1, (1, 0.1, 0.2))), []),
        (together(cube(3), cube(2, inwards=True), cube(1)), []),
        (POT, []),
    ],
)
def test_what_reads_as_solid_though_it_may_be_meant_otherwise_is_told(mesh: Raw, phrases: list[str]) -> None:
    doubts = enclosed_by(*mesh).doubts
    assert len(doubts) == len(phrases)
    for doubt, phrase in zip(doubts, phrases, strict=True):
        assert phrase in doubt.problem


def test_each_cavity_is_cut_from_the_smallest_solid_around_it() -> None:
    solids = enclosed_by(*together(cube(4), cube(3, inwards=True), cube(2), cube(1, inwards=True))).solids
    assert [len(solid.cavities) for solid in solids] == [1, 1]
    (large, small) = (solid.skin.max() // 8 for solid in solids)
    assert (large, small) == (0, 2)
    assert [cavity.max() // 8 for solid in solids for cavity in solid.cavities] == [1, 3]


def bent_sheet(rng: np.random.Generator) -> Raw:
    """Return a closed thick sheet of 8 by 8 quads, bent at random: it may cross itself, and has deep pockets."""
    x, y = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9), indexing="ij")
    z = rng.uniform(-0.5, 0.5, x.shape)
    upper, lower = (np.stack((x, y, z + lift), axis=2).reshape(-1, 3) for lift in (0.15, -0.15))
    quads = np.array([(i * 9 + j, i * 9 + 9 + j, i * 9 + 10 + j, i * 9 + 1 + j) for i in range(8) for j in range(8)])
    rim = [*range(0, 73, 9), *range(73, 81), *range(71, -1, -9), *range(7, 0, -1)]
    top = np.concatenate((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]))
    sides = [t for a, b in zip(rim, rim[1:] + rim[:1], strict=True) for t in ((a + 81, b + 81, b), (a + 81, b, a))]
    return np.vstack((upper, lower)), np.vstack((top, top[:, ::-1] + 81, sides))


def test_a_large_mesh_is_searched_for_crossings_only_where_a_point_depends_on_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(rule, "MOST_SEARCHED", 0)
    rng = np.random.default_rng(5)
    mesh = bent_sheet(rng)
    (solid,) = enclosed_by(*mesh).solids
    assert solid.crossed is None
    points = rng.uniform(-1.0, 1.0, (16, 3)) * (1.0, 1.0, 0.4)
    expected = np.abs(winding_numbers(points, mesh[0][mesh[1]])) > 0.5
    assert 2 <= expected.sum() <= 14
    assert inside(mesh, points) == expected.tolist()


@pytest.mark.parametrize("seed", range(4))
def test_all_pairs_of_triangles_whose_boxes_meet_are_found_once(seed: int) -> None:
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-1, 1, (300, 1, 3)) + rng.uniform(-0.1, 0.1, (300, 3, 3)) * 10.0 ** rng.uniform(
        -2, 1, (300, 1, 1)
    )
    low, high = corners.min(axis=1), corners.max(axis=1)
    meet = ((low[:, None] <= high) & (low <= high[:, None])).all(axis=2)
    expected = {(i, j) for i, j in np.argwhere(meet).tolist() if i < j}
    found = [
        tuple(sorted(pair)) for i, j in near_each_other(corners) for pair in zip(i.tolist(), j.tolist(), strict=True)
    ]
    assert len(found) == len(set(found))
    assert set(found) == expected


def test_triangles_told_apart_never_share_a_point_and_those_told_otherwise_nearly_do() -> None:
    """Against the oracle's least distance: apart beyond rounding, or within it."""
    rng = np.random.default_rng(2)
    one = rng.normal(size=(3000, 3, 3))
    other = rng.normal(size=(3000, 3, 3)) * rng.choice([0.1, 1.0], 3000)[:, None, None]
    other[:500, :, 2] = one[:500, :, 2] = 0.0
    other[500:700, 0] = one[500:700, 1]
    distances = separation(np.moveaxis(one, 2, 0), np.moveaxis(other, 2, 0))
    told = apart(one, other)
    crossing = told & (distances <= 0.0)
    assert not crossing.any()
    assert told[distances > 1e-9].mean() > 0.99


def test_lines_tell_how_often_a_surface_winds_and_how_far_they_are_free() -> None:
    mesh = together(cube(2), cube(1, inwards=True), cube(0.5, (1.7, 0, 0)))
    points = np.random.default_rng(0).uniform(-3, 3, (400, 3))
    around = Surroundings(mesh[0][mesh[1]])
    expected = np.round(winding_numbers(points, mesh[0][mesh[1]]))
    np.testing.assert_array_equal(around.windings(points), expected)
    held = np.abs(points).max(axis=1) < 1.0
    np.testing.assert_array_equal(around.open(points), (expected == 0) & ~held)


def reached(labels: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Tell which cells join the first one without a wall between."""
    there = np.zeros(labels.shape, dtype=bool)
    there[0, 0, 0] = True
    while True:
        before = there.sum()
        for axis in range(3):
            for one, other in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
                of, to = (np.moveaxis(array, axis, 0)[part] for array, part in ((there, one), (there, other)))
                a, b = (np.moveaxis(labels, axis, 0)[part] for part in (one, other))
                to |= of & (a == b)
        if there.sum() == before:
            return there


@pytest.mark.parametrize("turned_share", [0.0, 0.05, 0.5])
def test_of_walls_between_cells_matter_is_inside_and_what_joins_the_outside_is_not(turned_share: float) -> None:
    """Cells at random, two kinds of matter: edges of three and four walls, corners that touch, walls turned over."""
    decided = 0
    for seed in range(5):
        rng = np.random.default_rng(seed)
        labels = np.zeros((5, 5, 5), dtype=np.int64)
        labels[1:-1, 1:-1, 1:-1] = rng.integers(0, 3, (3, 3, 3)) * (rng.random((3, 3, 3)) < 0.7)
        told = (labels > 0) | reached(labels)
        try:
            found = inside(walls_between(labels, rng, turned_share), np.argwhere(told) + 0.5)
        except UndecidedError:
            assert not reached(labels)[labels == 0].all(), "nothing but what encloses a void may be refused"
            continue
        decided += 1
        assert found == (labels[told] > 0).tolist(), seed
    assert decided >= 3


def test_of_boxes_put_together_at_random_every_point_is_in_a_box_and_in_no_cavity_of_it() -> None:
    """Boxes with whole numbers as corners: they share corners, edges and faces, hold each other and cross."""
    decided = 0
    for seed in range(25):
        rng = np.random.default_rng(seed)
        lows = rng.integers(0, 6, (4, 3))
        highs = lows + np.array([(5, 4, 4), (4, 3, 3), (3, 2, 2), (2, 1, 1)])
        inwards = rng.random(4) < rng.choice([0.0, 0.5])
        boxes = [box(*each) for each in zip(lows, highs, inwards.tolist(), strict=True)]
        points, of = np.unique(together(*boxes)[0], axis=0, return_inverse=True)
        places = rng.integers(0, 11, (20, 3)) + 0.5
        try:
            found = inside((points, of.reshape(-1)[together(*boxes)[1]]), places)
        except UndecidedError:
            assert inwards.any()
            continue
        decided += 1
        cavity = np.zeros(4, dtype=bool)
        expected = np.zeros(len(places), dtype=bool)
        held = np.all((places[:, None] > lows) & (places[:, None] < highs), axis=2)
        hosts = [
            [h for h in range(k) if (lows[h] < lows[k]).all() and (highs[h] > highs[k]).all()][-1:] for k in range(4)
        ]
        for k, host in enumerate(hosts):
            cavity[k] = any(inwards[h] != inwards[k] and not cavity[h] for h in host)
        for k in np.flatnonzero(~cavity):
            own = [c for c in range(4) if cavity[c] and hosts[c] == [k]]
            expected |= held[:, k] & ~held[:, own].any(axis=1)
        assert found == expected.tolist(), seed
    assert decided > 15


def test_a_mesh_of_too_many_triangles_across_each_other_is_not_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rule, "MOST_PAIRS", 10)
    (one, other) = enclosed_by(*together(cube(1), cube(1, (1, 0.1, 0.2)))).solids
    assert one.crossed is None
    assert other.crossed is None
    with pytest.raises(UndecidedError, match="too many triangles"):
        enclosed_by(*together(cube(2), cube(1, inwards=True)))
