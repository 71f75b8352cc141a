"""Faults of a scene file: where each lies and what would be right, in one line whatever the file holds."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from sys import float_info

Where = tuple[str | int, ...]
"""The keys and list indices that lead from the root of a scene to one of its values."""

_PLAIN_KEY = re.compile(r"[\w-]+\Z")
_LONGEST_QUOTE = 60
_LONGEST_EXACT = 10**17
_MOST_CANDIDATES = 1000
"""Beyond this many names none is suggested: difflib would take longer than the reading."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing wrong in a scene file.

    Attributes:
        file: the scene file, as the caller named it.
        line: counted from 1.
        column: in characters, counted from 1.
        place: the path in the scene, such as `bodies.gear.motion.keys[3].t`; `scene` for the whole.
        message: what is wrong, and what would be right.
    """

    file: str
    line: int
    column: int
    place: str
    message: str

    def __str__(self) -> str:
        return f"{printable(self.file)}:{self.line}:{self.column}: {self.place}: {self.message}"


def whole_file(file: object, message: str) -> Fault:
    """Return a fault of a scene file as a whole."""
    return Fault(str(file), 1, 1, place_text(()), message)


class SceneError(Exception):
    """A scene file that cannot be read.

    Attributes:
        faults: in the order of the file.
        lines: its text, one line a fault.
    """

    def __init__(self, faults: Iterable[Fault]) -> None:
        super().__init__()
        self.faults = in_order(faults)
        self.lines = tuple(map(str, self.faults))

    def __str__(self) -> str:
        return "\n".join(self.lines)


class WarnedError(SceneError):
    """A scene that is refused for its warnings alone; its text is one line a warning, each with its place once."""

    def __init__(self, warnings: Iterable[str]) -> None:
        super().__init__(())
        self.lines = tuple(f"{warning} (a warning, refused under --strict)" for warning in warnings)


def in_order(faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """Return the faults in the order of the file."""
    return tuple(sorted(faults, key=lambda fault: (fault.line, fault.column)))


def place_text(where: Where) -> str:
    """Return `where` as people write it: `bodies.gear.shapes[0]`; keys with other characters are quoted."""
    text = ""
    for key in where:
        if isinstance(key, int):
            text += f"[{key}]"
        elif _PLAIN_KEY.match(key):
            text += f".{key}" if text else key
        else:
            text += f"[{quoted(key)}]"
    return text or "scene"


def printable(text: str) -> str:
    """Return `text` with control, bidirectional and other unprintable characters escaped."""
    return text if text.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def quoted(value: object) -> str:
    """Return `value` as a message shows it: one printable line, shortened when long."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, tuple):
        return "a list"
    if isinstance(value, float) or (isinstance(value, int) and abs(value) <= float_info.max):
        return repr(value if abs(value) < _LONGEST_EXACT else float(value)).removesuffix(".0")
    text = str(value)
    return repr(text if len(text) <= _LONGEST_QUOTE else text[:_LONGEST_QUOTE] + "...")


def counted(count: int, thing: str, things: str = "") -> str:
    """Return a number with its noun, whose plural has an s unless it is given: `1 pair`, `2 bodies`."""
    return f"{count} {thing if count == 1 else things or thing + 's'}"


def suggestion(name: object, candidates: Iterable[str]) -> str:
    """Return ` (did you mean 'x'?)` for the nearest of the candidates, or nothing."""
    known = list(candidates)
    if not isinstance(name, str) or len(name) > _LONGEST_QUOTE or len(known) > _MOST_CANDIDATES:
        return ""
    near = get_close_matches(name, known, n=1)
    return f" (did you mean {quoted(near[0])}?)" if near else ""
