"""The faults of the log's reading and writing."""

from __future__ import annotations

from pathlib import Path

from ..scene.text.errors import printable


class LogError(Exception):
    """A log that cannot be written or read: one line that names the file, what is wrong, and what to do.

    Attributes:
        path: the file at fault.
        problem: what is wrong with it.
        remedy: what the caller can do about it.
    """

    def __init__(self, path: Path, problem: str, remedy: str) -> None:
        super().__init__(printable(f"{path}: {problem}; {remedy}"))
        self.path = path
        self.problem = problem
        self.remedy = remedy


class DamagedLogError(LogError):
    """A log that was one, and of which nothing can be read any more."""
