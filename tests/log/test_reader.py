"""Reading a log back: its summary, its facts as far as they go, or one line that says why not."""

from __future__ import annotations

import os
import random
import re
import struct
from pathlib import Path

import pytest
from bare_scenes import loaded
from cli_process import closecall
from guarded import memory_limited
from mcap.data_stream import RecordBuilder
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.writer import Writer
from places import SAMPLES
from rewritten_logs import rewrite

from closecall import __version__
from closecall.formats.log.container.attachments import read_attachment
from closecall.formats.log.container.chunks import Compression
from closecall.formats.log.container.records import chunk_content
from closecall.formats.log.errors import DamagedLogError, LogError
from closecall.formats.log.reader import LogReader, Loss
from closecall.formats.log.result import fold, read_found, read_summary
from closecall.formats.log.writer import LogOptions, LogWriter, Topics
from closecall.formats.scene.loaded import LoadedScene
from closecall.scheduler.model.events import (
    Bound,
    Distance,
    Feature,
    FeatureKind,
    Level,
    PairKey,
    Reason,
    Wakeup,
)
from closecall.scheduler.model.scene import Settings


@pytest.fixture
def scene(tmp_path: Path) -> LoadedScene:
    return loaded(tmp_path, names=("größe", "hammer"), end=10.0)


@pytest.fixture
def log(tmp_path: Path, scene: LoadedScene) -> Path:
    with LogWriter(tmp_path / "out.mcap", scene, Settings(), 1, LogOptions()) as writer:
        for k in range(100):
            time = k / 10
            writer.write(Wakeup(time, PairKey(0, 0, 1), Reason.START, Level.MESH, Bound.SPEED_ACCELERATION, 1.0, 0.1))
    return tmp_path / "out.mcap"


@pytest.fixture(scope="module")
def spinning_bar(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scene = SAMPLES / "spinning_bar" / "scene.yaml"
    path = tmp_path_factory.mktemp("bar") / "bar.mcap"
    assert closecall("run", scene, "-o", path, "-q", "--log", "certificate", cwd=path.parent).returncode == 0
    return path


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

    def failing_run() -> None:
        with writer:
            writer.write(Wakeup(0.0, PairKey(0, 0, 1), Reason.START, Level.MESH, Bound.SPEED_ACCELERATION, 1.0, 0.1))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        failing_run()
    assert ": is unfinished: " in refusal(writer.partial)
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
    for _ in range(1200):
        damaged = bytearray(data)
        place = rng.randrange(len(data)) if rng.random() < 0.5 else rng.randrange(len(data) - 900, len(data))
        damaged[place] ^= 1 << rng.randrange(8)
        log.write_bytes(damaged)
        try:
            assert read_summary(log) == intact
        except LogError as error:
            refusals.append(str(error))
    assert len(refusals) > 120
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


def written(path: Path, scene: LoadedScene, compression: Compression, chunk: int = 200) -> list[int]:
    """Write a log of several chunks; return the log times of its wakeups, in the order of the file."""
    with LogWriter(path, scene, Settings(), 1, LogOptions(compression=compression)) as writer:
        for k in range(5 * chunk):
            if k % chunk == 0:
                writer._chunks.flush()
            writer.write(
                Wakeup(k / 100, PairKey(0, 0, 1), Reason.START, Level.MESH, Bound.SPEED_ACCELERATION, 1.0, 0.1)
            )
    return [k * 10_000_000 for k in range(5 * chunk)]


def read_to_the_end(path: Path, *topics: str) -> tuple[list[int], Loss | None]:
    with LogReader(path) as log:
        return [log_time for _, log_time, _ in log.facts(*topics)], log.loss


@pytest.mark.parametrize("compression", Compression)
def test_all_facts_of_a_topic_come_in_the_order_of_the_file(tmp_path, scene, compression):
    times = written(tmp_path / "o.mcap", scene, compression)
    assert read_to_the_end(tmp_path / "o.mcap", "/wakeups") == (times, None)
    everything, _ = read_to_the_end(tmp_path / "o.mcap")
    with (tmp_path / "o.mcap").open("rb") as file:
        assert everything == [message.log_time for _, _, message in make_reader(file).iter_messages()]


def test_topics_by_body_are_read_by_the_name_they_share(tmp_path, scene):
    point, face = (0.0, 0.0, 0.0), Feature(FeatureKind.FACE, 0, 0, 0)
    with LogWriter(tmp_path / "o.mcap", scene, Settings(), 1, LogOptions(topics=Topics.BODY)) as writer:
        writer.write(Distance(2.0, PairKey(0, 0, 1), 0.5, point, point, face, face))
    assert read_to_the_end(tmp_path / "o.mcap", "/distances") == ([2_000_000_000], None)
    assert read_to_the_end(tmp_path / "o.mcap", "/dist") == ([], None)


@pytest.mark.parametrize("compression", Compression)
def test_a_damaged_chunk_is_passed_over_and_the_rest_read(tmp_path, scene, compression):
    path = tmp_path / "o.mcap"
    times = written(path, scene, compression)
    with path.open("rb") as file:
        index = make_reader(file).get_summary()
    assert index is not None
    chunk = index.chunk_indexes[2]
    data = bytearray(path.read_bytes())
    data[chunk.chunk_start_offset + chunk.chunk_length - 20] ^= 4
    path.write_bytes(data)
    read, loss = read_to_the_end(path, "/wakeups")
    assert read == [time for time in times if not chunk.message_start_time <= time <= chunk.message_end_time]
    assert 0 < len(read) < len(times)
    assert loss is not None
    assert (loss.offset, loss.cut, loss.places, loss.read_to) == (chunk.chunk_start_offset, False, 1, None)
    assert re.match(f"{re.escape(str(path))}: damaged at byte {chunk.chunk_start_offset}: .*a chunk", str(loss))


def test_topics_are_known_by_the_index_where_the_chunk_that_told_of_them_is_lost(tmp_path, scene):
    path = tmp_path / "o.mcap"
    times = written(path, scene, Compression.NONE)
    data = bytearray(path.read_bytes())
    data[data.index(b"/wakeups")] ^= 1
    path.write_bytes(data)
    read, loss = read_to_the_end(path, "/wakeups")
    assert loss is not None
    assert 0 < len(read) < len(times)
    assert read == times[-len(read) :]


def test_a_log_cut_short_is_read_up_to_its_last_whole_chunk(tmp_path, scene):
    path = tmp_path / "o.mcap"
    times = written(path, scene, Compression.ZSTD)
    data = path.read_bytes()
    told = data.index(b"version") + len("version") + 4 + len(__version__)  # all that must be whole
    lengths = set()
    for length in range(len(data) - 1, 0, -61):
        path.write_bytes(data[:length])
        if length < told:
            with pytest.raises(DamagedLogError if length >= 8 else LogError):
                read_to_the_end(path)
            continue
        read, loss = read_to_the_end(path, "/wakeups")
        assert read == times[: len(read)]
        assert loss is not None
        assert loss.cut
        if 0 < len(read) < len(times):
            assert loss.read_to == read[-1] / 1e9
        lengths.add(len(read))
    assert len(lengths) == 6, "whole chunks, or nothing"


def test_a_length_that_lies_takes_no_memory(tmp_path, scene):
    path = tmp_path / "o.mcap"
    written(path, scene, Compression.ZSTD)
    data = path.read_bytes()
    with path.open("rb") as file:
        index = make_reader(file).get_summary()
    assert index is not None
    start = index.chunk_indexes[2].chunk_start_offset
    frame = data.index(b"\x28\xb5\x2f\xfd", start)
    places = {"record": start + 1 + 6, "uncompressed size": start + 9 + 16 + 4, "frame": frame + 6, "data": frame - 3}
    for name, place in places.items():
        damaged = bytearray(data)
        damaged[place] ^= 0x40
        path.write_bytes(damaged)
        with memory_limited():
            read, loss = read_to_the_end(path, "/wakeups")
        assert loss is not None, name
        expected = {"record": (200, start), "data": (1000, 0)}.get(name, (800, start))  # all the data that is there
        assert (len(read), loss.offset) == expected, name


def test_a_frame_that_declares_a_terabyte_is_refused_before_it_is_set_aside():
    frame = struct.pack("<IBQ", 0xFD2FB528, 0xE0, 2**40) + b"\x01\x00\x00"
    chunk = RecordBuilder()
    Chunk("zstd", frame, 0, 0, 0, 100).write(chunk)
    with pytest.raises(ValueError, match="cannot be decompressed"):
        chunk_content(chunk.end()[9:])
    lies = RecordBuilder()
    Chunk("zstd", frame, 0, 0, 0, 2**40).write(lies)
    with pytest.raises(ValueError, match="too large"):
        chunk_content(lies.end()[9:])


def test_what_is_wrong_outside_the_facts_is_told_too(tmp_path, scene):
    path = tmp_path / "o.mcap"
    times = written(path, scene, Compression.ZSTD)
    data = path.read_bytes()
    for phrase, place in (("checksum of the file", data.index(b"closecall: 1")), ("index", len(data) - 50)):
        damaged = bytearray(data)
        damaged[place] ^= 1
        path.write_bytes(damaged)
        read, loss = read_to_the_end(path, "/wakeups")
        assert read == times
        assert loss is not None
        assert phrase in loss.problem


def test_facts_fold_into_the_summary_that_the_log_carries(spinning_bar):
    carried, folded = read_summary(spinning_bar), fold(spinning_bar)
    assert folded.loss is None
    assert folded.lost == {}
    for pair in (*carried["pairs"], *folded.summary["pairs"]):
        pair["distance"]["time"] = round(pair["distance"]["time"] or 0.0, 9)
    assert folded.summary == carried


def test_what_a_cut_log_does_not_say_is_unresolved(spinning_bar, tmp_path):
    path = tmp_path / "cut.mcap"
    rewrite(spinning_bar, path)
    data = path.read_bytes()
    with path.open("rb") as file:
        index = make_reader(file).get_summary()
    assert index is not None
    path.write_bytes(data[: index.chunk_indexes[len(index.chunk_indexes) // 2].chunk_start_offset])
    found = read_found(path)
    assert found.loss is not None
    (pair,) = found.summary["pairs"]
    (lost,) = found.lost.values()
    assert lost[-1][1] == found.summary["time"][1]
    assert [list(gap) for gap in lost] == [gap for gap in pair["unresolved"] if tuple(gap) in lost]
    assert pair["distance"]["lower"] == 0.0


def test_the_summary_is_found_without_an_index_too(log):
    intact = read_summary(log)
    log.write_bytes(log.read_bytes()[:-10])
    found = read_found(log)
    assert found.summary == intact
    assert found.loss is not None
    assert "index" in found.loss.problem


def test_logs_that_say_less_of_their_run_are_read_too(log, tmp_path):
    """As those of versions did that knew no margins of pairs in their logs."""
    newer = {"margins", "exists", "chord_errors", "count/ignored", "length_unit"}
    path = tmp_path / "older.mcap"
    rewrite(log, path, metadata=lambda name, values: {key: values[key] for key in values.keys() - newer})
    with LogReader(path) as reader:
        assert reader.identity.margin("größe", "hammer") == 0.0
        assert reader.identity.shared_time("größe", "hammer") == (0.0, 10.0)
        assert reader.identity.length_unit == "m"
    folded = fold(path)
    assert folded.loss is None
    assert [pair["pair"] for pair in folded.summary["pairs"]] == ["größe|hammer"]
