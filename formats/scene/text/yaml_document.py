"""YAML 1.2 over libyaml's events: PyYAML's own constructors lose lines, duplicate keys and `1e-3`."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, NoReturn

import yaml

from ..limits import DEEPEST_NESTING
from .document import NULL, Document, Position, Value, refuse
from .errors import Where, printable, quoted
from .scalars import NotFiniteError, plain_scalar

LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

TOO_DEEP = f"nested more than {DEEPEST_NESTING} deep"
EMPTY = "the file is empty, a scene begins with 'closecall: 1'"

_UNPRINTABLE = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]|\ufeff")


def read_yaml(text: str, file: str, loader: Any = LOADER) -> Document:
    """Parse one YAML document without tags, anchors or duplicate keys.

    Args:
        text: the document, decoded.
        file: its name, for messages.
        loader: PyYAML's loader class whose parser reads the events.

    Raises:
        SceneError: with the position of the first thing that cannot be read.
    """
    _refuse_unprintable(text, file)
    builder = _Builder(file)
    try:
        for event in yaml.parse(text, Loader=loader):
            builder.take(event)
    except yaml.YAMLError as error:
        _refuse_syntax(error, builder, text)
    return builder.finish()


def _refuse_unprintable(text: str, file: str) -> None:
    found = _UNPRINTABLE.search(text)
    if found:
        before = text[: found.start()]
        position = before.count("\n") + 1, found.start() - before.rfind("\n")
        refuse(file, position, (), f"the character U+{ord(found[0]):04X} is not allowed, write printable text")


_HINTS = {
    "cannot start any token": "put text that begins with this character in quotes",
    "mapping values are not allowed": "is a space missing after a colon, or are quotes around text with a colon in it?",
    "did not find expected key": "is the line indented as those above?",
    "expected <block end>": "is the line indented as those above?",
}
"""What libyaml and PyYAML say, and what most often is behind it."""


def _hint(problem: str, text: str, mark: Any) -> str:
    """Return what may mend a problem at a place of the text; empty if that is not known."""
    if mark and text[mark.index : mark.index + 1] == "\t":
        return ": it is a tab, indent with spaces"
    return next((f": {hint}" for said, hint in _HINTS.items() if said in problem), "")


def _refuse_syntax(error: yaml.YAMLError, builder: _Builder, text: str) -> NoReturn:
    if not isinstance(error, yaml.MarkedYAMLError):
        refuse(builder.file, (1, 1), (), f"not valid YAML: {printable(str(error))}")
    mark = error.problem_mark or error.context_mark
    if "nesting depth" in str(error.problem):  # libyaml looks ahead, and stops at a limit of its own
        refuse(builder.file, (1, 1), (), TOO_DEEP)
    position = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    context = f" {error.context}" if error.context else ""
    if error.context and error.context_mark and error.context_mark.line + 1 != position[0]:
        context += f" that begins in line {error.context_mark.line + 1}"
    hint = _hint(str(error.problem), text, mark)
    refuse(builder.file, position, builder.where(), f"not valid YAML: {printable(str(error.problem))}{context}{hint}")


@dataclass(slots=True)
class _Open:
    """A mapping or list whose end has not come yet."""

    where: Where
    values: dict[str, Value] | list[Value]
    key: str | None = None

    def next_where(self) -> Where:
        if isinstance(self.values, list):
            return (*self.where, len(self.values))
        return self.where if self.key is None else (*self.where, self.key)


class _Builder:
    """Turns events into values; the stack holds the open mappings and lists."""

    def __init__(self, file: str) -> None:
        self.file = file
        self._stack: list[_Open] = []
        self._roots: list[Value] = []
        self._values: dict[Where, Position] = {}
        self._keys: dict[Where, Position] = {}

    def where(self) -> Where:
        """Return the path of the value that comes next."""
        return self._stack[-1].next_where() if self._stack else ()

    def finish(self) -> Document:
        """Return the document once all events are taken."""
        if not self._roots:
            refuse(self.file, (1, 1), (), EMPTY)
        return Document(self.file, self._roots[0], self._values, self._keys)

    def take(self, event: yaml.Event) -> None:
        """Take the next event.

        Raises:
            SceneError: the event is a thing that a scene may not hold.
        """
        if isinstance(event, yaml.NodeEvent):
            self._refuse_reference(event)
        if isinstance(event, yaml.ScalarEvent):
            self._scalar(event)
        elif isinstance(event, yaml.CollectionStartEvent):
            self._open(event)
        elif isinstance(event, yaml.CollectionEndEvent):
            self._close()
        elif isinstance(event, yaml.DocumentStartEvent) and self._roots:
            self._refuse(event, "a second document begins here, a scene file holds one")

    def _scalar(self, event: yaml.ScalarEvent) -> None:
        top = self._stack[-1] if self._stack else None
        if top is not None and isinstance(top.values, dict) and top.key is None:
            self._take_key(top, top.values, event)
            return
        self._values[self.where()] = _begin(event)
        self._add(self._resolved(event))

    def _take_key(self, top: _Open, values: dict[str, Value], event: yaml.ScalarEvent) -> None:
        key = str(event.value)
        if key in values:
            problem = f"the key {quoted(key)} appears twice, remove one"
            refuse(self.file, _begin(event), (*top.where, key), problem)
        top.key = key
        self._keys[(*top.where, key)] = _begin(event)

    def _resolved(self, event: yaml.ScalarEvent) -> Value:
        if not event.implicit[0]:
            return str(event.value)
        try:
            value = plain_scalar(event.value)
        except NotFiniteError:
            self._refuse(event, f"expected a finite number, got {quoted(event.value)}")
        if value is None:
            self._refuse(event, NULL if self._stack else EMPTY)
        return value

    def _open(self, event: yaml.CollectionStartEvent) -> None:
        if self._stack and isinstance(self._stack[-1].values, dict) and self._stack[-1].key is None:
            self._refuse(event, "a key must be text, got a mapping or list")
        if len(self._stack) == DEEPEST_NESTING:
            self._refuse(event, TOO_DEEP)
        where = self.where()
        self._values[where] = _begin(event)
        self._stack.append(_Open(where, {} if isinstance(event, yaml.MappingStartEvent) else []))

    def _close(self) -> None:
        values = self._stack.pop().values
        self._add(tuple(values) if isinstance(values, list) else values)

    def _add(self, value: Value) -> None:
        if not self._stack:
            self._roots.append(value)
            return
        top = self._stack[-1]
        if isinstance(top.values, list):
            top.values.append(value)
        elif top.key is not None:
            top.values[top.key] = value
            top.key = None

    def _refuse_reference(self, event: yaml.NodeEvent) -> None:
        if isinstance(event, yaml.AliasEvent):
            self._refuse(event, f"the alias {quoted(f'*{event.anchor}')} is not allowed, write the value out")
        if event.anchor is not None:
            self._refuse(event, f"the anchor {quoted(f'&{event.anchor}')} is not allowed, remove it")
        if isinstance(event, yaml.ScalarEvent | yaml.CollectionStartEvent) and event.tag is not None:
            self._refuse(event, f"the tag {quoted(event.tag)} is not allowed, remove it")

    def _refuse(self, event: yaml.Event, message: str) -> NoReturn:
        refuse(self.file, _begin(event), self.where(), message)


def _begin(event: yaml.Event) -> Position:
    mark = event.start_mark
    return (mark.line + 1, mark.column + 1) if mark else (1, 1)
