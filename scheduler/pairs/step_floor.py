"""The minimum step, the lecture's t_min. An unproved step is retried at a quarter; a proved step doubles it again."""

from __future__ import annotations

from math import ulp

from ..model.scene import Settings

#: How often a pair may step finer than the time resolution before something restores the number: a contact's begin or
#: end, or a proved step of the whole resolution. Leaving a contact with a bound r times the true speed takes about
#: 3.5 r such steps.
FINE_STEPS = 256
#: So many of them come back with each time resolution that passes: what a long graze costs is at most so many times
#: what measuring at each time resolution would.
STEPS_BACK = 16.0
#: The finest of those steps, as a share of the contact tolerance; none is finer than the tolerance of a crossed margin.
FINEST = 1.0 / 256.0


class StepFloor:
    """The least sleep of a pair (s), now.

    A step of the floor that cannot be proved clear is taken back and tried with a quarter of it, down to a share of the
    tolerance and while `FINE_STEPS` last; each step of the floor that is proved doubles it again, and at least
    to the tolerance: touching there, it would close a bracket.
    """

    def __init__(self, settings: Settings, tolerance: float, latest: float) -> None:
        """Start at the time resolution; `tolerance` is the least bracket in s, no time is greater than `latest` s."""
        self._resolution = settings.time_resolution
        self._tolerance = tolerance
        self._finest = max(min(FINEST * settings.contact_tolerance, tolerance), 8.0 * ulp(latest))
        self.restore()

    @property
    def finer(self) -> bool:
        """Whether the floor lies below the time resolution."""
        return self.seconds < self._resolution

    def restore(self) -> None:
        """Return to the time resolution, with all fine steps to spend."""
        self.seconds = self._resolution
        self._steps_left = float(FINE_STEPS)

    def proved(self, step: float) -> None:
        """Take in that a step (s) was proved clear."""
        if step >= self._resolution:
            self.restore()
            return
        if step <= self.seconds:
            self.seconds = min(max(2.0 * self.seconds, self._tolerance), self._resolution)
        self._spend()
        self._pass(step)

    def failed(self, step: float) -> bool:
        """Take in that a step (s) proved nothing; return whether to take it back and make it finer."""
        self._spend()
        if self._steps_left < 1.0 or step <= 2.0 * self._finest:
            self._pass(step)
            return False
        self.seconds = max(0.25 * step, self._finest)
        return True

    def _pass(self, step: float) -> None:
        """Give steps back for a time (s) that has passed."""
        self._steps_left = min(FINE_STEPS, self._steps_left + STEPS_BACK * step / self._resolution)

    def _spend(self) -> None:
        """Count a fine step; when none is left, the whole resolution is the floor again."""
        self._steps_left = max(0.0, self._steps_left - 1.0)
        if self._steps_left < 1.0:
            self.seconds = self._resolution
