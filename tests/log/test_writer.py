"""The log as a file: what readers find in it, and what is left where a run does not end well."""

from __future__ import annotations

import hashlib
import json
import math
import os
import subprocess
import sys
import tracemalloc
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bare_scenes import loaded
from mcap.reader import make_reader
from mcap.records import Chunk, DataEnd, Header, Message
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap_protobuf.decoder import DecoderFactory
from places import HELPERS

from closecall import __version__
from closecall.formats.log import messages_pb2 as pb
from closecall.formats.log.container.chunks import CHUNK_BYTES, Compression
from closecall.formats.log.writer import LogOptions, LogWriter
from closecall.formats.scene.loaded import LoadedScene
from closecall.scheduler.model.events import (
    Bound,
    Collision,
    ContactKind,
    Distance,
    Event,
    Feature,
    FeatureKind,
    Level,
    PairKey,
    Phase,
    Reason,
    Span,
    Verdict,
    Wakeup,
)
from closecall.scheduler.model.scene import Settings

PAIR = PairKey(0, 0, 1)
FEATURE_A = Feature(FeatureKind.EDGE, 1, 12, 2)
FEATURE_B = Feature(FeatureKind.FACE, 0, 7, 0)
OPEN_MESH = "open mesh: surface only"


def wakeup(time: float) -> Wakeup:
    return Wakeup(time, PAIR, Reason.KNOT, Level.SPHERE, Bound.DISPLACEMENT, 0.25, 0.5)


def distance(time: float) -> Distance:
    return Distance(time, PAIR, 0.125, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0), FEATURE_A, FEATURE_B)


def collision(phase: Phase, clear: float, touching: float) -> Collision:
    point = (1.0, 0.0, -1.0)
    return Collision(PAIR, phase, clear, touching, ContactKind.SURFACE, FEATURE_A, FEATURE_B, point)


EVENTS: tuple[Event, ...] = (
    wakeup(0.0),
    distance(0.1 + 0.2),
    collision(Phase.BEGIN, 1.0, 1.25),
    Span(PAIR, Verdict.CLEAR, 0.0, 1.0, 0.0625, 0.0),
    wakeup(1e5 + 1e-9),
    collision(Phase.END, 2.5, 2.25),
    Span(PAIR, Verdict.CONTACT, 1.0, 2.5, 0.0, math.nan),
    Span(PAIR, Verdict.CLEAR, 2.5, 1e6, 0.0625, 0.0),
)


def write(path: Path, scene: LoadedScene, events=EVENTS, **options: Any) -> Path:
    with LogWriter(path, scene, scene.settings, 1, LogOptions(**options)) as log:
        for event in events:
            log.write(event)
    return path


def decoded(path: Path) -> Iterator[tuple[str, Any, Any]]:
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        for _, channel, record, message in reader.iter_decoded_messages():
            yield channel.topic, record, message


def messages(path: Path, topic: str) -> list[Any]:
    return [message for name, _, message in decoded(path) if name == topic]


def attachments(path: Path) -> dict[str, bytes]:
    with path.open("rb") as file:
        return {entry.name: entry.data for entry in make_reader(file).iter_attachments()}


def metadata(path: Path) -> dict[str, dict[str, str]]:
    with path.open("rb") as file:
        return {entry.name: entry.metadata for entry in make_reader(file).iter_metadata()}


@pytest.mark.parametrize("compression", list(Compression))
def test_readers_find_every_fact_under_every_compression(tmp_path, compression):
    log = write(tmp_path / "out.mcap", loaded(tmp_path, warnings=(OPEN_MESH,)), compression=compression)
    topics = Counter(topic for topic, _, _ in decoded(log))
    assert topics == {"/wakeups": 2, "/distances": 1, "/collisions": 2, "/spans": 3, "/log": 5}
    assert set(tmp_path.iterdir()) == {log, tmp_path / "scene.yaml"}


def test_data_section_and_chunks_pass_their_checksums(tmp_path):
    log = write(tmp_path / "out.mcap", loaded(tmp_path, meshes=(b"solid",)))
    with log.open("rb") as file:
        records = list(StreamReader(file, validate_crcs=True).records)
    assert isinstance(records[0], Header)
    assert records[0].library == f"closecall {__version__}"
    (end,) = (record for record in records if isinstance(record, DataEnd))
    assert end.data_section_crc != 0


def test_messages_say_what_the_events_said(tmp_path):
    log = write(tmp_path / "out.mcap", loaded(tmp_path))
    woke = messages(log, "/wakeups")[0]
    assert (woke.pair, woke.pair_id, woke.body_a, woke.body_b) == ("gear|hammer", 0, "gear", "hammer")
    assert (woke.bound, woke.clearance, woke.sleep) == ("displacement", 0.25, 0.5)
    assert (woke.reason, woke.level) == (pb.Wakeup.Reason.KNOT, pb.Wakeup.Level.SPHERE)
    (measured,) = messages(log, "/distances")
    assert measured.distance == 0.125
    assert (measured.witness_b.x, measured.witness_b.y, measured.witness_b.z) == (4.0, 5.0, 6.0)
    feature = measured.feature_a
    assert (feature.kind, feature.shape, feature.triangle, feature.index) == (pb.Feature.EDGE, 1, 12, 2)
    begin, end = messages(log, "/collisions")
    assert (begin.phase, begin.kind) == (pb.Collision.Phase.BEGIN, pb.Collision.Kind.SURFACE)
    assert (begin.time_clear, begin.time_touching, end.time_touching, end.time_clear) == (1.0, 1.25, 2.25, 2.5)
    assert (end.phase, end.triangle_a, end.triangle_b, end.shape_a, end.point.z) == (
        pb.Collision.Phase.END,
        12,
        7,
        1,
        -1.0,
    )
    first, second, _ = messages(log, "/spans")
    assert (first.verdict, first.start, first.end, first.clearance) == (pb.Span.CLEAR, 0.0, 1.0, 0.0625)
    assert second.verdict == pb.Span.CONTACT
    assert math.isnan(second.depth_limit)


@pytest.mark.parametrize("epoch", [0, 1_767_225_600_000_000_001])
def test_times_are_the_facts_own_to_the_nanosecond(tmp_path, epoch):
    log = write(tmp_path / "out.mcap", loaded(tmp_path), epoch=epoch)
    wanted = sorted(round(Fraction(event.time) * 10**9) + epoch for event in EVENTS)
    found = []
    for topic, record, message in decoded(log):
        assert record.publish_time == record.log_time
        assert message.timestamp.ToNanoseconds() == record.log_time
        if topic != "/log":
            found.append(record.log_time)
    assert found == wanted
    spans = messages(log, "/spans")
    assert [span.end for span in spans] == [1.0, 2.5, 1e6], "doubles are scene seconds, without the epoch"


def test_chunks_are_sorted_within_and_of_the_agreed_size(tmp_path):
    order = np.random.default_rng(0).permutation(40_000)
    log = write(tmp_path / "out.mcap", loaded(tmp_path), [wakeup(float(k) / 64) for k in order])
    sizes = []
    with log.open("rb") as file:
        for chunk in StreamReader(file, emit_chunks=True).records:
            if isinstance(chunk, Chunk):
                times = [r.log_time for r in breakup_chunk(chunk, validate_crc=True) if isinstance(r, Message)]
                assert times == sorted(times)
                sizes.append(chunk.uncompressed_size)
    assert len(sizes) > 5
    assert all(256 * 1024 <= size <= 1024 * 1024 for size in sizes[:-1])
    delivered = [record.log_time for _, record, _ in decoded(log)]
    assert delivered == sorted(delivered)
    with log.open("rb") as file:
        reader = make_reader(file)
        numbers = [r.sequence for _, _, r in reader.iter_messages(topics="/wakeups", log_time_order=False)]
    assert sorted(numbers) == list(range(1, 40_001)), "sequence numbers tell the order of discovery, without gap"


def test_channels_exist_only_with_messages_and_schemas_once(tmp_path):
    log = write(tmp_path / "out.mcap", loaded(tmp_path), [wakeup(1.0), wakeup(2.0)])
    with log.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert {channel.topic for channel in summary.channels.values()} == {"/log", "/wakeups"}
    assert sorted(schema.name for schema in summary.schemas.values()) == ["closecall.Wakeup", "foxglove.Log"]


def test_log_topic_tells_start_warnings_collisions_and_end(tmp_path):
    scene = loaded(tmp_path, warnings=(OPEN_MESH,))
    with LogWriter(tmp_path / "out.mcap", scene, scene.settings, 1, LogOptions()) as log:
        log.warn("late warning", 7.0)
        for event in EVENTS:
            log.write(event)
    told = messages(tmp_path / "out.mcap", "/log")
    levels = [message.Level.Name(message.level) for message in told]
    assert levels == ["INFO", "WARNING", "ERROR", "INFO", "WARNING", "INFO"]
    assert "2 bodies, 1 pairs" in told[0].message
    assert told[1].message == OPEN_MESH
    assert "gear|hammer: contact begins" in told[2].message
    assert (told[4].message, told[4].timestamp.seconds) == ("late warning", 7)
    assert "1 contact" in told[-1].message


def test_log_carries_its_inputs_and_summary(tmp_path):
    scene = loaded(tmp_path, meshes=(b"solid one", b"solid two", b"solid one"))
    settings = Settings(time_resolution=2e-3)
    with LogWriter(tmp_path / "out.mcap", scene, settings, 1, LogOptions(epoch=5)) as log:
        for event in EVENTS:
            log.write(event)
        summary = log.summary()
    carried = attachments(tmp_path / "out.mcap")
    assert carried.pop("scene") == scene.source
    assert json.loads(carried.pop("settings.json"))["time_resolution"] == 2e-3
    assert json.loads(carried.pop("summary.json")) == summary
    assert carried == {f"mesh/{hashlib.sha256(data).hexdigest()}": data for data in (b"solid one", b"solid two")}
    records = metadata(tmp_path / "out.mcap")
    identity = records["closecall"]
    assert list(identity) == sorted(identity)
    assert identity["scene_sha256"] == hashlib.sha256(scene.source).hexdigest()
    assert identity["mesh/part_2"] == hashlib.sha256(b"solid one").hexdigest()
    assert (identity["start"], identity["end"], identity["epoch"]) == ("0.0", "1000000.0", "5")
    assert (identity["count/spans"], identity["count/wakeups"], identity["version"]) == ("3", "2", __version__)
    assert json.loads(identity["settings"])["time_resolution"] == 2e-3
    assert records["closecall/start"].items() < identity.items()


def test_meshes_can_stay_out_but_their_hashes_stay(tmp_path):
    scene = loaded(tmp_path, meshes=(b"solid",))
    scene.mesh_files[0].path.unlink()
    log = write(tmp_path / "out.mcap", scene, attach_meshes=False)
    assert set(attachments(log)) == {"scene", "settings.json", "summary.json"}
    assert metadata(log)["closecall"]["mesh/part_0"] == scene.mesh_files[0].sha256


@pytest.mark.parametrize("compression", list(Compression))
def test_same_events_give_the_same_bytes_whatever_the_hash_seed(tmp_path, compression):
    script = (
        "import sys; sys.path[:0] = sys.argv[1:3]; import test_writer as t; from pathlib import Path; "
        "f = Path(sys.argv[3]); s = t.loaded(f, meshes=(b'one', b'two')); "
        f"t.write(f / 'out.mcap', s, t.EVENTS * 5000, compression=t.Compression.{compression.name})"
    )
    hashes = set()
    for seed in ("0", "1", "4242"):
        folder = tmp_path / seed
        folder.mkdir()
        command = [sys.executable, "-c", script, str(Path(__file__).parent), str(HELPERS), str(folder)]
        subprocess.run(command, check=True, env=os.environ | {"PYTHONHASHSEED": seed})
        hashes.add(hashlib.sha256((folder / "out.mcap").read_bytes()).hexdigest())
    assert len(hashes) == 1


def test_memory_does_not_grow_with_the_log(tmp_path):
    scene = loaded(tmp_path)
    with LogWriter(tmp_path / "out.mcap", scene, Settings(), 1, LogOptions()) as log:
        for k in range(20_000):
            log.write(wakeup(float(k)))
        tracemalloc.start()
        for k in range(20_000, 60_000):
            log.write(wakeup(float(k)))
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    assert peak < 12 * CHUNK_BYTES


def test_the_remedy_for_times_before_zero_works(tmp_path):
    scene = loaded(tmp_path, start=-1.5)
    log = write(tmp_path / "out.mcap", scene, epoch=1_500_000_000)
    assert next(record.log_time for _, record, _ in decoded(log)) == 0
