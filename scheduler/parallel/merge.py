"""Streams of events, one for each share of the pairs, and their merge.

The queue wakes the pair with the earliest time. The other pairs in it change nothing for that pair. So the events of
one queue of all pairs are those of the shares' queues, taken each time from the share whose next wakeup comes first.
"""

from __future__ import annotations

import heapq
import pickle
from collections.abc import Generator, Iterable, Iterator, Sequence
from itertools import groupby
from math import inf
from operator import itemgetter
from typing import IO, NamedTuple

from ..broad.active_pairs import ActivePairs
from ..broad.broad_phase import BroadPhase, Tick
from ..broad.windows import Sweeps, ToldWindows, Windows
from ..model.events import Collision, Event, Snapshot, Window
from ..model.share import Share
from ..pairs.pair import Pair
from ..pairs.pair_factory import PairFactory
from ..queue import WakeupQueue
from ..run import run
from ..snapshots.nearest_pairs import CrowdObserver
from ..snapshots.schedule import Observes
from ..snapshots.snapshot import Observer
from .transport import Work, packed_stream, unpacked, unpacked_stream

#: Turns that are packed, and unpacked, together. The merger holds so many of each stream.
_TURNS_A_PACK = 256

#: A turn in the heap, and whose part of it: of the ends of windows, first the windows, then the pairs that enter by id.
Turn = tuple[float, int, int]


class Stream(NamedTuple):
    """The events of a share.

    Attributes:
        turns: packed for `merged`.
        collisions: those among them, in order, each with the latest turn up to then.
        fcl: wall-clock seconds inside FCL that they took.
    """

    turns: bytes
    collisions: list[tuple[Turn, Collision]]
    fcl: float


def windows_of(packed_work: bytes, share: Share) -> Windows:
    """Return all windows of a share of the bodies, made in any process or thread."""
    _, factory = unpacked(packed_work)
    return Sweeps(factory, share).all()


def packed_ticks(work: Work, shares: Iterable[Windows]) -> bytes:
    """Serialise the broad phase's ticks, made from the windows of all shares of the bodies."""
    return pickle.dumps(list(BroadPhase(work.scene, ToldWindows(Windows.joined(shares)))), pickle.HIGHEST_PROTOCOL)


def stream(packed_work: bytes, share: Share, ticks: bytes | None = None) -> Stream:
    """Run a share of the pairs to its end, in any process or thread, and return its events.

    With a broad phase, `ticks` are what `packed_ticks` returned.
    """
    work, factory = unpacked(packed_work)
    before = factory.narrow_phase.seconds
    queue = WakeupQueue()
    known_ticks: list[Tick] | None = None if ticks is None else pickle.loads(ticks)
    crowd = None if known_ticks is None else ActivePairs(factory, work.settings, known_ticks, share)
    pairs = factory.all(share) if crowd is None else ()
    collisions: list[tuple[Turn, Collision]] = []
    turns = packed_stream(_turns(run(pairs, work.settings, crowd, queue), queue, collisions), _TURNS_A_PACK)
    return Stream(turns, collisions, factory.narrow_phase.seconds - before)


def observer_of(factory: PairFactory, pairs: Sequence[Pair] | None, most_pairs: int) -> Observes[Snapshot]:
    """Return what takes snapshots of a scene and of its pairs, None for those of a crowd."""
    if pairs is None:
        return CrowdObserver(factory, most_pairs)
    return Observer(factory.scene, pairs, most_pairs, factory.narrow_phase)


def told_in_order(streams: Iterable[Stream]) -> list[Collision]:
    """Return the collisions of all shares in the order of `merged`.

    A turn that goes back, to refine, comes at once after the one before it: no other share's is earlier than that.
    """
    events = [collision for stream in streams for collision in stream.collisions]
    return [collision for _, collision in sorted(events, key=itemgetter(0))]


def merged(streams: Iterable[IO[bytes]]) -> Generator[Event, None, None]:
    """Yield the events of all shares' streams in the order in which one run of all pairs has them."""
    for _, events in heapq.merge(*map(unpacked_stream, streams), key=itemgetter(0)):
        yield from events


def _turns(
    events: Iterable[Event], queue: WakeupQueue, collisions: list[tuple[Turn, Collision]]
) -> Iterator[tuple[Turn, list[Event]]]:
    """Yield the events by turns, and note the collisions among them."""
    latest: Turn = (-inf, 0, 0)
    for turn, some in groupby(events, lambda event: (*queue.turn, _part(event))):
        events, latest = list(some), max(latest, turn)
        collisions.extend((latest, event) for event in events if isinstance(event, Collision))
        yield turn, events


def _part(event: Event) -> int:
    return -1 if isinstance(event, Window | Snapshot) else event.pair.id
