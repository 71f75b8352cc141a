"""The metadata of a run, read back and checked: another program may have written it."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any, NoReturn

from ....scheduler.motions import Interval
from ...scene.quantities.units import METRES
from ...scene.text.errors import quoted
from .checks import MOST_METRES, MOST_SECONDS
from .clock import LATEST_LOG_TIME_NS
from .identity import Identity

MOST_BODIES = 2**32
"""Of a log. The rank of a pair of more has no 64 bits."""

_COUNT = re.compile(r"[0-9]{1,20}")
_WHOLE = re.compile(r"-?[0-9]{1,20}")


def read_identity(values: Mapping[str, str]) -> Identity:
    """Return the metadata of a log; older logs lack some of its values.

    Raises:
        ValueError: names a value that is missing or impossible.
    """
    bodies = _count(values, "count/bodies", MOST_BODIES)
    most_pairs = bodies * (bodies - 1) // 2
    identity = Identity(
        version=_text(values, "version"),
        scene_sha256=_text(values, "scene_sha256"),
        start=_time(values, "start"),
        end=_time(values, "end"),
        epoch=_epoch(values),
        bodies=bodies,
        pairs_total=_count(values, "count/pairs", most_pairs),
        pairs_ignored=_count(values, "count/ignored", most_pairs) if "count/ignored" in values else 0,
        settings=_settings(values),
        chord_errors={body: _length(one, "chord_errors") for body, one in _mapping(values, "chord_errors").items()},
        exists={body: _interval(one, "exists") for body, one in _mapping(values, "exists").items()},
        margins=_margins(values),
        length_unit=_length_unit(values),
    )
    if identity.start > identity.end:
        raise ValueError(f"its end is {identity.end!r} s, before its start at {identity.start!r} s")
    if identity.log_time(identity.start) < 0 or identity.log_time(identity.end) > LATEST_LOG_TIME_NS:
        raise ValueError(f"its epoch is {identity.epoch} ns, which puts log times outside 0 to 2^63 - 1 ns")
    return identity


def _text(values: Mapping[str, str], key: str) -> str:
    if key not in values:
        raise ValueError(f"its {key} is missing")
    return values[key]


def _time(values: Mapping[str, str], key: str) -> float:
    text = _text(values, key)
    try:
        time = float(text)
    except ValueError:
        _refuse(key, text)
    return time if abs(time) <= MOST_SECONDS else _refuse(key, text)


def _epoch(values: Mapping[str, str]) -> int:
    text = _text(values, "epoch")
    return int(text) if _WHOLE.fullmatch(text) else _refuse("epoch", text)


def _count(values: Mapping[str, str], key: str, most: int) -> int:
    text = _text(values, key)
    return int(text) if _COUNT.fullmatch(text) and int(text) <= most else _refuse(key, text)


def _json(values: Mapping[str, str], key: str) -> Any:
    try:
        return json.loads(values[key])
    except (ValueError, RecursionError):
        return _refuse(key, values[key])


def _mapping(values: Mapping[str, str], key: str) -> dict[str, Any]:
    found = _json(values, key) if key in values else {}
    return found if isinstance(found, dict) else _refuse(key, found)


def _settings(values: Mapping[str, str]) -> dict[str, float | None]:
    _text(values, "settings")
    found = _mapping(values, "settings")
    if "margin" not in found:
        raise ValueError("its settings have no margin")
    return {key: None if value is None else _length(value, f"settings: {key}") for key, value in found.items()}


def _margins(values: Mapping[str, str]) -> tuple[tuple[frozenset[str], frozenset[str], float], ...]:
    found = _json(values, "margins") if "margins" in values else []
    if not isinstance(found, list):
        _refuse("margins", found)
    rules = []
    for rule in found:
        if not (isinstance(rule, list) and len(rule) == 3 and _are_names(rule[0]) and _are_names(rule[1])):
            _refuse("margins", rule)
        rules.append((frozenset(rule[0]), frozenset(rule[1]), _length(rule[2], "margins")))
    return tuple(rules)


def _length_unit(values: Mapping[str, str]) -> str:
    unit = values.get("length_unit", "m")
    return unit if unit in METRES else _refuse("length_unit", unit)


def _are_names(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(name, str) for name in value)


def _interval(value: Any, key: str) -> Interval:
    if isinstance(value, list) and len(value) == 2 and all(map(_is_number, value)):
        low, high = value
        if -MOST_SECONDS <= low <= high <= MOST_SECONDS:
            return float(low), float(high)
    return _refuse(key, value)


def _length(value: Any, key: str) -> float:
    return float(value) if _is_number(value) and 0.0 <= value <= MOST_METRES else _refuse(key, value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _refuse(key: str, value: Any) -> NoReturn:
    raise ValueError(
        f"its {key} cannot be {quoted(value if isinstance(value, str | int | float) else json.dumps(value))}"
    )
