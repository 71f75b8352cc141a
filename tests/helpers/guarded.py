"""Limits on what the reading of one hostile input may take, kept while it is read and not looked up afterwards."""

from __future__ import annotations

import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import NoReturn

MOST_SECONDS = 5.0
"""CPU s for one input. The slowest takes some 0.1 s, on a machine with nothing else to do."""

MOST_BYTES = 2**29
"""By which the address space may grow beyond what the process had when the reading of all inputs began."""


class OvertimeError(BaseException):
    """The time is up. Not an Exception, so that no reader takes it for a fault of its input."""


@contextmanager
def memory_limited() -> Iterator[None]:
    """Let whatever asks for more than MOST_BYTES fail with MemoryError."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MOST_BYTES, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@contextmanager
def time_limited() -> Iterator[None]:
    """Raise OvertimeError in whatever takes more than MOST_SECONDS of this process's CPU time."""
    before = signal.signal(signal.SIGPROF, _time_is_up)
    signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def _time_is_up(number: int, frame: FrameType | None) -> NoReturn:
    raise OvertimeError(f"more than {MOST_SECONDS:g} s")
