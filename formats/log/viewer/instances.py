"""Bodies that are too many for an entity and a frame each: their boxes, all in one entity, packed by numpy."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.timestamp_pb2 import Timestamp
from numpy.typing import NDArray

from ....scheduler.geometry.arrays import FloatArray
from .colours import RGB
from .transforms import WORLD, quaternions
from .wire import TAG_W, TAG_X, TAG_Y, TAG_Z, Bytes, embedded, power_of_two, rounded

# Steps to which poses are rounded: a picture shows no finer ones, and what ends in zeros takes less than half the room.
# Of what the boxes spread over; of a quaternion's unit.
_PLACE_STEP = 2.0**-20
_TURN_STEP = 2.0**-12

# A CubePrimitive in its field: position, orientation, size and colour (fields 1.1, 1.2, 2, 3), doubles yet to be filled
# in. Tags and lengths have no byte of ones.
_HOLE = b"\xff" * 8
_THREE = b"".join(bytes([tag]) + _HOLE for tag in (TAG_X, TAG_Y, TAG_Z))
_FOUR = _THREE + bytes([TAG_W]) + _HOLE
_CUBE = embedded(
    SceneEntity.CUBES_FIELD_NUMBER,
    embedded(1, embedded(1, _THREE) + embedded(2, _FOUR)) + embedded(2, _THREE) + embedded(3, _FOUR),
)
_HOLES = np.array([found.start() for found in re.finditer(_HOLE, _CUBE)])[:, None] + np.arange(8)


class Crowd:
    """The boxes of some bodies, 0.4 us each (`python -m benchmarks.viewer_cost`)."""

    def __init__(
        self, members: Sequence[int], outlines: FloatArray, colours: Sequence[RGB], opacity: float, poses: FloatArray
    ) -> None:
        """Take the bodies.

        Args:
            members: their indices; at least one.
            outlines: (n, k, 3) m, of all bodies, points of each in its own frame that span it.
            colours: of the members, in order.
            opacity: of the boxes, up to 1.
            poses: (n, 4, 4) world_from_body of all bodies at some time.
        """
        self._members = np.array(members, dtype=np.int64)
        low, high = outlines[self._members].min(axis=1), outlines[self._members].max(axis=1)
        self._middles = 0.5 * (low + high)
        self._sizes = high - low
        self._colours = np.array([(*rgb, opacity) for rgb in colours]).reshape(-1, 4)
        spread = np.ptp(poses[self._members, :3, 3], axis=0)
        self._step = power_of_two(_PLACE_STEP * float(max(spread.max(), self._sizes.max())))
        self._template: Bytes = np.tile(np.frombuffer(_CUBE, dtype=np.uint8), (len(members), 1))

    def __len__(self) -> int:
        return len(self._members)

    def update(self, stamp: Timestamp, poses: FloatArray, there: NDArray[np.bool_]) -> bytes:
        """Return a SceneUpdate with the boxes of the members that exist.

        The one entity takes the place of that of any message before: there is nothing to delete.

        Args:
            stamp: of the instant.
            poses: (n, 4, 4) world_from_body of every body then.
            there: (n,) which of them exist then.
        """
        drawn = there[self._members]
        now = poses[self._members[drawn]]
        places = now[:, :3, 3] + np.einsum("nij,nj->ni", now[:, :3, :3], self._middles[drawn])
        turns = quaternions(now[:, :3, :3])
        columns = (rounded(places, self._step), rounded(turns, _TURN_STEP), self._sizes[drawn], self._colours[drawn])
        cubes = self._template[: len(now)].copy()
        cubes[:, _HOLES.ravel()] = np.hstack(columns).astype("<f8").view(np.uint8)
        name = f"{len(self)} boxes"
        head: bytes = SceneEntity(timestamp=stamp, frame_id=WORLD, id=name, frame_locked=True).SerializeToString()
        return embedded(SceneUpdate.ENTITIES_FIELD_NUMBER, head + cubes.tobytes())
