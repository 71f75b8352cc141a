"""Chains of parents: each ends in the world."""

from __future__ import annotations

from collections.abc import Sequence

from ..text.document import Findings
from ..text.errors import quoted

_LONGEST_CYCLE_SHOWN = 8


def check_parents(names: Sequence[str], parents: Sequence[int | None], findings: Findings) -> None:
    """Record each cycle of parents once, at the body of it that the file names first.

    Args:
        names: of the bodies, as written.
        parents: the index of each body's parent, None for the world.
        findings: takes the faults.
    """
    walk_of: dict[int, int] = {}
    for first in range(len(names)):
        chain: list[int] = []
        body: int | None = first
        while body is not None and body not in walk_of:
            walk_of[body] = first
            chain.append(body)
            body = parents[body]
        if body is not None and walk_of[body] == first:
            _record_cycle(chain[chain.index(body) :], names, findings)


def _record_cycle(cycle: list[int], names: Sequence[str], findings: Findings) -> None:
    begin = cycle.index(min(cycle))
    cycle = cycle[begin:] + cycle[:begin]
    where = ("bodies", names[cycle[0]], "parent")
    if len(cycle) == 1:
        findings.fault(where, "a body cannot be its own parent, name another or leave the key out")
        return
    shown = [quoted(names[body]) for body in cycle[:_LONGEST_CYCLE_SHOWN]]
    if len(cycle) > _LONGEST_CYCLE_SHOWN:
        shown.append("...")
    way = " -> ".join((*shown, quoted(names[cycle[0]])))
    findings.fault(where, f"the parents go in a circle ({way}), one of them must have no parent")
