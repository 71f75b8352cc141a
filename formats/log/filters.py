"""Filters that match nothing are mistakes: they are refused, with the names that may have been meant."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from difflib import get_close_matches
from fnmatch import fnmatchcase
from pathlib import Path

from ..scene.text.errors import quoted
from .errors import LogError
from .message_filter import bar_closed, is_pair_among
from .reader import LogReader
from .result import Found

#: The topics of a log, those by body without the body.
TOPICS = (
    *("/windows", "/wakeups", "/distances", "/collisions", "/spans", "/log", "/world", "/tf"),
    *("/scene/meshes", "/scene/boxes", "/viz/clearance", "/viz/contacts", "/viz/names"),
)

#: So many names at most are named for a filter that matches nothing.
_MOST_NAMED = 3
#: Of more names none is sought: comparing them takes 50 us each.
_MOST_COMPARED = 10_000
#: How alike (0 to 1) a name is that may have been meant.
_LIKENESS = 0.4


def require_pairs(log: Path, patterns: Collection[str], found: Found, option: str = "--pair") -> None:
    """Check that each pattern matches a pair of a log, or one of its bodies.

    Pairs that swept boxes cleared are not listed; the boxes name their bodies. Nothing is refused of a log that is not
    whole: it may have lost any pair.

    Raises:
        LogError: for a pattern that matches nothing.
    """
    if found.loss is not None:
        return
    pairs = [pair["pair"] for pair in found.summary["pairs"]]
    missing = [pattern for pattern in patterns if not any(is_pair_among(pair, (pattern,)) for pair in pairs)]
    if missing and found.summary["pairs_total"] > len(pairs):
        bodies = bodies_of_windows(log)
        missing = [pattern for pattern in missing if not _among_bodies(pattern, bodies)]
    if missing:
        raise LogError(log, f"{option} {quoted(missing[0])} matches no pairs", _nearest(missing[0], pairs))


def require_topics(log: Path, patterns: Iterable[str], option: str = "--topic") -> None:
    """Check that each pattern matches a topic of a log, or a field of one ("/wakeups.sleep").

    Raises:
        LogError: for a pattern that matches nothing.
    """
    for pattern in patterns:
        forms = (pattern, pattern.rpartition(".")[0])
        if not any(fnmatchcase(topic, form) for topic in TOPICS for form in forms):
            near = get_close_matches(forms[-1] or pattern, TOPICS, _MOST_NAMED, _LIKENESS) or TOPICS
            raise LogError(log, f"{option} {quoted(pattern)} matches no topics", f"choose from {', '.join(near)}")


def bodies_of_windows(log: Path) -> set[str]:
    """Return the names of the bodies that a log has swept boxes of."""
    with LogReader(log) as reader:
        return {message.body for _, _, message in reader.facts("/windows")}


def _among_bodies(pattern: str, bodies: Collection[str]) -> bool:
    """Tell whether each side of a pattern matches a body."""
    sides = bar_closed(pattern).split("|")
    return all(any(fnmatchcase(body, side) for body in bodies) for side in sides)


def _nearest(pattern: str, pairs: Collection[str]) -> str:
    """Return the pairs, or the bodies for a pattern without a bar, whose names are most like a pattern."""
    if "|" in pattern:
        names = {"|".join(reversed(pair.split("|"))): pair for pair in pairs} | {pair: pair for pair in pairs}
    else:
        names = {body: body for pair in pairs for body in pair.split("|")}
    near = []
    if 0 < len(names) <= _MOST_COMPARED:
        near = [names[name] for name in get_close_matches(bar_closed(pattern), names, len(names), _LIKENESS)]
    found = list(dict.fromkeys(near)) or list(dict.fromkeys(names.values()))
    if not found:
        return "the log lists no pairs"
    more = f" and {len(found) - _MOST_NAMED} more" if not near and len(found) > _MOST_NAMED else ""
    return f"{'similar names' if near else 'choose from'}: {', '.join(map(quoted, found[:_MOST_NAMED]))}{more}"
