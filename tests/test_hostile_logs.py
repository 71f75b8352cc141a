"""Logs that are put together well and say what cannot be: each fault is one line that names the log and the place."""

from __future__ import annotations

import json
from os import SEEK_CUR
from pathlib import Path
from random import Random
from typing import Any

import lz4.frame
import pytest
import zstandard
from cli_process import closecall_inside
from guarded import memory_limited
from made_logs import SCHEMAS, MadeLog, sound_log
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.writer import MCAP0_MAGIC

from closecall.formats.log.carried import OlderSummaryError, SummaryError, as_summary
from closecall.formats.log.found import fold, read_found
from closecall.formats.log.reader import LogReader
from closecall.formats.log.records import RECORD_HEAD, chunk_content

COMMANDS = (
    ["summary", "log.mcap"],
    ["summary", "log.mcap", "--json"],
    ["diff", "log.mcap", "log.mcap"],
    ["diff", "log.mcap", "log.mcap", "--all", "--json"],
    ["report", "log.mcap", "-o", "page.html"],
    ["export", "log.mcap", "-o", "tables"],
    ["extract", "log.mcap"],
    ["extract", "log.mcap", "--to", "1", "-o", "part.mcap"],
)


def told_by_all(folder: Path, log: MadeLog, *commands: list[str]) -> set[str]:
    """Read a log by commands that must all end with 3; return the lines that they tell."""
    (folder / "log.mcap").write_bytes(log.bytes())
    lines = set()
    for command in commands or COMMANDS:
        done = closecall_inside(*command, cwd=folder)
        assert done.returncode == 3, (command, done.stderr)
        lines |= set(done.stderr.splitlines())
    assert all(line.startswith("log.mcap: ") and line.isprintable() for line in lines)
    return lines


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("epoch", "-5"),
        ("epoch", str(2**64)),
        ("epoch", str(2**63)),
        ("epoch", "٣"),
        ("epoch", "1.5"),
        ("start", "nan"),
        ("start", "-1e308"),
        ("start", "4.5"),
        ("end", "inf"),
        ("end", "1e308"),
        ("count/bodies", "-1"),
        ("count/bodies", "9" * 30),
        ("count/pairs", "7"),
        ("count/ignored", "x"),
        ("settings", "[]"),
        ("settings", "{}"),
        ("settings", '{"margin": NaN}'),
        ("settings", '{"margin": "1"}'),
        ("settings", "[" * 100_000),
        ("settings", '{"margin": 1%s}' % ("0" * 400)),
        ("exists", '{"arm": 1%s}' % ("0" * 400)),
        ("chord_errors", "[]"),
        ("chord_errors", '{"arm": -1}'),
        ("chord_errors", '{"arm": 1e308}'),
        ("exists", "[1]"),
        ("exists", '{"arm": [1]}'),
        ("exists", '{"arm": [2, 1]}'),
        ("exists", '{"arm": [0, Infinity]}'),
        ("margins", "{}"),
        ("margins", '[["a", "b", NaN]]'),
        ("margins", '[["a", "b", 1]]'),
        ("margins", '[[["a"], ["b"], -1]]'),
        ("margins", '[[["a"], [["b"]], 1]]'),
        ("version", None),
        ("scene_sha256", None),
        ("start", None),
    ],
)
def test_what_a_log_says_of_its_run_is_held_to_what_runs_are(tmp_path, key, value):
    log = sound_log(Random(1))
    for record in (log.start, log.end):
        assert record is not None
        record.pop(key)
        if value is not None:
            record[key] = value
    (line,) = told_by_all(tmp_path, log, COMMANDS[1], COMMANDS[5], COMMANDS[6])
    assert key.removeprefix("count/") in line or "start" in line


def test_what_it_says_of_its_run_at_its_end_is_what_it_says_at_its_start(tmp_path):
    log = sound_log(Random(1))
    assert log.end is not None
    log.end["settings"] = '{"margin": 1.0}'
    (line,) = told_by_all(tmp_path, log)
    assert "at its start and at its end are not the same" in line


@pytest.mark.parametrize("topic", SCHEMAS)
def test_a_topic_of_another_type_is_told_by_every_command(tmp_path, topic):
    log = sound_log(Random(2))
    for told in (
        ("closecall.Point", "protobuf", "protobuf"),
        ("", "protobuf", "protobuf"),
        (SCHEMAS[topic], "protobuf", "json"),
    ):
        log.schemas[topic] = told
        (line,) = told_by_all(tmp_path, log, *COMMANDS[1::3])
        assert f"topic '{topic}' is of " in line
        assert "expected" in line


def test_topics_of_others_are_passed_over(tmp_path):
    log = sound_log(Random(2))
    facts = [fact for fact in log.facts() if fact.topic == "/spans"][:2]
    log.schemas |= {"/theirs": ("std_msgs/String", "ros2msg", "cdr"), "/spans_too": SCHEMAS_OF_SPANS}
    log.chunks[0] += [type(facts[0])(topic, 0, facts[0].message) for topic in ("/theirs", "/spans_too")]
    (tmp_path / "log.mcap").write_bytes(log.bytes())
    for command in COMMANDS:
        assert closecall_inside(*command, cwd=tmp_path).returncode == 0


SCHEMAS_OF_SPANS = ("closecall.Span", "protobuf", "protobuf")


@pytest.mark.parametrize(
    ("topic", "change"),
    [
        ("/spans", {"start": 3.9, "end": 1.0}),
        ("/spans", {"end": 1e308}),
        ("/spans", {"clearance": float("nan")}),
        ("/spans", {"clearance": -1.0}),
        ("/spans", {"depth_limit": float("inf")}),
        ("/spans", {"error": float("nan")}),
        ("/spans", {"verdict": 99}),
        ("/spans", {"pair_id": 6}),
        ("/spans", {"pair_id": 2**64 - 1}),
        ("/spans", {"pair": "arm|arm"}),
        ("/spans", {"body_a": "", "pair": "|wall"}),
        ("/wakeups", {"reason": 0}),
        ("/wakeups", {"level": 99}),
        ("/wakeups", {"sleep": float("inf")}),
        ("/distances", {"distance": 1e308}),
        ("/distances", {"excess": -1.0}),
        ("/collisions", {"time_clear": 3.9, "time_touching": 0.1, "phase": 1}),
        ("/collisions", {"phase": 0}),
        ("/windows", {"end": float("nan")}),
        ("/world", {"min_distance": float("inf")}),
    ],
)
def test_a_message_that_says_what_cannot_be_is_told_and_left_out(tmp_path, topic, change):
    log = sound_log(Random(3))
    fact = [fact for fact in log.facts() if fact.topic == topic][-1]
    for name, value in change.items():
        setattr(fact.message, name, value)
    lines = told_by_all(tmp_path, log, *COMMANDS[3:4], *COMMANDS[5:])
    assert all(f"a message of {topic}: " in line for line in lines)


def test_poses_places_and_times_of_what_is_drawn_are_held_too(tmp_path):
    for topic, change in (
        ("/tf", lambda message: setattr(message.transforms[0].translation, "x", 1e308)),
        ("/tf", lambda message: setattr(message.transforms[0].rotation, "w", 2.0)),
        ("/scene/meshes", lambda message: setattr(message.entities[0].triangles[0].points[1], "y", float("nan"))),
        ("/scene/meshes", lambda message: setattr(message.entities[1].cubes[0].size, "y", float("inf"))),
        ("/viz/clearance", lambda message: setattr(message.entities[0].lines[0].points[1], "z", -1e308)),
        ("/viz/clearance", lambda message: message.entities[0].lines[0].points.pop()),
    ):
        log = sound_log(Random(4))
        change(next(fact for fact in log.facts() if fact.topic == topic).message)
        (line,) = told_by_all(tmp_path, log, *COMMANDS[3:5], *COMMANDS[6:])
        assert f"a message of {topic}: " in line
    log = sound_log(Random(4))
    log.facts()[0].log_time = 2**64 - 1
    (line,) = told_by_all(tmp_path, log, *COMMANDS[3:4], *COMMANDS[5:])
    assert f"its log time is {2**64 - 1}" in line


def test_what_is_left_out_is_never_clear(tmp_path):
    log = sound_log(Random(5))
    for fact in log.facts():
        if fact.topic == "/spans" and fact.message.pair == "arm|wall":
            fact.message.clearance = float("nan")
    (tmp_path / "log.mcap").write_bytes(log.bytes())
    found = read_found(tmp_path / "log.mcap")
    (pair,) = (pair for pair in found.summary["pairs"] if pair["pair"] == "arm|wall")
    assert pair["unresolved"] == [[0.0, 4.0]]
    assert pair["verdict"] != "clear"
    assert pair["distance"]["lower"] == 0.0


def test_a_log_of_a_negative_epoch_that_is_none_before_zero_can_be_taken_apart(tmp_path):
    log = sound_log(Random(6))
    for record in (log.start, log.end):
        assert record is not None
        record["epoch"] = "0"
        record |= {"start": "0.0", "end": "4.0"}
    for fact in log.facts():
        fact.log_time %= 10**18
    log.chunks = [[fact for fact in log.facts() if fact.log_time >= 2 * 10**9]]
    for record in (log.start, log.end):
        assert record is not None
        record |= {"epoch": "-2000000000", "start": "2.0", "end": "6.0"}
    for fact in log.facts():
        fact.log_time -= 2 * 10**9
    (tmp_path / "log.mcap").write_bytes(log.bytes())
    done = closecall_inside("extract", "log.mcap", "--to", "5", "-o", "part.mcap", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert closecall_inside("summary", "part.mcap", cwd=tmp_path).returncode == 0


@pytest.mark.parametrize("compression", ["zstd", "lz4", "lz4 without size"])
@pytest.mark.parametrize("told", [1000, 2**26 - 1])
def test_a_chunk_that_holds_more_than_it_says_takes_no_memory(monkeypatch, compression, told):
    held = bytes(2**29)
    match compression:
        case "zstd":
            data = zstandard.ZstdCompressor(write_content_size=False).compress(held)
        case "lz4":
            data = lz4.frame.compress(held, store_size=True)
        case _:
            data = lz4.frame.compress(held, store_size=False)
    del held
    record = RecordBuilder()
    Chunk(compression.split()[0], data, 0, 0, 0, told).write(record)
    monkeypatch.setattr("guarded.MOST_BYTES", 2**28)
    with memory_limited(), pytest.raises(ValueError, match="size is not what it says"):
        chunk_content(record.end()[9:])


@pytest.mark.parametrize("opcode", [Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE, Opcode.CHUNK])
def test_a_record_of_gigabytes_that_takes_no_room_on_a_disk_is_passed_over_without_memory(tmp_path, opcode):
    data, size = sound_log(Random(1)).bytes(), 2**33
    head = len(MCAP0_MAGIC) + RECORD_HEAD.size  # of the first record
    begins = head + int.from_bytes(data[head - 8 : head], "little")
    with (tmp_path / "log.mcap").open("wb") as file:
        file.write(data[:begins] + RECORD_HEAD.pack(opcode, size))
        file.seek(size, SEEK_CUR)  # a hole
        file.write(data[begins:])
    (tmp_path / "sound.mcap").write_bytes(data)
    with memory_limited(), LogReader(tmp_path / "log.mcap") as log, LogReader(tmp_path / "sound.mcap") as sound:
        assert list(log.messages()) == list(sound.messages())
        assert log.loss is not None
        assert (log.loss.offset, log.loss.problem) == (begins, f"a record of {size} bytes is too large")


@pytest.mark.parametrize("compression", ["", "zstd", "lz4", "lz4 without size"])
@pytest.mark.parametrize("size", [0, 1, 2**20 - 1, 2**20, 2**20 + 1, 20_000_000])
def test_a_chunk_comes_back_as_it_was(compression, size):
    from made_logs import compressed

    held = Random(size).randbytes(min(size, 1000)) + bytes(max(0, size - 1000))
    record = RecordBuilder()
    Chunk(compression.split(" ")[0], compressed(compression, held), 0, 0, 0, size).write(record)
    assert chunk_content(record.end()[9:]) == held


@pytest.fixture(scope="module")
def carried(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return the summary of a log whose pairs touch, are in breach and are clear."""
    path = tmp_path_factory.mktemp("carried") / "log.mcap"
    for seed in range(100):
        path.write_bytes(sound_log(Random(seed)).bytes())
        summary = fold(path).summary
        if any(pair["contacts"] and pair["breaches"] for pair in summary["pairs"]):
            return json.loads(json.dumps(summary))
    raise AssertionError("no such log")


def places(value: Any, where: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the way to every value inside a value of JSON."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [where, *(place for key, one in inner for place in places(one, (*where, key)))]


@pytest.mark.parametrize("other", [True, -1, 1e308, "x", [], {}, [None], 2**70, 10**400])
def test_a_summary_is_one_in_each_of_its_values(carried, other):
    text = json.dumps(carried)
    assert as_summary(text.encode()) == carried
    refused = 0
    for place in places(carried):
        value: Any = {"it": json.loads(text)}
        inner = value
        for key in ("it", *place[:-1]) if place else ():
            inner = inner[key]
        inner[place[-1] if place else "it"] = other
        try:
            summary = as_summary(json.dumps(value["it"]).encode())
        except SummaryError:
            refused += 1
        else:
            assert all(pair["verdict"] in carried["totals"]["pairs"] for pair in summary["pairs"])
    assert refused > 0.5 * len(places(carried))


def test_a_summary_that_lacks_a_value_is_an_older_one(carried):
    older = json.loads(json.dumps(carried))
    del older["pairs"][0]["margin"]
    with pytest.raises(OlderSummaryError, match="has no margin"):
        as_summary(json.dumps(older).encode())


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"time": [0.0, 5.0]}, "of another time"),
        ({"pairs_total": 7}, "of another time, or of other pairs"),
        ({"time": [float("inf"), 1]}, "not JSON"),
        ({"pairs": 5}, "pairs is 5"),
    ],
)
def test_a_summary_that_cannot_be_the_logs_is_told_and_the_facts_are_read(tmp_path, change, said):
    log = sound_log(Random(7))
    (tmp_path / "log.mcap").write_bytes(log.bytes())
    folded = fold(tmp_path / "log.mcap").summary
    log.attachments.append(("summary.json", "application/json", json.dumps(folded | change).encode()))
    (line,) = told_by_all(tmp_path, log, *COMMANDS[:2], COMMANDS[4])
    assert said in line
    assert read_found(tmp_path / "log.mcap").summary == folded
