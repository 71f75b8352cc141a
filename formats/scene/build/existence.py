"""When bodies exist, and until when the frames that carry them are needed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from ....scheduler.model.scene import ALWAYS
from ....scheduler.motions import Interval
from ..grammar.scene import BodyPart, TimeRange
from ..limits import SMALLEST_SIZE
from ..text.document import Findings
from ..text.errors import quoted


def existence(name: str, part: BodyPart, time: TimeRange, findings: Findings) -> Interval:
    """Return from when to when (s) a body exists; a span without length or outside the scene's time is a fault."""
    if part.exists is None:
        return ALWAYS
    begin, end = part.exists
    where = ("bodies", name, "exists")
    if end - begin < SMALLEST_SIZE:
        least = f" by at least {SMALLEST_SIZE:g} s" if end > begin else ""
        problem = f"expected to exist until after it begins ({quoted(begin)} s){least}, got {quoted(end)} s"
        findings.fault((*where, 1), problem)
    elif end <= time.start or begin >= time.end:
        problem = f"the body never exists within the scene's time, {quoted(time.start)} to {quoted(time.end)} s"
        findings.fault(where, problem)
    return begin, end


def needed_times(parents: Sequence[int | None], exists: Sequence[Interval], time: TimeRange) -> list[Interval]:
    """Return when (s) each body's frame must be known: while it or a body that it carries exists.

    Args:
        parents: the index of each body's parent.
        exists: when each one exists.
        time: the scene's.
    """
    needed = [(max(time.start, begin), min(time.end, end)) for begin, end in exists]
    children = Counter(parents)
    ready = [body for body in range(len(parents)) if not children[body]]
    while ready:  # each body once, after all that it carries; those of a faulty circle never
        body = ready.pop()
        above = parents[body]
        if above is None:
            continue
        needed[above] = min(needed[above][0], needed[body][0]), max(needed[above][1], needed[body][1])
        children[above] -= 1
        if not children[above]:
            ready.append(above)
    return needed
