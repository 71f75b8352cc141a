"""The report's page in headless Chromium: it draws, moves, jumps, and asks nothing of any network.

`tests/studio/install FOLDER` gets what this needs, and CLOSECALL_STUDIO_DIR names the folder; `.ci/run` does both. One
browser opens all pages.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from report_pages import HOSTILE, hostile_log
from studio.logs import SAMPLES, Log
from studio.looks import differs, thick
from studio.pages import PageSeen, PageVisit, visited_pages
from studio.viewer import MISSING

from benchmarks.report_cost import write_log

pytestmark = pytest.mark.skipif(MISSING is not None, reason=MISSING or "")

OPENED, MIDDLE, JUMPED, WHOLE, DARK, FILTERED, MOVED = range(7)
"""The looks at arm_pick's page."""

ARM_STEPS = (
    ("slide", 0.5),
    ("click", "#contacts .jump"),
    ("click", "#whole"),
    ("click", "#theme"),
    ("type", "#filter", "hanger fore"),
    ("press", "#rows", "ArrowRight"),
)


CUT = "Array.from(document.querySelectorAll('.scroll, #now li')).filter((e) => e.scrollWidth > e.clientWidth).length"
"""How many tables and rows are wider than the place that they have."""


def made(scene: Path, folder: Path, name: str, *options: str) -> Log:
    log = folder / f"{name}.mcap"
    run = [sys.executable, "-m", "closecall", "run", scene, "-q", *options, "-o", log]
    subprocess.run(list(map(str, run)), check=True, capture_output=True, timeout=120)
    return Log(log)


def reported(log: Path, expected: int = 0) -> Path:
    done = subprocess.run([sys.executable, "-m", "closecall", "report", str(log)], capture_output=True, timeout=120)
    assert done.returncode == expected, done.stderr
    return log.with_suffix(".html")


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Log]:
    folder = tmp_path_factory.mktemp("logs")
    arm = SAMPLES / "arm_pick" / "scene.yaml"
    logs = {name: made(SAMPLES / name / "scene.yaml", folder, name) for name in ("arm_pick", "asteroids")}
    logs["certificate"] = made(arm, folder, "certificate", "--log", "certificate")
    logs["still"] = made(arm, folder, "still", "--rate", "0")
    cut = logs["arm_pick"].path.read_bytes()
    (folder / "cut.mcap").write_bytes(cut[: int(0.7 * len(cut))])
    hostile_log(folder / "hostile.mcap")
    write_log(folder / "many.mcap", bodies=20)
    return logs | {name: Log(folder / f"{name}.mcap") for name in ("cut", "hostile", "many")}


@pytest.fixture(scope="module")
def pages(logs: dict[str, Log], tmp_path_factory: pytest.TempPathFactory) -> dict[str, PageSeen]:
    files = {name: reported(log.path, 3 if name == "cut" else 0) for name, log in logs.items()}
    map_steps = [("point", "#rows-canvas", 0.6, 0.05), ("press", "#rows", "End"), ("press", "#rows", "ArrowDown")]
    visits = [
        PageVisit("arm_pick", files["arm_pick"], ARM_STEPS, print=True),
        PageVisit("asteroids", files["asteroids"], [("click", "#after"), ("evaluate", CUT)], width=400, theme="dark"),
        PageVisit("certificate", files["certificate"], [("slide", 0.97)]),
        PageVisit("still", files["still"], [("evaluate", CUT)]),
        PageVisit("cut", files["cut"]),
        PageVisit("hostile", files["hostile"], [("evaluate", "[window.hacked ?? null, document.body.innerText]")]),
        PageVisit("many", files["many"], map_steps),
    ]
    return visited_pages(visits, tmp_path_factory.mktemp("pages"))


def near_colour(picture: NDArray[np.int16], colour: tuple[int, int, int]) -> int:
    """Return how many pixels have a colour, nearly."""
    return int(np.count_nonzero((np.abs(picture - np.array(colour)) < 12).all(axis=-1)))


def reddish(picture: NDArray[np.int16]) -> int:
    """Return how many pixels are as red as bodies in contact."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    return int(np.count_nonzero((red > 100) & (red > 2 * green) & (red > 2 * blue)))


CONTACT_IN_LIGHT = (193, 51, 11)


def test_no_page_complains_or_asks_for_anything(pages: dict[str, PageSeen]) -> None:
    for name, page in pages.items():
        assert page.complaints == [], name
        assert page.requests == [], name


def test_bodies_are_drawn_and_the_slider_moves_them(logs: dict[str, Log], pages: dict[str, PageSeen]) -> None:
    opened, middle = pages["arm_pick"].looks[OPENED], pages["arm_pick"].looks[MIDDLE]
    background = opened.scene[2, 2]
    assert np.count_nonzero(thick(differs(opened.scene, background))) > 2000
    assert np.count_nonzero(thick(differs(opened.scene, middle.scene))) > 300
    assert middle.time == pytest.approx(logs["arm_pick"].time(0.5))
    assert middle.time_told == "1.8 s"


def test_a_click_on_a_contact_jumps_to_it(logs: dict[str, Log], pages: dict[str, PageSeen]) -> None:
    pair, begin, _ = min(logs["arm_pick"].contacts, key=lambda contact: (contact[1], contact[0]))
    before, jumped = pages["arm_pick"].looks[MIDDLE], pages["arm_pick"].looks[JUMPED]
    assert jumped.time == pytest.approx(begin, abs=1e-9)  # a slider keeps fewer digits
    assert jumped.selected.startswith(pair.replace("|", " | "))
    assert f"{pair.replace('|', ' | ')}\ncontact" in jumped.now
    assert reddish(jumped.scene) > 500 > 20 > reddish(before.scene)


def test_a_page_opens_at_the_first_contact(logs: dict[str, Log], pages: dict[str, PageSeen]) -> None:
    for name in ("arm_pick", "asteroids", "many"):
        pair, begin, _ = min(logs[name].contacts, key=lambda contact: (contact[1], contact[0]))
        opened = pages[name].looks[OPENED]
        assert opened.time == pytest.approx(begin, abs=1e-9)
        assert opened.selected.startswith(pair.replace("|", " | "))
    assert pages["hostile"].looks[OPENED].time == 0.0  # none touches, and no distance was measured


def test_the_next_contact_is_the_first_that_begins_after_now(logs: dict[str, Log], pages: dict[str, PageSeen]) -> None:
    first, second = sorted(begin for _, begin, _ in logs["asteroids"].contacts)[:2]
    opened, after, _ = pages["asteroids"].looks
    assert opened.time == pytest.approx(first, abs=1e-9)
    assert after.time == pytest.approx(second, abs=1e-9)


def test_the_theme_changes_page_and_pictures(pages: dict[str, PageSeen]) -> None:
    light, dark = (pages["arm_pick"].looks[look] for look in (WHOLE, DARK))
    assert light.scene[2, 2].min() > 200 > 60 > dark.scene[2, 2].max()
    assert pages["asteroids"].looks[0].scene[2, 2].max() < 60  # as the system prefers


def test_contacts_are_on_the_map_where_they_are(logs: dict[str, Log], pages: dict[str, PageSeen]) -> None:
    """Both contacts of arm_pick stand from 3.48 s to the end: the rightmost 3.3 % of the cells, in two rows."""
    picture = pages["arm_pick"].looks[OPENED].pixels("any")
    red = np.flatnonzero([near_colour(column[:, None], CONTACT_IN_LIGHT) > 5 for column in np.moveaxis(picture, 1, 0)])
    begin = min(logs["arm_pick"].share(contact[1]) for contact in logs["arm_pick"].contacts)
    assert red.max() == picture.shape[1] - 1
    assert red.min() == pytest.approx(begin * picture.shape[1], abs=picture.shape[1] / 320 + 1)
    rows = pages["arm_pick"].looks[OPENED].pixels("rows-canvas")
    assert near_colour(rows[:44], CONTACT_IN_LIGHT) > 50
    assert near_colour(rows[44:], CONTACT_IN_LIGHT) == 0


def test_the_filter_leaves_the_pairs_that_bear_all_words(pages: dict[str, PageSeen]) -> None:
    before, after = (pages["arm_pick"].looks[look].pixels("rows-canvas") for look in (DARK, FILTERED))
    background = after[-1, -1]
    assert np.count_nonzero(differs(before, background)[66:].any(axis=1)) > 100
    assert not differs(after, background)[66:, 4:].any()  # hanger|forearm is one row of 22 pixels


def test_keys_move_in_time_by_a_column(pages: dict[str, PageSeen]) -> None:
    before, after = (pages["arm_pick"].looks[look] for look in (FILTERED, MOVED))
    assert after.time - before.time == pytest.approx(3.6 / 320)


def test_a_click_on_the_map_selects_the_pair_and_its_time(pages: dict[str, PageSeen]) -> None:
    opened, pointed, _, moved = pages["many"].looks
    assert pointed.time > opened.time
    assert pointed.selected.split("\n")[0] in pointed.told
    assert moved.selected != pointed.selected


def test_neither_a_page_nor_a_table_in_it_scrolls_sideways(pages: dict[str, PageSeen]) -> None:
    assert all(page.overflow <= 0 for page in pages.values())
    assert pages["asteroids"].looks[-1].value == pages["still"].looks[-1].value == 0


def test_without_bodies_in_the_log_the_page_says_so_and_the_rest_works(pages: dict[str, PageSeen]) -> None:
    page = pages["certificate"]
    assert not page.looks[0].shows("scene-canvas")
    assert page.looks[0].shows("rows-canvas")
    assert page.looks[1].time == pytest.approx(0.97 * 3.6)


def test_bodies_without_ticks_stand_still(pages: dict[str, PageSeen]) -> None:
    assert pages["still"].looks[0].shows("scene-canvas")


def test_names_are_text_and_never_run(pages: dict[str, PageSeen]) -> None:
    hacked, text = pages["hostile"].looks[1].value
    assert hacked is None
    for name in HOSTILE:
        assert name in text


def test_pages_print(pages: dict[str, PageSeen]) -> None:
    assert pages["arm_pick"].printed_bytes > 50_000


@pytest.mark.deep
def test_a_million_messages_are_a_page_of_20_megabytes_drawn_in_five_seconds(tmp_path: Path) -> None:
    assert write_log(tmp_path / "million.mcap") > 1_000_000
    page = reported(tmp_path / "million.mcap")
    assert page.stat().st_size < 20e6
    seen = visited_pages([PageVisit("million", page, [("slide", 0.5)])], tmp_path)["million"]
    assert seen.complaints == []
    assert seen.drawn_ms < 5000
