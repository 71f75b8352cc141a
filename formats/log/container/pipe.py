"""A log that goes down a pipe instead of into a file: there is no partial, and nothing to rename."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import IO, cast

from ..errors import LogError

STDOUT = Path("-")
"""The output path that means standard output."""


class ClosedPipeError(LogError):
    """The reader of the pipe went away, which is its right."""


class CountingStream:
    """A pipe that knows how many bytes went down it, as the MCAP writer's `tell` wants."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self._written = 0

    def write(self, data: bytes) -> int:
        """Write all of the bytes: unbuffered, a pipe takes a part where its reader goes away, and tells the next."""
        left = memoryview(data)
        while left:
            left = left[self._stream.write(left) :]
        self._written += len(data)
        return len(data)

    def tell(self) -> int:
        """Return how many bytes were written."""
        return self._written

    def flush(self) -> None:
        """Hand everything to the system."""
        self._stream.flush()


class Pipe:
    """Standard output in the place of an `Output`.

    Raises:
        LogError: at once, where standard output is a terminal.
    """

    def __init__(self, stream: IO[bytes]) -> None:
        self.path = self.partial = STDOUT
        if stream.isatty():
            raise LogError(STDOUT, "standard output is a terminal", "pipe it to a program, or name a file with -o")
        self._stream = stream

    def open(self) -> IO[bytes]:
        """Return the stream to write on; it counts, and can do no more than the MCAP writer asks of it."""
        return cast(IO[bytes], CountingStream(self._stream))

    def publish(self) -> None:
        """Hand the last bytes to the reader."""
        self._stream.flush()

    def abandon(self) -> None:
        """Do nothing: what was sent was sent."""

    def discard(self) -> None:
        """Do nothing: what was sent was sent."""

    def fault(self, error: OSError) -> LogError:
        """Return the system's refusal to write as one line."""
        if isinstance(error, BrokenPipeError):
            with suppress(OSError):
                self._stream.close()
            return ClosedPipeError(STDOUT, "the reader closed the pipe", "make the reader read to the end")
        return LogError(STDOUT, f"cannot write: {error.strerror or error}", "check the reader of the pipe")
