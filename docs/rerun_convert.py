"""Turn a closecall log into a Rerun recording, then ask the recording for its collisions and print them.

    pip install 'rerun-sdk[catalog]>=0.41'
    python docs/rerun_convert.py bar.mcap bar.rrd

Rerun reads the MCAP by itself: every topic becomes an entity with its messages as they are, /tf moves frames, /log is
text. What it does not draw is added here: the bodies' meshes, and distances as curves.
"""

from __future__ import annotations

import json
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

try:
    import datafusion  # noqa: F401  (the queries of rerun's catalog need it)
    import numpy as np
    import pyarrow as pa
    import rerun as rr
    import rerun.blueprint as rrb
    from foxglove_schemas_protobuf.Pose_pb2 import Pose
    from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
    from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
    from mcap.reader import make_reader
    from rerun.chunk import Chunk, McapReader, RrdReader

    from closecall.formats.log.messages_pb2 import Distance, World
except ImportError as missing:
    sys.exit(f"{missing}: this script needs closecall, and pip install 'rerun-sdk[catalog]>=0.41'")

TIMELINE = "message_log_time"
"""What Rerun calls MCAP's log times: simulation time, plus the run's --epoch."""

NUMBER = "message"
"""A second timeline, that counts the messages of each topic.

A query gives one row for each entity and time, the last: of two contacts that begin in the same ns it would lose one.
"""

COLLISION = "/collisions:closecall.Collision:message"
"""The column of a topic's messages: entity, then type."""


def convert(log: Path, recording: Path) -> None:
    """Write the recording of a log."""
    scene = rrb.Spatial3DView(origin="/", spatial_information=rrb.SpatialInformation(target_frame="world"))
    plot = rrb.TimeSeriesView(origin="/", contents=["/least_distance", "/distance/**"])
    views = rrb.Horizontal(scene, rrb.Vertical(plot, rrb.TextLogView(origin="/log")))
    with rr.RecordingStream("closecall", recording_id=log.stem) as stream:
        stream.save(recording, default_blueprint=rrb.Blueprint(views))
        stream.send_chunks(McapReader(log, timeline_type="duration_ns").stream().flat_map(Numbers()))
        log_bodies(stream, log)
        log_distances(stream, log)


class Numbers:
    """Gives every message its number in its topic, as a time on the timeline `NUMBER`."""

    def __init__(self) -> None:
        """Start every topic at 0."""
        self._next: Counter[str] = Counter()

    def __call__(self, chunk: Chunk) -> list[Chunk]:
        """Return a chunk of messages with their numbers; what has no time has no number."""
        if chunk.is_static:
            return [chunk]
        first = self._next[chunk.entity_path]
        self._next[chunk.entity_path] += chunk.num_rows
        numbers = pa.array(range(first, first + chunk.num_rows), pa.int64())
        batch = chunk.to_record_batch().append_column(NUMBER, numbers)
        return Chunk.from_record_batch(batch, index=[*chunk.timeline_names, NUMBER])


def collisions(recording: Path) -> list[dict[str, Any]]:
    """Query a recording for its collisions, in order of time."""
    store = RrdReader(recording).stream().collect()
    rows = store.reader(NUMBER, contents="/collisions").sort(NUMBER).to_pylist()
    return [collision for row in rows for collision in row[COLLISION] or ()]


def messages(log: Path, topic: str, kind: type[Any]) -> Iterator[tuple[int, Any]]:
    """Yield the messages of a topic, each with its log time, ns."""
    with log.open("rb") as stream:
        for _, _, message in make_reader(stream).iter_messages(topics=[topic]):
            yield message.log_time, kind.FromString(message.data)


def log_bodies(stream: rr.RecordingStream, log: Path) -> None:
    """Log the shapes of the bodies while they exist: each message tells of all that do from then on."""
    there: set[str] = set()
    for time, update in messages(log, "/scene/meshes", SceneUpdate):
        stream.set_time(TIMELINE, duration=np.timedelta64(time, "ns"))
        now = {entity.id: entity for entity in update.entities}
        for gone in there - now.keys():
            stream.log(["bodies", gone], rr.Clear(recursive=True))
        for name in now.keys() - there:
            log_body(stream, now[name])
        there = set(now)
    stream.reset_time()


def log_body(stream: rr.RecordingStream, entity: SceneEntity) -> None:
    """Log the shapes of a body in its frame."""
    path = ["bodies", entity.id]
    stream.log(path, rr.CoordinateFrame(entity.frame_id))
    for index, mesh in enumerate(entity.triangles):
        points = np.array([(point.x, point.y, point.z) for point in mesh.points])
        colour = (mesh.color.r, mesh.color.g, mesh.color.b, mesh.color.a)
        shape = rr.Mesh3D(
            vertex_positions=placed(points, mesh.pose),
            triangle_indices=np.array(mesh.indices).reshape(-1, 3),
            albedo_factor=colour,
        )
        stream.log([*path, f"mesh_{index}"], rr.CoordinateFrame(entity.frame_id), shape)
    for index, ball in enumerate(entity.spheres):
        shape = rr.Ellipsoids3D(
            half_sizes=[(0.5 * ball.size.x, 0.5 * ball.size.y, 0.5 * ball.size.z)],
            centers=placed(np.zeros((1, 3)), ball.pose),
            colors=[(ball.color.r, ball.color.g, ball.color.b, ball.color.a)],
            fill_mode="solid",
        )
        stream.log([*path, f"sphere_{index}"], rr.CoordinateFrame(entity.frame_id), shape)
    for index, box in enumerate(entity.cubes):
        turn = box.pose.orientation
        shape = rr.Boxes3D(
            sizes=[(box.size.x, box.size.y, box.size.z)],
            centers=placed(np.zeros((1, 3)), box.pose),
            quaternions=[(turn.x, turn.y, turn.z, turn.w)],
            colors=[(box.color.r, box.color.g, box.color.b, box.color.a)],
            fill_mode="solid",
        )
        stream.log([*path, f"box_{index}"], rr.CoordinateFrame(entity.frame_id), shape)


def log_distances(stream: rr.RecordingStream, log: Path) -> None:
    """Log every pair's measured distances, m, and the least of all, as curves over time."""
    curves: dict[tuple[str, ...], list[tuple[int, float]]] = defaultdict(list)
    for _, message in messages(log, "/distances", Distance):
        curves["distance", message.pair].append((message.timestamp.ToNanoseconds(), message.distance))
    for _, message in messages(log, "/world", World):
        curves["least_distance",].append((message.timestamp.ToNanoseconds(), message.min_distance))
    for path, curve in curves.items():
        times, values = zip(*curve, strict=True)
        index = rr.TimeColumn(TIMELINE, duration=np.array(times, dtype="timedelta64[ns]"))
        stream.send_columns(rr.new_entity_path(list(path)), [index], rr.Scalars.columns(scalars=values))


def placed(points: np.ndarray, pose: Pose) -> np.ndarray:
    """Return points (n, 3) where a pose puts them."""
    turn, shift = pose.orientation, pose.position
    axis = np.array((turn.x, turn.y, turn.z))
    across = 2.0 * np.cross(axis, points)
    return points + turn.w * across + np.cross(axis, across) + (shift.x, shift.y, shift.z)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: python docs/rerun_convert.py LOG RECORDING")
    source, target = map(Path, sys.argv[1:])
    if not source.is_file():
        sys.exit(f"{source}: there is no such log")
    convert(source, target)
    for found in collisions(target):
        found["phase"], found["kind"] = found["phase"]["name"], found["kind"]["name"]
        print(json.dumps(found))
