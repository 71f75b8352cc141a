"""What spans proved from both ends save: exact queries of each sample scene with and without them.

`python -m benchmarks.two_sided [SCENE ...]` runs scenes (default: all samples) as they are and with one-sided spans
alone, and prints exact measurements, all wakeups and the share of time left unresolved of both.
"""

from __future__ import annotations

import sys
from collections import Counter
from math import inf
from pathlib import Path
from unittest.mock import patch

from closecall.formats.scene.reader import read_scene
from closecall.scheduler.bounds import motion_bound
from closecall.scheduler.bounds.motion_bound import Proof
from closecall.scheduler.kinematics.relative_motion import PairState, RelativeMotion
from closecall.scheduler.model.events import Level, Span, Verdict, Wakeup
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide
from closecall.scheduler.run import run

SAMPLES = sorted((Path(__file__).parents[1] / "sample_scenes").glob("*/scene.yaml"))


def counted(scene: Path, both: bool) -> tuple[int, int, float]:
    """Run a scene; return exact measurements, wakeups and the share of UNRESOLVED time."""
    loaded = read_scene(scene)
    narrow_phase = NarrowPhase(loaded.scene.bodies)
    exact = wakeups = 0
    time: Counter[Verdict] = Counter()
    whole = motion_bound.proof

    def one_sided(motion: RelativeMotion, state: PairState, before: float, duration: float, after: float) -> Proof:
        found = whole(motion, state, before, duration, -inf)
        return Proof(found.clearance, whole(motion, state, before, duration, after).depth_limit)

    with patch.object(motion_bound, "proof", whole if both else one_sided):
        pairs = pairs_that_might_collide(loaded.scene, narrow_phase, loaded.settings.margin)
        for event in run(pairs, loaded.settings):
            if isinstance(event, Wakeup):
                wakeups += 1
                exact += event.level is Level.MESH
            elif isinstance(event, Span):
                time[event.verdict] += event.end - event.start
    return exact, wakeups, time[Verdict.UNRESOLVED] / max(1e-300, sum(time.values()))


def main() -> None:
    """Print the table."""
    print(f"{'scene':24}{'exact':>9}{'one end':>9}{'wakeups':>9}{'one end':>9}{'unresolved':>12}{'one end':>9}")
    for scene in map(Path, sys.argv[1:]) if len(sys.argv) > 1 else SAMPLES:
        (exact, wakeups, open_), (exact_one, wakeups_one, open_one) = counted(scene, True), counted(scene, False)
        print(
            f"{scene.parent.name:24}{exact:9}{exact_one:9}{wakeups:9}{wakeups_one:9}{open_:12.1e}{open_one:9.1e}",
            flush=True,
        )


if __name__ == "__main__":
    main()
