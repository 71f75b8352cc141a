"""The logs of the samples in Foxglove Studio, run in headless Chromium: what a person would see there.

`tests/studio/install FOLDER` gets what this needs, and CLOSECALL_STUDIO_DIR names the folder; `.ci/run` does both.
Everything stays on 127.0.0.1. One browser looks at every log, with the log's own layout: as it has just opened, at the
start, half-way through the run, and in a contact.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlencode

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_protobuf.decoder import DecoderFactory
from numpy.typing import NDArray
from studio.server import served

HERE = Path(__file__).parent / "studio"
SAMPLES = HERE.parents[1] / "sample_scenes"
NAMES = sorted(path.parent.name for path in SAMPLES.glob("*/scene.yaml"))
TOUCHING = ["arm_pick", "asteroids", "ball_in_shell", "spinning_bar"]
FOLDER = os.environ.get("CLOSECALL_STUDIO_DIR", "")
BROWSERS = ("chromium", "chromium-browser", "google-chrome")

OPENED, START, MIDDLE, LATER = range(4)
"""The looks at a log, in order; the last is in a contact, where there is one."""

WITHOUT_CONTACT = 0.85
"""Share of the run at which the last look is taken where nothing touches."""

NOISE = (
    r"(?i).*\bfonts?\b|.*OTS parsing error",
    # Studio builds its 3D panel anew while the layout is set, and the panel tells what it has been given back.
    r"warn: Disposing renderer$",
    r"warn: Panel action resulted in identical config",
)
NOISE_BEFORE_THE_FIRST_FRAME = (
    r'warn: \[general > followTf\] Frame "world" not found$',
    r"warn: \[layers > \w+\] Missing transform from frame <world> to frame <\(none\)>$",
)

BROKEN = "broken"
"""A log that is not closecall's: it shows that problems and blank scenes are noticed."""


def _missing() -> str | None:
    """Tell what hinders these tests, if anything does."""
    if not FOLDER:
        return "CLOSECALL_STUDIO_DIR names no folder, as tests/studio/install fills it"
    if shutil.which("node") is None:
        return "node is not installed"
    if not any(map(shutil.which, BROWSERS)):
        return "chromium is not installed"
    for name, version in json.loads((HERE / "package.json").read_text())["dependencies"].items():
        package = Path(FOLDER, "node_modules", name, "package.json")
        if not package.exists() or json.loads(package.read_text())["version"] != version:
            return f"the npm package {name} {version} is not in {FOLDER}"
    return None


MISSING = _missing()
pytestmark = pytest.mark.skipif(MISSING is not None, reason=MISSING or "")


class Told(NamedTuple):
    """A message of a log: when, ns, and what."""

    time: int
    message: Any


@dataclass(frozen=True)
class Log:
    """A sample's log, read by the MCAP library for Python."""

    path: Path

    @cached_property
    def attachments(self) -> dict[str, bytes]:
        with self.path.open("rb") as stream:
            return {attachment.name: attachment.data for attachment in make_reader(stream).iter_attachments()}

    @cached_property
    def layout(self) -> dict[str, Any]:
        return json.loads(self.attachments["layout.json"])

    @cached_property
    def contacts(self) -> list[tuple[str, float, float]]:
        """Every contact's pair, begin and end, s."""
        summary = json.loads(self.attachments["summary.json"])
        end = summary["time"][1]
        return [
            (pair["pair"], contact["begin"][1], contact["end"][0] if contact["end"] else end)
            for pair in summary["pairs"]
            for contact in pair["contacts"]
        ]

    @cached_property
    def seeks(self) -> list[float]:
        """Shares of the run to seek to; all samples start at 0 s."""
        end = json.loads(self.attachments["summary.json"])["time"][1]
        later = WITHOUT_CONTACT
        if self.contacts:
            _, first, last = self.contacts[0]
            later = (first + 0.35 * (last - first)) / end
        return [0.0, 0.5, later]

    def messages(self, topic: str) -> list[Told]:
        with self.path.open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            return [Told(found[2].log_time, found[3]) for found in reader.iter_decoded_messages(topics=[topic])]

    def latest(self, topic: str, shown: str) -> list[Any]:
        """Return the messages that may be a topic's latest at a time of day, which Studio cuts to whole ms."""
        time = round(seconds(shown) * 1e9)
        messages = self.messages(topic)
        known = [told for told in messages if told.time <= time]
        latest = [told.message for told in known if told.time == known[-1].time]
        return latest + [told.message for told in messages if time < told.time < time + 1_000_000]


def seconds(time_of_day: str) -> float:
    """Return the time of day, as in 12:00:01.500 AM UTC, in s."""
    parts = re.fullmatch(r"(\d+):(\d+):([\d.]+) AM UTC", time_of_day)
    assert parts, time_of_day
    return (int(parts[1]) % 12 * 60 + int(parts[2])) * 60 + float(parts[3])


class Look:
    """What Studio showed at one time."""

    def __init__(self, seen: Mapping[str, Any]) -> None:
        self.time: str = seen["time"]
        self._panels: dict[str, dict[str, Any]] = seen["panels"]
        self._scene: dict[str, Any] = seen["scene"]

    def panel(self, kind: str) -> dict[str, Any]:
        """Return the only panel of a kind."""
        (found,) = (panel for name, panel in self._panels.items() if name.startswith(f"{kind}!"))
        return found

    def text(self, kind: str) -> str:
        return str(self.panel(kind)["text"])

    @cached_property
    def scene(self) -> NDArray[np.int16]:
        """The picture of the 3D panel, (height, width, 3), without the buttons at its right."""
        pixels = np.fromfile(self._scene["file"], dtype=np.uint8)
        picture = pixels.reshape(self._scene["height"], self._scene["width"], 4)
        return picture[:, :-60, :3].astype(np.int16)

    @property
    def bodies(self) -> NDArray[np.bool_]:
        """Where the picture is neither background nor thin, as the grid's lines and the labels' letters are."""
        colours, counts = np.unique(packed(self.scene), return_counts=True)
        background = colours[counts.argmax()] >> np.array((16, 8, 0)) & 255
        return thick(differs(self.scene, background))

    @property
    def red(self) -> int:
        """How many pixels are as red as colliding bodies."""
        red, green, blue = np.moveaxis(self.scene, -1, 0)
        return int(np.count_nonzero((red > 110) & (red > 2 * green) & (red > 2 * blue)))


@dataclass(frozen=True)
class Visit:
    """What Studio showed of one log."""

    looks: Sequence[Look]
    problems: str
    painted: frozenset[str]
    opening: Sequence[str]
    console: Sequence[str]

    @property
    def complaints(self) -> list[str]:
        """Lines of the console that tell of something wrong."""
        return _complaints(self.opening, NOISE + NOISE_BEFORE_THE_FIRST_FRAME) + _complaints(self.console, NOISE)


def _complaints(lines: Sequence[str], noise: Sequence[str]) -> list[str]:
    wrong = [line for line in lines if not re.match(r"debug|log|info", line)]
    return [line for line in wrong if not any(re.match(pattern, line) for pattern in noise)]


def differs(picture: NDArray[np.int16], other: NDArray[Any]) -> NDArray[np.bool_]:
    return np.asarray((np.abs(picture - other) > 20).any(axis=-1))


def packed(picture: NDArray[np.int16]) -> NDArray[np.int64]:
    """Return colours as one number each."""
    return picture.astype(np.int64) @ np.array((1 << 16, 1 << 8, 1))


def thick(area: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the pixels whose eight neighbours belong to the area too."""
    inner = area.copy()
    for rows in (-1, 0, 1):
        for columns in (-1, 0, 1):
            inner &= np.roll(area, (rows, columns), axis=(0, 1))
    return inner


def node(script: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = ["node", str(HERE / script), *map(str, arguments)]
    environment = os.environ | {"CLOSECALL_STUDIO_DIR": str(Path(FOLDER).resolve())}
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600)


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Log]:
    """Run the tool on every sample."""
    folder = tmp_path_factory.mktemp("logs")
    found = {}
    for name in NAMES:
        found[name] = Log(folder / f"{name}.mcap")
        command = [sys.executable, "-m", "closecall", "run", SAMPLES / name / "scene.yaml", "-o", found[name].path]
        subprocess.run(list(map(str, command)), check=True, capture_output=True, timeout=120)
    return found


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
    write_broken(folder / f"{BROKEN}.mcap")
    seeks: dict[str, list[float]] = {BROKEN: []}
    for name, log in logs.items():
        shutil.copy(log.path, folder)
        (folder / f"{name}.json").write_bytes(log.attachments["layout.json"])
        seeks[name] = log.seeks
    shutil.copy(folder / "spinning_bar.json", folder / f"{BROKEN}.json")
    with served({"/modules/": Path(FOLDER, "node_modules"), "/logs/": folder, "/": HERE}) as site:
        jobs = []
        for name, shares in seeks.items():
            query = {"ds": "remote-file", "ds.url": f"{site}/logs/{name}.mcap", "layout": f"/logs/{name}.json"}
            jobs.append({"name": name, "address": f"{site}/index.html?{urlencode(query)}", "seeks": shares})
        browser = next(filter(None, map(shutil.which, BROWSERS)))
        (folder / "visits").write_text(json.dumps({"browser": browser, "folder": str(folder), "visits": jobs}))
        done = node("look.mjs", folder / "visits")
    assert done.returncode == 0, done.stderr
    return {
        name: Visit(
            looks=[Look(look) for look in seen["looks"]],
            problems=seen["problems"],
            painted=frozenset(seen["painted"]),
            opening=seen["opening"],
            console=seen["console"],
        )
        for name, seen in json.loads(done.stdout).items()
    }


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
    end = json.loads(logs[name].attachments["summary.json"])["time"][1]
    times = [seconds(look.time) for look in visits[name].looks]
    assert times[START:] == pytest.approx([share * end for share in logs[name].seeks], abs=2e-3 * end)


def test_bodies_are_in_view_and_shaded(name: str, visits: dict[str, Visit]) -> None:
    """From the first seek on: while a log opens, Studio builds the 3D panel twice.

    About one time in ten the second has missed what the log tells of its first 0.1 s, and shows nothing until a seek.
    """
    for look in visits[name].looks[START:]:
        bodies = look.bodies
        assert np.count_nonzero(bodies) > 300
        assert len(np.unique(packed(look.scene[bodies] // 16))) >= 4


def test_bodies_move(name: str, visits: dict[str, Visit]) -> None:
    looks = visits[name].looks
    for one, other in ((START, MIDDLE), (MIDDLE, LATER), (START, LATER)):
        moved = thick(differs(looks[one].scene, looks[other].scene))
        if np.count_nonzero(moved) > 200:
            return
    pytest.fail("the 3D panel shows the same at all times")


@pytest.mark.parametrize("name", TOUCHING)
def test_colliding_bodies_are_red_while_they_touch(name: str, logs: dict[str, Log], visits: dict[str, Visit]) -> None:
    looks = visits[name].looks
    assert looks[LATER].red > 20  # the fingers of arm_pick are small, and partly behind their names
    for look in looks[START:]:
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


def test_state_transitions_show_where_contacts_begin(name: str, visits: dict[str, Visit]) -> None:
    assert "START (1)" in visits[name].painted
    assert ("BEGIN (1)" in visits[name].painted) is (name in TOUCHING)


def test_the_log_panel_tells_the_latest_line(name: str, logs: dict[str, Log], visits: dict[str, Visit]) -> None:
    """After a seek Studio restores the last message of a topic; of several at one time it takes one."""
    for look in visits[name].looks:
        assert any(line.message in look.text("RosOut") for line in logs[name].latest("/log", look.time))


def test_the_log_panel_shows_the_line_that_tells_of_the_start(logs: dict[str, Log], visits: dict[str, Visit]) -> None:
    for name in NAMES:
        first, *others = logs[name].messages("/log")
        if not any(line.time == first.time for line in others):
            assert first.message.message in visits[name].looks[START].text("RosOut")
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
