"""Streams of events: what a share of the pairs tells, packed to travel between processes, and the merger of them all.

The heap wakes the pair whose time comes first; which pairs it holds beside changes nothing for that pair. So the events
of one heap of all pairs are those of the shares' heaps, always from the one whose next turn comes first.
"""

from __future__ import annotations

import gzip
import heapq
import pickle
import threading
from collections.abc import Generator, Iterable, Iterator
from io import BytesIO
from itertools import groupby, islice
from operator import itemgetter
from typing import IO, NamedTuple

from .crowd import Crowd
from .events import Event, Snapshot, Window
from .heap import WakeupQueue
from .narrow_phase import NarrowPhase
from .pairing import Pairing
from .run import run
from .scene import Scene, Settings
from .share import Share

#: Turns that are packed, and unpacked, together. The merger holds so many of each stream.
_TURNS_A_PACK = 256

#: A turn in the heap, and whose part of it: of the ends of windows, first the windows, then the pairs that enter by id.
Turn = tuple[float, int, int]


class Work(NamedTuple):
    """What is run; `crowded` says whether windows clear distant pairs."""

    scene: Scene
    settings: Settings
    crowded: bool


class Stream(NamedTuple):
    """What a share told: its turns, packed for `merged`, and the wall-clock seconds inside FCL that they took."""

    turns: bytes
    fcl: float


def packed(work: Work) -> bytes:
    """Return the work as it travels to the processes that run shares of it."""
    return pickle.dumps(work, pickle.HIGHEST_PROTOCOL)


def stream(packed_work: bytes, share: Share) -> Stream:
    """Run a share of the pairs to its end, in any process or thread, and return what it tells."""
    work, pairing = _unpacked(packed_work)
    before = pairing.narrow_phase.seconds
    queue = WakeupQueue()
    pairs = () if work.crowded else pairing.all(share)
    crowd = Crowd(pairing, work.settings, share) if work.crowded else None
    turns = _turns(run(pairs, work.settings, crowd, queue), queue)
    buffer = BytesIO()
    with gzip.GzipFile(fileobj=buffer, mode="wb", compresslevel=1) as pack:
        while some := list(islice(turns, _TURNS_A_PACK)):
            pickle.dump(some, pack, pickle.HIGHEST_PROTOCOL)
        pickle.dump(some, pack)
    return Stream(buffer.getvalue(), pairing.narrow_phase.seconds - before)


def merged(streams: Iterable[IO[bytes]]) -> Generator[Event, None, None]:
    """Yield the events of all shares' streams in the order in which one run of all pairs has them."""
    for _, events in heapq.merge(*map(_unpacked_turns, streams), key=itemgetter(0)):
        yield from events


def _turns(events: Iterable[Event], queue: WakeupQueue) -> Iterator[tuple[Turn, list[Event]]]:
    """Yield the events by turns."""
    for turn, some in groupby(events, lambda event: (*queue.turn, _part(event))):
        yield turn, list(some)


def _part(event: Event) -> int:
    return -1 if isinstance(event, Window | Snapshot) else event.pair.id


def _unpacked_turns(file: IO[bytes]) -> Iterator[tuple[Turn, list[Event]]]:
    with gzip.open(file) as pack:
        while some := pickle.load(pack):
            yield from some


class _Bench(threading.local):
    """What a thread works at: the models of a scene serve one measurement at a time, and take long to build."""

    packed = b""
    work: Work
    pairing: Pairing


_bench = _Bench()


def _unpacked(packed_work: bytes) -> tuple[Work, Pairing]:
    """Return the work, and what makes its pairs, built once by each thread."""
    if _bench.packed != packed_work:
        work: Work = pickle.loads(packed_work)
        _bench.work = work
        _bench.pairing = Pairing(work.scene, NarrowPhase(work.scene.bodies), work.settings.margin)
        _bench.packed = packed_work
    return _bench.work, _bench.pairing
