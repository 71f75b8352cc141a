"""The `pairs` section: names, groups and patterns to the sets of bodies that the scheduler's rules speak of."""

from __future__ import annotations

from ....scheduler.model.scene import PairRules, PairSet
from ..grammar.scene import PairPart, PairsPart
from ..quantities.units import Scale
from ..text.document import Findings
from ..text.errors import Where, quoted
from .names import Bodies


def pair_rules(part: PairsPart, bodies: Bodies, scale: Scale, findings: Findings) -> PairRules:
    """Return the rules of a scene; what names nothing is recorded as a fault.

    Args:
        part: as the grammar read it.
        bodies: what may be named.
        scale: the file's units.
        findings: takes the faults.
    """

    def sets(section: str, written: tuple[PairPart, ...]) -> tuple[PairSet, ...]:
        return tuple(_pair_set(one, ("pairs", section, i), bodies, findings) for i, one in enumerate(written))

    margins = [scale.length(one.margin) for one in part.margins]
    return PairRules(
        ignored=sets("ignore", part.ignore),
        checked=sets("check", part.check),
        default=part.default == "check",
        margins=tuple(zip(sets("margins", part.margins), margins, strict=True)),
    )


def _pair_set(part: PairPart, where: Where, bodies: Bodies, findings: Findings) -> PairSet:
    sides = [(*where, "between", i) for i in range(2)]
    one, other = (bodies.matching(name, side) for name, side in zip(part.between, sides, strict=True))
    if one == other and len(one) == 1:
        (index,) = one
        name = quoted(bodies.names[index])
        findings.fault(sides[1], f"expected two bodies, both sides are the body {name} alone")
    return PairSet(one, other)
