"""What a run calls as it goes on: a progress bar, for example."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import AbstractContextManager, nullcontext

from ...formats.log.viewer.pictures import Picture
from ...scheduler.model.events import Event
from ...scheduler.model.scene import Scene

Events = Generator[Event | Picture, None, None]
"""The events of a run, with its snapshots or pictures."""

SharesDone = Callable[[str, int, int], None]
"""A function of the name of a step, how many of its shares are done, and how many there are."""


class Watcher:
    """A run calls these methods. Here they do nothing."""

    def ready(self) -> None:
        """The scene is read and checked; the log begins after this."""

    def events(self, events: Events, scene: Scene, told: bool) -> Events:
        """Return the events, to observe each as the log takes it.

        Args:
            events: of the whole run.
            scene: of the run.
            told: whether workers have already found all events.
        """
        return events

    def shares(self) -> AbstractContextManager[SharesDone]:
        """Return a context with a function, to which the run reports the progress of its workers."""
        return nullcontext(lambda step, done, of: None)


UNWATCHED = Watcher()
