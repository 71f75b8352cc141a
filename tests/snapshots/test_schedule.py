"""When snapshots are taken, and which pairs touch then, held against contacts drawn at random."""

import numpy as np
import pytest

from closecall.scheduler.model.events import (
    Bound,
    Collision,
    ContactKind,
    Feature,
    FeatureKind,
    Level,
    PairKey,
    Phase,
    Reason,
    Snapshot,
    Wakeup,
)
from closecall.scheduler.model.scene import Body, PairRules, Scene
from closecall.scheduler.motions import Fixed
from closecall.scheduler.snapshots.schedule import Taken, Touching, instants, observed, snapshot_times

RESOLUTION = 0.01
FEATURE = Feature(FeatureKind.FACE, 0, 0, 0)


def collision(pair: int, phase: Phase, time: float) -> Collision:
    key = PairKey(pair, 0, pair + 1)
    return Collision(key, phase, time, time, ContactKind.SURFACE, FEATURE, FEATURE, (0.0, 0.0, 0.0))


def wakeup(pair: int, time: float) -> Wakeup:
    return Wakeup(time, PairKey(pair, 0, pair + 1), Reason.TIME_BOUND, Level.MESH, Bound.SPEED_ACCELERATION, 0.0, 0.0)


def drawn_run(rng) -> tuple[list[tuple[int, float, float]], list[Collision | Wakeup]]:
    """Return contacts (pair, begin, end), and events in some order that a run may have."""
    contacts, events = [], []
    for pair in range(5):
        ends = np.sort(rng.uniform(0.0, 1.0, 2 * int(rng.integers(0, 6)))).tolist()
        late = float(rng.uniform(0.0, RESOLUTION))  # a change is told at a wakeup that is not much later
        for begin, end in zip(ends[::2], ends[1::2], strict=True):
            contacts.append((pair, begin, end))
            events.append((begin + late, collision(pair, Phase.BEGIN, begin)))
            events.append((end + late, collision(pair, Phase.END, end)))
    events += [(time, wakeup(7, time)) for time in np.sort(rng.uniform(0.0, 1.0, 40)).tolist()]
    told = sorted(events, key=lambda event: event[0])
    return contacts, [event for _, event in told]


class Camera:
    """Notes what it is asked for."""

    def __init__(self) -> None:
        self.asked: list[tuple[float, frozenset[int], Collision | None]] = []

    def at(self, time, touching, trigger=None) -> Snapshot:
        self.asked.append((time, touching, trigger))
        return Snapshot(time, np.empty((0, 4, 4)), np.empty(0, dtype=bool), (), len(touching), trigger)


def test_snapshots_are_taken_with_the_pairs_that_touch_then_whenever_that_is_told() -> None:
    rng = np.random.default_rng(1)
    together = 0
    for _ in range(50):
        contacts, events = drawn_run(rng)
        times = np.sort(rng.uniform(0.0, 1.0, 20)).tolist()
        camera = Camera()
        list(observed(events, camera, times, RESOLUTION))
        ticks = [(time, touching) for time, touching, trigger in camera.asked if trigger is None]
        assert ticks == [(t, frozenset(pair for pair, b, e in contacts if b <= t <= e)) for t in times]
        for time, touching, trigger in camera.asked:
            if trigger is not None:
                assert time == trigger.time
                assert trigger.pair.id in touching
                assert touching <= {pair for pair, b, e in contacts if b <= time <= e + RESOLUTION}
                together += len(touching) > 1
    assert together > 100


def test_snapshots_may_be_taken_before_at_the_same_instants() -> None:
    rng = np.random.default_rng(2)
    for _ in range(50):
        _, events = drawn_run(rng)
        times = np.sort(rng.uniform(0.0, 1.0, 20)).tolist()
        camera = Camera()
        live = list(observed(events, camera, times, RESOLUTION))
        kinds = instants([event for event in events if isinstance(event, Collision)], times)
        taken = Taken(*(iter([Camera().at(*instant) for instant in kind]) for kind in kinds))
        again = list(observed(events, taken, times, RESOLUTION))
        assert [asked for asked in camera.asked if asked[2] is None] == [tuple(instant) for instant in kinds[0]]
        assert [asked for asked in camera.asked if asked[2] is not None] == [tuple(instant) for instant in kinds[1]]
        assert [type(event) for event in live] == [type(event) for event in again]
        assert [e.time for e in live if isinstance(e, Snapshot)] == [e.time for e in again if isinstance(e, Snapshot)]


def test_what_ended_is_forgotten_only_before_the_time_that_is_named() -> None:
    touching = Touching()
    for event in (collision(1, Phase.BEGIN, 1.0), collision(1, Phase.END, 2.0), collision(2, Phase.BEGIN, 3.0)):
        touching.take(event)
    touching.forget(2.0)
    assert [touching.at(time) for time in (0.5, 1.0, 2.0, 2.5, 3.0)] == [set(), {1}, {1}, set(), {2}]
    touching.forget(2.1)
    assert touching.at(2.0) == set()


@pytest.mark.parametrize(
    ("rate", "times"),
    [(0.0, [0.25]), (2.0, [0.0, 0.25, 0.5, 1.0]), (3.0, [0.0, 0.25, 1.0 / 3.0, 2.0 / 3.0, 1.0])],
)
def test_snapshots_are_taken_at_the_rate_and_whenever_something_appears(rate, times) -> None:
    body = Body("a", None, np.eye(4), Fixed(), (), (0.25, 9.0))
    assert list(snapshot_times(Scene((body,), 0.0, 1.0, PairRules()), rate)) == pytest.approx(times)
