"""The file that a log or a report becomes: written beside it as `.partial`, and put in its place only when whole."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, NamedTuple

from ..errors import LogError
from .pipe import STDOUT, Pipe

PARTIAL = ".partial"
"""Behind an output's name until the output is whole."""

_FULL = frozenset((errno.ENOSPC, errno.EDQUOT, errno.EFBIG))


class Kind(NamedTuple):
    """A kind of file that closecall writes: its name, and how all such files begin; an empty file is of every kind."""

    name: str
    beginnings: tuple[bytes, ...]


LOG = Kind("a log", (b"\x89MCAP0\r\n",))
REPORT = Kind("a report of closecall", (b"<!DOCTYPE html>\n<!-- a report of closecall -->",))
JUNIT = Kind("a JUnit report", (b"<?xml", b"<testsuite"))
TABLE = Kind("a table of closecall", (b"time,log_time,", b'{"time": ', b"PAR1"))
FILE = Kind("a file", (b"",))
"""Any file."""


def destination(path: Path, inputs: Sequence[Path], kind: Kind) -> Output | Pipe:
    """Return where a log or a report goes: into a file, which is none of `inputs`, or down standard output.

    Raises:
        LogError: at once, where that cannot be written.
    """
    return Pipe(sys.stdout.buffer) if path == STDOUT else Output(path, inputs, kind)


@contextmanager
def published(place: Output | Pipe) -> Iterator[IO[bytes]]:
    """Lend a stream; what was written on it is published at the end of the block, or nothing of it is left.

    Raises:
        LogError: where the system refuses to write.
    """
    try:
        yield place.open()
        place.publish()
    except OSError as error:
        raise place.fault(error) from error
    finally:
        place.discard()


class Output:
    """A log or a report on its way to `path`, in the file `partial` of the same folder.

    Args:
        path: what is written; an existing file is replaced.
        inputs: files that are read, which neither `path` nor `partial` may be.
        kind: what is written; an existing file of another kind is not replaced.
        option: of the command line, with which the user chooses `path`.

    Raises:
        LogError: at once, when `path` cannot be written or is one of `inputs`; nothing was touched then.
    """

    def __init__(self, path: Path, inputs: Sequence[Path], kind: Kind, option: str = "-o") -> None:
        self.path = path
        self._option = option
        self.partial = path.with_name(path.name + PARTIAL) if path.name else path
        self._stream: IO[bytes] | None = None
        self._own: os.stat_result | None = None
        try:
            _require_place(path, option)
            _require_short_name(path, option)
            for target in (self.path, self.partial):
                _require_plain_file(path, target, option)
                for source in inputs:
                    _require_other_file(path, target, source, option)
            _require_kind(path, kind, option)
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
        """Put the whole file in place of `path`, safe from a crash of the machine once this returns."""
        if self._stream is None:
            raise ValueError("publish() before open()")
        self._stream.flush()
        os.fsync(self._stream.fileno())
        self._require_own_partial()
        self._stream.close()
        self.partial.replace(self.path)
        # Some file systems cannot sync a folder. The file is whole and in place by now.
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
        """Return the system's refusal to write as one line, which names `partial` once that is there."""
        place = self.path if self._own is None else self.partial
        remedy = f"choose another output with {self._option}"
        if error.errno in _FULL:
            remedy = f"free space there, or choose another folder with {self._option}"
        return LogError(place, f"cannot write: {error.strerror or error}", remedy)


def _require_place(path: Path, option: str) -> None:
    if path.is_dir():
        raise LogError(path, "is a folder", f"name a file in it with {option}")
    if not path.parent.is_dir():
        raise LogError(path, f"there is no folder {path.parent}", f"create it, or choose another folder with {option}")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise LogError(path, f"the folder {path.parent} is not writable", f"choose another with {option}")


def _require_short_name(path: Path, option: str) -> None:
    most = _longest_name(path.parent) - len(PARTIAL)
    length = len(os.fsencode(path.name))
    if length > most:
        problem = f"the name has {length} bytes, but at most {most} fit, because closecall first writes NAME{PARTIAL}"
        raise LogError(path, problem, f"choose a shorter name with {option}")


def _longest_name(folder: Path) -> int:
    """Return how many bytes a file's name may have in a folder."""
    try:
        return os.pathconf(folder, "PC_NAME_MAX")
    except (OSError, ValueError, AttributeError):  # where the system does not say
        return 255


def _require_plain_file(path: Path, target: Path, option: str) -> None:
    if target.exists() and not target.is_file():
        if target == path:
            raise LogError(path, "exists and is not a plain file", f"choose another output with {option}")
        what = "a folder" if target.is_dir() else "not a plain file"
        problem = f"{target}, the place of the unfinished file, is {what}"
        raise LogError(path, problem, f"remove that, or choose another output with {option}")


def _require_other_file(path: Path, target: Path, source: Path, option: str) -> None:
    if target.exists() and source.exists() and target.samefile(source):
        through = "" if target == path else f" through {target}"
        problem = f"would overwrite the input {source}{through}"
        raise LogError(path, problem, f"choose another output with {option}")


def _require_kind(path: Path, kind: Kind, option: str) -> None:
    if not path.is_file():
        return
    with path.open("rb") as file:
        beginning = file.read(max(map(len, kind.beginnings)))
    if beginning and not beginning.startswith(kind.beginnings):
        raise LogError(path, f"exists and is not {kind.name}", f"remove it, or choose another output with {option}")


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
