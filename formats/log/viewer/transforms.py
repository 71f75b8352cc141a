"""Poses as foxglove.FrameTransforms, packed by numpy: all frames have the world for parent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from google.protobuf.timestamp_pb2 import Timestamp

from ....scheduler.geometry.arrays import FloatArray, IntArray
from .wire import TAG_W, TAG_X, TAG_Y, TAG_Z, Bytes, embedded

WORLD = "world"

# The end of every FrameTransform: translation (field 4) and rotation (field 5) with doubles yet to be filled in.
_HOLE = bytes(8)
_TRANSLATION = b"".join(bytes([tag]) + _HOLE for tag in (TAG_X, TAG_Y, TAG_Z))
_TAIL = embedded(4, _TRANSLATION) + embedded(5, _TRANSLATION + bytes([TAG_W]) + _HOLE)
_HOLES = np.array([3, 12, 21, 32, 41, 50, 59])  # where in _TAIL the doubles go


@dataclass(frozen=True, slots=True, eq=False)
class _Template:
    """A message with holes: `stamps` (n, length of a stamp) and `doubles` (n, 7 * 8) index its bytes."""

    data: Bytes
    stamps: IntArray
    doubles: IntArray


class TransformPacker:
    """Packs the poses of some frames, 0.25 us each (`python -m benchmarks.viewer_cost`) once a template is made."""

    def __init__(self, names: Sequence[str]) -> None:
        """Take the frames' names."""
        self._names = tuple(names)
        # By the length of the stamp, which varies by a few bytes: its numbers are as long as they need be.
        self._templates: dict[int, _Template] = {}

    def pack(self, timestamp: Timestamp, poses: FloatArray) -> bytes:
        """Return the message that these frames have the poses world_from_frame, (n, 4, 4)."""
        stamp = timestamp.SerializeToString()
        template = self._templates.get(len(stamp))
        if template is None:
            template = self._templates[len(stamp)] = self._template(len(stamp))
        columns = np.hstack((poses[:, :3, 3], quaternions(poses[:, :3, :3]))).astype("<f8")
        data = template.data.copy()
        data[template.stamps] = np.frombuffer(stamp, dtype=np.uint8)
        data[template.doubles] = columns.view(np.uint8)
        return data.tobytes()

    def _template(self, stamp_bytes: int) -> _Template:
        head = embedded(1, bytes(stamp_bytes)) + embedded(2, WORLD.encode())
        bodies = [head + embedded(3, name.encode()) + _TAIL for name in self._names]
        records = [embedded(1, body) for body in bodies]
        ends = np.cumsum([len(record) for record in records], dtype=np.int64)
        begins = ends - np.array([len(body) for body in bodies], dtype=np.int64)
        first_stamp_byte = len(embedded(1, bytes(stamp_bytes))) - stamp_bytes
        holes = (_HOLES[:, None] + np.arange(8)).ravel() - len(_TAIL)
        return _Template(
            data=np.frombuffer(b"".join(records), dtype=np.uint8),
            stamps=begins[:, None] + first_stamp_byte + np.arange(stamp_bytes),
            doubles=ends[:, None] + holes,
        )


def quaternions(rotations: FloatArray) -> FloatArray:
    """Return (n, 4) unit quaternions x, y, z, w with w >= 0 of rotations (n, 3, 3).

    4 q q^T is linear in the rotation; its row with the largest diagonal, normalised, is q without cancellation.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = np.moveaxis(rotations, 0, -1)
    products = np.array(
        (
            (1.0 + xx - yy - zz, xy + yx, xz + zx, zy - yz),
            (xy + yx, 1.0 - xx + yy - zz, yz + zy, xz - zx),
            (xz + zx, yz + zy, 1.0 - xx - yy + zz, yx - xy),
            (zy - yz, xz - zx, yx - xy, 1.0 + xx + yy + zz),
        )
    )
    largest = np.argmax(np.einsum("iin->in", products), axis=0)
    rows = products[largest, :, np.arange(len(rotations))]
    rows *= np.where(rows[:, 3:] < 0.0, -1.0, 1.0)
    unit: FloatArray = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    return unit
