"""The tree of bodies: which body carries which."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..motions import Fixed
from .scene import Body


def ancestors(bodies: tuple[Body, ...], body: int) -> tuple[int, ...]:
    """Return the body and its ancestors, nearest first."""
    line = [body]
    while (parent := bodies[line[-1]].parent) is not None:
        line.append(parent)
    return tuple(line)


def rigid_group(bodies: tuple[Body, ...], body: int) -> int | None:
    """Return the nearest of a body and its ancestors that moves in its parent; bodies of one never part."""
    return next((index for index in ancestors(bodies, body) if not isinstance(bodies[index].motion, Fixed)), None)


def anchors(bodies: tuple[Body, ...]) -> NDArray[np.int64]:
    """Return every body's anchor, (n,); -1 for none."""
    found = (rigid_group(bodies, index) for index in range(len(bodies)))
    return np.array([-1 if at is None else at for at in found], dtype=np.int64)


def topological_order(bodies: tuple[Body, ...]) -> tuple[int, ...]:
    """Return the bodies' indices ordered so that a parent comes before its children."""
    order: list[int] = []
    placed: set[int] = set()
    for body in range(len(bodies)):
        missing = []
        above: int | None = body
        while above is not None and above not in placed:
            missing.append(above)
            above = bodies[above].parent
        order.extend(reversed(missing))
        placed.update(missing)
    return tuple(order)


def common_ancestor(bodies: tuple[Body, ...], a: int, b: int) -> int | None:
    """Return the lowest common ancestor, which may be a or b itself; None for the world."""
    above_b = set(ancestors(bodies, b))
    return next((body for body in ancestors(bodies, a) if body in above_b), None)
