"""When snapshots are taken: at regular ticks, when bodies begin or cease to exist, and at every collision."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from heapq import merge
from itertools import groupby
from math import floor
from typing import Generic, NamedTuple, Protocol, TypeVar

import numpy as np

from ..model.events import Collision, Event, Phase, Wakeup
from ..model.scene import Scene
from .snapshot import lifetimes


class Instant(NamedTuple):
    """A time (s), the ids of the pairs that touch then, and the collision that it is looked at for, if any."""

    time: float
    touching: frozenset[int]
    trigger: Collision | None = None


class Seen(Protocol):
    """A snapshot, or what is made of it."""

    @property
    def time(self) -> float:
        """When (s) it was taken."""
        ...


SeenT = TypeVar("SeenT", bound=Seen)
SeenT_co = TypeVar("SeenT_co", bound=Seen, covariant=True)


class Observes(Protocol[SeenT_co]):
    """What takes snapshots."""

    def at(self, time: float, touching: frozenset[int], trigger: Collision | None = None) -> SeenT_co:
        """Return the snapshot at `time` (s), while the pairs with ids in `touching` are in contact."""
        ...


class Touching:
    """Which pairs touch when, both ends included, as far as collisions have been seen."""

    def __init__(self) -> None:
        """Start with none."""
        self._begun: dict[int, float] = {}
        self._ended: list[tuple[float, float, int]] = []

    def take(self, collision: Collision) -> None:
        """Take in a pair's next collision."""
        number = collision.pair.id
        if collision.phase is Phase.BEGIN:
            self._begun[number] = collision.time
        else:
            self._ended.append((self._begun.pop(number), collision.time, number))

    def at(self, time: float) -> frozenset[int]:
        """Return the ids of the pairs that touch at a time, s."""
        begun = {number for number, begin in self._begun.items() if begin <= time}
        return frozenset(begun.union(number for begin, end, number in self._ended if begin <= time <= end))

    def forget(self, before: float) -> None:
        """Forget what ended before a time (s), earlier than any that will be asked of."""
        if self._ended:
            self._ended = [contact for contact in self._ended if contact[1] >= before]


def observed(
    events: Iterable[Event], observer: Observes[SeenT], times: Iterable[float], time_resolution: float
) -> Generator[Event | SeenT, None, None]:
    """Yield the events with snapshots between them: at each time, and at each collision.

    A tick is taken once every pair is decided up to it: no wakeup goes back by more than one time resolution.

    Args:
        events: of `run`.
        observer: of the same scene.
        times: s, of `snapshot_times`.
        time_resolution: s, of the run.
    """
    touching, ticks = Touching(), iter(times)
    tick = next(ticks, None)
    for event in events:
        if isinstance(event, Wakeup):
            decided = event.time - time_resolution
            while tick is not None and tick < decided:
                yield observer.at(tick, touching.at(tick))
                tick = next(ticks, None)
            touching.forget(decided - 3.0 * time_resolution)
        yield event
        if isinstance(event, Collision):
            touching.take(event)
            yield observer.at(event.time, touching.at(event.time), event)
    while tick is not None:
        yield observer.at(tick, touching.at(tick))
        tick = next(ticks, None)


def instants(collisions: Iterable[Collision], times: Iterable[float]) -> tuple[list[Instant], list[Instant]]:
    """Return where `observed` takes snapshots: at the times, and at the collisions, given in the order of events."""
    touching = Touching()
    occasions = []
    for collision in collisions:
        touching.take(collision)
        occasions.append(Instant(collision.time, touching.at(collision.time), collision))
    return [Instant(time, touching.at(time)) for time in times], occasions


class Taken(Generic[SeenT]):
    """Snapshots that were taken before, at the instants that `instants` returned."""

    def __init__(self, ticks: Iterator[SeenT], occasions: Iterator[SeenT]) -> None:
        """Take those at times and those at collisions, each in order."""
        self._ticks, self._triggers = ticks, occasions

    def at(self, time: float, touching: frozenset[int], trigger: Collision | None = None) -> SeenT:
        """Return the next snapshot of its kind."""
        snapshot = next(self._ticks if trigger is None else self._triggers)
        assert snapshot.time == time, "snapshots were taken in another order"
        return snapshot


def snapshot_times(scene: Scene, rate: float) -> Iterator[float]:
    """Yield when snapshots are taken, whatever happens: at the start, every 1/rate s, and at the end, in order, s.

    They are also taken whenever a body appears or vanishes, whatever the rate; that may be 0.
    """
    return (time for time, _ in groupby(merge(tick_times(scene.start, scene.end, rate), changes_of_existence(scene))))


def tick_times(start: float, end: float, rate: float) -> Iterator[float]:
    """Yield start, start + 1/rate, ... and the end, s; nothing for rate 0."""
    if rate <= 0.0:
        return
    for index in range(floor((end - start) * rate * (1.0 - 1e-12)) + 1):
        yield start + index / rate
    yield end


def changes_of_existence(scene: Scene) -> list[float]:
    """Return the times (s) inside the scene's at which a body appears or vanishes, in order."""
    return [time for time in np.unique(lifetimes(scene)).tolist() if scene.start < time < scene.end]
