"""Exponential back-off: after a failed try skip 1, 3, then 7 opportunities; start again after a success."""

from __future__ import annotations

#: So many chances in turn are let pass at most.
MOST_PASSED = 7


class Backoff:
    """Chances to try something, most of which pass after it has failed some times."""

    def __init__(self) -> None:
        """Begin with a try."""
        self._pass = 0  # how many chances pass after a try
        self._left = 0  # and how many of them still will

    def due(self) -> bool:
        """Take an opportunity: return whether to try."""
        self._left -= 1
        return self._left < 0

    def learn(self, paid: bool) -> None:
        """Take in whether a try paid."""
        self._pass = 0 if paid else min(MOST_PASSED, 2 * self._pass + 1)
        self._left = self._pass
