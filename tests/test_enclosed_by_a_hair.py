"""What is inside a mesh does not depend on how small a part is beside the rest, nor on how little a part overlaps."""

from __future__ import annotations

import numpy as np
import pytest
from closed_meshes import Raw, cube, moved, together
from scipy.spatial.transform import Rotation
from test_enclosed import inside, walls_between

from closecall.scheduler.enclosed import UndecidedError


@pytest.mark.parametrize("half", [1e-3, 1e-4, 1e-5, 1e-6])
@pytest.mark.parametrize("inwards", [False, True])
def test_a_part_millions_of_times_smaller_than_the_mesh_is_a_solid_or_a_cavity_as_it_is_wound(
    half: float, inwards: bool
) -> None:
    for middle in np.random.default_rng(1).uniform(20.0, 60.0, (12, 3)):
        mesh = together(cube(100.0), cube(half, middle, inwards))
        assert inside(mesh, [middle, middle + 2.0 * half]) == [not inwards, True]


def pot_with_lid(overlap: float) -> tuple[Raw, tuple[float, float, float]]:
    """Return one skin, a pot whose lid hangs on an arm and overlaps its rim by this, and a point in the pot."""
    labels = np.zeros((7, 5, 6), dtype=np.int64)
    labels[1:4, 1:4, 1:3] = 1
    labels[2, 2, 2] = 0
    labels[4, 2, 1] = labels[5, 2, 1:5] = 1  # the arm
    labels[1:5, 1:4, 4] = 1
    points, triangles = walls_between(labels, np.random.default_rng(0), 0.0)
    lid = (points[:, 2] >= 4.0) & (points[:, 0] <= 4.0)
    points[lid] = (points[lid] - 2.5) * (0.93, 0.93, 1.0) + 2.5
    points[lid & (points[:, 2] == 4.0), 2] = 3.0 - overlap
    return (points, triangles), (2.5, 2.5, 2.5)


@pytest.mark.parametrize("overlap", [1e-1, 1e-5, 1e-7, 1e-10])
@pytest.mark.parametrize("seed", range(2))
def test_a_skin_that_closes_a_room_by_crossing_itself_by_a_hair_is_refused(overlap: float, seed: int) -> None:
    mesh, _ = pot_with_lid(overlap)
    with pytest.raises(UndecidedError, match="crosses itself"):
        inside(moved(mesh, Rotation.random(rng=np.random.default_rng(seed)).as_matrix(), (0.1, 0.2, 0.3)), [])


@pytest.mark.parametrize("away", [0.0, 1e12, 1e14])
def test_a_skin_that_closes_a_room_by_crossing_itself_is_refused_however_far_away_it_lies(away: float) -> None:
    (points, triangles), _ = pot_with_lid(0.5)
    with pytest.raises(UndecidedError, match="crosses itself"):
        inside((points + away, triangles), [])


@pytest.mark.parametrize("gap", [1e-1, 1e-5, 1e-9])
def test_a_room_that_a_hair_leaves_open_is_outside(gap: float) -> None:
    mesh, room = pot_with_lid(-gap)
    assert inside(mesh, [room, (1.5, 2.5, 2.5), (2.5, 2.5, 4.5), (5.5, 2.5, 3.5), (4.5, 2.5, 3.0)]) == [
        *(False, True, True, True, False)
    ]
