"""Connected components of a graph, without SciPy."""

from __future__ import annotations

import numpy as np

from ..geometry.arrays import IntArray


def components(count: int, ones: IntArray, others: IntArray) -> IntArray:
    """Return (count,) for each node the least node of its component; links join `ones[k]` and `others[k]`."""
    labels = np.arange(count)
    while len(ones):
        ones, others = labels[ones], labels[others]
        apart = ones != others
        ones, others = ones[apart], others[apart]
        np.minimum.at(labels, np.maximum(ones, others), np.minimum(ones, others))
        while not np.array_equal(labels, following := labels[labels]):
            labels = following
    return labels
