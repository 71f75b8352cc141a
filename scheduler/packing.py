"""What travels between processes: the work, what is built of it, and long streams of what is told."""

from __future__ import annotations

import gzip
import pickle
import threading
from collections.abc import Iterable, Iterator
from io import BytesIO
from itertools import islice
from typing import IO, Any, NamedTuple

from .narrow_phase import NarrowPhase
from .pairing import Pairing
from .scene import Scene, Settings


class Work(NamedTuple):
    """What is run; `crowded` says whether windows clear distant pairs."""

    scene: Scene
    settings: Settings
    crowded: bool


def packed(work: Work) -> bytes:
    """Return the work as it travels to the processes that run shares of it."""
    return pickle.dumps(work, pickle.HIGHEST_PROTOCOL)


class _Bench(threading.local):
    """What a thread works at: the models of a scene serve one measurement at a time, and take long to build."""

    packed = b""
    work: Work
    pairing: Pairing


_bench = _Bench()


def unpacked(packed_work: bytes) -> tuple[Work, Pairing]:
    """Return the work, and what makes its pairs, built once by each thread."""
    if _bench.packed != packed_work:
        work: Work = pickle.loads(packed_work)
        _bench.work = work
        _bench.pairing = Pairing(work.scene, NarrowPhase(work.scene.bodies), work.settings.margin)
        _bench.packed = packed_work
    return _bench.work, _bench.pairing


def packed_stream(told: Iterable[Any], together: int) -> bytes:
    """Return whatever is told, so many at a time packed together."""
    buffer, rest = BytesIO(), iter(told)
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
