"""How accelerations are bounded in every direction: joints that move in one plane give none across it."""

import numpy as np
import pytest
from drawn_motions import random_unit
from scipy.spatial.transform import Rotation

from closecall.scheduler.kinematics.chain import Chain, Joint, Part
from closecall.scheduler.kinematics.relative_motion import RelativeMotion
from closecall.scheduler.model.extent import Ball, Extent
from closecall.scheduler.motions import Constant, Harmonic, Orbit, Polynomial, Screw, Swing

CASES = 100


def planar_chain(rng, points) -> Chain:
    """Return a chain of joints that turn about z and slide across it, one of them more than once."""
    return _chain_about_z(rng, points, lambda: 0.0)


def tilted_chain(rng, points) -> Chain:
    """Return the same with rest frames that are tilted now and then."""
    return _chain_about_z(rng, points, lambda: float(rng.normal()) if rng.random() < 0.5 else 0.0)


def _chain_about_z(rng, points, tilt) -> Chain:
    up, joints = (0.0, 0.0, 1.0), []
    for _ in range(int(rng.integers(1, 5))):
        across = (*random_unit(rng)[:2], 0.0)
        length = float(np.hypot(*across[:2]))
        across = (across[0] / length, across[1] / length, 0.0)
        point, size = (float(rng.normal()), float(rng.normal()), 0.0), float(rng.uniform(0.1, 2.0))
        drawn = (
            Swing(up, point, size, float(rng.uniform(0.5, 3.0)), size),
            Screw(up, point, size, 0.0),
            Orbit(up, across, size, size, 0.3, bool(rng.random() < 0.5)),
            Harmonic(across, size, float(rng.uniform(0.5, 3.0)), size),
            Constant((size, -size, 0.0), (0.0, 0.0, size)),
            Polynomial(tuple((float(rng.normal()), float(rng.normal()), 0.0) for _ in range(5)), (0.0, 0.0, -size)),
        )
        rest = np.eye(4)
        rest[:3, :3] = Rotation.from_euler("zx", [float(rng.normal()), tilt()]).as_matrix()
        rest[:2, 3] = rng.normal(size=2)
        joints.append(Joint(rest, drawn[int(rng.integers(0, len(drawn)))]))
    ball = Ball((0.0, 0.0, 0.0), float(np.max(np.linalg.norm(points, axis=1))))
    return Chain(tuple(joints), np.eye(4), Extent(points, np.zeros(len(points)), ball))


@pytest.mark.parametrize("kind", [planar_chain, tilted_chain])
def test_accelerations_are_bounded_in_every_direction(kind):
    """By much less across a plane that all joints move in."""
    rng = np.random.default_rng(9)
    for _ in range(CASES):
        points = rng.normal(size=(10, 3)) * 0.5
        motion, still = RelativeMotion(kind(rng, points), kind(rng, points)), float(rng.uniform(-2, 1))
        state = motion.at(still)
        approach = motion.approach(state, 0.3, Part.CORE)
        directions = np.vstack((np.eye(3), -np.eye(3), [random_unit(rng) for _ in range(10)]))
        most = directions @ np.array(approach.steady) + approach.varying.supports(directions)
        if kind is planar_chain:
            assert most[2] <= 1e-9 * approach.acceleration
        step = min(1e-4, approach.horizon / 10)
        for s in np.linspace(still + step, still + approach.horizon - step, 10):
            bends = []
            for chain in (motion.a, motion.b):
                a, b, c = (points @ p[:3, :3].T + p[:3, 3] for p in (chain.at(s + d).pose for d in (-step, 0, step)))
                bends.append((a - 2 * b + c) / step**2 @ directions.T)
            slack = 1e-4 * (approach.acceleration + 1.0) + 1e-13 / step**2
            assert np.all(bends[0].max(axis=0) - bends[1].min(axis=0) <= most + slack)
