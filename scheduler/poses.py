"""Where all bodies of a scene are in the world at one time."""

from __future__ import annotations

import numpy as np

from .lineage import lineage
from .motions import Fixed
from .rotation import FloatArray
from .scene import Body


class WorldPoses:
    """The poses of a scene's bodies; what never moves is placed once, and a generation's bodies all at a time."""

    def __init__(self, bodies: tuple[Body, ...]) -> None:
        """Take the bodies, in document order."""
        self._rest = np.array([body.pose for body in bodies]).reshape(-1, 4, 4)
        self._motions = [
            (index, body.motion) for index, body in enumerate(bodies) if not isinstance(body.motion, Fixed)
        ]
        self._moved = np.array([index for index, _ in self._motions], dtype=np.int64)
        depths = np.array([len(lineage(bodies, index)) for index in range(len(bodies))], dtype=np.int64)
        parents = np.array([-1 if body.parent is None else body.parent for body in bodies], dtype=np.int64)
        generations = [np.flatnonzero(depths == depth) for depth in range(2, int(depths.max(initial=1)) + 1)]
        self._generations = [(children, parents[children]) for children in generations]

    @property
    def moving(self) -> int:
        """How many bodies move in their parent."""
        return len(self._motions)

    def at(self, time: float) -> FloatArray:
        """Return world_from_body of every body at `time` (s), (n, 4, 4)."""
        poses = self._rest.copy()
        if len(self._moved):
            moved = np.array([motion.pose(time) for _, motion in self._motions])
            poses[self._moved] = self._rest[self._moved] @ moved
        for children, parents in self._generations:
            poses[children] = poses[parents] @ poses[children]
        return poses
