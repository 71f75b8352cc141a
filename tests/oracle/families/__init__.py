"""Scenes made to break a certificate: fourteen families, each by number."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..draw import Draw
from ..scenes import Bodies, begun, scene_of, write_document
from . import far, instants, nested, speed, wound

Family = Callable[[Draw], Bodies]

FAMILIES: dict[str, Family] = {
    "fast_spin": speed.fast_spin,
    "long_bars": speed.long_bars,
    "nested_shells": nested.nested_shells,
    "shared_parents": nested.shared_parents,
    "cancelling_velocities": speed.cancelling_velocities,
    "knots_with_jumps": instants.knots_with_jumps,
    "parallel_sliding": far.parallel_sliding,
    "contact_at_the_start": instants.contact_at_the_start,
    "contact_at_the_end": instants.contact_at_the_end,
    "far_offsets": far.far_offsets,
    "opposite_parts": wound.opposite_parts,
    "turned_faces": wound.turned_faces,
    "joined_parts": wound.joined_parts,
    "cavities": wound.cavities,
}

FIRST_SEED = 10_000_000
"""Families take seeds from here, a thousand each."""


def write_family(name: str, number: int, folder: Path) -> Path:
    """Write a family's scene of this number into the folder and return the scene file."""
    draw = begun(FIRST_SEED + 1000 * list(FAMILIES).index(name) + number, folder)
    bodies = FAMILIES[name](draw)
    rules: dict[str, Any] = {}
    return write_document(scene_of(draw, bodies, rules), draw)
