"""Whether a part of one body lies inside a solid of another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .bodies import Surface
from .rigid import FloatArray


class Containment:
    """Tells at which poses a part of the `guest` lies inside a solid of the `host`.

    Exact where the surfaces are disjoint: then each connected part is wholly inside or wholly outside.
    """

    def __init__(self, guest: Surface, host: Surface) -> None:
        self.probes = guest.probes
        self.solids = host.solids
        self.boxes = [(solid.skin.min(axis=(0, 1)), solid.skin.max(axis=(0, 1))) for solid in host.solids]

    def any_inside(self, poses: FloatArray) -> NDArray[np.bool_]:
        """Return (n,) booleans at poses (n, 4, 4) of the guest in the frame of the host."""
        out = np.zeros(len(poses), dtype=bool)
        points = self.probes @ np.swapaxes(poses[:, :3, :3], 1, 2) + poses[:, None, :3, 3]
        for solid, (low, high) in zip(self.solids, self.boxes, strict=True):
            at, probe = np.nonzero(((points > low) & (points < high)).all(axis=2) & ~out[:, None])
            out[at[solid.holds(points[at, probe])]] = True
        return out
