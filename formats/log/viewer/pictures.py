"""Pictures for viewers, taken and drawn in any process: its log is written by another."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import NamedTuple

from ....scheduler.instants import Instant
from ....scheduler.packing import packed_stream, unpacked
from ....scheduler.streams import observer_of
from ..clock import nanoseconds
from .viewer import Viewer, ViewerOptions
from .wire import Pieces

#: Pictures that are packed, and unpacked, together. What several of them show alike is packed once.
_TOGETHER = 16


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
    work, pairing = unpacked(packed_work)
    before = pairing.narrow_phase.seconds
    observer = observer_of(pairing, None if work.crowded else tuple(pairing.all()), options.pairs)
    viewer = _studio.viewer(packed_work, options)

    def taken() -> Iterator[Picture]:
        for instant in instants:
            shown = viewer.shown(observer.at(*instant), nanoseconds(instant.time) + epoch)
            yield Picture(instant.time, [(channel.name, pieces) for channel, pieces in shown])

    packed = packed_stream(taken(), _TOGETHER)
    return Pictures(packed, pairing.narrow_phase.seconds - before)


class _Studio(threading.local):
    """What a thread draws with."""

    _made: tuple[bytes, ViewerOptions, Viewer] | None = None

    def viewer(self, packed_work: bytes, options: ViewerOptions) -> Viewer:
        """Return what draws the scene, made once by each thread."""
        if self._made is None or self._made[:2] != (packed_work, options):
            self._made = packed_work, options, Viewer(unpacked(packed_work)[0].scene, options)
        return self._made[2]


_studio = _Studio()
