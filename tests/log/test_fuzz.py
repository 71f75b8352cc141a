"""Logs that are put together well and say what cannot be, under every command that reads logs.

`pytest -m deep` reads CLOSECALL_FUZZ_LOGS of them, 5,000 if that is not set. Their seeds begin with
CLOSECALL_FUZZ_FIRST, 0 if that is not set. With CLOSECALL_FUZZ_COMMANDS=one each is read by one command, in turn.
"""

from __future__ import annotations

import csv
import json
import os
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import chdir
from pathlib import Path
from random import Random
from shutil import rmtree
from subprocess import CompletedProcess
from typing import NoReturn

import pytest
from cli_process import closecall_inside
from guarded import memory_limited, time_limited
from made_logs import sound_log
from wrong_logs import sets_nonsense, wrong_log

READING = {
    "summary": ["summary", "LOG"],
    "summary --json": ["summary", "LOG", "--json"],
    "diff": ["diff", "sound.mcap", "LOG"],
    "diff --all": ["diff", "LOG", "sound.mcap", "--all", "--json", "--junit", "junit.xml"],
    "export csv": ["export", "LOG", "-o", "tables", "-q"],
    "export ndjson": ["export", "LOG", "-o", "tables", "--format", "ndjson"],
    "extract": ["extract", "LOG"],
    "extract, a part": ["extract", "LOG", "--to", "2", "-o", "part.mcap"],
    "extract, pairs": ["extract", "LOG", "--pair", "arm|*", "-o", "part.mcap", "-q"],
    "extract, a file": ["extract", "LOG", "summary.json", "-o", "file"],
    "report": ["report", "LOG", "-o", "report.html"],
}


WORDS_OF_NONE = ("no messages match", "no listed pair matches in this time")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with a sound log to compare with, and a limit on memory."""
    folder = tmp_path_factory.mktemp("fuzz")
    (folder / "sound.mcap").write_bytes(sound_log(Random(0)).bytes())
    with pytest.MonkeyPatch.context() as patch, memory_limited():
        patch.setattr(os, "fsync", lambda descriptor: None)  # which costs more than all else
        yield folder


def read_by(names: Iterable[str], folder: Path, data: bytes) -> dict[str, CompletedProcess[str]]:
    """Read a log by some commands; check what each says and writes; return how each ended."""
    (folder / "log.mcap").write_bytes(data)
    ends = {}
    for name in names:
        arguments = READING[name]
        with time_limited():
            done = closecall_inside(*("log.mcap" if word == "LOG" else word for word in arguments), cwd=folder)
        check_said(name, done)
        with chdir(folder):
            check_written(name, done)
        ends[name] = done
    assert not list(folder.glob("**/*.partial"))
    return ends


def check_said(name: str, done: CompletedProcess[str]) -> None:
    codes = (0, 1, 2, 3) if name.startswith("diff") else (0, 2, 3)
    assert done.returncode in codes, name
    lines = [*done.stdout.split("\n"), *done.stderr.split("\n")]
    assert all(line.isprintable() for line in lines), name
    told = [line for line in done.stderr.splitlines() if line not in WORDS_OF_NONE]
    assert len(told) == (done.returncode in (2, 3)), (name, told)
    other = "sound.mcap: cannot be compared: " if name.startswith("diff") else "log.mcap: "
    assert all(line.startswith(("log.mcap: ", other)) for line in told), (name, told)
    if "--json" in READING[name] and done.returncode != 2 and done.stdout:
        strict_json(done.stdout)


def check_written(name: str, done: CompletedProcess[str]) -> None:
    for path in Path("tables").glob("*"):
        text = path.read_text()
        if path.suffix == ".ndjson":
            assert all(isinstance(strict_json(line), dict) for line in text.splitlines())
        else:
            rows = list(csv.reader(text.splitlines()))
            assert {len(row) for row in rows} == {len(rows[0])}
            assert not any(cell.startswith(("=", "+", "@")) for row in rows for cell in row)
    if Path("report.html").exists():
        assert "<script>alert" not in Path("report.html").read_text()
    if name.startswith("extract, ") and Path("part.mcap").exists():
        again = closecall_inside("summary", "part.mcap", "--json", cwd=Path())
        assert again.returncode == done.returncode, again.stderr
    for path in ("tables", "report.html", "part.mcap", "file", "junit.xml"):
        rmtree(path) if Path(path).is_dir() else Path(path).unlink(missing_ok=True)


def strict_json(text: str) -> object:
    return json.loads(text, parse_constant=refuse)


def refuse(name: str) -> NoReturn:
    raise ValueError(f"{name} is not JSON")


def check_seed(folder: Path, seed: int, names: Iterable[str] = READING) -> Counter[tuple[str, int]]:
    try:
        ends = read_by(names, folder, wrong_log(seed))
    except BaseException as error:
        error.add_note(f"the log of seed {seed}")
        raise
    return Counter((name, done.returncode) for name, done in ends.items())


def test_sound_logs_of_every_compression_are_read_without_a_word(folder):
    for seed in range(4):
        log = sound_log(Random(seed))
        log.compression = ("", "zstd", "lz4", "lz4 without size")[seed]
        for name, done in read_by(READING, folder, log.bytes()).items():
            expected = 2 if name == "extract, a file" else 0
            assert name.startswith("diff") or done.returncode == expected, (seed, name, done.stderr)


def test_a_number_that_cannot_be_is_told_with_its_topic_by_every_command(folder):
    for seed in range(6):
        rng = Random(seed)
        log = sound_log(rng)
        fact = sets_nonsense(log, rng)
        for name, done in read_by(READING, folder, log.bytes()).items():
            if name == "extract, a file" or (fact.topic == "/wakeups" and name == "diff"):
                continue  # which read no such message
            assert done.returncode == 3, (seed, name)
            assert re.search(rf"a message of {fact.topic}(/arm)?: ", done.stderr), (seed, name, done.stderr)


@pytest.mark.parametrize("first", [0, 10])
def test_every_command_ends_well_on_logs_that_are_wrong(folder, first):
    for seed in range(first, first + 10):
        check_seed(folder, seed)


@pytest.mark.parametrize("seed", [100264])  # which names more pairs than it counts
def test_every_command_ends_well_on_logs_that_once_went_wrong(folder, seed):
    check_seed(folder, seed)


@pytest.mark.deep
def test_every_command_ends_well_on_thousands_of_logs_that_are_wrong(folder, capsys):
    first, count = (int(os.environ.get(f"CLOSECALL_FUZZ_{name}", value)) for name, value in DEEP.items())
    one = os.environ.get("CLOSECALL_FUZZ_COMMANDS") == "one"
    ends: Counter[tuple[str, int]] = Counter()
    for done, seed in enumerate(range(first, first + count), start=1):
        names = [list(READING)[seed % len(READING)]] if one else READING
        ends += check_seed(folder, seed, names)
        if done % 500 == 0 or done == count:
            with capsys.disabled():
                told = ", ".join(f"{name} {code}: {times}" for (name, code), times in sorted(ends.items()))
                print(f"\n{done} logs; {told}", file=sys.stderr, flush=True)


DEEP = {"FIRST": "0", "LOGS": "5000"}
"""Seeds of the deep test: the first, and how many."""
