"""Two log files into one comparison."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from ..errors import LogError
from ..filters import require_pairs, require_topics
from ..reader import LogReader
from ..result import FINDINGS, Found, fold
from .difference import Comparison
from .findings import Rules, differences, notes, require_comparable
from .topics import TopicDiff


def compare(golden: Path, new: Path, rules: Rules, every_topic: bool = False) -> Comparison:
    """Compare what two logs found, by their facts; the summaries that they carry are not asked.

    Args:
        golden: the log that is right.
        new: the log to be judged.
        rules: what counts as the same.
        every_topic: whether all messages are compared too, beside what they say together.

    Raises:
        LogError: for what is no log of closecall, or no log of the same time and pairs.
    """
    before, after = fold(golden, FINDINGS), fold(new, FINDINGS)
    require_comparable(before, after, new, rules)
    _require_ignored(golden, new, before, after, rules.ignored.patterns)
    found = list(differences(before, after, rules))
    losses = before.loss, after.loss
    if every_topic:
        with LogReader(golden) as one, LogReader(new) as other:
            found += TopicDiff(one, other, rules.tolerances, rules.ignored).differences()
            losses = before.loss or one.loss, after.loss or other.loss
    names = {frozenset((pair["body_a"], pair["body_b"])): pair["pair"] for pair in after.summary["pairs"]}
    names |= {frozenset((pair["body_a"], pair["body_b"])): pair["pair"] for pair in before.summary["pairs"]}
    return Comparison(
        differences=tuple(found),
        pairs=tuple(name for name in names.values() if not rules.ignored.pair(name)),
        notes=tuple(notes(before, after)),
        losses=tuple(loss for loss in losses if loss is not None),
        length_unit=before.length_unit,
    )


def _require_ignored(golden: Path, new: Path, before: Found, after: Found, patterns: tuple[str, ...]) -> None:
    """Check that each pattern to be ignored matches something in one of the logs at least.

    Raises:
        LogError: for one that matches nothing.
    """
    require_topics(new, (pattern for pattern in patterns if pattern.startswith("/")), "--ignore")
    for pattern in patterns:
        if not pattern.startswith("/"):
            with suppress(LogError):
                require_pairs(golden, (pattern,), before, "--ignore")
                continue
            require_pairs(new, (pattern,), after, "--ignore")
