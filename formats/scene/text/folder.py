"""Where the files that a scene names may lie."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path, PurePosixPath, PureWindowsPath

from .errors import printable

_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:")


class FolderError(Exception):
    """A file that a scene may not name."""

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self.message = message


class Folder:
    """The scene's own folder, and others that the caller named as roots."""

    def __init__(self, folder: Path, roots: Sequence[Path]) -> None:
        """Take the scene file's folder, and other folders in which files may lie."""
        self._folder = folder
        self._roots = tuple(roots)

    def found(self, file: str) -> Path:
        """Return where a file lies, absolute, symbolic links resolved.

        Raises:
            FolderError: the scene may not refer to it.
        """
        shown = printable(file)
        if _URL.match(file):
            raise FolderError(f"{shown} is a URL, expected a file relative to the scene")
        try:
            path = (self._folder / file).resolve()
            roots = [root.resolve() for root in self._roots]
            folder = self._folder.resolve()
        except (OSError, RuntimeError, ValueError) as error:
            raise FolderError(f"{shown} is no path: {printable(str(error))}") from error
        if any(path.is_relative_to(root) for root in roots):
            return path
        if PurePosixPath(file).is_absolute() or PureWindowsPath(file).anchor:
            raise FolderError(f"{shown} is absolute, expected a path relative to the scene, or name its root")
        if not path.is_relative_to(folder):
            raise FolderError(f"{shown} lies outside the scene's folder, move it inside or name its root")
        return path
