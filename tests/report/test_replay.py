"""What the report's replay is made of: surfaces thinned to a budget, poses at the ticks, bodies while they exist."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from cli_process import SPHERES, closecall
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive

from closecall.formats.report import models as models_module
from closecall.formats.report import replay as replay_module
from closecall.formats.report.gathering import gather
from closecall.formats.report.models import Models
from closecall.formats.report.replay import Replay

MOST = 2000

EXISTING = SPHERES.replace("  right: {", "  right: {exists: [1, 2.5], ")


def primitive(mesh: trimesh.Trimesh) -> TriangleListPrimitive:
    made = TriangleListPrimitive(indices=mesh.faces.ravel().tolist())
    for x, y, z in mesh.vertices.tolist():
        made.points.add(x=x, y=y, z=z)
    return made


def replayed(text: str, folder: Path, *options: str) -> Replay:
    (folder / "scene.yaml").write_text(text)
    done = closecall("run", "scene.yaml", "-q", *options, "-o", "out.mcap", cwd=folder)
    assert done.returncode == 0, done.stderr
    replay = gather(folder / "out.mcap").replay
    assert replay is not None
    return replay


def test_a_fine_surface_is_drawn_coarser_and_stays_where_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(models_module, "_MOST_TRIANGLES", MOST)
    models = Models()
    fine, plain = trimesh.creation.icosphere(subdivisions=5), trimesh.creation.box()
    assert models.add(primitive(fine)) == models.add(primitive(fine)) == 0
    assert models.add(primitive(plain)) == 1
    ball, box = models.drawn()
    assert 200 < len(ball.triangles) <= MOST < len(fine.faces)
    assert np.linalg.norm(ball.points, axis=1) == pytest.approx(1.0, abs=0.1)
    drawn = trimesh.Trimesh(ball.points, ball.triangles, process=False)
    assert drawn.area == pytest.approx(fine.area, rel=0.1)
    assert np.array_equal(box.triangles, plain.faces)
    assert models.coarser == 1


def test_a_body_is_there_while_it_exists(tmp_path: Path) -> None:
    replay = replayed(EXISTING, tmp_path)
    assert replay.bodies["left"].there == [0.0, 5.0]
    assert replay.bodies["right"].there == pytest.approx([1.0, 2.5], abs=1.0 / 30.0)  # to a tick


def test_thinned_poses_are_ticks_and_the_last_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = replayed(SPHERES, tmp_path)
    monkeypatch.setattr(replay_module, "_MOST_KEPT", 100)
    monkeypatch.setattr(replay_module, "_MOST_DRAWN", 50)
    thinned = replayed(SPHERES, tmp_path)
    for name, rows in thinned.poses.items():
        assert 10 < len(rows) <= 26 < len(whole.poses[name])
        assert {tuple(row) for row in rows.tolist()} <= {tuple(row) for row in whole.poses[name].tolist()}
        assert (rows[0, 0], rows[-1, 0]) == (0.0, 5.0)


def test_without_ticks_bodies_stand_where_they_start(tmp_path: Path) -> None:
    replay = replayed(SPHERES, tmp_path, "--rate", "0")
    assert not replay.moves
    assert [rows[:, 0].tolist() for rows in replay.poses.values()] == [[0.0], [0.0]]
    assert replayed(SPHERES, tmp_path).moves
