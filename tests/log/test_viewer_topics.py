"""What viewers are shown: bodies, frames, clearances and contacts, held against independent readers and the oracle."""

from __future__ import annotations

import json
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from viewer_logs import MOVING, SCENE, Shown, seen_by, show, write_scene

from closecall.formats.log.viewer.viewer import ViewerOptions
from closecall.scheduler.model.events import PairKey, Phase, Snapshot, Verdict
from oracle.check import check
from oracle.logs import read_log
from oracle.poses import Kinematics, read_scene
from oracle.truth import Truth

NAMES = ["floor", "anvil", "hammer", "pin", "joint", "carriage"]


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Path:
    return write_scene(tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="module")
def shown(scene) -> Shown:
    return show(scene, scene.parent / "out.mcap")


def matrix(transform) -> np.ndarray:
    turn, place = transform.rotation, transform.translation
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
    pose[:3, 3] = (place.x, place.y, place.z)
    return pose


def xyz(point) -> tuple[float, float, float]:
    return (point.x, point.y, point.z)


def pair_name(pair: PairKey) -> str:
    return f"{NAMES[pair.a]}|{NAMES[pair.b]}"


def at(shown: Shown, topic: str) -> list[tuple[Snapshot, Any]]:
    """Return each snapshot with its message of a topic that has one for each."""
    messages = shown.messages(topic)
    snapshots = sorted(shown.snapshots, key=lambda snapshot: snapshot.time)
    assert [round(snapshot.time * 1e9) for snapshot in snapshots] == [time for time, _ in messages]
    return [(snapshot, message) for snapshot, (_, message) in zip(snapshots, messages, strict=True)]


def test_the_scene_has_ticks_and_both_ends_of_a_contact(shown):
    phases = [snapshot.trigger.phase for snapshot in shown.snapshots if snapshot.trigger]
    assert phases == [Phase.BEGIN, Phase.END]
    assert sum(snapshot.trigger is None for snapshot in shown.snapshots) == 31  # 30 Hz over 1 s, and the end


def test_every_tick_tells_all_moving_frames_where_the_oracle_has_them(scene, shown):
    kinematics = Kinematics(read_scene(scene))
    ticks = [(time, m) for time, m in shown.messages("/tf") if len(m.transforms) == len(MOVING)]
    assert {time for time, _ in ticks} >= {round(s.time * 1e9) for s in shown.snapshots if s.trigger is None}
    for time, message in ticks:
        assert [transform.child_frame_id for transform in message.transforms] == MOVING
        for transform in message.transforms:
            assert transform.parent_frame_id == "world"
            assert transform.timestamp.ToNanoseconds() == time
            true = kinematics.world_from_body(transform.child_frame_id, np.array([time * 1e-9]))[0]
            assert np.abs(matrix(transform) - true).max() < 1e-7  # a log time is to the nanosecond


def test_a_collision_tells_the_frames_of_its_chains_alone(shown):
    collisions = {round(snapshot.time * 1e9) for snapshot in shown.snapshots if snapshot.trigger}
    found = {time: message for time, message in shown.messages("/tf") if time in collisions}
    assert len(found) == 2
    for message in found.values():
        assert [transform.child_frame_id for transform in message.transforms] == ["hammer"]  # the anvil is fixed


def test_chains_include_moving_ancestors(scene):
    text = SCENE.replace("xyz: [0, 0, 0.8]", "xyz: [0.6, 0, 10]").replace(
        "velocity: [3, 0, 0]", "velocity: [0, 0, -1.5]"
    )
    (scene.parent / "chain").mkdir()
    shown = show(write_scene(scene.parent / "chain", text), scene.parent / "chain.mcap", rate=0.0)
    told = {round(s.time * 1e9): NAMES[s.trigger.pair.b] for s in shown.snapshots if s.trigger}
    assert "pin" in told.values()
    for time, message in shown.messages("/tf"):
        if told.get(time) == "pin":
            assert [transform.child_frame_id for transform in message.transforms] == ["pin", "joint", "carriage"]


def test_bodies_are_shown_once_all_in_one_message(scene, shown):
    ((time, update),) = shown.messages("/scene/meshes")
    assert time == 500_000_000
    assert [entity.id for entity in update.entities] == ["floor", "anvil", "hammer", "pin", "carriage"]
    for entity in update.entities:
        assert entity.frame_locked
        assert entity.frame_id == (entity.id if entity.id in MOVING else "world")
        assert entity.timestamp.ToNanoseconds() == time
        assert entity.lifetime.ToNanoseconds() == 0
    by_name = {entity.id: entity for entity in update.entities}
    counts = {name: (len(entity.spheres), len(entity.triangles), len(entity.cubes)) for name, entity in by_name.items()}
    assert counts["floor"] == (0, 1, 0)
    assert counts["carriage"] == (1, 0, 0)
    assert counts["hammer"] == counts["pin"] == (0, 1, 0)
    (sphere,) = by_name["carriage"].spheres
    assert xyz(sphere.size) == (0.4, 0.4, 0.4)


def test_drawn_points_are_the_bodies_own(scene, shown):
    truth = Truth(scene)
    ((_, update),) = shown.messages("/scene/meshes")
    for entity in update.entities:
        if entity.id not in ("floor", "hammer"):
            continue
        (drawn,) = entity.triangles
        frame = matrix_of_pose(drawn.pose)
        points = np.array([xyz(point) for point in drawn.points]) @ frame[:3, :3].T + frame[:3, 3]
        corners = points[np.array(drawn.indices).reshape(-1, 3)]
        pose = np.eye(4) if entity.id == "hammer" else truth.kinematics.world_from_body("floor", np.zeros(1))[0]
        true = truth.surfaces[entity.id].triangles @ pose[:3, :3].T + pose[:3, 3]
        areas = [0.5 * np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1) for c in (corners, true)]
        assert np.allclose(np.sort(areas[0]), np.sort(areas[1]))
        apart = np.linalg.norm(corners.reshape(-1, 1, 3) - true.reshape(1, -1, 3), axis=2)
        assert apart.min(axis=0).max() < 1e-12
        assert apart.min(axis=1).max() < 1e-12


def matrix_of_pose(pose) -> np.ndarray:
    turn = pose.orientation
    out = np.eye(4)
    out[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
    out[:3, 3] = xyz(pose.position)
    return out


def test_least_distance_is_that_of_brute_force(scene, shown):
    truth = Truth(scene)
    for snapshot, world in at(shown, "/world"):
        if snapshot.trigger is not None:
            continue
        times = np.array([snapshot.time])
        true = {f"{a}|{b}": max(0.0, float(truth.signed(a, b, times)[0])) for a, b in truth.pairs()}
        assert world.min_distance == pytest.approx(min(true.values()), abs=1e-9)
        assert true[world.pair] == pytest.approx(world.min_distance, abs=1e-9)
        assert [pair.distance for pair in world.pairs] == pytest.approx(sorted(true.values()), abs=1e-9)
        assert world.contacts == sum(pair.verdict == "CONTACT" for pair in world.pairs)
        assert all(before.distance <= after.distance for before, after in pairwise(world.pairs))


def test_the_log_passes_the_oracles_other_checks(scene, shown):
    log = read_log(shown.path)
    for message in log.of("tf"):  # whose timestamps are its transforms'
        message["timestamp"] = message["log_time"]
    assert check(Truth(scene), log) == []


@pytest.mark.parametrize("topic", ["/viz/clearance", "/viz/contacts"])
def test_every_marker_message_is_a_full_snapshot(shown, topic):
    for snapshot, update in at(shown, topic):
        (deletion,) = update.deletions
        assert deletion.type == 1  # ALL
        assert deletion.timestamp.ToNanoseconds() == round(snapshot.time * 1e9)
        names = [entity.id for entity in update.entities]
        assert len(set(names)) == len(names)
        assert all(entity.frame_locked for entity in update.entities)


def test_clearance_lines_end_at_the_witness_points(shown):
    size = viewer_size(shown)
    drawn = 0
    for snapshot, update in at(shown, "/viz/clearance"):
        apart = [n for n in snapshot.nearest if n.distance > 0.0]
        near = {pair_name(n.pair): n for n in apart if n is apart[0] or n.distance < 0.1 * size}
        assert [entity.id for entity in update.entities] == list(near)
        for entity in update.entities:
            line, *_ = entity.lines
            assert [xyz(point) for point in line.points] == [near[entity.id].witness_a, near[entity.id].witness_b]
            assert entity.frame_id == "world"
            drawn += 1
        if update.entities:
            assert len(update.entities[0].texts) == 1, "the nearest is told"
    assert drawn > 10


def viewer_size(shown: Shown) -> float:
    """Return the diagonal of what the bodies reach, from the layout's label size, 1.8 % of it."""
    layout = json.loads(shown.attachment("layout.json") or b"")
    return layout["configById"]["3D!scene"]["scene"]["transforms"]["labelSize"] / 0.018


def test_figures_stand_over_the_middle_and_say_the_distance(shown):
    """Over it from where the layout looks: they come towards the eye, out of the bodies that would hide them."""
    layout = json.loads(shown.attachment("layout.json") or b"")
    view = layout["configById"]["3D!scene"]["cameraState"]
    told = 0
    for snapshot, update in at(shown, "/viz/clearance"):
        near = {pair_name(n.pair): n for n in snapshot.nearest}
        for entity in update.entities:
            for text in entity.texts:
                a, b = np.array(near[entity.id].witness_a), np.array(near[entity.id].witness_b)
                top, middle = seen_by(view, np.array((xyz(text.pose.position), 0.5 * (a + b))))
                assert top[0] == pytest.approx(middle[0], abs=0.01)
                assert 0.0 < top[1] - middle[1] < 0.1
                assert top[2] < middle[2]
                told += 1
                value, unit = text.text.split()
                metres = float(value) * {"µm": 1e-6, "mm": 1e-3, "m": 1.0}[unit]
                assert metres == pytest.approx(near[entity.id].distance, rel=0.006)
    assert told > 10


def test_what_stands_still_is_painted_before_what_stands_on_it_and_what_moves(shown):
    """Viewers paint translucent triangles from the farthest origin to the nearest, as seen from the layout."""
    layout = json.loads(shown.attachment("layout.json") or b"")
    view = layout["configById"]["3D!scene"]["cameraState"]
    ((_, meshes),) = shown.messages("/scene/meshes")
    origins = {
        entity.id: np.array([xyz(drawn.pose.position) for drawn in entity.triangles]) for entity in meshes.entities
    }
    depths = {name: seen_by(view, origins[name])[:, 2] for name in ("floor", "anvil")}
    assert depths["floor"].min() > depths["anvil"].max()
    size = viewer_size(shown)
    assert depths["anvil"].min() > view["distance"] + size, "all that moves is within the scene"


def test_moving_bodies_bear_their_names_and_no_text_covers_another(shown):
    layout = json.loads(shown.attachment("layout.json") or b"")
    view = layout["configById"]["3D!scene"]["cameraState"]
    half_height = np.tan(np.radians(22.5))
    called = set()
    texts: dict[float, list[Any]] = {}
    for topic in ("/viz/names", "/viz/clearance", "/viz/contacts"):
        for snapshot, update in at(shown, topic):
            texts.setdefault(snapshot.time, []).extend(text for entity in update.entities for text in entity.texts)
    for together in texts.values():
        called |= {text.text for text in together}
        places = seen_by(view, np.array([xyz(text.pose.position) for text in together]))[:, :2] / half_height
        for (one, text), (other, beside) in combinations(zip(places, together, strict=True), 2):
            across, upright = np.abs(one - other)
            # 650 pixels high, letters of 15: 9 wide, 20 with the box around them.
            letters = 0.5 * (len(text.text) + len(beside.text))
            assert across > letters * 9 / 325 or upright > 20 / 325
    assert {"hammer", "pin"} < called  # the carriage is where the pin hangs
    assert not {"joint", "floor", "anvil"} & called, "frames without shapes and what stands still have no names"


def test_contacts_are_marked_and_their_bodies_turn_red(shown):
    seen = 0
    for snapshot, update in at(shown, "/viz/contacts"):
        touching = [n for n in snapshot.nearest if n.verdict is Verdict.CONTACT]
        if snapshot.trigger is not None and snapshot.trigger.phase is Phase.END:
            touching = [n for n in touching if n.pair != snapshot.trigger.pair]
        bodies = {NAMES[index] for n in touching for index in (n.pair.a, n.pair.b)}
        marks = {pair_name(n.pair): n for n in touching}
        assert {entity.id for entity in update.entities} == bodies | set(marks)
        for entity in update.entities:
            if entity.id in marks:
                assert xyz(entity.spheres[0].pose.position) == marks[entity.id].witness_a
            else:
                assert entity.frame_id == (entity.id if entity.id in MOVING else "world")
                assert all(drawn.color.r > 0.8 > drawn.color.g + drawn.color.b for drawn in entity.triangles)
            seen += 1
    assert seen >= 6


def test_red_skin_stands_off_the_body_all_round(scene, shown):
    ((_, meshes),) = shown.messages("/scene/meshes")
    body = next(entity for entity in meshes.entities if entity.id == "hammer")
    skins = [e for _, update in shown.messages("/viz/contacts") for e in update.entities if e.id == "hammer"]
    for skin in skins:
        inner, outer = (placed(entity.triangles[0]) for entity in (body, skin))
        assert (outer.min(axis=0) < inner.min(axis=0)).all()
        assert (outer.max(axis=0) > inner.max(axis=0)).all()
        assert np.abs(outer.max(axis=0) - inner.max(axis=0)).max() < 0.02


def placed(triangles) -> np.ndarray:
    frame = matrix_of_pose(triangles.pose)
    return np.array([xyz(point) for point in triangles.points]) @ frame[:3, :3].T + frame[:3, 3]


def test_a_heavy_body_in_contact_gets_a_red_box(scene, monkeypatch):
    monkeypatch.setattr("closecall.formats.log.viewer.entities._MOST_IN_RED", 3)
    shown = show(scene, scene.parent / "heavy.mcap")
    skins = [e for _, update in shown.messages("/viz/contacts") for e in update.entities if e.id == "hammer"]
    assert skins
    assert all(len(skin.cubes) == 1 and not skin.triangles for skin in skins)


def test_bodies_beyond_the_triangles_are_boxes_and_the_log_says_so(scene):
    shown = show(scene, scene.parent / "boxes.mcap", viewer=ViewerOptions(triangles=12))
    ((_, update),) = shown.messages("/scene/meshes")
    drawn = {entity.id: (len(entity.triangles), len(entity.cubes)) for entity in update.entities}
    # The floor's 12 triangles are all there are; balls, which have none, are drawn all the same.
    assert drawn == {"floor": (1, 0), "anvil": (0, 1), "hammer": (0, 1), "pin": (0, 1), "carriage": (0, 0)}
    cube = next(entity for entity in update.entities if entity.id == "pin").cubes[0]
    assert xyz(cube.size) == pytest.approx((0.2, 0.2, 0.8))
    told = [message.message for _, message in shown.messages("/log")]
    assert any("3 bodies are drawn as boxes" in line for line in told)
