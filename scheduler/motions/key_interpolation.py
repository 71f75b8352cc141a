"""How translations run from key to key: straight, held, or as cubic Hermite curves."""

from __future__ import annotations

from enum import Enum

import numpy as np

from ..geometry.arrays import FloatArray
from .key_translation import Path


class Translation(Enum):
    """How keyframes interpolate the translation."""

    LINEAR = "linear"
    STEP = "step"
    CUBIC = "cubic"


def path_between(times: FloatArray, places: FloatArray, how: Translation, velocities: FloatArray | None) -> Path:
    """Return the path through the keys.

    Args:
        times: (n,) s, strictly increasing.
        places: (n, 3) m.
        how: which way.
        velocities: (n, 3) m/s at the keys, for CUBIC; None: non-uniform Catmull-Rom.
    """
    durations = np.diff(times)
    moves = np.diff(places, axis=0)
    away = np.linalg.norm(places, axis=1)
    straight = np.zeros(len(moves), dtype=bool)
    match how:
        case Translation.STEP:
            return Path(places[:, None], away[:, None], durations, np.any(moves != 0.0, axis=1))
        case Translation.LINEAR:
            slopes = np.vstack((moves / durations[:, None], np.zeros(3)))
            sizes = np.column_stack((away, np.linalg.norm(slopes, axis=1)))
            return Path(np.stack((places, slopes), axis=1), sizes, durations, straight)
        case Translation.CUBIC:
            if velocities is None:
                tangents, sizes = catmull_rom(durations, moves)
            else:
                tangents, sizes = velocities, np.linalg.norm(velocities, axis=1)
            return Path(*_cubic(places, moves, tangents, sizes, durations), durations, straight)


def catmull_rom(durations: FloatArray, moves: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the velocities (n, 3) m/s at n keys, and (n,) the sizes of their terms.

    Inside, the velocity of the parabola through a key and both its neighbours; at the ends the slope of the only
    segment there; zero at a single key.

    Args:
        durations: (n - 1,) s.
        moves: (n - 1, 3) m.
    """
    if len(moves) == 0:
        return np.zeros((1, 3)), np.zeros(1)
    slopes = moves / durations[:, None]
    share = durations[1:] / (durations[:-1] + durations[1:])  # the following segment's, which weighs the slope before
    inner = share[:, None] * slopes[:-1] + (1.0 - share)[:, None] * slopes[1:]
    steepness = np.linalg.norm(slopes, axis=1)
    sizes = share * steepness[:-1] + (1.0 - share) * steepness[1:]
    velocities = np.vstack((slopes[:1], inner, slopes[-1:]))
    return velocities, np.concatenate((steepness[:1], sizes, steepness[-1:]))


def _cubic(
    places: FloatArray, moves: FloatArray, velocities: FloatArray, velocity_sizes: FloatArray, durations: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return coefficients (n, 4, 3) m/s^k and the sizes of their terms (n, 4), the last key's at rest."""
    h = durations[:, None]
    slopes, first, last = moves / h, velocities[:-1], velocities[1:]
    coefficients = np.zeros((len(places), 4, 3))
    coefficients[:, 0] = places
    coefficients[:-1, 1] = first
    coefficients[:-1, 2] = (3.0 * slopes - 2.0 * first - last) / h
    coefficients[:-1, 3] = (first + last - 2.0 * slopes) / h**2
    steepness, first_size, last_size = np.linalg.norm(slopes, axis=1), velocity_sizes[:-1], velocity_sizes[1:]
    sizes = np.zeros((len(places), 4))
    sizes[:, 0] = np.linalg.norm(places, axis=1)
    sizes[:-1, 1] = first_size
    sizes[:-1, 2] = (3.0 * steepness + 2.0 * first_size + last_size) / durations
    sizes[:-1, 3] = (first_size + last_size + 2.0 * steepness) / durations**2
    return coefficients, sizes
