"""Arrays that leave the reader: checked once, and read-only from then on."""

from __future__ import annotations

from typing import TypeVar

from ....scheduler.geometry.arrays import FloatArray, IntArray

Array = TypeVar("Array", FloatArray, IntArray)


def read_only(array: Array) -> Array:
    """Return the array itself, which nobody can write to any more."""
    array.flags.writeable = False
    return array
