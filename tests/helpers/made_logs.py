"""Small logs built record by record, with right checksums: as the writer would, or wrong in their structure.

Nothing here is closecall's own but the types of its messages, so that what it refuses to write can be written too.
"""

from __future__ import annotations

import json
import zlib
from dataclasses import dataclass, field
from itertools import combinations, pairwise
from random import Random
from typing import Any

import lz4.frame
import zstandard
from foxglove_schemas_protobuf.CubePrimitive_pb2 import CubePrimitive
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    DataEnd,
    Header,
    Message,
    Metadata,
    Schema,
    Statistics,
)
from mcap.writer import MCAP0_MAGIC

from closecall.formats.log import messages_pb2 as pb

NAMES = ("arm", "wall", "post", "ball")
START, END = 0.0, 4.0

SCHEMAS = {
    "/wakeups": "closecall.Wakeup",
    "/distances": "closecall.Distance",
    "/distances/arm": "closecall.Distance",
    "/collisions": "closecall.Collision",
    "/spans": "closecall.Span",
    "/windows": "closecall.Window",
    "/world": "closecall.World",
    "/tf": "foxglove.FrameTransforms",
    "/scene/meshes": "foxglove.SceneUpdate",
    "/scene/boxes": "foxglove.SceneUpdate",
    "/viz/clearance": "foxglove.SceneUpdate",
    "/log": "foxglove.Log",
}


@dataclass
class Fact:
    """A message as it will stand in the log; `data`, where there is any, takes the place of the message's own bytes."""

    topic: str
    log_time: int
    message: Any
    data: bytes | None = None

    def bytes(self) -> bytes:
        return self.message.SerializeToString() if self.data is None else self.data


@dataclass
class MadeLog:
    """A log in the making; `bytes` builds it.

    Attributes:
        start, end: the values of the two metadata records, None to leave one out.
        schemas: of each topic: the schema's name and encoding, and the encoding of the messages.
        chunks: facts, chunk by chunk.
        attachments: name, media type, data.
        compression: of the chunks.
    """

    start: dict[str, str] | None
    end: dict[str, str] | None
    schemas: dict[str, tuple[str, str, str]]
    chunks: list[list[Fact]]
    attachments: list[tuple[str, str, bytes]]
    compression: str = "zstd"
    chunk_changes: dict[str, Any] = field(default_factory=dict)
    index_changes: dict[str, int] = field(default_factory=dict)
    footer_changes: dict[str, int] = field(default_factory=dict)
    extra: list[tuple[int, bytes]] = field(default_factory=list)
    inner: bytes = b""
    swapped: bool = False
    with_index: bool = True

    def facts(self) -> list[Fact]:
        return [fact for chunk in self.chunks for fact in chunk]

    def bytes(self) -> bytes:
        records = [_record(Header(profile="", library="made"))]
        records += [] if self.start is None else [_record(Metadata("closecall/start", self.start))]
        attached = [_record(_attachment(*one)) for one in self.attachments]
        records += attached[:1]
        ids = {topic: number for number, topic in enumerate(self.schemas, start=1)}
        told: set[str] = set()
        for facts in self.chunks:
            records.append(self._chunk(facts, ids, told))
        records += [_framed(opcode, body) for opcode, body in self.extra]
        records += [] if self.end is None else [_record(Metadata("closecall", self.end))]
        records += attached[1:]
        if self.swapped:
            records[1], records[-1] = records[-1], records[1]
        data = MCAP0_MAGIC + b"".join(records)
        data += _record(DataEnd(zlib.crc32(data)))
        begins = len(data)
        index = self._index(records, ids) if self.with_index else b""
        footer = {"summary_start": begins if index else 0, "summary_offset_start": 0} | self.footer_changes
        tail = index + Opcode.FOOTER.to_bytes(1, "little") + (20).to_bytes(8, "little")
        tail += footer["summary_start"].to_bytes(8, "little") + footer["summary_offset_start"].to_bytes(8, "little")
        return data + tail + zlib.crc32(tail).to_bytes(4, "little") + MCAP0_MAGIC

    def _schema_records(self, topic: str, ids: dict[str, int]) -> bytes:
        name, encoding, messages = self.schemas[topic]
        number = ids[topic]
        schema = _record(Schema(number, b"", encoding, name)) if name else b""
        return schema + _record(Channel(number, topic, messages, {}, number if name else 0))

    def _chunk(self, facts: list[Fact], ids: dict[str, int], told: set[str]) -> bytes:
        inner = b""
        for sequence, fact in enumerate(facts):
            if fact.topic not in told:
                told.add(fact.topic)
                inner += self._schema_records(fact.topic, ids)
            inner += _record(Message(ids[fact.topic], fact.log_time, fact.bytes(), fact.log_time, sequence))
        inner += self.inner
        data = compressed(self.compression, inner)
        times = [fact.log_time for fact in facts] or [0]
        fields = {
            "compression": "lz4" if self.compression == "lz4 without size" else self.compression,
            "data": data,
            "message_start_time": min(times),
            "message_end_time": max(times),
            "uncompressed_crc": zlib.crc32(inner),
            "uncompressed_size": len(inner),
        }
        return _record(Chunk(**(fields | self.chunk_changes)))

    def _index(self, records: list[bytes], ids: dict[str, int]) -> bytes:
        out = b"".join(self._schema_records(topic, ids) for topic in self.schemas)
        offset = len(MCAP0_MAGIC)
        for record in records:
            if record[0] == Opcode.ATTACHMENT:
                name = record[29 : 29 + int.from_bytes(record[25:29], "little")].decode(errors="replace")
                fields = {"offset": offset, "length": len(record), "data_size": 0} | self.index_changes
                out += _record(AttachmentIndex(create_time=0, media_type="", log_time=0, name=name, **fields))
            offset += len(record)
        count = len(self.facts())
        statistics = Statistics(len(self.attachments), len(ids), {}, len(self.chunks), count, 2**63, 0, 2, len(ids))
        return out + _record(statistics)


def compressed(kind: str, data: bytes) -> bytes:
    if kind == "zstd":
        return zstandard.ZstdCompressor().compress(data)
    if kind.startswith("lz4"):
        return lz4.frame.compress(data, store_size=kind == "lz4")
    return data


def _record(record: Any) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()


def _framed(opcode: int, body: bytes) -> bytes:
    return opcode.to_bytes(1, "little") + len(body).to_bytes(8, "little") + body


def _attachment(name: str, media_type: str, data: bytes) -> Attachment:
    return Attachment(create_time=0, log_time=0, name=name, media_type=media_type, data=data)


def sound_log(rng: Random) -> MadeLog:
    """Return a log in which nothing is wrong."""
    epoch = rng.choice((0, 0, 10**18))
    facts = _facts(rng, epoch)
    facts.sort(key=lambda fact: fact.log_time)
    cut = rng.randrange(len(facts))
    values = _values(epoch)
    return MadeLog(
        start=values,
        end=dict(values),
        schemas={topic: (name, "protobuf", "protobuf") for topic, name in SCHEMAS.items()},
        chunks=[facts[:cut], facts[cut:]],
        attachments=[("scene", "application/yaml", b"closecall: 1\n"), ("mesh/0", "", bytes(100))],
        compression=rng.choice(("", "zstd", "lz4", "lz4 without size")),
    )


def _values(epoch: int) -> dict[str, str]:
    settings = {"contact_tolerance": 1e-6, "distance_tolerance": 0.01, "margin": 0.0, "time_resolution": 0.001}
    return {
        "version": "0.1.0",
        "scene_sha256": "0" * 64,
        "settings": json.dumps(settings),
        "start": repr(START),
        "end": repr(END),
        "epoch": str(epoch),
        "count/bodies": str(len(NAMES)),
        "count/pairs": "6",
        "count/ignored": "0",
        "chord_errors": '{"arm": 0.001}',
        "exists": '{"ball": [0.0, 3.5]}',
        "margins": '[[["arm"], ["wall", "post"], 0.01]]',
        "length_unit": "m",
        "mesh/0": "0" * 64,
    }


def _facts(rng: Random, epoch: int) -> list[Fact]:
    facts: list[Fact] = []

    def add(topic: str, time: float, message: Any) -> None:
        log_time = epoch + round(time * 1e9)
        message.timestamp.seconds, message.timestamp.nanos = divmod(log_time, 10**9) if topic != "/tf" else (0, 0)
        facts.append(Fact(topic, log_time, message))

    for rank, (a, b) in enumerate(combinations(range(4), 2)):
        pair = {"pair": f"{NAMES[a]}|{NAMES[b]}", "pair_id": rank, "body_a": NAMES[a], "body_b": NAMES[b]}
        times = [START, *sorted(round(rng.uniform(START, END), 3) for _ in range(rng.randrange(3))), END]
        for first, last in pairwise(times):
            verdict = rng.choice((1, 1, 1, 2, 3, 4, 5))
            clearance = rng.uniform(0.0, 2.0) if verdict in (1, 2) else 0.0
            depth = float("nan") if verdict == 3 else 0.0
            span = {"verdict": verdict, "start": first, "end": last, "clearance": clearance, "depth_limit": depth}
            add("/spans", last, pb.Span(**pair, **span))
            if verdict == 3:
                touch = {"time_clear": first, "time_touching": first, "kind": 1, "point": {"x": 1.0}}
                begin, finish = pb.Collision.Phase.BEGIN, pb.Collision.Phase.END
                add("/collisions", first, pb.Collision(**pair, phase=begin, key_before_a="home", **touch))
                over = {"time_clear": last, "time_touching": last, "kind": 1, "point": {"y": -1.0}}
                add("/collisions", last, pb.Collision(**pair, phase=finish, **over))
        for time in times:
            woken = {"reason": rng.randrange(1, 10), "level": rng.choice((1, 3)), "bound": "displacement"}
            add("/wakeups", time, pb.Wakeup(**pair, clearance=rng.uniform(0.0, 3.0), sleep=0.25, **woken))
            measured = pb.Distance(**pair, distance=rng.uniform(2.0, 3.0), witness_a={"x": 1.0}, witness_b={"y": -2.0})
            measured.feature_a.kind = pb.Feature.VERTEX
            add("/distances/arm" if a == 0 and rank % 2 else "/distances", time, measured)
    for name in NAMES:
        box = {"box_min": {"x": -1.0}, "box_max": {"x": 1.0, "y": 1.0, "z": 1.0}}
        add("/windows", START, pb.Window(body=name, start=START, end=END, **box))
    for tick in range(4):
        near = [{"pair": "arm|wall", "distance": 0.5, "verdict": "CLEAR"}]
        add("/world", tick, pb.World(min_distance=0.5, pair="arm|wall", contacts=0, pairs=near))
        place, turn = Vector3(x=tick / 2), Quaternion(w=1.0)
        frame = FrameTransform(parent_frame_id="world", child_frame_id="arm", translation=place, rotation=turn)
        facts.append(Fact("/tf", epoch + tick * 10**9, FrameTransforms(transforms=[frame])))
        line = LinePrimitive(points=[Point3(x=0.0), Point3(x=1.0)])
        shown = SceneUpdate(entities=[SceneEntity(id="arm|wall", frame_id="world", lines=[line])])
        facts.append(Fact("/viz/clearance", epoch + tick * 10**9, shown))
    facts += [Fact("/scene/meshes", epoch, _bodies()), Fact("/scene/boxes", epoch, _bodies())]
    add("/log", START, Log(level=Log.WARNING, message="arm: a warning", name="closecall"))
    return facts


def _bodies() -> SceneUpdate:
    pose = Pose(position=Vector3(x=1.0), orientation=Quaternion(w=1.0))
    size = Vector3(x=1.0, y=1.0, z=1.0)
    mesh = TriangleListPrimitive(pose=pose, points=[Point3(x=0.0), Point3(x=1.0), Point3(y=1.0)], indices=[0, 1, 2])
    arm = SceneEntity(id="arm", frame_id="arm", triangles=[mesh])
    wall = SceneEntity(id="wall", frame_id="world", cubes=[CubePrimitive(pose=pose, size=size)])
    ball = SceneEntity(id="ball", frame_id="world", spheres=[SpherePrimitive(pose=pose, size=size)])
    return SceneUpdate(entities=[arm, wall, ball])
