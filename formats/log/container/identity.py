"""The metadata at the start of a log: hashes of the inputs, settings, time base, margins, length unit."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from math import inf

from closecall import __version__

from ....scheduler.model.pair_count import count_pairs
from ....scheduler.model.scene import ALWAYS, Scene, Settings
from ....scheduler.motions import Interval
from ...scene.loaded import LoadedScene
from .clock import NANOSECONDS_PER_SECOND, nanoseconds
from .contents import input_files, settings_json


def identity(loaded: LoadedScene, settings: Settings, pairs_total: int, epoch: int) -> dict[str, str]:
    """Return the metadata that identifies a run, in s and m; the epoch is in ns."""
    scene = loaded.scene
    values = {
        "version": __version__,
        "scene_sha256": hashlib.sha256(loaded.source).hexdigest(),
        "settings": settings_json(settings),
        "start": repr(scene.start),
        "end": repr(scene.end),
        "epoch": str(epoch),
        "count/bodies": str(len(scene.bodies)),
        "count/pairs": str(pairs_total),
        "count/ignored": str(count_pairs(scene).ignored),
        "chord_errors": json.dumps({body.name: body.chord_error for body in scene.bodies if body.chord_error}),
        "exists": json.dumps(_existence(scene)),
        "margins": json.dumps(_margins(scene)),
        "length_unit": loaded.length_unit,
    }
    return values | {f"{kind}/{file.name}": file.sha256 for kind, file in input_files(loaded)}


def _existence(scene: Scene) -> dict[str, Interval]:
    """Return when those bodies exist that do not always, s."""
    return {
        body.name: scene.shared_time(index, index) for index, body in enumerate(scene.bodies) if body.exists != ALWAYS
    }


def _margins(scene: Scene) -> list[tuple[list[str], list[str], float]]:
    """Return the rules that give pairs a margin (m) of their own, by the names of the bodies on both sides."""

    def names(side: frozenset[int]) -> list[str]:
        return [scene.bodies[index].name for index in sorted(side)]

    return [(names(pairs.one), names(pairs.other), margin) for pairs, margin in scene.rules.margins]


@dataclass(frozen=True, slots=True)
class Identity:
    """The metadata of a run, read from its log.

    Attributes:
        version: of closecall.
        scene_sha256: of the scene file.
        start, end: scene seconds.
        epoch: ns, in every log time.
        bodies: how many.
        pairs_total, pairs_ignored: as in the summary.
        settings: in SI, under the scene file's keys.
        chord_errors: m, by body, 0 where not named.
        exists: s, by body, always where not named.
        length_unit: of the scene file, for texts that people read; m in older logs.
        margins: m, of the pairs with one body in each of two sets, a later rule before an earlier one.
    """

    version: str
    scene_sha256: str
    start: float
    end: float
    epoch: int
    bodies: int
    pairs_total: int
    pairs_ignored: int
    settings: dict[str, float | None]
    chord_errors: dict[str, float]
    exists: dict[str, Interval]
    margins: tuple[tuple[frozenset[str], frozenset[str], float], ...]
    length_unit: str = "m"

    def seconds(self, log_time: int) -> float:
        """Return a log time, ns, in scene seconds."""
        return (log_time - self.epoch) / NANOSECONDS_PER_SECOND

    def log_time(self, time: float) -> int:
        """Return scene seconds as a log time, ns."""
        return nanoseconds(time) + self.epoch

    def margin(self, body_a: str, body_b: str) -> float:
        """Return a pair's margin, m."""
        for one, other, margin in reversed(self.margins):
            if (body_a in one and body_b in other) or (body_b in one and body_a in other):
                return margin
        return self.settings["margin"] or 0.0

    def shared_time(self, body_a: str, body_b: str) -> Interval:
        """Return when both bodies exist within the scene's time, s."""
        (a_from, a_to), (b_from, b_to) = (self.exists.get(body, (-inf, inf)) for body in (body_a, body_b))
        return max(self.start, a_from, b_from), min(self.end, a_to, b_to)
