"""Cut and flipped logs under every command that reads logs: an end, a line or two, and no traceback."""

from __future__ import annotations

import os
import random
import signal
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from diff_logs import run_scene, write_scene
from guarded import memory_limited, time_limited
from rewritten_logs import rewrite

from closecall.cli.main import main

READING = {
    "summary": ["summary", "LOG", "--json"],
    "diff": ["diff", "golden.mcap", "LOG"],
    "diff, as golden": ["diff", "LOG", "golden.mcap", "--json"],
    "diff --all": ["diff", "golden.mcap", "LOG", "--all"],
    "export": ["export", "LOG", "-o", "tables", "--format", "ndjson"],
    "extract, a part": ["extract", "LOG", "--from", "0.5", "-o", "part.mcap"],
    "extract, a file": ["extract", "LOG", "scene"],
    "extract, the list": ["extract", "LOG"],
    "report": ["report", "LOG", "-o", "report.html"],
}


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a full log as the writer makes it, and with the same in small chunks of each compression."""
    folder = tmp_path_factory.mktemp("damage")
    run_scene(write_scene(folder), folder / "golden.mcap", "--log", "full", "--broad-phase", "on", "--rate", "10")
    rewrite(folder / "golden.mcap", folder / "chunks.mcap")
    run_scene(folder / "scene.yaml", folder / "plain.mcap", "--compression", "none", "--no-attach-meshes")
    return folder


@pytest.fixture
def folder(logs: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(logs)
    handler = signal.getsignal(signal.SIGTERM)
    yield logs
    signal.signal(signal.SIGTERM, handler)


def cut(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data))]


def flipped(data: bytes, rng: random.Random) -> bytes:
    out = bytearray(data)
    out[rng.randrange(len(data))] ^= rng.randrange(1, 256)
    return bytes(out)


def read_by_all(
    seed: int,
    damage: Callable[[bytes, random.Random], bytes],
    monkeypatch: pytest.MonkeyPatch,
    capsysbinary: pytest.CaptureFixture[bytes],
) -> Counter[tuple[str, int]]:
    """Damage a log and read it by every command; return how each ended."""
    rng = random.Random(seed)
    source = rng.choice(["golden.mcap", "chunks.mcap", "plain.mcap"])
    Path("log.mcap").write_bytes(damage(Path(source).read_bytes(), rng))
    ends: Counter[tuple[str, int]] = Counter()
    for name, arguments in READING.items():
        monkeypatch.setattr(sys, "argv", ["closecall", *("log.mcap" if word == "LOG" else word for word in arguments)])
        with time_limited(), pytest.raises(SystemExit) as left:
            main()
        printed = capsysbinary.readouterr()
        code = left.value.code or 0
        assert isinstance(code, int)
        assert code in (0, 1, 2, 3), (seed, name, printed.err)
        assert b"Traceback" not in printed.err, (seed, name)
        assert (code in (2, 3)) is bool(printed.err), (seed, name, code, printed.err)
        assert all(line.startswith(b"log.mcap: ") for line in printed.err.splitlines()), (seed, name, printed.err)
        ends[name, code] += 1
    assert not list(Path().glob("*.partial"))
    return ends


@pytest.mark.parametrize("damage", [cut, flipped])
def test_every_reading_command_ends_well_on_damaged_logs(damage, folder, monkeypatch, capsysbinary):
    with memory_limited():
        for seed in range(4):
            read_by_all(seed, damage, monkeypatch, capsysbinary)


@pytest.mark.deep
@pytest.mark.parametrize("damage", [cut, flipped])
def test_every_reading_command_ends_well_on_a_hundred_damaged_logs(damage, folder, monkeypatch, capsysbinary):
    first, count = (int(os.environ.get(f"CLOSECALL_DEEP_DAMAGE{name}", value)) for name, value in DEEP.items())
    ends: Counter[tuple[str, int]] = Counter()
    with memory_limited():
        for seed in range(first, first + count):
            ends += read_by_all(seed, damage, monkeypatch, capsysbinary)
    with capsysbinary.disabled():
        for (name, code), times in sorted(ends.items()):
            print(f"{damage.__name__}: {name} exited {times} times with {code}")


DEEP = {"_FIRST": "1000", "": "100"}
"""Seeds of the deep test: the first, and how many."""
