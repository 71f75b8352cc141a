"""Tables of a log against what mcap's own reader and the log's own descriptors say of it."""

from __future__ import annotations

import csv
import io
import json
import math
import re
import signal
import subprocess
from pathlib import Path
from typing import Any

import pyarrow.parquet
import pytest
from cli_process import closecall_inside, command
from diff_logs import run_scene, write_scene
from places import ROOT
from rewritten_logs import rewrite

from closecall.formats.log.message_filter import Choice
from closecall.formats.log.tables.export import export_table, export_tables
from closecall.formats.log.tables.tables import tables
from oracle.logs import read_log

DOCUMENT = (ROOT / "docs" / "tables.md").read_text(encoding="utf-8")
EPOCH = 1_700_000_000_000_000_000


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("export")
    options = ["--log", "full", "--broad-phase", "on", "--topics", "body", "--epoch", str(EPOCH), "--rate", "10"]
    return run_scene(write_scene(folder), folder / "out.mcap", *options)


def flat(values: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return a message's fields as a table has them: nested ones joined, the unknown as None."""
    out: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, dict):
            out |= flat(value, f"{prefix}{name}_")
        elif name not in ("timestamp", "publish_time"):
            out[prefix + name] = None if isinstance(value, float) and not math.isfinite(value) else value
    return out


@pytest.mark.parametrize("name", ["wakeups", "distances", "collisions", "spans", "windows"])
def test_every_field_of_every_message_is_in_its_row(log, name):
    stream = io.BytesIO()
    done = export_table(log, "ndjson", Choice(topics=(f"/{name}",)), stream)
    rows = [json.loads(line) for line in stream.getvalue().splitlines()]
    expected = [flat(message) for message in read_log(log).of(name)]
    assert done.rows == {name: len(expected)}
    assert expected
    for row in rows:
        assert row["time"] == (row["log_time"] - EPOCH) / 1e9
        del row["time"]
    order = sorted(range(len(rows)), key=lambda i: (rows[i]["log_time"], json.dumps(rows[i], sort_keys=True)))
    expected.sort(key=lambda row: (row["log_time"], json.dumps(row, sort_keys=True)))
    assert [rows[i] for i in order] == expected


def test_all_formats_have_the_same_rows(log, tmp_path):
    for kind in ("csv", "ndjson", "parquet"):
        export_tables(log, kind, Choice(), tmp_path)
    names = {"wakeups", "distances", "collisions", "spans", "windows", "world", "tf", "log"}
    assert {path.stem for path in tmp_path.iterdir()} == names
    for name in names:
        objects = [json.loads(line) for line in (tmp_path / f"{name}.ndjson").read_text().splitlines()]
        assert pyarrow.parquet.read_table(tmp_path / f"{name}.parquet").to_pylist() == objects
        with (tmp_path / f"{name}.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert rows == [{key: "" if value is None else str(value) for key, value in one.items()} for one in objects]


def test_rows_are_chosen_by_pair_body_and_time(log):
    def rows(**choice: Any) -> list[dict[str, Any]]:
        stream = io.BytesIO()
        export_table(log, "ndjson", Choice(topics=("/spans",), **choice), stream)
        return [json.loads(line) for line in stream.getvalue().splitlines()]

    everything = rows()
    assert rows(pairs=("wall|arm",)) == rows(pairs=("arm|wall",)) == [r for r in everything if r["pair"] == "arm|wall"]
    assert rows(pairs=("a*",)) == [r for r in everything if "arm" in r["pair"]]
    assert rows(start=0.97, end=1.0) == [r for r in everything if r["end"] >= 0.97 and r["start"] <= 1.0]
    assert 0 < len(rows(pairs=("arm|wall",), start=0.97, end=1.0)) < len(rows(pairs=("arm|wall",)))


@pytest.mark.parametrize("where", [["-o", "tables"], ["--topic", "/spans"]])
def test_where_no_message_is_wanted_a_line_says_so_and_there_is_no_folder(log, tmp_path, where):
    done = closecall_inside("export", log, "--from", "1e6", *where, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "no messages match\n")
    assert not list(tmp_path.iterdir())
    quiet = closecall_inside("export", log, "--from", "1e6", *where, "-q", cwd=tmp_path)
    assert quiet.stderr == ""
    found = closecall_inside("export", log, "--pair", "arm", *where, cwd=tmp_path)
    assert (found.returncode, found.stderr) == (0, "")


def test_the_document_tells_every_column_and_its_type():
    common, *sections = re.split(r"^## (\w+)$", DOCUMENT, flags=re.MULTILINE)
    told = dict(zip(sections[::2], map(columns_told, sections[1::2]), strict=True))
    timed, paired = (columns_told(part) for part in common.split("and goes on with"))
    assert set(told) == {table.name for table in tables().values()}
    for table in tables().values():
        expected = {column.name: column.kind for column in table.columns}
        shared = timed | (paired if "pair_id" in expected else {})
        assert shared | told[table.name] == expected, table.name


def columns_told(text: str) -> dict[str, str]:
    """Return the columns of a document's tables, with their types."""
    rows = re.findall(r"^\| (`.+?`) \| (\w+) \|", text, flags=re.MULTILINE)
    return {name: kind for names, kind in rows for name in re.findall(r"`(\w+)`", names)}


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["out.mcap"], 2, "Give one --topic"),
        (["out.mcap", "--topic", "/spnas"], 2, "choose from /wakeups, /distances"),
        (["out.mcap", "--topic", "/spans", "--format", "parquet"], 2, "Parquet needs -o DIR"),
        (["out.mcap", "--topic", "/spans", "--from", "2", "--to", "1"], 2, "expected --from before --to"),
        (["none.mcap", "--topic", "/spans"], 2, "none.mcap: does not exist"),
        (["out.mcap", "-o", "out.mcap"], 2, "is not a folder"),
        (["cut.mcap", "--topic", "/spans"], 3, "cut.mcap: unfinished at byte"),
    ],
)
def test_what_cannot_be_exported_is_told(log, arguments, code, said):
    (log.parent / "cut.mcap").write_bytes(log.read_bytes()[:-3000])
    done = closecall_inside("export", *arguments, cwd=log.parent)
    assert done.returncode == code
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert (len(done.stdout.splitlines()) > 5) is (code == 3)


def test_parquet_without_pyarrow_is_a_line_that_says_what_to_install(log, monkeypatch):
    monkeypatch.setattr("closecall.cli.commands.export.find_spec", lambda name: None)
    done = closecall_inside("export", log, "--format", "parquet", "-o", "tables", cwd=log.parent)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "Error: Parquet needs pyarrow: pip install 'closecall[parquet]'\n"


@pytest.fixture(scope="module")
def long_log(log: Path) -> Path:
    """Return a log whose wakeups make far more rows than a pipe holds."""
    path = log.parent / "long.mcap"
    rewrite(log, path, lambda channel, message: [message] * (200 if channel.topic == "/wakeups" else 1))
    return path


def test_a_reader_that_leaves_early_ends_the_export_quietly(long_log):
    script = 'set -o pipefail; "$@" | head -2'
    export = command("export", long_log, "--topic", "/wakeups")
    done = subprocess.run(["bash", "-c", script, "bash", *export], capture_output=True, text=True, timeout=60)
    assert done.stdout.startswith("time,log_time,pair,pair_id,body_a,body_b,reason,")
    assert len(done.stdout.splitlines()) == 2
    assert (done.returncode, done.stderr) == (141, "")


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_an_export_in_a_line(long_log, number, code):
    export = command("export", long_log, "--topic", "/wakeups", "--format", "ndjson")
    process = subprocess.Popen(
        export,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert process.stdout is not None
    assert process.stdout.read(10) == b'{"time": 0'  # and no more: the pipe fills, and the export waits
    process.send_signal(number)
    _, told = process.communicate(timeout=60)
    assert process.returncode == code
    assert told.count(b"\n") == 1


def test_an_export_that_fails_leaves_nothing(log, tmp_path, monkeypatch):
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("closecall.formats.log.tables.export.NdjsonWriter.write", full)
    with pytest.raises(Exception, match="cannot write: No space left on device"):
        export_tables(log, "ndjson", Choice(), tmp_path)
    assert not list(tmp_path.iterdir())
