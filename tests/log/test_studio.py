"""The logs of the samples in Foxglove Studio, run in headless Chromium: what a person would see there.

`tests/studio/install FOLDER` gets what this needs, and CLOSECALL_STUDIO_DIR names the folder; `.ci/run` does both.
One browser looks at every log, with the log's own layout: as it has just opened, half-way through the run, and
in a contact. One log is looked at in the light theme too.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer
from studio.logs import NAMES, Log, logs_of_samples, seconds
from studio.looks import Visit, differs, packed, thick
from studio.viewer import MISSING, Job, node, visited

TOUCHING = [
    "arm_pick",
    "asteroids",
    "ball_in_shell",
    "compound_gripper",
    "door_and_drawer",
    "gantry",
    "spinning_bar",
]

OPENED, MIDDLE, LATER = range(3)
"""The looks at a log, in order; the last is in a contact, where there is one."""

WITHOUT_CONTACT = 0.85
"""Share of the run at which the last look is taken where nothing touches."""

BROKEN = "broken"
"""A log that is not closecall's: it shows that problems and blank scenes are noticed."""

IN_LIGHT = "arm_pick"
"""The sample that is looked at in the light theme too."""

pytestmark = pytest.mark.skipif(MISSING is not None, reason=MISSING or "")


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Log]:
    return logs_of_samples(tmp_path_factory.mktemp("logs"))


def seeks(log: Log) -> list[float]:
    """Return the shares of the run to seek to."""
    later = WITHOUT_CONTACT
    if log.contacts:
        _, first, last = log.contacts[0]
        later = log.share(first + 0.35 * (last - first))
    return [0.5, later]


def write_broken(path: Path) -> None:
    """Write a log whose only topic has a schema that is none."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("closecall.World", "protobuf", b"no file descriptor")
        channel = writer.register_channel("/world", "protobuf", schema)
        for time in (0, 500_000_000):
            writer.add_message(channel, log_time=time, publish_time=time, data=b"\x11" + bytes(8))
        writer.finish()


@pytest.fixture(scope="module")
def visits(logs: dict[str, Log], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Visit]:
    """Open every log in Studio."""
    folder = tmp_path_factory.mktemp("visits")
    jobs = [Job(name, log.path, log.attachments["layout.json"], seeks(log)) for name, log in logs.items()]
    write_broken(folder / "wrong")
    jobs.append(Job(BROKEN, folder / "wrong", logs["spinning_bar"].attachments["layout.json"]))
    layout = logs[IN_LIGHT].attachments["layout.json"]
    jobs.append(Job("light", logs[IN_LIGHT].path, layout, seeks(logs[IN_LIGHT])[1:], theme="light", pictures=True))
    return visited(jobs, folder)


@pytest.fixture(params=NAMES)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_every_sample_with_a_contact_is_known(logs: dict[str, Log]) -> None:
    assert [name for name in NAMES if logs[name].contacts] == TOUCHING


def test_studio_finds_no_problem_and_complains_of_nothing(name: str, visits: dict[str, Visit]) -> None:
    assert "No problems found" in visits[name].problems
    assert visits[name].complaints == []


def test_a_log_with_a_broken_schema_is_a_problem_and_its_scene_is_blank(visits: dict[str, Visit]) -> None:
    """What the tests of the samples rest on: problems are listed, complaints kept, and a grid is no body."""
    broken = visits[BROKEN]
    assert "No problems found" not in broken.problems
    assert broken.complaints
    assert not broken.looks[OPENED].bodies.any()


def test_the_slider_seeks(name: str, logs: dict[str, Log], visits: dict[str, Visit]) -> None:
    log = logs[name]
    times = [seconds(look.time) for look in visits[name].looks]
    start, end = log.summary["time"]
    # To a pixel of the slider, and to the ms that Studio shows.
    assert times[MIDDLE:] == pytest.approx([log.time(share) for share in seeks(log)], abs=2e-3 * (end - start) + 1e-3)


def test_bodies_are_in_view_and_shaded(name: str, visits: dict[str, Visit]) -> None:
    """From the first seek on: while a log opens, Studio builds the 3D panel twice.

    About one time in ten the second has missed what the log tells of its first 0.1 s, and shows nothing until a seek.
    """
    for look in visits[name].looks[MIDDLE:]:
        bodies = look.bodies
        assert np.count_nonzero(bodies) > 300
        assert len(np.unique(packed(look.scene[bodies] // 16))) >= 4


def test_bodies_move(name: str, visits: dict[str, Visit]) -> None:
    looks = visits[name].looks
    for one, other in ((MIDDLE, LATER), (OPENED, MIDDLE), (OPENED, LATER)):
        width = min(looks[one].scene.shape[1], looks[other].scene.shape[1])  # a table's scroll bar may narrow the panel
        moved = thick(differs(looks[one].scene[:, :width], looks[other].scene[:, :width]))
        if np.count_nonzero(moved) > 200:
            return
    pytest.fail("the 3D panel shows the same at all times")


@pytest.mark.parametrize("name", TOUCHING)
def test_colliding_bodies_are_red_while_they_touch(name: str, logs: dict[str, Log], visits: dict[str, Visit]) -> None:
    looks = visits[name].looks
    assert looks[LATER].red > 20  # the fingers of arm_pick are small, and partly behind their names
    for look in looks[MIDDLE:]:
        if logs[name].latest("/world", look.time)[-1].contacts == 0:
            assert look.red < looks[LATER].red / 3


def test_the_table_lists_the_nearest_pairs(name: str, logs: dict[str, Log], visits: dict[str, Visit]) -> None:
    for look in visits[name].looks:
        worlds = logs[name].latest("/world", look.time)
        rows = [line.split("\t") for line in look.text("Table").splitlines() if "|" in line]
        assert [row[1] for row in rows] in [[pair.pair for pair in world.pairs] for world in worlds]
        assert [float(row[2]) for row in rows] in [[pair.distance for pair in world.pairs] for world in worlds]


def test_the_table_names_the_pair_in_contact_first(logs: dict[str, Log], visits: dict[str, Visit]) -> None:
    for name in TOUCHING:
        first = next(line for line in visits[name].looks[LATER].text("Table").splitlines() if "|" in line)
        assert first.split("\t")[1] in [pair for pair, _, _ in logs[name].contacts]


def test_the_plot_is_of_the_least_distance(name: str, logs: dict[str, Log], visits: dict[str, Visit]) -> None:
    plots = [panel for key, panel in logs[name].layout["configById"].items() if key.startswith("Plot!")]
    ((path,),) = (plot["paths"] for plot in plots)
    assert path["value"] == "/world.min_distance"
    for look in visits[name].looks:
        label, value = look.text("Plot").splitlines()[-2:]
        assert label == path.get("label", path["value"])
        assert float(value) in [world.min_distance for world in logs[name].latest("/world", look.time)]


def test_the_plot_has_room(name: str, visits: dict[str, Visit]) -> None:
    """Studio's legend above a plot takes the greater part of a low panel."""
    plot = visits[name].looks[OPENED].panel("Plot")
    assert plot["canvas"] > 0.6 * plot["height"]


def test_bodies_and_contacts_are_seen_in_the_light_theme(visits: dict[str, Visit]) -> None:
    look = visits["light"].looks[1]
    assert look.background.min() > 200
    assert np.count_nonzero(look.bodies) > 300
    assert look.red > 20


def test_state_transitions_show_where_contacts_begin(name: str, visits: dict[str, Visit]) -> None:
    assert "START (1)" in visits[name].painted
    assert ("BEGIN (1)" in visits[name].painted) is (name in TOUCHING)


def test_the_log_panel_tells_the_latest_line(name: str, logs: dict[str, Log], visits: dict[str, Visit]) -> None:
    """After a seek Studio restores the last message of a topic; of several at one time it takes one."""
    for look in visits[name].looks:
        assert any(line.message in look.text("RosOut") for line in logs[name].latest("/log", look.time))


def test_the_log_panel_shows_the_line_that_tells_of_the_start(logs: dict[str, Log], visits: dict[str, Visit]) -> None:
    """Studio opens a log 0.1 s after its start."""
    for name in NAMES:
        first, *others = logs[name].messages("/log")
        if not any(line.time <= first.time + 100_000_000 for line in others):
            assert first.message.message in visits[name].looks[OPENED].text("RosOut")
            assert "runs scene.yaml" in first.message.message


def test_an_independent_reader_finds_every_log_whole(logs: dict[str, Log]) -> None:
    """Index, CRCs, order and counts, and each message by the descriptor in the log: see validate.mjs."""
    done = node("validate.mjs", *(log.path for log in logs.values()))
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert {path: found["faults"] for path, found in said.items()} == {str(log.path): [] for log in logs.values()}
    for log in logs.values():
        found = said[str(log.path)]
        assert {"layout.json", "summary.json"} <= set(found["attachments"])
        assert {"/world", "/tf", "/scene/meshes", "/viz/clearance", "/viz/contacts", "/log"} <= set(found["topics"])
        assert ("/collisions" in found["topics"]) is bool(log.contacts)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_an_independent_reader_notices_one_changed_bit(logs: dict[str, Log], tmp_path: Path, share: float) -> None:
    data = bytearray(logs["spinning_bar"].path.read_bytes())
    data[int(share * len(data))] ^= 1
    (tmp_path / "changed.mcap").write_bytes(data)
    done = node("validate.mjs", tmp_path / "changed.mcap")
    assert done.returncode != 0 or json.loads(done.stdout)[str(tmp_path / "changed.mcap")]["faults"]
