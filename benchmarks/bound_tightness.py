"""How far the bounds of the motions lie above the truth, alone and through a moving parent.

For every kind of motion, the median over random cases of: the displacement bound over the farthest that a point gets in
dense samples; the path length bound over the way that it goes; the longest distance that the lecture's speed and
acceleration could cover over the farthest that it gets. And of two sleeps: what they would have been with the truth,
over what the bounds allow, for a clearance that the point uses up by the interval's end.

Run from the project's folder: python -m benchmarks.bound_tightness [CASES] [SEED]
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from closecall.scheduler.bounds.closed_form import longest_sleep, time_bound
from closecall.scheduler.kinematics.chain import Chain, ChainState, Joint, Part
from closecall.scheduler.model.extent import Ball, Extent
from closecall.scheduler.motions import Motion

sys.path.extend(str(Path(__file__).resolve().parent.parent / name) for name in ("tests", "tests/helpers"))
from drawn_motions import KINDS, constant, interval, random_rest, screw, swing, vector

SAMPLES = 200
#: What the medians shall not exceed, alone and below a moving parent.
TARGET, PARENT_TARGET = 2.0, 4.0
#: m, shorter ways are all rounding.
LEAST_WAY = 1e-6
PARENTS = (constant, screw, swing)


class Ratios(NamedTuple):
    """Bound over truth, of one case or the medians of many."""

    displacement: float
    path_length: float
    lecture: float
    sleep: float
    lecture_sleep: float


def chain_of(motions: list[Motion], rests: list[np.ndarray], points: np.ndarray) -> Chain:
    """Return the chain that carries the points."""
    centre = points.mean(axis=0)
    ball = Ball(vector(centre), float(np.max(np.linalg.norm(points - centre, axis=1))))
    joints = tuple(Joint(rest, motion) for rest, motion in zip(rests, motions, strict=True))
    return Chain(joints, np.eye(4), Extent(points, np.zeros(len(points)), ball))


def ratios(chain: Chain, t: float, duration: float, points: np.ndarray) -> Ratios | None:
    """Return how far the bounds lie above what the points do over one interval; None where they do nothing."""
    times = np.linspace(t, t + duration, SAMPLES)
    poses = np.array([chain.at(float(s)).pose for s in times])
    track = np.einsum("tij,pj->tpi", poses[:, :3, :3], points) + poses[:, None, :3, 3]
    away = np.max(np.linalg.norm(track - track[0], axis=2), axis=1)
    way = float(np.max(np.sum(np.linalg.norm(np.diff(track, axis=0), axis=2), axis=0)))
    farthest = float(np.max(away))
    if farthest < LEAST_WAY:
        return None
    moment = chain.at(t)
    reached = float(times[int(np.argmax(away))]) - t
    sleep = longest_sleep(lambda s: chain.displacement(moment, s), farthest, duration, 0.5 * duration)
    displacement = chain.displacement(moment, duration) / farthest
    straight = straight_ratios(chain, moment, duration, times - t, away)
    return Ratios(displacement, chain.path_length(moment, duration) / way, straight[0], reached / sleep, straight[1])


def straight_ratios(
    chain: Chain, moment: ChainState, duration: float, times: np.ndarray, away: np.ndarray
) -> tuple[float, float]:
    """Return the ratios of way and sleep of the lecture's bound, which looks no farther than the next knot."""
    horizon = min(duration, chain.knot_after(moment.time) - moment.time)
    _, v, w = moment.twist
    rates = chain.rates(moment, horizon * (1 - 1e-9))
    speed = float(np.linalg.norm(v) + np.linalg.norm(w) * chain.radius(Part.WHOLE))
    acceleration = float(np.linalg.norm(rates.steady)) + rates.acceleration
    acceleration += (rates.angular_acceleration + rates.angular_speed**2) * chain.radius(Part.WHOLE)
    before = away[times <= horizon]
    farthest = float(np.max(before))
    if farthest < LEAST_WAY:
        return np.nan, np.nan
    way = speed * horizon + 0.5 * acceleration * horizon**2
    slept = min(horizon, time_bound(farthest, speed, acceleration))
    return way / farthest, float(times[int(np.argmax(before))]) / slept


def medians(draw: Callable[[np.random.Generator], list[Motion]], cases: int, seed: int) -> Ratios:
    """Return the medians over random cases of a body of eight points."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(cases):
        motions = draw(rng)
        points = rng.normal(size=(8, 3)) * 0.5
        rests = [random_rest(rng) for _ in motions]
        t, duration = interval(rng, motions[-1])
        if (case := ratios(chain_of(motions, rests, points), t, duration, points)) is not None:
            found.append(case)
    return Ratios(*np.nanmedian(np.array(found), axis=0).tolist())


def report(name: str, row: Ratios, target: float) -> None:
    """Print a row, and what misses the target."""
    missed = [field for field, value in zip(Ratios._fields[:2], row[:2], strict=True) if value > target]
    print(
        f"{name:24}" + "".join(f"{value:14.2f}" for value in row) + ("  MISSED " + ", ".join(missed) if missed else "")
    )


def alone(kind: Callable[..., Motion]) -> Callable[[np.random.Generator], list[Motion]]:
    """Return what draws one motion."""
    return lambda rng: [kind(rng)]


def below_a_parent(kind: Callable[..., Motion]) -> Callable[[np.random.Generator], list[Motion]]:
    """Return what draws a motion and one for its parent."""
    return lambda rng: [PARENTS[int(rng.integers(0, len(PARENTS)))](rng), kind(rng)]


def main(cases: int = 300, seed: int = 1) -> None:
    """Print the table."""
    print(
        f"median bound / truth over {cases} cases, seed {seed}; targets {TARGET} alone, {PARENT_TARGET} below a parent"
    )
    for title, draw, target in (("alone", alone, TARGET), ("below a moving parent", below_a_parent, PARENT_TARGET)):
        print(f"\n{title:24}" + "".join(f"{field:>14}" for field in Ratios._fields))
        for kind in KINDS:
            report(kind.__name__.replace("_", " "), medians(draw(kind), cases, seed), target)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
