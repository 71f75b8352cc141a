"""A run as viewers see it: the bodies while they exist, and what every snapshot tells of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from math import nan

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.timestamp_pb2 import Timestamp
from numpy.typing import NDArray

from ....scheduler.geometry.arrays import FloatArray
from ....scheduler.model.body_tree import ancestors
from ....scheduler.model.events import Collision, Nearness, PairKey, Phase, Snapshot, Verdict
from ....scheduler.model.scene import Scene
from ....scheduler.model.world_poses import WorldPoses
from ....scheduler.motions import Fixed
from ....scheduler.snapshots.schedule import changes_of_existence
from ....scheduler.snapshots.snapshot import existing
from .. import messages_pb2 as pb
from ..container.chunks import Channel
from ..summary import SEVERITY, Summary
from .camera import camera
from .colours import AMBER, RED
from .drawings import Drawings
from .entities import BodyEntities, Look
from .layout import CloseUp, layout
from .markers import CallOuts, MarkerSizes, clearances, contact, names
from .transforms import TransformPacker
from .view_extent import reach
from .wire import Pieces, timestamp, update_in_pieces

_SEVERITY = [verdict.name.lower() for verdict in SEVERITY]

# How far a close-up is from its pair, in the pair's bodies' size and distance.
_CLOSE_UP = 5.0

# Moving bodies with shapes. More of them do not bear their names, which would hide what they name.
_MOST_NAMED = 12

# Moving bodies. The rest have no frame on /tf and no entity on /scene/meshes: Foxglove Studio goes through all frames
# for every picture, and blocks for minutes where there are thousands.
_MOST_FRAMES = 500


@dataclass(frozen=True, slots=True)
class ViewerOptions:
    """How much viewers get.

    Attributes:
        pairs: how many of the nearest pairs are told and drawn, at most.
        triangles: of the bodies' drawings in all; bodies that do not fit are drawn as their boxes. All are drawn anew
            whenever one appears or vanishes.
    """

    pairs: int = 10
    triangles: int = 1_000_000


class Viewer:
    """Turns a run into messages for viewers: pairs of a channel and a message's bytes.

    Attributes:
        channels: all that it writes to.
        remarks: what is not drawn as it is, in words.
    """

    def __init__(self, scene: Scene, options: ViewerOptions) -> None:
        """Take the scene and how much of it to show."""
        bodies = scene.bodies
        self._scene = scene
        self._changes = frozenset(changes_of_existence(scene))
        self._options = options
        self._bodies = bodies
        self._names = tuple(body.name for body in bodies)
        moving = [
            any(not isinstance(bodies[i].motion, Fixed) for i in ancestors(bodies, k)) for k in range(len(bodies))
        ]
        self._frames = [index for index, moves in enumerate(moving) if moves][:_MOST_FRAMES]
        self._packer = self._packer_of(self._frames)
        self._poses_at_start = WorldPoses(bodies).at(scene.start)
        drawings = Drawings(bodies)
        seen = reach(scene, drawings.outlines, moving)
        self._view = camera(seen)
        self._sizes = MarkerSizes(seen.size)
        framed = set(self._frames)
        look = Look(
            framed=[index in framed for index in range(len(bodies))],
            triangles=options.triangles,
            size=seen.size,
            top=float(seen.high[2]),
        )
        self._entities = BodyEntities(scene, moving, self._poses_at_start, drawings, look)
        self._meshes = Channel("/scene/meshes", SceneUpdate)
        self._tf = Channel("/tf", FrameTransforms)
        self._world = Channel("/world", pb.World)
        self._clearance = Channel("/viz/clearance", SceneUpdate)
        self._contacts = Channel("/viz/contacts", SceneUpdate)
        self._tags = Channel("/viz/names", SceneUpdate)
        named = [index for index in self._frames if bodies[index].shapes]
        self._named = named if len(named) <= _MOST_NAMED else []
        self._boxes = Channel("/scene/boxes", SceneUpdate)
        drawn = [self._meshes, self._clearance, self._contacts]
        drawn += [self._tags] * bool(self._named) + [self._boxes] * (self._entities.crowd is not None)
        self.channels: tuple[Channel, ...] = (self._tf, self._world, *drawn)
        self.remarks = self._remarks()
        self._layout = partial(layout, seen, self._view, [channel.name for channel in drawn])

    def layout(self, summary: Summary) -> bytes:
        """Return the Foxglove layout that fits the scene and what was found, as JSON."""
        return self._layout(self._close_up(summary))

    def opening(self, log_time: int) -> Iterator[tuple[Channel, Pieces]]:
        """Yield the bodies and where they are at the start, `log_time` in ns: without ticks, all that is known."""
        there = existing(self._scene, self._scene.start)
        yield self._meshes, (self._entities.all(timestamp(log_time), there),)
        yield from self._placed(self._poses_at_start, there, timestamp(log_time))

    def shown(self, snapshot: Snapshot, log_time: int) -> Iterator[tuple[Channel, Pieces]]:
        """Yield what a snapshot shows, at `log_time` in ns, whatever was shown before."""
        stamp = timestamp(log_time)
        if snapshot.trigger is not None:
            frames = self._frames_of(snapshot.trigger.pair)
            if frames:
                yield self._tf, (self._packer_of(frames).pack(stamp, snapshot.poses[frames]),)
        elif snapshot.time != self._scene.start:  # the opening told where all is at the start
            if snapshot.time in self._changes:
                yield self._meshes, (self._entities.all(stamp, snapshot.there),)
            yield from self._placed(snapshot.poses, snapshot.there, stamp)
        yield self._world, (self._told(snapshot, stamp),)
        told = CallOuts(self._view)
        yield self._contacts, self._touching(snapshot, told, stamp)
        apart = [near for near in snapshot.nearest[: self._options.pairs] if near.distance > 0.0]
        drawn = (near for near in apart if near is apart[0] or near.distance < self._sizes.farthest)
        lines = ((self._pair_name(near.pair), near) for near in drawn)
        front = partial(self._front, snapshot.poses)
        yield self._clearance, (clearances(lines, front, self._sizes, told, stamp),)
        if self._named:
            yield self._tags, (self._called(snapshot, told, stamp),)

    def _close_up(self, summary: Summary) -> CloseUp | None:
        """Return how to see the worst pair where it is nearest, if its bodies are too small to be seen as they are."""
        measured = [pair for pair in summary["pairs"] if pair["distance"]["upper"] is not None]
        if not measured:
            return None
        worst = min(measured, key=lambda pair: (_SEVERITY.index(pair["verdict"]), pair["distance"]["upper"] or 0.0))
        moving = [k for k in map(self._names.index, (worst["body_a"], worst["body_b"])) if k in self._frames]
        if not moving or not all(map(self._entities.is_small, moving)):
            return None
        size = max(map(self._entities.size, moving)) + (worst["distance"]["upper"] or 0.0)
        return CloseUp(self._names[moving[0]], _CLOSE_UP * size)

    def _placed(
        self, poses: FloatArray, there: NDArray[np.bool_], stamp: Timestamp
    ) -> Iterator[tuple[Channel, Pieces]]:
        """Yield where all that moves is, given each body's pose (n, 4, 4) in the world, and whether it exists (n,)."""
        if self._frames:
            yield self._tf, (self._packer.pack(stamp, poses[self._frames]),)
        if self._entities.crowd is not None:
            yield self._boxes, (self._entities.crowd.update(stamp, poses, there),)

    def _remarks(self) -> list[str]:
        remarks = []
        if self._entities.boxed:
            drawn = f"{self._entities.boxed} bodies are drawn as boxes"
            remarks.append(f"{drawn}: --viz-triangles is too low to draw all bodies")
        if self._entities.crowd is not None:
            drawn = f"{len(self._entities.crowd)} moving bodies are drawn as boxes on {self._boxes.name}"
            remarks.append(
                f"{drawn}, without frames on {self._tf.name}: viewers do not handle more than {_MOST_FRAMES}"
            )
        return remarks

    def _told(self, snapshot: Snapshot, stamp: Timestamp) -> bytes:
        world = pb.World(timestamp=stamp, min_distance=nan, contacts=snapshot.contacts)
        if snapshot.nearest:
            world.min_distance = snapshot.nearest[0].distance
            world.pair = self._pair_name(snapshot.nearest[0].pair)
        for near in snapshot.nearest[: self._options.pairs]:
            world.pairs.add(pair=self._pair_name(near.pair), distance=near.distance, verdict=near.verdict.name)
        data: bytes = world.SerializeToString()
        return data

    def _front(self, poses: FloatArray, near: Nearness, point: FloatArray) -> FloatArray:
        """Return how far (3,) m from a point (3,) towards the eye both bodies of a pair reach, within limits."""
        direction = self._view.place - point
        direction /= np.linalg.norm(direction)
        reached = max(self._entities.front(body, poses[body], point, direction) for body in (near.pair.a, near.pair.b))
        front: FloatArray = min(reached, self._sizes.farthest_front) * direction
        return front

    def _called(self, snapshot: Snapshot, told: CallOuts, stamp: Timestamp) -> bytes:
        """Return the names over moving bodies, where there is room."""
        bodies = [index for index in self._named if snapshot.there[index]]
        tags = [(self._names[k], self._entities.peak(k, snapshot.poses[k]), self._entities.rgb(k)) for k in bodies]
        return names(tags, self._sizes, told, stamp)

    def _touching(self, snapshot: Snapshot, told: CallOuts, stamp: Timestamp) -> Pieces:
        touching = [near for near in snapshot.nearest if _stays_in_contact(near, snapshot.trigger)]
        possible = [near for near in snapshot.nearest if near.verdict is Verdict.POSSIBLE and near.distance == 0.0]
        bodies = sorted({body for near in touching for body in (near.pair.a, near.pair.b)})
        red = [self._entities.in_red(body, stamp, snapshot.poses[body]) for body in bodies]
        marks = []
        for near in (*touching, *possible):
            roof = max(self._entities.roof(body, snapshot.poses[body]) for body in (near.pair.a, near.pair.b))
            word, rgb = ("possible", AMBER) if near.verdict is Verdict.POSSIBLE else ("contact", RED)
            name = self._pair_name(near.pair)
            marks.append((contact(name, word, rgb, near.witness_a, roof, self._sizes, told, stamp),))
        return update_in_pieces(stamp, [*red, *marks])

    def _frames_of(self, pair: PairKey) -> list[int]:
        """Return the moving bodies in the chains of a pair's two, in document order."""
        chains = {*ancestors(self._bodies, pair.a), *ancestors(self._bodies, pair.b)}
        return sorted(chains.intersection(self._frames))

    def _packer_of(self, frames: list[int]) -> TransformPacker:
        return TransformPacker([self._names[frame] for frame in frames])

    def _pair_name(self, pair: PairKey) -> str:
        return f"{self._names[pair.a]}|{self._names[pair.b]}"


def _stays_in_contact(near: Nearness, trigger: Collision | None) -> bool:
    """Tell whether a pair touches, and goes on: where a contact ends the snapshot shows what is left."""
    ends = trigger is not None and trigger.phase is Phase.END and trigger.pair.id == near.pair.id
    return near.verdict is Verdict.CONTACT and not ends
