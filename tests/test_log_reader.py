"""Reading a summary back: from a finished log, or one line that says why not."""

from __future__ import annotations

import os
import random
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from mcap.writer import Writer

from closecall.formats.log.errors import LogError
from closecall.formats.log.reader import read_attachment, read_summary
from closecall.formats.log.writer import LogOptions, LogWriter
from closecall.formats.scene.loaded import LoadedScene
from closecall.scheduler.events import Bound, Level, PairKey, Reason, Wakeup
from closecall.scheduler.scene import Body, PairRules, Scene, Settings


@pytest.fixture
def scene(tmp_path: Path) -> LoadedScene:
    path = tmp_path / "scene.yaml"
    path.write_bytes(b"closecall: 1\n")
    bodies = tuple(Body(name, None, np.eye(4), cast(Any, None), ()) for name in ("größe", "hammer"))
    return LoadedScene(path, path.read_bytes(), Scene(bodies, 0.0, 10.0, PairRules()), Settings(), (), ())


@pytest.fixture
def log(tmp_path: Path, scene: LoadedScene) -> Path:
    with LogWriter(tmp_path / "out.mcap", scene, Settings(), 1, LogOptions()) as writer:
        for k in range(100):
            time = k / 10
            writer.write(Wakeup(time, PairKey(0, 0, 1), Reason.START, Level.MESH, Bound.LECTURE, 1.0, 0.1))
    return tmp_path / "out.mcap"


def refusal(path: Path) -> str:
    with pytest.raises(LogError) as caught:
        read_summary(path)
    line = str(caught.value)
    assert line.startswith(f"{path}: ")
    assert "\n" not in line
    return line


def test_finished_log_gives_its_summary(log):
    summary = read_summary(log)
    assert summary["pairs"][0]["pair"] == "größe|hammer"
    assert summary["totals"]["wakeups"] == 100


def test_attachments_come_back_byte_for_byte(log, scene):
    assert read_attachment(log, "scene") == scene.source


def test_unfinished_log_is_called_unfinished(tmp_path, scene):
    writer = LogWriter(tmp_path / "out.mcap", scene, Settings(), 1, LogOptions())
    with pytest.raises(ZeroDivisionError), writer:
        raise ZeroDivisionError
    assert "unfinished" in refusal(writer.partial)
    assert "mcap recover" in refusal(writer.partial)


def test_log_cut_short_anywhere_is_one_line(log):
    data = log.read_bytes()
    for length in (*range(0, len(data), 97), len(data) - 1, 8, 9, 16):
        log.write_bytes(data[:length])
        line = refusal(log)
        assert ("unfinished" if length >= 8 else "not an MCAP file") in line


def test_damaged_log_is_one_line_or_still_reads_the_same(log):
    data, intact = log.read_bytes(), read_summary(log)
    rng = random.Random(7)
    refusals: list[str] = []
    for _ in range(3000):
        damaged = bytearray(data)
        place = rng.randrange(len(data)) if rng.random() < 0.5 else rng.randrange(len(data) - 900, len(data))
        damaged[place] ^= 1 << rng.randrange(8)
        log.write_bytes(damaged)
        try:
            assert read_summary(log) == intact
        except LogError as error:
            refusals.append(str(error))
    assert len(refusals) > 300
    assert not any("\n" in line for line in refusals)


def test_foreign_files_are_told_from_logs(tmp_path):
    text = tmp_path / "notes.txt"
    text.write_text("not a log at all, but long enough to hold a footer and more")
    assert "is not an MCAP file" in refusal(text)
    foreign = tmp_path / "foreign.mcap"
    with foreign.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.finish()
    assert "closecall did not write it" in refusal(foreign)


@pytest.mark.parametrize("content", [b"{}", b"[1]", b"{", b"\xff\xfe", b'{"closecall": NaN}', b"[" * 100_000])
def test_foreign_summaries_are_refused(tmp_path, content):
    path = tmp_path / "foreign.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.add_attachment(0, 0, "summary.json", "application/json", content)
        writer.finish()
    refusal(path)


def test_missing_files_folders_and_pipes_are_refused_without_waiting(tmp_path):
    assert "does not exist" in refusal(tmp_path / "none.mcap")
    assert "not a plain file" in refusal(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    assert "not a plain file" in refusal(tmp_path / "pipe")
