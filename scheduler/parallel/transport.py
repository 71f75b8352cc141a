"""Serialisation between processes: the work, and long streams of events."""

from __future__ import annotations

import gzip
import pickle
import threading
from collections.abc import Callable, Iterable, Iterator
from io import BytesIO
from itertools import islice
from typing import IO, Any, Generic, NamedTuple, TypeVar

from ..model.scene import Scene, Settings
from ..narrow.narrow_phase import NarrowPhase
from ..pairs.pair_factory import PairFactory

MadeT = TypeVar("MadeT")


class Work(NamedTuple):
    """What is run; `crowded` says whether windows clear distant pairs."""

    scene: Scene
    settings: Settings
    crowded: bool


def packed(work: Work) -> bytes:
    """Return the work as it travels to the processes that run shares of it."""
    return pickle.dumps(work, pickle.HIGHEST_PROTOCOL)


class MadeLast(threading.local, Generic[MadeT]):
    """What each thread made last, and of what: what takes long to make, and serves one thread at a time."""

    _kept: tuple[Any, MadeT] | None = None

    def get(self, of: Any, make: Callable[[], MadeT]) -> MadeT:
        """Return what the thread made last, if it was of the same; else make it."""
        if self._kept is None or self._kept[0] != of:
            self._kept = of, make()
        return self._kept[1]


_bench: MadeLast[tuple[Work, PairFactory]] = MadeLast()


def unpacked(packed_work: bytes) -> tuple[Work, PairFactory]:
    """Return the work, and what makes its pairs, built once by each thread."""

    def built() -> tuple[Work, PairFactory]:
        work: Work = pickle.loads(packed_work)
        return work, PairFactory(work.scene, NarrowPhase(work.scene.bodies), work.settings.margin)

    return _bench.get(packed_work, built)


def packed_stream(events: Iterable[Any], together: int) -> bytes:
    """Serialise events, so many at a time together."""
    buffer, rest = BytesIO(), iter(events)
    with gzip.GzipFile(fileobj=buffer, mode="wb", compresslevel=1) as pack:
        while some := list(islice(rest, together)):
            pickle.dump(some, pack, pickle.HIGHEST_PROTOCOL)
        pickle.dump(some, pack)
    return buffer.getvalue()


def unpacked_stream(file: IO[bytes]) -> Iterator[Any]:
    """Yield what was packed, of which no more is held than was packed together."""
    with gzip.open(file) as pack:
        while some := pickle.load(pack):
            yield from some
