"""Hold a log against the truth of its scene: every promise of the log format that brute force can test.

`check_log` reads the files; `check` takes the decoded values, so that a test may spoil them first.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from .check_events import check_collisions, check_distances, check_wakeups
from .check_frames import check_transforms
from .check_minimum import Tally, check_least
from .check_spans import check_certificate, check_contacts, check_depths, check_tiling
from .check_windows import check_windows
from .check_world import check_summary, check_world, stated_chords, summary_of
from .logs import Log, read_log
from .sampling import Effort, Samples, sample
from .truth import NANOSECOND, Pair, Truth, seconds

Values = dict[str, Any]

PAIR_TOPICS = ("spans", "collisions", "distances", "wakeups")

OWN_TIME = {"spans": "end", "collisions": "time_touching"}
"""Messages whose timestamp repeats one of their own times."""


def check_log(scene_path: Path, log_path: Path, *, effort: Effort | None = None) -> list[str]:
    """Return what is wrong with a log of a scene, a line each; nothing when it holds.

    Args:
        scene_path: the scene file, its meshes beside it.
        log_path: the MCAP log of a run of it.
        effort: how hard to try.
    """
    log = read_log(log_path)
    return check(Truth(scene_path), log, effort=effort, epoch=int(log.metadata["closecall"]["epoch"]))


def check(
    truth: Truth, log: Log, *, effort: Effort | None = None, epoch: int = 0, tally: Tally | None = None
) -> list[str]:
    """Return what is wrong with decoded values of a log whose times `epoch` ns were added to, a line each.

    What was looked at is added to the `tally`.
    """
    effort = effort or Effort()
    tally = tally or Tally()
    faults = [*check_times(log, epoch), *check_names(truth, log)]
    faults += check_transforms(truth, log, effort, epoch)
    faults += check_windows(truth, log, effort)
    if any("no such pair" in fault for fault in faults):
        return faults
    chords = stated_chords(log)
    told = {one["pair"]: one for one in (summary_of(log) or {"pairs": []})["pairs"]}
    by_pair = {topic: log.by_pair(topic) for topic in PAIR_TOPICS}
    for a, b in truth.pairs():
        facts = {topic: found.get(f"{a}|{b}", []) for topic, found in by_pair.items()}
        chord = min(chords.get(f"{a}|{b}", np.inf), truth.chord_limit(a, b))
        samples = sample(truth, (a, b), in_order(facts["spans"]), facts["wakeups"], effort, epoch)
        tally.add(truth, facts["spans"], samples, told.get(f"{a}|{b}"))
        faults += check_pair(truth, (a, b), facts, samples, effort, epoch, chord)
        faults += check_least(truth, (a, b), told.get(f"{a}|{b}"), samples)
    faults += check_summary(truth, log)
    return [*faults, *check_world(truth, log, effort, epoch, chords)]


def in_order(spans: list[Values]) -> list[Values]:
    """Return spans by their start."""
    return sorted(spans, key=lambda span: span["start"])


def check_pair(
    truth: Truth,
    pair: Pair,
    facts: dict[str, list[Values]],
    samples: Samples,
    effort: Effort,
    epoch: int,
    chord: float,
) -> Iterable[str]:
    """Yield what is wrong about one pair, given its messages by topic and its chord error (m).

    Without spans it must never touch, nor come within its margin.
    """
    spans = in_order(facts["spans"])
    collisions = sorted(facts["collisions"], key=lambda event: event["time_clear"])
    yield from check_tiling(truth, pair, spans)
    yield from check_presence(truth, pair, facts, epoch)
    yield from check_certificate(truth, pair, spans, samples, chord)
    yield from check_depths(truth, pair, spans, samples, effort)
    yield from check_contacts(truth, pair, spans, collisions, effort, chord)
    yield from check_collisions(truth, pair, collisions, chord)
    yield from check_distances(truth, pair, facts["distances"], effort, epoch, chord)
    yield from check_wakeups(truth, pair, facts["wakeups"], samples, effort, epoch)


def check_times(log: Log, epoch: int) -> Iterable[str]:
    """Log and publish times repeat the timestamp, which repeats the message's own time; readers get them in order."""
    for topic, messages in log.topics.items():
        latest = -1
        for message in messages:
            stamp = message.get("timestamp", message["log_time"])
            if not stamp == message["log_time"] == message["publish_time"]:
                yield f"/{topic} at {message['log_time']} ns: timestamp {stamp} differs"
            if message["log_time"] < latest:
                yield f"/{topic} at {message['log_time']} ns: comes after {latest} ns"
            latest = message["log_time"]
            own = message[OWN_TIME[topic]] if topic in OWN_TIME else None
            if own is not None and abs(own * 1e9 - (stamp - epoch)) > 1.0 + 1e-6 * abs(own):
                yield f"/{topic} at {stamp} ns: its own time is {own} s"


def check_presence(truth: Truth, pair: Pair, facts: dict[str, list[Values]], epoch: int) -> Iterable[str]:
    """Nothing is told of a pair while one of the two is not there, but for the nanosecond that times are rounded to."""
    start, end = truth.interval(*pair)
    for topic, messages in facts.items():
        times = np.array([seconds(message, epoch) for message in messages])
        for time in times[(times < start - NANOSECOND) | (times > end + NANOSECOND)][:3]:
            yield f"{'|'.join(pair)}: /{topic} at {time} s, both exist from {start} to {end}"


def check_names(truth: Truth, log: Log) -> Iterable[str]:
    """Every message of a pair names a pair that may be watched, lower body first, with the pair's rank."""
    watched = {f"{a}|{b}": (a, b) for a, b in truth.pairs()}
    seen: set[tuple[Any, ...]] = set()
    for topic in PAIR_TOPICS:
        for message in log.of(topic):
            said = (message["pair"], message["body_a"], message["body_b"], message["pair_id"])
            if said in seen:
                continue
            seen.add(said)
            pair = watched.get(message["pair"])
            if pair is None:
                yield f"/{topic}: no such pair to watch: {message['pair']}"
            elif said[1:] != (*pair, truth.pair_id(*pair)):
                yield f"/{topic}: {message['pair']} has bodies {said[1:3]} and rank {said[3]}"


def unresolved_share(log: Log) -> float:
    """Return which part of all spans' time is UNRESOLVED: not a fault, but a measure of the tool."""
    lengths = np.array([span["end"] - span["start"] for span in log.of("spans")])
    unresolved = np.array([span["verdict"] == "UNRESOLVED" for span in log.of("spans")], dtype=bool)
    return float(lengths[unresolved].sum() / lengths.sum()) if len(lengths) else 0.0
