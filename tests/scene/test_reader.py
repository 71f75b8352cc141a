"""A scene file becomes the scheduler's scene in SI units, or every fault in it is told."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from scene_files import HEAD, TETRAHEDRON, load

from closecall.scheduler.model.scene import PairRules, PairSet, Settings

GOOD = """\
closecall: 1
units: {length: m, angle: deg}
time: {start: 0, end: 3.6}
settings:
  time_resolution: 0.001
  contact_tolerance: 1e-5
  margin: 0.005
meshes:
  crank: {file: crank.obj, units: mm, up: z}
bodies:
  bench:
    shapes: [{box: [6, 4, 0.1], pose: {xyz: [1, 0, -1.2]}}]
    groups: [static]
  gear:
    pose: {xyz: [2.05, 0, 0]}
    shapes: [{mesh: crank, pose: {rpy: [90, 0, 15]}}, {mesh: crank}]
    motion: {type: constant, angular_velocity: [0, 0, 100]}
    groups: [drive]
  hammer:
    parent: carriage
    shapes: [{capsule: {radius: 0.05, length: 0.6}}]
    motion: {type: swing, axis: [0, 1, 0], amplitude: 60, period: 0.7}
  carriage:
    motion: {type: harmonic, direction: [1, 0, 0], amplitude: 0.4, period: 2, phase: 90}
  link_1:
    shapes: [{sphere: 0.25}]
    motion:
      type: keyframes
      keys:
        - {t: 0, xyz: [0, 0, 0]}
        - {t: 4, xyz: [0, 0, 1], axis_angle: {axis: [0, 0, 2], angle: 90}}
pairs:
  default: check
  ignore:  [{between: [static, drive], reason: bolted together}]
  check:   [{between: [gear, "link_*"]}]
  margins: [{between: [gear, hammer], margin: 0.001}]
"""
CRANK = TETRAHEDRON.replace("1", "400", 3)
"""400 mm along each axis."""


def test_the_scene_of_the_contract_is_read(tmp_path: Path) -> None:
    (tmp_path / "crank.obj").write_text(CRANK)
    loaded = load(tmp_path, GOOD)
    scene = loaded.scene
    assert [body.name for body in scene.bodies] == ["bench", "gear", "hammer", "carriage", "link_1"]
    assert [body.parent for body in scene.bodies] == [None, None, 3, None, None]
    assert (scene.start, scene.end) == (0.0, 3.6)
    assert loaded.settings == Settings(time_resolution=1e-3, contact_tolerance=1e-5, margin=0.005)
    assert loaded.source == GOOD.encode()
    assert loaded.path == tmp_path / "scene.yaml"
    assert [(file.name, file.path) for file in loaded.mesh_files] == [("crank", (tmp_path / "crank.obj").resolve())]
    assert scene.bodies[1].shapes[0].mesh is scene.bodies[1].shapes[1].mesh
    assert loaded.warnings == ()
    assert loaded.key_names == {}
    assert loaded.trajectory_files == ()
    assert scene.rules == PairRules(
        ignored=(PairSet(frozenset({0}), frozenset({1})),),
        checked=(PairSet(frozenset({1}), frozenset({4})),),
        default=True,
        margins=((PairSet(frozenset({1}), frozenset({2})), 0.001),),
    )


def test_settings_are_in_the_files_unit_and_have_defaults(tmp_path: Path) -> None:
    assert load(tmp_path, HEAD + "bodies: {}").settings == Settings(1e-3, 1e-6, 0.0)
    assert load(tmp_path, HEAD + "settings: {margin: 5}\nbodies: {}").settings == Settings(1e-3, 1e-6, 0.005)


def test_json_gives_the_scene_that_yaml_gives(tmp_path: Path) -> None:
    document = {
        "closecall": 1,
        "units": {"length": "mm", "angle": "rad"},
        "time": {"start": -1, "end": 1e0},
        "bodies": {"a": {"shapes": [{"sphere": 5}], "pose": {"xyz": [1, 2, 3]}}},
    }
    for scene in (load(tmp_path, json.dumps(document), name).scene for name in ("s.json", "s.yaml")):
        assert scene.start == -1.0
        assert scene.bodies[0].pose[:3, 3].tolist() == [0.001, 0.002, 0.003]
        assert scene.bodies[0].shapes[0].radius == 0.005


def test_names_are_compared_and_kept_in_normal_form(tmp_path: Path) -> None:
    text = (
        HEAD
        + 'bodies: {"e\\u0301": {groups: ["o\\u0308"]}, b: {parent: "\\u00e9"}}\n'
        + 'pairs: {ignore: [{between: ["\\u00f6", b]}]}'
    )
    scene = load(tmp_path, text).scene
    assert (scene.bodies[0].name, scene.bodies[1].parent) == ("\u00e9", 0)
    assert scene.rules.ignored[0].one == {0}


def test_a_long_chain_of_parents_is_followed_without_recursion(tmp_path: Path) -> None:
    lines = "".join(f"  b{i}: {{parent: b{i - 1}}}\n" for i in range(1, 5000))
    assert len(load(tmp_path, f"{HEAD}bodies:\n  b0: {{}}\n{lines}").scene.bodies) == 5000


def test_trimesh_is_not_imported_before_a_mesh_needs_it() -> None:
    code = "import sys, closecall.formats.scene.reader; sys.exit('trimesh' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
