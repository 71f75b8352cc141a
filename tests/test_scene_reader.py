"""A scene file becomes the scheduler's scene in SI units, or every fault in it is told."""

from __future__ import annotations

import json
import math
import random
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from closecall.formats.scene.errors import SceneError
from closecall.formats.scene.loaded import LoadedScene
from closecall.formats.scene.reader import read_scene
from closecall.scheduler.motions import Ballistic, Constant, Fixed, Harmonic, Keyframes, Screw, Swing
from closecall.scheduler.scene import Body

HEAD = "closecall: 1\nunits: {length: mm, angle: deg}\ntime: {start: 0, end: 1}\n"
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
GOOD = """\
closecall: 1
units: {length: m, angle: deg}
time: {start: 0, end: 3.6}
settings:
  time_resolution: 0.001
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
  ignore:  [{between: [static, drive], reason: bolted together}]
  check:   [{between: [gear, "link_*"]}]
"""


def load(folder: Path, text: str, name: str = "scene.yaml") -> LoadedScene:
    (folder / "crank.obj").write_text(TETRAHEDRON)
    (folder / name).write_text(text)
    return read_scene(folder / name)


def body(folder: Path, text: str) -> Body:
    return load(folder, f"{HEAD}bodies: {{a: {{{text}}}}}").scene.bodies[0]


def test_the_scene_of_the_contract_is_read(tmp_path: Path) -> None:
    loaded = load(tmp_path, GOOD)
    scene = loaded.scene
    assert [body.name for body in scene.bodies] == ["bench", "gear", "hammer", "carriage", "link_1"]
    assert [body.parent for body in scene.bodies] == [None, None, 3, None, None]
    assert (scene.start, scene.end) == (0.0, 3.6)
    assert (loaded.settings.time_resolution, loaded.settings.contact_tolerance) == (1e-3, 1e-6)
    assert loaded.source == GOOD.encode()
    assert loaded.path == tmp_path / "scene.yaml"
    assert [(file.name, file.path) for file in loaded.mesh_files] == [("crank", (tmp_path / "crank.obj").resolve())]
    assert scene.bodies[1].shapes[0].mesh is scene.bodies[1].shapes[1].mesh
    assert loaded.warnings == ()
    ignore, check = scene.rules
    assert (ignore.one, ignore.other, ignore.check) == ({0}, {1}, False)
    assert (check.one, check.other, check.check) == ({1}, {4}, True)


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


def test_shapes_become_cores_and_radii_in_metres(tmp_path: Path) -> None:
    shapes = (
        "shapes: [{box: [200, 400, 600], pose: {xyz: [0, 0, 7]}}, {sphere: 50}, {capsule: {radius: 5, length: 600}}]"
    )
    box, sphere, capsule = body(tmp_path, shapes).shapes
    assert box.mesh.vertices.max(axis=0).tolist() == pytest.approx([0.1, 0.2, 0.3])
    assert (len(box.mesh.triangles), box.mesh.solid, box.radius) == (12, True, 0.0)
    assert box.pose[:3, 3].tolist() == [0, 0, 0.007]
    assert (sphere.mesh.triangles.tolist(), sphere.radius, sphere.mesh.solid) == ([[0, 0, 0]], 0.05, False)
    assert (capsule.mesh.triangles.tolist(), capsule.radius) == ([[0, 1, 1]], 0.005)
    assert capsule.mesh.vertices.tolist() == [[0, 0, -0.3], [0, 0, 0.3]]


@pytest.mark.parametrize(
    ("motion", "expected"),
    [
        (
            "{type: constant, velocity: [1000, 0, -500], angular_velocity: [0, 180, 0]}",
            Constant((1.0, 0.0, -0.5), (0.0, math.pi, 0.0)),
        ),
        (
            "{type: ballistic, velocity: [0, 0, 2000], acceleration: [0, 0, -9810], angular_velocity: [90, 0, 0]}",
            Ballistic((0.0, 0.0, 2.0), (0.0, 0.0, -9.81), (math.pi / 2, 0.0, 0.0)),
        ),
        (
            "{type: screw, axis: [0, 0, 5], point: [10, 20, 30], rate: 360, pitch: -4}",
            Screw((0.0, 0.0, 1.0), (0.01, 0.02, 0.03), 2 * math.pi, -0.004),
        ),
        (
            "{type: harmonic, direction: [0, -3, 4], amplitude: 250, period: 2, phase: 45}",
            Harmonic((0.0, -0.6, 0.8), 0.25, 2.0, math.pi / 4),
        ),
        (
            "{type: swing, axis: [0, 2, 0], point: [0, 0, 500], amplitude: 60, period: 0.7, phase: -90}",
            Swing((0.0, 1.0, 0.0), (0.0, 0.0, 0.5), math.pi / 3, 0.7, -math.pi / 2),
        ),
    ],
)
def test_motions_are_converted_to_metres_and_radians(tmp_path: Path, motion: str, expected: object) -> None:
    assert body(tmp_path, f"motion: {motion}").motion == expected


def test_a_body_without_motion_is_fixed(tmp_path: Path) -> None:
    assert body(tmp_path, "pose: {}").motion == Fixed()


def test_radians_and_inches_are_taken_as_they_are(tmp_path: Path) -> None:
    text = HEAD.replace("mm", "in").replace("deg", "rad")
    motion = "{type: screw, axis: [1, 0, 0], rate: 2.5, pitch: 10}"
    screw = load(tmp_path, f"{text}bodies: {{a: {{motion: {motion}}}}}").scene.bodies[0].motion
    assert screw == Screw((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), 2.5, 0.254)


def test_numbers_whose_inverse_would_overflow_are_read_as_zero(tmp_path: Path) -> None:
    motion = body(
        tmp_path, "motion: {type: constant, velocity: [1e-20, 0, 0], angular_velocity: [0, 0, 1e-310]}"
    ).motion
    assert motion == Constant((1e-23, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert np.isfinite(motion.pose(1.0)).all()


def test_keyframes_are_converted_key_by_key(tmp_path: Path) -> None:
    keys = "[{t: -1}, {t: 0.5, xyz: [1, 2, 3], rpy: [0, 0, 90]}, {t: 1, quat_xyzw: [0, 0, 0.6, 0.8]}]"
    motion = body(tmp_path, f"motion: {{type: keyframes, keys: {keys}, interpolation: {{rotation: step}}}}").motion
    assert isinstance(motion, Keyframes)
    assert motion.times.tolist() == [-1, 0.5, 1]
    assert motion.translations.tolist() == [[0, 0, 0], [0.001, 0.002, 0.003], [0, 0, 0]]
    half = math.sqrt(0.5)
    np.testing.assert_allclose(motion.quaternions, [[1, 0, 0, 0], [half, 0, 0, half], [0.8, 0, 0, 0.6]], atol=1e-16)
    assert (motion.step_translation, motion.step_rotation) == (False, True)


def keyframes(keys: str) -> str:
    return f"{HEAD}bodies:\n  a:\n    motion: {{type: keyframes, keys: [{keys}]}}\n"


BODIES = f"{HEAD}bodies:\n  a: {{groups: [g]}}\n  b: {{groups: [g]}}\n  c: {{groups: [h]}}\n"


def test_pair_rules_take_names_groups_and_patterns(tmp_path: Path) -> None:
    rules = load(
        tmp_path,
        BODIES + "pairs: {ignore: [{between: [g, '[bc]'], reason: r}], check: [{between: ['*', c]}]}",
    ).scene.rules
    assert [(set(r.one), set(r.other), r.check) for r in rules] == [
        ({0, 1}, {1, 2}, False),
        ({0, 1, 2}, {2}, True),
    ]


def test_names_are_compared_and_kept_in_normal_form(tmp_path: Path) -> None:
    text = (
        HEAD
        + 'bodies: {"e\\u0301": {groups: ["o\\u0308"]}, b: {parent: "\\u00e9"}}\n'
        + 'pairs: {ignore: [{between: ["\\u00f6", b]}]}'
    )
    scene = load(tmp_path, text).scene
    assert (scene.bodies[0].name, scene.bodies[1].parent) == ("\u00e9", 0)
    assert scene.rules[0].one == {0}


def test_a_long_chain_of_parents_is_followed_without_recursion(tmp_path: Path) -> None:
    lines = "".join(f"  b{i}: {{parent: b{i - 1}}}\n" for i in range(1, 5000))
    assert len(load(tmp_path, f"{HEAD}bodies:\n  b0: {{}}\n{lines}").scene.bodies) == 5000


def test_keys_far_apart_are_warned_of_where_slerp_may_mislead(tmp_path: Path) -> None:
    keys = "{t: 0}, {t: 0.3, rpy: [0, 0, 149]}, {t: 0.6, rpy: [0, 0, -59]}, {t: 1, rpy: [0, 0, 121]}"
    first, second = load(tmp_path, keyframes(keys)).warnings
    assert ":6:" in first
    assert "bodies.a.motion.keys[2]: keys 1 and 2 are 152.0 degrees apart" in first
    assert "keys 2 and 3 are 180.0 degrees apart: which way round is ambiguous" in second
    stepped = keyframes(keys).replace("keys:", "interpolation: {rotation: step}, keys:")
    assert load(tmp_path, stepped).warnings == ()


def test_a_doubtful_mesh_is_warned_of_where_it_is_named(tmp_path: Path) -> None:
    (tmp_path / "open.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    loaded = load(tmp_path, HEAD + "meshes: {m: {file: open.obj, units: m}}\nbodies: {}")
    (warning,) = loaded.warnings
    assert warning.startswith(f"{tmp_path / 'scene.yaml'}:4:20: meshes.m.file: open.obj is open: treated as a surface")


def test_trimesh_is_not_imported_before_a_mesh_needs_it() -> None:
    code = "import sys, closecall.formats.scene.reader; sys.exit('trimesh' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


SPLINTERS = (
    *"{}[]:,-#&*!|>'\"%@`?~\t\n\0\\",
    *("- ", ": ", "null", "true", "1e400", ".nan", "0", "-1", "1e-320", "9" * 400, "{}", "[]", "\u202e", "\ud800"),
    *("world", "keyframes", "orbit", "gear", "matrix", "quat_wxyz", "../", "/dev/zero", "crank.obj", "[0, 0, 0]"),
)  # fmt: skip


def outcome(path: Path) -> LoadedScene | SceneError:
    try:
        return read_scene(path)
    except SceneError as error:
        return error


def mutated(source: random.Random, text: str) -> str:
    """Return the text with a few characters, words or lines removed, doubled, swapped or replaced."""
    for _ in range(source.randint(1, 4)):
        a, b = sorted(source.randrange(len(text) + 1) for _ in range(2))
        b = min(b, a + source.choice((1, 2, 8, 40)))
        pieces = ("", text[a:b] * 2, source.choice(SPLINTERS), text[a:b][::-1], chr(source.randrange(0x300)))
        text = text[:a] + source.choice(pieces) + text[b:]
    return text


@pytest.mark.parametrize("seed", range(20))
def test_nothing_but_located_faults_comes_of_a_mangled_scene(tmp_path: Path, seed: int) -> None:
    source = random.Random(seed)
    (tmp_path / "crank.obj").write_text(TETRAHEDRON)
    for _ in range(40):
        name = source.choice(("scene.yaml", "scene.json"))
        path = tmp_path / name
        path.write_bytes(mutated(source, GOOD).encode(errors="surrogatepass"))
        found = outcome(path)
        if isinstance(found, SceneError):
            assert found.faults
            assert all(str(fault).isprintable() for fault in found.faults)
            assert all(one.line <= other.line for one, other in pairwise(found.faults))
        else:
            assert all(np.isfinite(body.pose).all() for body in found.scene.bodies)
