"""The file a log is published as: written beside it as `.partial`, and put in its place only when whole."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from .errors import LogError
from .pipe import STDOUT, Pipe


def destination(path: Path, inputs: Sequence[Path]) -> Output | Pipe:
    """Return where a log or a page goes: into a file, which is none of `inputs`, or down standard output.

    Raises:
        LogError: at once, where that cannot be written.
    """
    return Pipe(sys.stdout.buffer) if path == STDOUT else Output(path, inputs)


@contextmanager
def published(place: Output | Pipe) -> Iterator[IO[bytes]]:
    """Lend a stream; what was written is published at the end of the block, and nothing of it is left where it fails.

    Raises:
        LogError: where the system refuses.
    """
    try:
        yield place.open()
        place.publish()
    except OSError as error:
        raise place.fault(error) from error
    finally:
        place.discard()


class Output:
    """A log on its way to `path`, in the file `partial` of the same folder.

    Raises:
        LogError: at once, when `path` cannot be written or is one of `inputs`; nothing was touched then.
    """

    def __init__(self, path: Path, inputs: Sequence[Path]) -> None:
        self.path = path
        self.partial = path.with_name(path.name + ".partial") if path.name else path
        self._stream: IO[bytes] | None = None
        self._own: os.stat_result | None = None
        try:
            _require_place(path)
            for target in (self.path, self.partial):
                _require_plain_file(target)
                for source in inputs:
                    _require_other_file(target, source)
        except OSError as error:
            raise self.fault(error) from error

    def open(self) -> IO[bytes]:
        """Open `partial`, new: what an earlier run left there goes, and no link is followed."""
        try:
            self.partial.unlink(missing_ok=True)
            self._stream = self.partial.open("xb")
            self._own = os.fstat(self._stream.fileno())
        except OSError as error:
            raise self.fault(error) from error
        return self._stream

    def publish(self) -> None:
        """Put the whole log in place of `path`, safe from a crash of the machine once this returns."""
        if self._stream is None:
            raise ValueError("publish() before open()")
        self._stream.flush()
        os.fsync(self._stream.fileno())
        self._require_own_partial()
        self._stream.close()
        self.partial.replace(self.path)
        # Some file systems cannot sync a folder. The log is whole and in place by now.
        with suppress(OSError):
            _sync_folder(self.path.parent)

    def abandon(self) -> None:
        """Close `partial` and leave it; bytes that the disk refused once already are lost."""
        if self._stream is not None:
            with suppress(OSError):
                self._stream.close()

    def discard(self) -> None:
        """Close `partial` and remove it, unless it is published or another run took its place."""
        with suppress(LogError, OSError):
            self._require_own_partial()
            self.partial.unlink()
        self.abandon()

    def _require_own_partial(self) -> None:
        if self._own is None or not self.partial.exists() or not os.path.samestat(self._own, self.partial.stat()):
            raise LogError(self.path, f"another run took or removed {self.partial}", "give every run its own output")

    def fault(self, error: OSError) -> LogError:
        """Return the system's refusal to write as one line."""
        reason = error.strerror or str(error)
        return LogError(self.partial, f"cannot write: {reason}", "free space there, or choose another folder with -o")


def _require_place(path: Path) -> None:
    if path.is_dir():
        raise LogError(path, "is a folder", "name a file in it, such as out.mcap")
    if not path.parent.is_dir():
        raise LogError(path, f"there is no folder {path.parent}", "create it, or choose another with -o")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise LogError(path, f"the folder {path.parent} is not writable", "choose another with -o")


def _require_plain_file(path: Path) -> None:
    if path.exists() and not path.is_file():
        raise LogError(path, "exists and is not a plain file", "choose another output with -o")


def _require_other_file(target: Path, source: Path) -> None:
    if target.exists() and source.exists() and target.samefile(source):
        raise LogError(target, f"would overwrite the input {source}", "choose another output with -o")


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
