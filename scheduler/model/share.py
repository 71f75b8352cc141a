"""A share of a scene's pairs.

Each pair depends on its own measurements alone, so each share runs alone.
"""

from __future__ import annotations

from typing import NamedTuple

#: 2^32 over the golden ratio: scatters numbers evenly that come in rows or at regular distances, as neighbours' do.
_SCATTER = 2654435769


class Share(NamedTuple):
    """One of `of` shares, `number` from 0 on, into which the pairs are dealt by their ids."""

    number: int
    of: int

    def has(self, pair: int) -> bool:
        """Return whether the pair of this id belongs to the share."""
        return self.of == 1 or ((pair * _SCATTER & 0xFFFFFFFF) * self.of >> 32) == self.number


WHOLE = Share(0, 1)
"""All pairs."""


def shares_of(of: int) -> list[Share]:
    """Return all of so many shares."""
    return [Share(number, of) for number in range(of)]
