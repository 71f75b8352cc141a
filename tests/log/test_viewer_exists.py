"""Bodies that do not always exist: what a viewer shows of them at any time, also after a seek."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from viewer_logs import Shown, show, write_scene

from closecall.formats.log.viewer.viewer import ViewerOptions

# The pier is rammed by the ship, and is taken away while they touch; the crate hangs on the ship's frame for a while.
SCENE = """\
closecall: 1
units: {length: m, angle: deg}
time: {start: 0, end: 2}
bodies:
  quay: {pose: {xyz: [0, 3, 0]}, shapes: [{box: [8, 1, 1]}]}
  pier: {exists: [0, 1.21], pose: {xyz: [1, 0, 0]}, shapes: [{box: [1, 1, 1]}]}
  ship:
    exists: [0.33, 3]
    pose: {xyz: [-1, 0, 0]}
    shapes: [{box: [1, 1, 1]}]
    motion: {type: constant, velocity: [1, 0, 0]}
  crate: {parent: ship, exists: [0.5, 1.5], pose: {xyz: [0, 0, 1]}, shapes: [{sphere: 0.2}]}
"""
EXISTS = {"quay": (0.0, 3.0), "pier": (0.0, 1.21), "ship": (0.33, 3.0), "crate": (0.5, 1.5)}
CHANGES = [0.33, 0.5, 1.21, 1.5]


@pytest.fixture(scope="module", params=[30.0, 0.0])
def shown(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Shown:
    folder = tmp_path_factory.mktemp("exists")
    return show(write_scene(folder, SCENE), folder / "out.mcap", rate=request.param)


def restored(shown: Shown, topic: str, time: float) -> Any:
    """Return what a viewer restores of a topic after a seek: the last message that is not later, s."""
    return [message for at, message in shown.messages(topic) if at <= round(time * 1e9)][-1]


@pytest.mark.parametrize("time", [0.0, 0.1, 0.329, 0.33, 0.4, 0.5, 0.9, 1.209, 1.21, 1.3, 1.4999, 1.5, 1.9, 2.0])
def test_after_a_seek_the_bodies_that_exist_are_drawn_and_no_others(shown: Shown, time: float) -> None:
    update = restored(shown, "/scene/meshes", time)
    (deletion,) = update.deletions
    assert deletion.type == 1  # ALL
    there = {name for name, (begin, end) in EXISTS.items() if begin <= time < end}
    assert {entity.id for entity in update.entities} == there


def test_meshes_are_told_when_they_change_and_not_else(shown: Shown) -> None:
    times = [at for at, _ in shown.messages("/scene/meshes")]
    assert times == [round(time * 1e9) for time in [0.0, *CHANGES]]
    frames = [at for at, _ in shown.messages("/tf")]
    assert set(times) <= set(frames)


def test_what_is_told_of_pairs_is_of_bodies_that_exist(shown: Shown) -> None:
    told = 0
    for topic in ("/world", "/viz/clearance", "/viz/contacts", "/viz/names"):
        for at, message in shown.messages(topic):
            parts = (one.pair for one in message.pairs) if topic == "/world" else (one.id for one in message.entities)
            for name in {name for part in parts for name in part.split("|")}:
                begin, end = EXISTS[name]
                assert begin <= at / 1e9 < end
                told += 1
    assert told > 15


def test_a_contact_ends_with_its_body(shown: Shown) -> None:
    worlds = shown.messages("/world")
    assert [message.phase for _, message in shown.messages("/collisions")] == [1], "no END is told"
    assert {message.contacts for at, message in worlds if 1.0e9 < at < 1.21e9} == {1}
    assert {message.contacts for at, message in worlds if at >= 1.21e9} == {0}


def test_a_crowd_shows_those_that_exist(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("closecall.formats.log.viewer.viewer._MOST_FRAMES", 0)
    crowd = show(write_scene(tmp_path, SCENE), tmp_path / "crowd.mcap")
    for time, count in ((0.0, 0), (0.4, 1), (1.0, 2), (1.6, 1), (2.0, 1)):
        (entity,) = restored(crowd, "/scene/boxes", time).entities
        assert len(entity.cubes) == count
    names = {entity.id for _, update in crowd.messages("/scene/meshes") for entity in update.entities}
    assert names == {"quay", "pier"}


def test_the_camera_looks_at_places_where_bodies_exist(tmp_path: Path) -> None:
    """The rocket is there for its first half second, and its frame flies on for 10 km."""
    rocket = "{exists: [0, 0.5], shapes: [{sphere: 0.5}], motion: {type: constant, velocity: [0, 0, 5000]}}"
    shown = show(write_scene(tmp_path, SCENE + f"  rocket: {rocket}\n"), tmp_path / "out.mcap")
    layout = shown.attachment("layout.json") or b""
    distance = json.loads(layout)["configById"]["3D!scene"]["cameraState"]["distance"]
    assert 2_000.0 < distance < 6_000.0


def test_triangles_count_each_time_that_a_body_is_drawn(tmp_path: Path) -> None:
    """The quay's box has 12 triangles, and is drawn five times: 60."""
    for most, whole in ((59, False), (60, True)):
        shown = show(write_scene(tmp_path, SCENE), tmp_path / "out.mcap", viewer=ViewerOptions(triangles=most))
        for _, update in shown.messages("/scene/meshes"):
            quay = next(entity for entity in update.entities if entity.id == "quay")
            assert (len(quay.triangles) > 0) is whole


def test_small_bodies_have_a_dot_that_is_seen_from_anywhere(tmp_path: Path) -> None:
    speck = "{pose: {xyz: [0, 0, 1000]}, shapes: [{sphere: 0.5}], motion: {type: constant, velocity: [1, 0, 0]}}"
    shown = show(write_scene(tmp_path, SCENE + f"  speck: {speck}\n"), tmp_path / "out.mcap")
    update = restored(shown, "/scene/meshes", 0.0)
    dots = {entity.id: [line for line in entity.lines if line.scale_invariant] for entity in update.entities}
    assert len(dots["speck"]) == 1
    first, last = (np.array((point.x, point.y, point.z)) for point in dots["speck"][0].points)
    assert np.abs(0.5 * (first + last)).max() < 1e-12
    assert dots["quay"] == []
