"""The summary that a log carries, as it is read back: a file like any other, and held to what summaries are."""

from __future__ import annotations

import json
from types import NoneType, UnionType
from typing import Any, NoReturn, cast, get_args, get_origin, get_type_hints, is_typeddict

from ..scene.text.errors import quoted
from .container.checks import MOST_METRES
from .container.identity import Identity
from .severity import VERDICTS
from .summary import Contact, PairSummary, Summary

_MOST_COUNT = 2**63 - 1


class SummaryError(ValueError):
    """A summary that is none: where, and what is wrong there."""


class OlderSummaryError(SummaryError):
    """A summary that lacks what this version writes."""


def as_summary(data: bytes) -> Summary:
    """Return the summary that is written so.

    Raises:
        SummaryError: where it is none.
    """
    try:
        value = json.loads(data, parse_constant=_refuse_constant)
    except RecursionError as error:
        raise SummaryError("it is nested too deeply") from error
    except ValueError as error:
        raise SummaryError("it is not JSON") from error
    _require(value, Summary, "it")
    summary = cast(Summary, value)
    _interval(summary["time"], "time")
    for verdict in VERDICTS:
        if verdict not in summary["totals"]["pairs"]:
            raise OlderSummaryError(f"totals.pairs.{verdict} is missing")
    for index, pair in enumerate(summary["pairs"]):
        _require_pair(pair, f"pairs[{index}]")
    return summary


def require_same_run(summary: Summary, identity: Identity) -> None:
    """Check that a summary is of the run that its log tells of.

    Raises:
        SummaryError: where it is not.
    """
    told = summary["time"], summary["pairs_total"]
    if told != ([identity.start, identity.end], identity.pairs_total):
        raise SummaryError("its time or its number of pairs differs from the log")


def _require_pair(pair: PairSummary, where: str) -> None:
    if pair["verdict"] not in VERDICTS:
        raise SummaryError(f"{where}.verdict is {quoted(pair['verdict'])}")
    if pair["pair"] != f"{pair['body_a']}|{pair['body_b']}":
        raise SummaryError(f"{where}.pair is {quoted(pair['pair'])}")
    distance = pair["distance"]
    lengths = pair["margin"], pair["chord_error"], distance["lower"], distance["upper"] or 0.0
    if min(lengths) < 0.0 or (distance["upper"] is None) is not (distance["time"] is None):
        raise SummaryError(f"{where} has an impossible length")
    for spans in (pair["breaches"], pair["unresolved"], pair["possible"]):
        for span in spans:
            _interval(span, where)
    for contact in pair["contacts"]:
        _require_contact(contact, where)


def _require_contact(contact: Contact, where: str) -> None:
    _interval(contact["begin"], where)
    if contact["end"] is not None:
        _interval(contact["end"], where)
    if any(len(keys) != 2 for keys in contact["keys"].values()):
        raise SummaryError(f"{where} has a contact that is not between two keys")


def _interval(value: list[float], where: str) -> None:
    if len(value) != 2 or not value[0] <= value[1]:
        raise SummaryError(f"{where} has an impossible interval: {quoted(str(value))}")


def _require(value: Any, kind: Any, where: str) -> None:
    """Check that a value of JSON is of a type that summaries are made of."""
    if is_typeddict(kind):
        _require(value, dict, where)
        for key, inner in get_type_hints(kind).items():
            if key not in value:
                raise OlderSummaryError(f"{where} has no {key}")
            _require(value[key], inner, f"{where}.{key}".removeprefix("it."))
        return
    origin, inner = get_origin(kind), get_args(kind)
    if origin is UnionType:
        if value is not None or NoneType not in inner:
            _require(value, inner[0], where)
    elif origin is list:
        _require(value, list, where)
        for index, one in enumerate(value):
            _require(one, inner[0], f"{where}[{index}]")
    elif origin is dict:
        _require(value, dict, where)
        for key, one in value.items():
            _require(one, inner[1], f"{where}.{key}")
    elif not _is_plain(value, kind):
        raise SummaryError(f"{where} is {quoted(value)}")


def _is_plain(value: Any, kind: type) -> bool:
    if kind is float:
        return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= MOST_METRES
    if kind is int:
        return isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= _MOST_COUNT
    return isinstance(value, kind)


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not JSON")
