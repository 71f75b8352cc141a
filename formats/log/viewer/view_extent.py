"""Where the bodies of a scene get to in a run: what a camera must see, and what markers are sized by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....scheduler.geometry.arrays import FloatArray
from ....scheduler.model.scene import Scene
from ....scheduler.model.world_poses import WorldPoses
from ....scheduler.snapshots.schedule import changes_of_existence
from ....scheduler.snapshots.snapshot import existing

# At most this many instants are looked at, and of large scenes so few that this many poses suffice (30 us each).
_MOST_INSTANTS = 101
_MOST_POSES = 6_000


@dataclass(frozen=True, eq=False)
class Reach:
    """Where the bodies that exist are at instants spread over the run, m in the world.

    Attributes:
        points: (k, 3) that span all bodies; at least one.
        moving: (m, 3) those of the bodies that move; may be none.
    """

    points: FloatArray
    moving: FloatArray

    @cached_property
    def low(self) -> FloatArray:
        """The lowest coordinates, (3,) m."""
        low: FloatArray = self.points.T.copy().min(axis=1)
        return low

    @cached_property
    def high(self) -> FloatArray:
        """The highest coordinates, (3,) m."""
        high: FloatArray = self.points.T.copy().max(axis=1)
        return high

    @cached_property
    def size(self) -> float:
        """The diagonal, m; 1 for scenes without extent."""
        return float(np.linalg.norm(self.high - self.low)) or 1.0


def reach(scene: Scene, outlines: FloatArray, moving: Sequence[bool]) -> Reach:
    """Return where the bodies get to.

    Args:
        scene: whose bodies and times.
        outlines: (n, k, 3) m, points of each body in its own frame that span it.
        moving: of each body, whether it ever moves.
    """
    shown = [index for index, body in enumerate(scene.bodies) if body.shapes]
    if not shown:
        return Reach(np.zeros((1, 3)), np.zeros((0, 3)))
    instants = int(np.clip(_MOST_POSES // len(scene.bodies), 3, _MOST_INSTANTS))
    changes = changes_of_existence(scene)
    times = [*np.linspace(scene.start, scene.end, instants).tolist(), *changes[:: 1 + len(changes) // instants]]
    world_poses = WorldPoses(scene.bodies)
    poses = np.array([world_poses.at(time) for time in times])[:, shown]
    there = np.array([existing(scene, time) for time in times])[:, shown]
    turned: FloatArray = outlines[shown] @ poses[..., :3, :3].swapaxes(-1, -2)
    placed = turned + poses[:, :, None, :3, 3]
    if not there.any():
        return Reach(placed.reshape(-1, 3), np.zeros((0, 3)))
    moves = there & np.array(moving)[shown]
    return Reach(placed[there].reshape(-1, 3), placed[moves].reshape(-1, 3))
