"""`closecall report`: one page in one file, which says no more than the log proves, whatever bodies are called."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_process import SPHERES, closecall
from mcap.reader import make_reader
from places import ROOT
from report_pages import HOSTILE, WARNING, Parsed, hostile_log

from closecall.formats.report.gathering import gather
from closecall.formats.report.page import page

PAGE = ROOT / "formats" / "report" / "page"


def block(text: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the facts that a page carries for its scripts, and the arrays by name."""
    data = gzip.decompress(base64.b64decode(Parsed(text).apart["script"][0]))
    length = int.from_bytes(data[:4], "little")
    facts = json.loads(data[4 : 4 + length])
    at = 4 + length
    arrays = {name: np.frombuffer(data, kind, count, at + offset) for name, kind, offset, count in facts["arrays"]}
    return facts, arrays


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("log")
    (folder / "scene.yaml").write_text(SPHERES)
    done = closecall("run", "scene.yaml", "-o", "balls.mcap", cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder / "balls.mcap"


@pytest.fixture(scope="module")
def text(log: Path) -> str:
    return page(gather(log))


def test_a_page_refers_to_nothing_outside_itself(text: str) -> None:
    parsed = Parsed(text)
    for tag, attributes in parsed.elements:
        assert not {"src", "href", "action", "srcset", "data"} & set(attributes), tag
    assert parsed.count("link") == parsed.count("iframe") == parsed.count("img") == 0
    assert not re.search(r"@import|url\(", "".join(parsed.apart["style"]))
    addresses = set(re.findall(r"https?://[^\"'`)\s]+", text))
    assert addresses == {"http://www.w3.org/1999/xhtml"}  # a namespace, which three.js makes elements with


def test_only_the_page_s_own_scripts_may_run_and_nothing_may_be_fetched(text: str) -> None:
    parsed = Parsed(text)
    policy = next(a["content"] for _, a in parsed.elements if a.get("http-equiv") == "Content-Security-Policy")
    assert policy is not None
    rules = {rule.split()[0]: rule.split()[1:] for rule in policy.split(";")}
    assert rules["default-src"] == ["'none'"]
    assert set(rules) == {"default-src", "script-src", "style-src", "img-src"}
    scripts = parsed.apart["script"][1:]
    hashes = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts]
    assert rules["script-src"] == [f"'sha256-{hashed}'" for hashed in hashes]


def test_hostile_names_are_text(tmp_path: Path, text: str) -> None:
    hostile_log(tmp_path / "<b>log.mcap")
    hostile, plain = Parsed(page(gather(tmp_path / "<b>log.mcap"))), Parsed(text)
    for tag in ("script", "img", "b"):
        assert hostile.count(tag) == plain.count(tag)
    assert not any(name.startswith("on") for _, attributes in hostile.elements for name in attributes)
    for name in (*HOSTILE, WARNING, "<b>log.mcap"):
        assert name in hostile.text


def test_the_same_log_gives_the_same_bytes(log: Path) -> None:
    command = [sys.executable, "-m", "closecall", "report", str(log), "-o", "-"]
    pages = [
        subprocess.run(command, env=os.environ | {"PYTHONHASHSEED": seed}, capture_output=True, check=True).stdout
        for seed in ("1", "2")
    ]
    assert pages[0] == pages[1]
    assert pages[0].startswith(b"<!DOCTYPE html>")


def test_a_page_goes_beside_its_log_or_where_it_is_told(log: Path, tmp_path: Path) -> None:
    assert closecall("report", log, "-q", cwd=tmp_path).stdout == ""
    beside = log.with_suffix(".html")
    done = closecall("report", log, "-o", "new.html", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("new.html: ")
    assert (tmp_path / "new.html").read_bytes() == beside.read_bytes()
    assert os.listdir(tmp_path) == ["new.html"]
    (tmp_path / "new.html").write_bytes(beside.read_bytes()[:1000])
    assert closecall("report", log, "-o", "new.html", cwd=tmp_path).returncode == 0
    assert (tmp_path / "new.html").read_bytes() == beside.read_bytes()


@pytest.mark.parametrize(
    ("output", "problem"),
    [("LOG", "would overwrite the input"), ("no/new.html", "there is no folder"), (".", "folder")],
)
def test_a_page_that_cannot_be_written_is_refused(log: Path, tmp_path: Path, output: str, problem: str) -> None:
    before = log.read_bytes()
    done = closecall("report", log, "-o", log if output == "LOG" else output, cwd=tmp_path)
    assert done.returncode == 2
    assert problem in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert log.read_bytes() == before
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_goes_away_ends_it_with_141(log: Path, unbuffered: str) -> None:
    command = [sys.executable, "-m", "closecall", "report", str(log), "-o", "-"]
    environment = os.environ | {"PYTHONUNBUFFERED": unbuffered}
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.read(9) == b"<!DOCTYPE"
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 141


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    (tmp_path / "text.mcap").write_text("hello")
    for name in ("text.mcap", "missing.mcap"):
        done = closecall("report", name, cwd=tmp_path)
        assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
        assert not (tmp_path / name).with_suffix(".html").exists()


def test_a_cut_log_gives_a_page_with_a_banner_and_exit_3(log: Path, tmp_path: Path) -> None:
    (tmp_path / "cut.mcap").write_bytes(log.read_bytes()[: log.stat().st_size // 2])
    done = closecall("report", "cut.mcap", "-q", cwd=tmp_path)
    assert done.returncode == 3
    assert "unfinished at byte" in done.stderr
    cut = Parsed((tmp_path / "cut.html").read_text())
    assert "Incomplete log. The log is unfinished at byte" in cut.text
    assert re.search(r"end unknown; the log has lost the spans in [\d.]+ to 5 s", cut.text)
    assert "to the end" not in cut.text


def test_what_was_not_read_is_not_said_not_to_be(log: Path, tmp_path: Path) -> None:
    """Cut in the middle of the first chunk, whose facts and bodies are lost with it."""
    with log.open("rb") as file:
        index = make_reader(file).get_summary()
    assert index is not None
    (tmp_path / "cut.mcap").write_bytes(log.read_bytes()[: index.chunk_indexes[0].chunk_start_offset + 100])
    assert closecall("report", "cut.mcap", "-q", cwd=tmp_path).returncode == 3
    cut = Parsed((tmp_path / "cut.html").read_text())
    assert "The log has no contacts in the parts that can be read." in cut.text
    assert "The readable parts of the log have no bodies to draw." in cut.text
    assert "1 of 1 pair is unresolved." in cut.text
    assert "The log lists no pairs in the parts that can be read." in cut.text
    assert "more pair" not in cut.text
    assert "--log certificate" not in cut.text


def test_a_summary_that_is_whole_is_told_as_such_where_the_facts_are_damaged(log: Path, tmp_path: Path) -> None:
    with log.open("rb") as file:
        index = make_reader(file).get_summary()
    assert index is not None
    damaged = bytearray(log.read_bytes())
    for chunk in index.chunk_indexes:
        damaged[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 1
    (tmp_path / "damaged.mcap").write_bytes(damaged)
    assert closecall("report", "damaged.mcap", "-q", cwd=tmp_path).returncode == 3
    told = Parsed((tmp_path / "damaged.html").read_text()).text
    assert "Incomplete log." in told
    assert "The statements about pairs come from the summary in the log, which is complete" in told
    assert "nothing is proved" not in told
    assert "1 of 1 pair touches." in told


def test_balls_that_touch_are_told_with_when(text: str) -> None:
    """Centres apart by 4 - 2t and 0.3, radii 0.75: they touch while |4 - 2t| <= sqrt(0.75^2 - 0.3^2)."""
    reach = (0.75**2 - 0.3**2) ** 0.5
    told = Parsed(text).text
    assert "1 of 1 pair touches." in told
    begin = re.search(r"left \| right at ([\d.]+) s, begins within ([\d.]+) to ([\d.]+) s, lasts until", told)
    end = re.search(r"until ([\d.]+) s, ends within ([\d.]+) to ([\d.]+) s", told)
    assert begin
    assert end
    for found, exact in ((begin, (4.0 - reach) / 2.0), (end, (4.0 + reach) / 2.0)):
        assert float(found[2]) <= exact <= float(found[3])
        assert float(found[3]) - float(found[2]) < 2e-6
        assert float(found[1]) == pytest.approx(exact, abs=1e-5)


def test_what_the_scripts_draw_is_what_the_log_holds(log: Path, text: str) -> None:
    facts, arrays = block(text)
    gathered = gather(log)
    assert facts["bodies"] == ["left", "right"]
    assert (facts["start"], facts["end"]) == (0.0, 5.0)
    measured = gathered.curves[0].measured
    assert len(measured) > 5
    exact = np.maximum(0.0, np.hypot(4.0 - 2.0 * measured[:, 0], 0.3) - 0.75)
    assert measured[:, 1] == pytest.approx(exact, abs=1e-8)
    is_measured = arrays["pointMeasured"] == 1
    assert arrays["pointTime"][is_measured] == pytest.approx(measured[:, 0], abs=1e-6)
    true = np.hypot(4.0 - 2.0 * arrays["pointTime"].astype(float), 0.3) - 0.75
    assert (arrays["pointDistance"] <= np.maximum(0.0, true) + 2e-6).all()
    kinds = [facts["spanVerdicts"][str(kind)] for kind in arrays["spanVerdict"][:-1].tolist()]
    assert kinds == ["clear", "contact", "clear"]
    assert arrays["spanStart"][0] == 0.0
    assert arrays["spanStart"][-1] == 5.0
    assert arrays["touchTime"][0] == gathered.pairs[0]["contacts"][0]["begin"][1]


def test_bodies_are_replayed_where_they_are(text: str) -> None:
    facts, arrays = block(text)
    tracks = facts["replay"]["tracks"]
    assert sorted(tracks) == ["left", "right"]
    for track, name in enumerate(tracks):
        rows = slice(arrays["poseFrom"][track], arrays["poseFrom"][track + 1])
        times, places = arrays["poseTime"][rows], arrays["posePlace"].reshape(-1, 3)[rows]
        assert len(times) > 100
        speed = 1.0 if name == "left" else -1.0
        assert places[:, 0] - places[0, 0] == pytest.approx(speed * times, abs=1e-5)
    (left, right) = (facts["replay"]["bodies"][index]["parts"][0]["size"] for index in range(2))
    assert (left, right) == ([1.0] * 3, [0.5] * 3)  # diameters


def test_the_libraries_are_those_that_were_built() -> None:
    """docs/report_libraries/build makes them of pinned packages and keeps their checksums."""
    told = (ROOT / "docs/report_libraries/checksums").read_text().splitlines()
    assert told == [
        f"{hashlib.sha256((PAGE / name).read_bytes()).hexdigest()}  {name}"
        for name in ("libraries.js", "libraries.css")
    ]
    notice = (PAGE / "libraries.js").read_text()[:4000]
    pinned = json.loads((ROOT / "docs/report_libraries/package.json").read_text())["dependencies"]
    for name in ("three", "uplot"):
        assert f"\n{name} {pinned[name]}\n\nThe MIT License" in notice
