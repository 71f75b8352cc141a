"""pydantic's errors in the scene's own words, each at the line of its key or value."""

from __future__ import annotations

import re
import types
from collections.abc import Callable, Iterator, Sequence
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import Tag, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from ..text.document import Document, Findings
from ..text.errors import Where, quoted, suggestion
from .base import Part
from .motions import MOTIONS
from .scene import SceneFile
from .shapes import SHAPES

_MEASURE = re.compile(r"[-+]?[0-9.]+([eE][-+]?[0-9]+)? *[^\W\d_]+\Z|[-+]?[0-9.]+ *[°%\"']\Z")
"""A number with a unit after it."""

_NUMBER_OR: dict[tuple[int | str, ...], str] = {
    ("scale", "all"): "a number or a list of 3",
    ("distance_tolerance", "share"): "a number or none",
}
"""Where another value than a number may stand, by the end of pydantic's `loc`."""

FORMAT_VERSION = 1


def parsed(document: Document) -> SceneFile:
    """Return the document as the grammar reads it.

    Raises:
        SceneError: with every fault of grammar in it.
    """
    findings = Findings(document)
    root = document.value
    if isinstance(root, dict) and "closecall" in root and not _is_version(root["closecall"]):
        got = quoted(root["closecall"])
        findings.fault(("closecall",), f"expected format version {FORMAT_VERSION}, got {got}")
        findings.stop_if_faulty()
    try:
        return SceneFile.model_validate(root)
    except ValidationError as error:
        _record(error, findings)
        findings.stop_if_faulty()
        raise


def _is_version(value: object) -> bool:
    return not isinstance(value, bool) and value == FORMAT_VERSION


def _record(error: ValidationError, findings: Findings) -> None:
    told: set[tuple[Where, str]] = set()
    for details in error.errors(include_url=False):
        if details["type"] == "too_short" and details["input"]:
            continue  # its entries are faulty themselves, and pydantic counts the good ones
        where, message, at_key = _told(details)
        if (where, message) in told:
            continue
        told.add((where, message))
        if at_key is None:
            findings.fault(where, message)
        else:
            findings.fault_at_key(at_key, message, where)


def _told(details: ErrorDetails) -> tuple[Where, str, Where | None]:
    """Return the place of an error, its message, and the key to point at unless it is the value."""
    kind, loc = details["type"], details["loc"]
    if kind == "missing" and isinstance(loc[-1], str):
        where, _ = _followed(loc[:-1])
        _, annotation = _followed(loc)
        words = [str(word) for word in get_args(annotation)] if get_origin(annotation) is Literal else []
        expected = f", expected {_one_of(words)}" if words else ""
        return where, f"missing key {quoted(loc[-1])}{expected}", where
    if kind == "extra_forbidden":
        where, annotation = _followed(loc[:-1])
        return where, _unknown_key(annotation, str(loc[-1])), (*where, loc[-1])
    if kind in ("missing", "too_long"):
        where, annotation = _followed(loc[:-1] if kind == "missing" else loc)
        return where, _wrong_count(annotation, details), None
    if kind.startswith("union_tag"):
        where, _ = _followed(loc)
        return _wrong_choice(where, details["input"])
    where, _ = _followed(loc)
    if kind == "literal_error":
        return where, _wrong_word(loc, details["input"]), None
    reword = _WORDINGS.get(kind)
    return where, reword(details) if reword else details["msg"], None


def _unknown_key(annotation: Any, key: str) -> str:
    if not (isinstance(annotation, type) and issubclass(annotation, Part)):
        return f"unknown key {quoted(key)}"
    known = _keys(annotation)
    return f"unknown key {quoted(key)}{suggestion(key, known)}, expected {_one_of(known)}"


def _wrong_count(annotation: Any, details: ErrorDetails) -> str:
    items, got = get_args(annotation), details["input"]
    count = len(got) if isinstance(got, tuple) else 0
    if items and items[-1] is Ellipsis:
        return f"expected at most {details.get('ctx', {})['max_length']} entries, got {count}"
    what = {float: "numbers", str: "names"}.get(_bare(items[0]), "lists") if items else "values"
    return f"expected {len(items)} {what}, got {count}"


def _wrong_choice(where: Where, got: Any) -> tuple[Where, str, Where | None]:
    """Tell why no motion or no shape was recognised."""
    motion = where[-1] == "motion"
    if not isinstance(got, dict):
        key = "'type'" if motion else _one_of(SHAPES)
        return where, f"expected a mapping with the key {key}, got {quoted(got)}", None
    return _wrong_motion(where, got) if motion else _wrong_shape(where, got)


def _wrong_motion(where: Where, got: dict[str, Any]) -> tuple[Where, str, Where | None]:
    if "type" not in got:
        return where, f"missing key 'type', expected one of {_one_of(MOTIONS)}", where
    name = got["type"]
    near = suggestion(name, MOTIONS)
    return (*where, "type"), f"unknown motion {quoted(name)}{near}, expected {_one_of(MOTIONS)}", None


def _wrong_shape(where: Where, got: dict[str, Any]) -> tuple[Where, str, Where | None]:
    known = [kind for kind in SHAPES if kind in got]
    if known:
        return where, f"expected one of {_one_of(SHAPES)}, got {' and '.join(known)}", None
    unknown = [key for key in got if key != "pose"]
    if not unknown:
        return where, f"missing key, expected {_one_of(SHAPES)}", None
    near = suggestion(unknown[0], SHAPES)
    message = f"unknown shape {quoted(unknown[0])}{near}, expected {_one_of(SHAPES)}"
    return where, message, (*where, unknown[0])


def _wrong_word(loc: tuple[int | str, ...], got: Any) -> str:
    _, annotation = _followed(loc)
    words = [str(word) for word in get_args(annotation)]
    return f"expected {_one_of(words)}, got {quoted(got)}{suggestion(got, words)}"


def _too_small(details: ErrorDetails) -> str:
    least, got = details.get("ctx", {})["ge"], details["input"]
    if least > 0 and got <= 0:
        return f"expected a number greater than 0, got {quoted(got)}"
    return f"expected a number of at least {least:g}, got {quoted(got)}"


def _no_number(details: ErrorDetails) -> str:
    what = _NUMBER_OR.get(details["loc"][-2:], "a number")
    got = details["input"]
    remedy = ": write the number alone, 'units' says its unit" if isinstance(got, str) and _MEASURE.match(got) else ""
    return f"expected {what}, got {quoted(got)}{remedy}"


def _expected(what: str) -> Callable[[ErrorDetails], str]:
    return lambda details: f"expected {what}, got {quoted(details['input'])}"


_WORDINGS: dict[str, Callable[[ErrorDetails], str]] = {
    "float_type": _no_number,
    "finite_number": _expected("a finite number"),
    "string_type": _expected("text"),
    "dict_type": _expected("a mapping"),
    "model_type": _expected("a mapping"),
    "model_attributes_type": _expected("a mapping"),
    "tuple_type": _expected("a list"),
    "bool_type": _expected("true or false"),
    "too_short": lambda details: "expected at least one entry, got none",
    "string_too_short": lambda details: "expected text, got an empty one",
    "greater_than_equal": _too_small,
    "less_than": lambda details: (
        f"expected a number less than {details.get('ctx', {})['lt']:g}, got {quoted(details['input'])}"
    ),
    "less_than_equal": lambda details: (
        f"expected a number of at most {details.get('ctx', {})['le']:g}, got {quoted(details['input'])}"
    ),
}


def _one_of(words: Sequence[str]) -> str:
    return ", ".join(words[:-1]) + " or " + words[-1] if len(words) > 1 else words[0]


def _followed(loc: tuple[int | str, ...]) -> tuple[Where, Any]:
    """Return where pydantic's `loc` leads in the document, and what the grammar expects there.

    `loc` also names the member of each union it passes; those names are no keys of the document.
    """
    where: list[str | int] = []
    annotation: Any = SceneFile
    for step in loc:
        annotation = _bare(annotation)
        if get_origin(annotation) in (Union, types.UnionType):
            annotation = _member(annotation, step)
            continue
        where.append(step)
        annotation = _child(annotation, step)
    return tuple(where), _bare(annotation)


def _bare(annotation: Any) -> Any:
    """Return a type without its annotations, and what may be absent without the absence."""
    while get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    if get_origin(annotation) in (Union, types.UnionType):
        present = [member for member in get_args(annotation) if _bare(member) is not types.NoneType]
        if len(present) == 1:
            return _bare(present[0])
    return annotation


def _member(union: Any, tag: str | int) -> Any:
    return next((member for member in get_args(union) if Tag(str(tag)) in getattr(member, "__metadata__", ())), None)


def _fields(part: type[Part]) -> Iterator[tuple[str, FieldInfo]]:
    """Yield a mapping's keys as they are written, each with what the grammar says of it."""
    for name, field in part.model_fields.items():
        yield field.alias or name, field


def _keys(part: type[Part]) -> list[str]:
    return [key for key, _ in _fields(part) if not key.startswith("$")]


def _child(annotation: Any, step: str | int) -> Any:
    if isinstance(annotation, type) and issubclass(annotation, Part):
        return next((field.annotation for key, field in _fields(annotation) if key == step), None)
    items = get_args(annotation)
    if get_origin(annotation) is dict:
        return items[1]
    if get_origin(annotation) is tuple and isinstance(step, int):
        return items[0] if items[-1] is Ellipsis else items[min(step, len(items) - 1)]
    return None
