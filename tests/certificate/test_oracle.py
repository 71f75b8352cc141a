"""The oracle itself: its distances against closed forms and FCL, its poses against formulas, its power to object."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from fractions import Fraction
from itertools import combinations
from pathlib import Path
from typing import Any

import fcl
import numpy as np
import pytest
import yaml
from google.protobuf import timestamp_pb2
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet
from google.protobuf.message_factory import GetMessages
from mcap.writer import Writer
from scipy.spatial.transform import Rotation

from oracle.bodies import BOX_CORNERS, BOX_TRIANGLES, Surface
from oracle.check import check
from oracle.distance import PairDistance
from oracle.enclosed import solids_of
from oracle.logs import Log, read_log
from oracle.meshes import topology
from oracle.poses import Kinematics
from oracle.rigid import FloatArray, numbers, rigid, rotations
from oracle.scenes import write_scene
from oracle.solids import random_solid, write_mesh
from oracle.truth import Truth
from oracle.wall import SPOILED, WALL, true_log

AXES = np.eye(3)


def surface(triangles: FloatArray, radius: float = 0.0) -> Surface:
    kind = topology(triangles)
    return Surface(triangles, np.full(len(triangles), radius), triangles[kind.parts, 0], solids_of(triangles))


def box(x: float, y: float, z: float) -> Surface:
    return surface((BOX_CORNERS * [x, y, z])[BOX_TRIANGLES])


def ball(radius: float) -> Surface:
    return surface(np.zeros((1, 3, 3)), radius)


def stick(length: float, radius: float = 0.0) -> Surface:
    end = 0.5 * length * AXES[2]
    return surface(np.array([[-end, end, end]]), radius)


def at(*place: float, turn: FloatArray | None = None) -> FloatArray:
    return rigid(None if turn is None else turn[None], np.array([place], dtype=float))


def signed(a: Surface, b: Surface, pose: FloatArray) -> float:
    return float(PairDistance(a, b).signed(pose)[0])


TILTED = rotations(np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0), np.array([np.arctan(np.sqrt(2.0))]))[0]
QUARTER = rotations(AXES[0], np.array([0.5 * np.pi]))[0]


@pytest.mark.parametrize(
    ("a", "b", "pose", "expected"),
    [
        (ball(0.5), ball(0.25), at(3, 4, 0), 4.25),
        (ball(0.5), ball(0.25), at(0.5, 0, 0), -0.25),
        (box(2, 2, 2), ball(0.5), at(2, 2, 2), np.sqrt(3) - 0.5),
        (box(2, 2, 2), ball(0.5), at(0, 0, 1.75), 0.25),
        (box(2, 2, 2), box(2, 2, 2), at(2.5, 0, 0), 0.5),
        (box(2, 2, 2), box(2, 2, 2), at(5, 6, 0), 5.0),
        (box(4, 4, 1), box(1, 1, 1), at(0, 0, 0.5 + 0.5 * np.sqrt(3) + 0.1, turn=TILTED), 0.1),
        (stick(2), stick(2), at(0.3, 0, 0, turn=QUARTER), 0.3),
        (stick(2, 0.1), stick(2, 0.05), at(0.3, 0, 0.7), 0.15),
        (stick(2), stick(2), at(0, 0, 2.5), 0.5),
        (box(2, 2, 2), stick(1, 0.125), at(1.25, 0, 0), 0.125),
    ],
)
def test_distance_has_its_closed_form(a: Surface, b: Surface, pose: FloatArray, expected: float) -> None:
    assert signed(a, b, pose) == pytest.approx(expected, abs=1e-14)
    back = np.linalg.inv(pose[0])[None]
    assert signed(b, a, back) == pytest.approx(expected, abs=1e-14)


def test_coplanar_faces_apart_do_not_touch() -> None:
    """Boxes that stand on one floor have bottom faces in one plane: rounding must not make edges pierce them."""
    for angle in np.linspace(0.0, 0.3, 31):
        turn = rotations(AXES[2], np.array([angle]))[0]
        reach = 0.5 * (np.cos(angle) + np.sin(angle))
        assert signed(box(1, 1, 1), box(1, 1, 1), at(0.6 + reach, 0, 0, turn=turn)) == pytest.approx(0.1, abs=1e-14)


def test_coplanar_faces_that_overlap_are_at_distance_zero() -> None:
    assert abs(signed(box(1, 1, 1), box(0.3, 0.3, 0.3), at(0.1, 0.2, 0.65))) < 1e-15


def test_nearly_parallel_edges_that_cross_have_their_small_distance() -> None:
    """Crossing at an angle of 1e-9, 1e-6 apart: the usual denominator a e - b^2 has no correct digit left."""
    turn = rotations(AXES[0], np.array([1e-9]))[0]
    assert signed(stick(2), stick(2), at(1e-6, 0, 0, turn=turn)) == pytest.approx(1e-6, abs=1e-18)


@pytest.mark.parametrize("held", [ball(0.1), box(0.2, 0.2, 0.2), stick(0.3, 0.1)])
def test_a_body_inside_a_closed_one_overlaps(held: Surface) -> None:
    host = box(2, 2, 2)
    assert signed(host, held, at(0.3, 0.1, 0.2)) < -0.4
    assert signed(held, host, at(0.3, 0.1, 0.2)) < -0.4
    opened = surface(host.triangles[:-1])
    assert signed(opened, held, at(0.3, 0.1, 0.2)) > 0.4


def fcl_model(triangles: FloatArray) -> fcl.BVHModel:
    model = fcl.BVHModel()
    model.beginModel(3 * len(triangles), len(triangles))
    model.addSubModel(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
    model.endModel()
    return model


@pytest.mark.parametrize("seed", range(12))
def test_surfaces_are_as_far_apart_as_fcl_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one, other = random_solid(rng), random_solid(rng)
    poses = rigid(Rotation.from_quat(rng.standard_normal((40, 4))).as_matrix(), rng.uniform(-1.5, 1.5, (40, 3)))
    found = PairDistance(surface(one), surface(other)).surfaces(poses)
    models = fcl_model(one), fcl_model(other)
    for pose, distance in zip(poses, found, strict=True):
        placed = fcl.Transform(pose[:3, :3], pose[:3, 3])
        told = fcl.distance(fcl.CollisionObject(models[0]), fcl.CollisionObject(models[1], placed))
        assert max(distance, 0.0) == pytest.approx(max(told, 0.0), abs=1e-13)


def test_random_solids_are_closed_and_outward() -> None:
    for seed in range(60):
        triangles = random_solid(np.random.default_rng(seed))
        assert topology(triangles).closed
        assert np.linalg.det(triangles).sum() > 0.0
        assert 20 <= len(triangles) <= 200


def posed(motion: dict[str, Any] | None, times: list[float], **body: Any) -> FloatArray:
    scene = {"units": {"length": "mm", "angle": "deg"}, "bodies": {"it": {"motion": motion, **body}}}
    return Kinematics(scene).world_from_body("it", np.array(times))


def test_screw_turns_about_its_point_and_advances_by_its_pitch() -> None:
    spec = {"type": "screw", "axis": [0, 0, 2], "point": [1000, 0, 0], "rate": 90, "pitch": 400, "t0": 1}
    place = posed(spec, [1.0, 2.0, 5.0])[:, :3, 3]
    np.testing.assert_allclose(place, [[0, 0, 0], [1, -1, 0.1], [0, 0, 0.4]], atol=1e-15)


def test_swing_and_harmonic_follow_their_sines() -> None:
    swing = {"type": "swing", "axis": [1, 0, 0], "point": [0, 0, 500], "amplitude": 60, "period": 2}
    angle = np.radians(60) * np.sin(np.pi * 0.3)
    expected = [0, 0.5 * np.sin(angle), 0.5 - 0.5 * np.cos(angle)]
    np.testing.assert_allclose(posed(swing, [0.3])[0, :3, 3], expected, atol=1e-15)
    harmonic = {"type": "harmonic", "direction": [0, 3, 0], "amplitude": 200, "period": 2, "phase": 90}
    np.testing.assert_allclose(posed(harmonic, [0.5, 1.0])[:, 1, 3], [0.0, -0.2], atol=1e-15)


def test_a_harmonic_is_where_it_is_after_a_thousand_million_periods() -> None:
    harmonic = {"type": "harmonic", "direction": [0, 0, 1], "amplitude": 500, "period": 1.7}
    times = [1700000001.1666667, 1700000007.1]
    periods = [Fraction(time) / Fraction(1.7) % 1 for time in times]
    expected = [0.5 * np.sin(2.0 * np.pi * float(part)) for part in periods]
    np.testing.assert_allclose(posed(harmonic, times)[:, 2, 3], expected, atol=1e-15)


def test_ballistic_flies_a_parabola_in_the_frame_of_its_pose() -> None:
    spec = {
        "type": "ballistic",
        "velocity": [1000, 0, 0],
        "acceleration": [0, 0, -2000],
        "angular_velocity": [0, 0, 90],
    }
    pose = {"xyz": [0, 0, 5000], "rpy": [0, 0, 90]}
    world = posed(spec, [2.0], pose=pose)[0]
    np.testing.assert_allclose(world[:3, 3], [0, 2, 1], atol=1e-14)
    np.testing.assert_allclose(world[:3, 0], [0, -1, 0], atol=1e-15)


def test_step_keys_take_effect_at_their_own_time() -> None:
    keys = [{"t": 0, "xyz": [0, 0, 0]}, {"t": 1, "xyz": [7, 0, 0]}, {"t": 2, "xyz": [9, 0, 0], "rpy": [0, 0, 90]}]
    spec = {"type": "keyframes", "keys": keys, "interpolation": {"translation": "step", "rotation": "slerp"}}
    world = posed(spec, [0.5, np.nextafter(1.0, 0.0), 1.0, 1.5, 2.0])
    np.testing.assert_allclose(world[:, 0, 3], [0, 0, 0.007, 0.007, 0.009])
    np.testing.assert_allclose(world[:, 1, 0], np.sin(np.radians([0, 0, 0, 45, 90])), atol=1e-15)


def test_keys_are_held_or_looped_outside_their_range() -> None:
    keys = [{"t": 1, "xyz": [0, 0, 0]}, {"t": 3, "xyz": [2000, 0, 0]}]
    spec = {"type": "keyframes", "keys": keys, "before": "hold", "after": "loop"}
    np.testing.assert_allclose(posed(spec, [0.0, 2.0, 3.5, 4.75])[:, 0, 3], [0, 1, 0.5, 1.75])


def test_a_float_before_a_key_of_an_earlier_loop_is_before_it() -> None:
    """The key at 0.21875 is shown at -0.078125 too; the float before that, 1.4e-17 s sooner, is not yet there."""
    keys = [{"t": 0.0, "xyz": [0, 0, 0]}, {"t": 0.21875, "xyz": [1, 0, 0]}, {"t": 0.296875, "xyz": [2, 0, 0]}]
    steps = {"translation": "step", "rotation": "step"}
    spec = {"type": "keyframes", "keys": keys, "before": "loop", "interpolation": steps}
    np.testing.assert_allclose(posed(spec, [np.nextafter(-0.078125, -1.0), -0.078125])[:, 0, 3], [0.0, 0.001])


def test_a_pose_reads_the_same_in_every_notation() -> None:
    turn = Rotation.from_euler("xyz", [10, 20, 30], degrees=True)
    x, y, z, w = turn.as_quat()
    vector = turn.as_rotvec(degrees=True)
    angle = float(np.linalg.norm(vector))
    matrix = np.eye(4)
    matrix[:3, :3] = turn.as_matrix()
    ways = [
        {"rpy": [10, 20, 30]},
        {"quat_wxyz": [w, x, y, z]},
        {"quat_xyzw": [x, y, z, w]},
        {"axis_angle": {"axis": (3 * vector).tolist(), "angle": angle}},
        {"matrix": matrix.tolist()},
    ]
    for way in ways:
        np.testing.assert_allclose(posed(None, [0.0], pose=way)[0], matrix, atol=1e-15)


def test_a_child_is_posed_by_all_its_ancestors() -> None:
    bodies = {
        "hand": {"parent": "arm", "pose": {"xyz": [0, 2, 0]}},
        "arm": {"parent": "base", "pose": {"xyz": [1, 0, 0]}, "motion": {"type": "constant", "velocity": [0, 0, 1]}},
        "base": {"motion": {"type": "constant", "angular_velocity": [0, 0, 90]}},
        "rock": {},
    }
    world = Kinematics({"units": {"length": "m", "angle": "deg"}, "bodies": bodies})
    np.testing.assert_allclose(world.world_from_body("hand", np.array([1.0]))[0, :3, 3], [-2, 1, 1], atol=1e-15)
    assert [world.anchor(name) for name in bodies] == ["arm", "arm", "base", "world"]


MESH_FILES = ("obj", "stl", "off", "ply", "glb", "3mf")


@pytest.mark.parametrize("seed", range(3))
def test_meshes_survive_their_files(seed: int, tmp_path: Path) -> None:
    triangles = random_solid(np.random.default_rng(3))
    scene = {
        "units": {"length": "mm", "angle": "deg"},
        "time": {"start": 0, "end": 1},
        "meshes": {kind: {"file": f"it.{kind}", "units": "cm", "up": "y"} for kind in MESH_FILES},
        "bodies": {kind: {"shapes": [{"mesh": kind, "scale": 2}]} for kind in MESH_FILES},
    }
    for kind in MESH_FILES:
        write_mesh(tmp_path / f"it.{kind}", triangles, seed, "cm")
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene))
    truth = Truth(tmp_path / "scene.yaml")
    expected = 0.02 * np.stack([triangles[..., 0], -triangles[..., 2], triangles[..., 1]], axis=2)
    for kind in MESH_FILES:
        single = kind in ("stl", "glb")
        np.testing.assert_allclose(truth.surfaces[kind].triangles, expected, rtol=1e-15, atol=2e-9 * single)
        assert len(truth.surfaces[kind].solids) == 1


def test_a_seed_always_writes_the_same_scene(tmp_path: Path) -> None:
    folders = [tmp_path / name for name in "ab"]
    for folder in folders:
        folder.mkdir()
        write_scene(7, folder)
    written = [{path.name: path.read_bytes() for path in folder.iterdir()} for folder in folders]
    assert written[0] == written[1]
    assert any("seed_7" in name for name in written[0])


def test_random_scenes_are_neither_all_clear_nor_all_in_contact(tmp_path: Path) -> None:
    pairs = touching = jumps = 0
    for seed in range(12):
        (tmp_path / str(seed)).mkdir()
        truth = Truth(write_scene(seed, tmp_path / str(seed)))
        times = np.linspace(truth.start, truth.end, 60)
        found = [truth.signed(a, b, times) < 0.0 for a, b in truth.pairs()]
        pairs += len(found)
        touching += sum(bool(one.any()) for one in found)
        jumps += sum("step" in str(body.get("motion")) for body in truth.scene["bodies"].values())
    assert 0.15 < touching / pairs < 0.5
    assert jumps > 4


@pytest.fixture
def wall(tmp_path: Path) -> Truth:
    (tmp_path / "wall.yaml").write_text(WALL)
    return Truth(tmp_path / "wall.yaml")


def test_a_true_log_has_no_faults(wall: Truth) -> None:
    assert check(wall, true_log()) == []


@pytest.mark.parametrize(("spoil", "said"), SPOILED, ids=lambda value: getattr(value, "__name__", ""))
def test_a_spoiled_log_is_objected_to(wall: Truth, spoil: Callable[[Log], None], said: str) -> None:
    log = deepcopy(true_log())
    spoil(log)
    assert any(said in fault for fault in check(wall, log)), check(wall, log)


def test_a_graze_of_a_tenth_of_a_micrometre_is_found(wall: Truth) -> None:
    """Sunk by 2e-7 m, the bird touches for 1e-4 s at a time, 40 times shorter than the checker's grid."""
    wall.scene["bodies"]["bird"]["pose"]["xyz"][2] -= 2e-7
    wall.kinematics = Kinematics(wall.scene)
    faults = check(wall, true_log())
    assert any("wall|bird: CLEAR" in fault and "touches at" in fault for fault in faults), faults


def test_rules_decide_which_pairs_are_watched(wall: Truth) -> None:
    names = [f"{a}|{b}" for a, b in combinations(wall.names, 2)]
    wall.scene["pairs"] = {"ignore": [{"between": ["wall", "*"]}], "check": [{"between": ["bird", "w*"]}]}
    assert [f"{a}|{b}" for a, b in wall.pairs()] == names[1:]
    wall.scene["bodies"]["dart"].pop("motion")
    wall.scene["pairs"] = {"default": "ignore", "check": [{"between": ["dart", "*"]}]}
    wall.kinematics = Kinematics(wall.scene)
    assert [f"{a}|{b}" for a, b in wall.pairs()] == ["dart|bird"]


def test_numbers_written_in_yaml_1_2_are_read() -> None:
    assert numbers(yaml.safe_load("[1e-3, 2]")).tolist() == [0.001, 2.0]


def test_a_log_is_read_by_its_own_descriptors(tmp_path: Path) -> None:
    file = FileDescriptorProto(name="probe.proto", package="probe", syntax="proto3")
    file.dependency.append(timestamp_pb2.DESCRIPTOR.name)
    probe = file.message_type.add(name="Span")
    verdict = probe.enum_type.add(name="Verdict")
    for number, name in enumerate(["UNKNOWN", "CLEAR"]):
        verdict.value.add(name=name, number=number)
    kinds = FieldDescriptorProto
    fields = [
        ("pair", kinds.TYPE_STRING, ""),
        ("verdict", kinds.TYPE_ENUM, ".probe.Span.Verdict"),
        ("start", kinds.TYPE_DOUBLE, ""),
        ("timestamp", kinds.TYPE_MESSAGE, ".google.protobuf.Timestamp"),
    ]
    for number, (name, kind, of) in enumerate(fields, 1):
        probe.field.add(name=name, number=number, type=kind, type_name=of or None, label=kinds.LABEL_OPTIONAL)
    stamps = FileDescriptorProto()
    timestamp_pb2.DESCRIPTOR.CopyToProto(stamps)
    stamp = {"seconds": 2, "nanos": 7}
    made = GetMessages([stamps, file])["probe.Span"](pair="a|b", verdict=1, start=0.5, timestamp=stamp)
    path = tmp_path / "probe.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema(
            "probe.Span", "protobuf", FileDescriptorSet(file=[stamps, file]).SerializeToString()
        )
        channel = writer.register_channel("/spans", "protobuf", schema)
        writer.add_message(channel, 2_000_000_007, made.SerializeToString(), 2_000_000_007)
        writer.add_metadata("closecall", {"version": "1"})
        writer.finish()
    log = read_log(path)
    times = dict.fromkeys(("timestamp", "log_time", "publish_time"), 2_000_000_007)
    assert log.by_pair("spans") == {"a|b": [{"pair": "a|b", "verdict": "CLEAR", "start": 0.5, **times}]}
    assert log.metadata == {"closecall": {"version": "1"}}
