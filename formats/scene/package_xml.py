"""The XML parts of a package such as 3MF: parsed as they stream by, with nothing that could grow without bound."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol
from xml.parsers import expat

from .errors import quoted
from .surface import MeshError

_DEEPEST = 64
"""Elements within each other. A deeper part is refused."""


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
        MeshError: it is no well-formed XML, is too deep, or has a document type, whose entities could grow; or the
            reader refuses an element. The message names the part and the line in it.
    """
    parser = expat.ParserCreate(namespace_separator=" ")
    depth = 0

    def begin(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > _DEEPEST:
            raise MeshError(f"elements are nested deeper than {_DEEPEST}")
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
    for chunk in chunks:
        _parse(parser, chunk, False, part)
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
