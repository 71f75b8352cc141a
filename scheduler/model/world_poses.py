"""Where all bodies of a scene are in the world at one time."""

from __future__ import annotations

import numpy as np

from ..geometry.arrays import FloatArray
from ..motions import Ballistic, Fixed
from .body_tree import ancestors
from .scene import Body


class WorldPoses:
    """The poses of a scene's bodies.

    Bodies that never move are placed once. Those that fly without turning are placed together,
    and so are the others of each generation.
    """

    def __init__(self, bodies: tuple[Body, ...]) -> None:
        """Take the bodies, in document order."""
        self._rest = np.array([body.pose for body in bodies]).reshape(-1, 4, 4)
        motions = [(index, body.motion) for index, body in enumerate(bodies) if not isinstance(body.motion, Fixed)]
        self._moved = np.array([index for index, _ in motions], dtype=np.int64)
        flights = [motion if isinstance(motion, Ballistic) and not motion.turns else None for _, motion in motions]
        self._flying = np.array([flight is not None for flight in flights], dtype=bool)
        self._velocities = np.array([flight.velocity for flight in flights if flight]).reshape(-1, 3)
        self._accelerations = np.array([flight.acceleration for flight in flights if flight]).reshape(-1, 3)
        self._others = [motion for (_, motion), flight in zip(motions, flights, strict=True) if flight is None]
        depths = np.array([len(ancestors(bodies, index)) for index in range(len(bodies))], dtype=np.int64)
        parents = np.array([-1 if body.parent is None else body.parent for body in bodies], dtype=np.int64)
        generations = [np.flatnonzero(depths == depth) for depth in range(2, int(depths.max(initial=1)) + 1)]
        self._generations = [(children, parents[children]) for children in generations]

    @property
    def moving(self) -> int:
        """How many bodies move in their parent."""
        return len(self._moved)

    def at(self, time: float) -> FloatArray:
        """Return world_from_body of every body at `time` (s), (n, 4, 4)."""
        poses = self._rest.copy()
        if len(self._moved):
            moved = np.tile(np.eye(4), (len(self._moved), 1, 1))
            moved[self._flying, :3, 3] = time * self._velocities + 0.5 * time * time * self._accelerations
            moved[~self._flying] = np.array([motion.pose(time) for motion in self._others]).reshape(-1, 4, 4)
            poses[self._moved] = self._rest[self._moved] @ moved
        for children, parents in self._generations:
            poses[children] = poses[parents] @ poses[children]
        return poses
