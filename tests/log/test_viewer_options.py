"""What the options leave of the viewer's topics: pairs, triangles, rates, certificates, topics by body, epochs."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from places import HELPERS
from viewer_logs import MOVING, SCENE, Shown, show, write_scene

from closecall.formats.log.errors import LogError
from closecall.formats.log.viewer.viewer import Viewer, ViewerOptions
from closecall.formats.log.writer import LogOptions, LogWriter, Topics
from closecall.formats.scene.reader import read_scene

VIEWER_TOPICS = {"/scene/meshes", "/tf", "/world", "/viz/clearance", "/viz/contacts"}


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Path:
    return write_scene(tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="module")
def shown(scene) -> Shown:
    return show(scene, scene.parent / "out.mcap")


def test_no_more_pairs_than_asked_for_are_told_or_drawn(scene):
    shown = show(scene, scene.parent / "few.mcap", viewer=ViewerOptions(pairs=1))
    for _, world in shown.messages("/world"):
        assert len(world.pairs) == 1
        assert world.pairs[0].pair == world.pair
    assert all(len(update.entities) <= 1 for _, update in shown.messages("/viz/clearance"))


def test_without_ticks_collisions_are_shown_and_where_all_is_at_the_start(scene):
    shown = show(scene, scene.parent / "rate0.mcap", rate=0.0)
    counts = Counter(topic for topic, _, _ in shown.decoded())
    assert counts["/world"] == counts["/viz/clearance"] == counts["/viz/contacts"] == 2
    first, *others = shown.messages("/tf")
    assert first[0] == 500_000_000
    assert [transform.child_frame_id for transform in first[1].transforms] == MOVING
    assert len(others) == 2
    _, last = shown.messages("/viz/contacts")[-1]
    assert not last.entities, "the contact is over"


def test_without_pairs_the_least_distance_is_unknown(scene):
    (scene.parent / "alone").mkdir()
    text = SCENE.split("pairs:")[0] + 'pairs: {ignore: [{between: ["*", "*"], reason: alone}]}\n'
    shown = show(write_scene(scene.parent / "alone", text), scene.parent / "alone.mcap")
    assert shown.messages("/world")
    for _, world in shown.messages("/world"):
        assert math.isnan(world.min_distance)
        assert (world.pair, world.contacts, len(world.pairs)) == ("", 0, 0)


def test_a_scene_without_motion_or_shapes_can_be_shown(tmp_path):
    head = SCENE.split("meshes:")[0]
    fixed = show(write_scene(tmp_path, head + "bodies: {one: {shapes: [{sphere: 1}]}}\n"), tmp_path / "fixed.mcap")
    assert not fixed.messages("/tf")
    assert len(fixed.messages("/scene/meshes")) == 1
    bare = show(write_scene(tmp_path, head + "bodies: {one: {motion: {type: constant}}}\n"), tmp_path / "bare.mcap")
    assert [len(update.entities) for _, update in bare.messages("/scene/meshes")] == [0]


def test_a_certificate_holds_nothing_for_viewers(scene, shown):
    loaded = read_scene(scene, ())
    path = scene.parent / "certificate.mcap"
    with LogWriter(path, loaded, loaded.settings, 0, LogOptions()) as log:
        for snapshot in shown.snapshots:
            log.write(snapshot)
    certificate = Shown(path, [])
    assert {topic for topic, _, _ in certificate.decoded()} == {"/log"}
    assert certificate.attachment("layout.json") is None
    assert {topic for topic, _, _ in shown.decoded()} > VIEWER_TOPICS


def test_times_carry_the_epoch(scene, shown):
    epoch = 1_767_225_600_000_000_001
    later = show(scene, scene.parent / "epoch.mcap", epoch=epoch)
    for topic in VIEWER_TOPICS:
        assert [time for time, _ in later.messages(topic)] == [time + epoch for time, _ in shown.messages(topic)]
    time, update = later.messages("/tf")[0]
    assert {transform.timestamp.ToNanoseconds() for transform in update.transforms} == {time}


@pytest.mark.parametrize("topics", list(Topics))
def test_distances_go_to_one_topic_or_to_one_a_body(scene, topics):
    shown = show(scene, scene.parent / f"{topics.value}.mcap", topics=topics)
    found = [(topic, message) for topic, _, message in shown.decoded() if topic.startswith("/distances")]
    assert len({message.body_a for _, message in found}) > 1
    for topic, message in found:
        assert topic == ("/distances" if topics is Topics.SINGLE else f"/distances/{message.body_a}")


def test_more_bodies_than_channels_are_refused_for_topics_by_body(scene, monkeypatch):
    monkeypatch.setattr("closecall.formats.log.writer._MOST_BODY_TOPICS", 5)
    loaded = read_scene(scene, ())
    with pytest.raises(LogError, match="cannot hold one topic for each of 6 bodies"):
        LogWriter(scene.parent / "many.mcap", loaded, loaded.settings, 0, LogOptions(topics=Topics.BODY))


def test_same_run_gives_the_same_bytes_whatever_the_hash_seed(scene):
    script = (
        "import sys; sys.path.insert(0, sys.argv[1]); from viewer_logs import show; from pathlib import Path; "
        "show(Path(sys.argv[2]), Path(sys.argv[3]))"
    )
    logs = set()
    for seed in ("0", "4242"):
        out = scene.parent / f"seed{seed}.mcap"
        command = [sys.executable, "-c", script, str(HELPERS), str(scene), str(out)]
        subprocess.run(command, check=True, env=os.environ | {"PYTHONHASHSEED": seed})
        logs.add(out.read_bytes())
    assert len(logs) == 1


def test_frames_repeat_themselves_byte_for_byte_and_start_is_not_told_twice(scene, shown):
    loaded = read_scene(scene, ())
    viewer = Viewer(loaded.scene, ViewerOptions())
    tick = next(snapshot for snapshot in shown.snapshots if snapshot.trigger is None and snapshot.time > 1.0)
    assert list(viewer.shown(tick, 7)) == list(viewer.shown(tick, 7))
    start = next(snapshot for snapshot in shown.snapshots if snapshot.time == loaded.scene.start)
    assert "/tf" not in {channel.name for channel, _ in viewer.shown(start, 7)}
    assert (ViewerOptions().pairs, ViewerOptions().triangles) == (10, 1_000_000)
