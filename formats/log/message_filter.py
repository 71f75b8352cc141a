"""Which of a log's messages are wanted: patterns for pairs and topics, and an interval of time."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from math import inf
from typing import Any

_BAR = re.compile(r"\s*\|\s*")


@dataclass(frozen=True, slots=True)
class Choice:
    """What is wanted of a log.

    Attributes:
        topics: patterns; all topics if there are none. A topic by body goes by the name without the body.
        pairs: patterns; all pairs, and what is of no pair, if there are none.
        start, end: s; spans and windows that reach into the interval belong to it.
    """

    topics: tuple[str, ...] = ()
    pairs: tuple[str, ...] = ()
    start: float = -inf
    end: float = inf

    def wants_topic(self, topic: str) -> bool:
        """Tell whether a topic, without a body, is wanted."""
        return not self.topics or any(fnmatchcase(topic, pattern) for pattern in self.topics)

    def wants(self, message: Any, time: float) -> bool:
        """Tell whether a message of a wanted topic, of a time in s, is wanted itself."""
        fields = message.DESCRIPTOR.fields_by_name
        first, last = (message.start, message.end) if "start" in fields else (time, time)
        if last < self.start or first > self.end:
            return False
        return not self.pairs or ("pair_id" in fields and is_pair_among(message.pair, self.pairs))


def is_pair_among(pair: str, patterns: Iterable[str]) -> bool:
    """Tell whether a pair, "a|b", is one of those that patterns name.

    A pattern with a bar is a pair's, in whichever order ("arm|*"); one without is a body's, in any pair ("tool*").
    Blanks around the bar may be there, as tables print them ("arm | hand").
    """
    body_a, _, body_b = pair.partition("|")
    names = (pair, f"{body_b}|{body_a}"), (body_a, body_b)
    return any(
        fnmatchcase(name, form) for pattern in patterns for form in _forms(pattern) for name in names["|" not in form]
    )


def _forms(pattern: str) -> set[str]:
    """Return a pattern as typed, and without blanks around its bar."""
    return {unicodedata.normalize("NFC", pattern), bar_closed(pattern)}


def bar_closed(pattern: str) -> str:
    """Return a pattern without blanks around its bar, in the Unicode form of names."""
    return _BAR.sub("|", unicodedata.normalize("NFC", pattern))
