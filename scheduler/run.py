"""The scheduling scheme: conservative advancement, by the loop of the lecture, section 1.3 (see docs/glossary.md).

Pairs sleep for a lower bound on their time to collision (Mirtich 1996; C2A). Windows of many bodies are certificates of
a kinetic data structure in the same queue (Basch, Guibas, Hershberger 1997).
"""

from __future__ import annotations

from collections.abc import Generator, Iterable

from .broad.active_pairs import ActivePairs
from .model.events import Bound, Event, Reason, Wakeup
from .model.scene import Settings
from .pairs.monitor import Monitor
from .pairs.pair import Pair
from .queue import WakeupQueue


def run(
    pairs: Iterable[Pair], settings: Settings, crowd: ActivePairs | None = None, queue: WakeupQueue | None = None
) -> Generator[Event, None, None]:
    """Yield everything that happens between the pairs that might collide, from the scene's start to its end.

    Invariant: every such pair sleeps in the heap, and until its wakeup either it provably cannot touch, or the step is
    one of the time resolution, which is judged afterwards and called unresolved where it cannot be proved clear. Pairs
    of a crowd sleep in it only while their swept boxes meet, or their own sleep lasts longer; windows of disjoint boxes
    clear the others.
    It ends because every wakeup of a pair is later than the one before by a bound or by the floor, except while a
    bracket between clear and touching is walked or halved, or an unproved step is tried again with finer ones; both
    are limited. So are windows.

    Wakeups come in order of time, but for those that refine: they go back by no more than one time resolution, until
    the pair is decided; those after that look for its least distance, at any time.

    Args:
        pairs: that are watched throughout.
        settings: of the run.
        crowd: makes further pairs as they are needed.
        queue: an empty one, of a caller who wants to know whose turn it is.
    """
    queue = WakeupQueue() if queue is None else queue
    # Initially all pairs that might collide are measured at t0: all wake at once, but those of bodies yet to come.
    for pair in pairs:
        queue.push(pair.start, Reason.START, Monitor(pair, settings))
    if crowd is not None:
        queue.push_tick(crowd.next_tick)

    # The first pair is pulled off the queue,
    while (first := queue.pop()) is not None:
        time, reason, monitor = first
        # unless windows end before: then new ones begin, and the pairs whose boxes meet enter the queue.
        if monitor is None:
            assert crowd is not None
            for entering in (yield from crowd.meet()):
                queue.push(*entering)
            queue.push_tick(crowd.next_tick)
            continue
        # and the distance measuring algorithm is run, at the poses A_i(t).
        measurement = monitor.pair.measure(time)
        # If a collision has occurred, it is reported,
        yield from monitor.learn(measurement)
        # and the pair goes back with t_min; if not, with a new lower bound on its time to collision: max(t_c, t_min).
        plan = monitor.plan()
        # Where windows clear it for longer than that, it leaves the queue until they no longer do.
        retired = crowd.retire(monitor, plan) if crowd is not None and plan is not None else None
        if retired is not None:
            plan = retired
        elif plan is not None:
            queue.push(plan.time, plan.reason, monitor)
        sleep, bound = (max(0.0, plan.time - time), plan.bound) if plan else (0.0, Bound.NONE)
        yield Wakeup(time, monitor.pair.key, reason, measurement.level, bound, monitor.clearance, sleep)
        # Once it is decided up to its end, how near the pair came is reported.
        if plan is None:
            yield from monitor.finish()
    # The queue runs empty when every wakeup would exceed the simulation time.
    if crowd is not None:
        yield from crowd.finish()
