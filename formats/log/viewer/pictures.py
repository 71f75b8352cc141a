"""Pictures for viewers, taken and drawn in any process: its log is written by another."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from ....scheduler.parallel.merge import observer_of
from ....scheduler.parallel.transport import MadeLast, packed_stream, unpacked
from ....scheduler.snapshots.schedule import Instant
from ..container.clock import nanoseconds
from .viewer import Viewer, ViewerOptions
from .wire import Pieces

#: Pictures that are packed, and unpacked, together. What several of them show alike is packed once.
_TOGETHER = 16

_studio: MadeLast[Viewer] = MadeLast()


class Picture(NamedTuple):
    """What viewers are shown of one time, s: for each topic the bytes of its message."""

    time: float
    messages: list[tuple[str, Pieces]]


class Pictures(NamedTuple):
    """Pictures, packed, and the wall-clock seconds inside FCL that they took."""

    packed: bytes
    fcl: float


def pictures(packed_work: bytes, options: ViewerOptions, epoch: int, instants: list[Instant]) -> Pictures:
    """Take pictures of some instants, in any process or thread; `epoch`, ns, is added to every log time."""
    work, factory = unpacked(packed_work)
    before = factory.narrow_phase.seconds
    observer = observer_of(factory, None if work.crowded else tuple(factory.all()), options.pairs)
    viewer = _studio.get((packed_work, options), lambda: Viewer(work.scene, options))

    def taken() -> Iterator[Picture]:
        for instant in instants:
            shown = viewer.shown(observer.at(*instant), nanoseconds(instant.time) + epoch)
            yield Picture(instant.time, [(channel.name, pieces) for channel, pieces in shown])

    packed = packed_stream(taken(), _TOGETHER)
    return Pictures(packed, factory.narrow_phase.seconds - before)
