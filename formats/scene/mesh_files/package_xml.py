"""The XML parts of a package such as 3MF: parsed as they stream by, with nothing that could grow without bound."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol
from xml.parsers import expat

from ..text.errors import quoted
from .surface import MeshError

_DEEPEST = 64
"""Elements within each other. A deeper part is refused."""


_LARGEST_ELEMENT = 2**20
"""Bytes that an element's tag, a comment or the like may have. The parser keeps the whole of it."""

_MOST_NAMES = 1000
"""Different names of elements, which the parser keeps. 3MF knows some 30, with all its extensions some 100."""


class ElementReader(Protocol):
    """What takes the elements of a part one by one."""

    def declare(self, prefix: str, namespace: str) -> None:
        """Take the namespace that a prefix stands for."""

    def begin(self, name: str, attributes: dict[str, str]) -> None:
        """Take the begin of an element; a name is `namespace local`, or `local` in no namespace."""

    def end(self) -> None:
        """Take the end of the last element that has not ended."""


def read_elements(chunks: Iterable[bytes], part: str, reader: ElementReader) -> None:
    """Give the elements of a part to `reader`.

    Raises:
        MeshError: it is no well-formed XML, is too deep, has too long an element or too many names of them, or has a
            document type, whose entities could grow; or the reader refuses an element. The message names the part and
            the line in it.
    """
    parser = expat.ParserCreate(namespace_separator=" ")
    depth, names = 0, set[str]()

    def begin(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > _DEEPEST:
            raise MeshError(f"elements are nested deeper than {_DEEPEST}")
        names.add(name)
        if len(names) > _MOST_NAMES:
            raise MeshError(f"elements have more than {_MOST_NAMES} different names")
        reader.begin(name, attributes)

    def end(_: str) -> None:
        nonlocal depth
        depth -= 1
        reader.end()

    def declare(prefix: str | None, namespace: str | None) -> None:
        reader.declare(prefix or "", namespace or "")

    parser.StartElementHandler = begin
    parser.EndElementHandler = end
    parser.StartNamespaceDeclHandler = declare
    parser.StartDoctypeDeclHandler = _refuse_doctype
    given = 0
    for chunk in chunks:
        _parse(parser, chunk, False, part)
        given += len(chunk)
        if given - parser.CurrentByteIndex > _LARGEST_ELEMENT:
            line = parser.CurrentLineNumber
            raise MeshError(
                f"{quoted(part)}, line {line}: an element or a comment has more than {_LARGEST_ELEMENT} bytes"
            )
    _parse(parser, b"", True, part)


def _parse(parser: expat.XMLParserType, chunk: bytes, last: bool, part: str) -> None:
    try:
        parser.Parse(chunk, last)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        raise MeshError(f"{quoted(part)}, line {error.lineno}: not well-formed XML, {reason}") from error
    except MeshError as error:
        raise MeshError(f"{quoted(part)}, line {parser.CurrentLineNumber}: {error.message}") from error


def _refuse_doctype(*_: object) -> None:
    raise MeshError("expected no document type")
