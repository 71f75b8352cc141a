"""Names of bodies, groups and meshes: what may be one, and what a reference to one means."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from fnmatch import translate
from re import compile

from ..grammar.scene import BodyPart
from ..limits import MOST_PATTERN_COMPARISONS
from ..text.document import Findings
from ..text.errors import Where, quoted

WORLD = "world"
_FORBIDDEN = frozenset("\"'/*?[]|")
_GLOB = frozenset("*?[")
_BIDIRECTIONAL = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")


def normal(name: str) -> str:
    """Return the name in Unicode's form C, in which names are compared."""
    return unicodedata.normalize("NFC", name)


def declared(section: str, names: Iterable[str], findings: Findings) -> Iterator[str]:
    """Yield the normal form of each name in turn, recording those that may not be names, or are equal.

    Args:
        section: the mapping whose keys they are.
        names: as written.
        findings: takes the faults.
    """
    seen: set[str] = set()
    for name in names:
        key = normal(name)
        problem = name_problem(key)
        if problem:
            findings.fault_at_key((section, name), problem)
        elif key in seen:
            findings.fault_at_key((section, name), "the name appears twice (in Unicode's normal form)")
        seen.add(key)
        yield key


def name_problem(name: str) -> str:
    """Return why `name`, in normal form, may not be a name; empty if it may."""
    if not name.strip():
        return "expected a name, got a blank one"
    if name == WORLD:
        return f"the name {quoted(WORLD)} is reserved, choose another"
    for character in name:
        if unicodedata.category(character) in ("Cc", "Zl", "Zp") or character in _BIDIRECTIONAL:
            return f"the character U+{ord(character):04X} is not allowed in a name"
        if character in _FORBIDDEN:
            return f"the character {character} is not allowed in a name"
    return ""


class Bodies:
    """The bodies by name and by group."""

    def __init__(self, bodies: Mapping[str, BodyPart], findings: Findings) -> None:
        """Take the bodies of a scene, recording names and groups that may not be."""
        self._findings = findings
        self.names = tuple(declared("bodies", bodies, findings))
        self.indices = {name: index for index, name in enumerate(self.names)}
        self._groups: dict[str, set[int]] = {}
        self._matches: dict[str, frozenset[int]] = {}
        self._comparisons_left = MOST_PATTERN_COMPARISONS
        for index, (name, body) in enumerate(bodies.items()):
            for place, group in enumerate(body.groups):
                self._join(index, normal(group), ("bodies", name, "groups", place))

    def _join(self, index: int, group: str, where: Where) -> None:
        problem = name_problem(group)
        if not problem and group in self.indices:
            problem = f"the group {quoted(group)} has the name of a body, choose another"
        if problem:
            self._findings.fault(where, problem)
        self._groups.setdefault(group, set()).add(index)

    def index(self, name: str, where: Where) -> int | None:
        """Return the index of the body called `name`; None, and a fault, if there is none."""
        found = self.indices.get(normal(name))
        if found is None:
            near = self._findings.suggestion(name, self.indices)
            hint = ", leave the key out for a body in the world" if name == WORLD else near
            self._findings.fault(where, f"unknown body {quoted(name)}{hint}")
        return found

    def matching(self, pattern: str, where: Where) -> frozenset[int]:
        """Return the bodies that a name, a group or a pattern stands for; none, and a fault, if it matches none."""
        key = normal(pattern)
        if key not in self._matches:
            self._matches[key] = self._found(key)
        found = self._matches[key]
        if not found:
            self._findings.fault(where, self._why_none(pattern))
        return found

    def _found(self, key: str) -> frozenset[int]:
        if key in self.indices:
            return frozenset({self.indices[key]})
        if key in self._groups:
            return frozenset(self._groups[key])
        if _GLOB.isdisjoint(key):
            return frozenset()
        self._comparisons_left -= len(self.names)
        if self._comparisons_left < 0:
            return frozenset()
        expression = compile(translate(key))
        return frozenset(index for index, name in enumerate(self.names) if expression.match(name))

    def _why_none(self, pattern: str) -> str:
        if _GLOB.isdisjoint(pattern):
            near = self._findings.suggestion(pattern, (*self.indices, *self._groups))
            return f"unknown body or group {quoted(pattern)}{near}"
        if self._comparisons_left < 0:
            return "too many patterns for so many bodies, use groups instead"
        return f"the pattern {quoted(pattern)} matches no body"
