"""The options of a run: their defaults, and the values that each can have.

The command line takes both from here, and prints them in its help. So this module imports nothing heavy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from math import inf, isfinite, nan
from numbers import Integral, Real
from pathlib import Path
from typing import Any, Literal, Self, get_args

from ...formats.scene.limits import LARGEST_DOCUMENT
from ...formats.scene.text.errors import quoted, suggestion
from .errors import OptionError

CompressionChoice = Literal["zstd", "lz4", "none"]
BroadPhaseChoice = Literal["auto", "on", "off"]
LogChoice = Literal["full", "certificate"]
TopicsChoice = Literal["single", "body"]

#: The words that an option can be.
CHOICES: dict[str, tuple[str, ...]] = {
    "compression": get_args(CompressionChoice),
    "broad_phase": get_args(BroadPhaseChoice),
    "log": get_args(LogChoice),
    "topics": get_args(TopicsChoice),
}
#: The least and the largest whole number that an option can be; None if no number is too large.
COUNTS: dict[str, tuple[int, int | None]] = {
    "max_bytes": (1, None),
    "max_pairs": (1, None),
    "viz_pairs": (1, 1000),
    "viz_triangles": (0, None),
}
MOST_JOBS = 1024
#: Hz.
LARGEST_RATE = 1e6
SMALLEST_FRACTION = 1e-6
#: Up to this many pairs a run watches each pair throughout, unless `broad_phase` says otherwise.
FEW_PAIRS = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """The options of a run. Each has the same name as on the command line.

    Attributes:
        time_resolution: s, the minimum step; None takes the scene's own.
        contact_tolerance: s, the maximum width of the bracket around the begin or end of a contact; None takes the
            scene's own.
        margin: m, a pair closer than this is a breach; None takes the scene's own.
        distance_tolerance: the fraction of each minimum distance to which it is certified; "none" skips the search;
            None takes the scene's own.
        epoch: ns, added to all log times.
        compression: the method for the chunks of the log.
        attach_meshes: whether the mesh files are attached to the log.
        mesh_roots: folders from which the scene can use files, besides its own folder.
        max_bytes: a larger scene file is refused.
        max_pairs: a scene with more pairs is refused when no broad phase is used.
        strict: whether warnings about the scene are errors.
        broad_phase: whether swept boxes clear distant pairs; "auto" does so for more than `FEW_PAIRS` pairs.
        jobs: how many processes share the pairs; "auto" starts one per processor. The log does not depend on it.
        cluster: the address of a Dask scheduler, whose workers share the pairs.
        log: the content of the log; "certificate" omits the data for viewers.
        topics: whether distances go to a single topic, or to one topic per body.
        rate: Hz, snapshots for viewers; 0 takes them only at contacts; None chooses a rate by the length of the run.
        viz_pairs: how many of the closest pairs each snapshot shows.
        viz_triangles: how many triangles are drawn at most; the remaining bodies are drawn as boxes.

    Raises:
        OptionError: for a value that an option cannot have. A run also raises it, if the scene rules out a value.
    """

    time_resolution: float | None = None
    contact_tolerance: float | None = None
    margin: float | None = None
    distance_tolerance: float | Literal["none"] | None = None
    epoch: int = 0
    compression: CompressionChoice = "zstd"
    attach_meshes: bool = True
    mesh_roots: Sequence[str | Path] = ()
    max_bytes: int = LARGEST_DOCUMENT
    max_pairs: int = 5_000_000
    strict: bool = False
    broad_phase: BroadPhaseChoice = "auto"
    jobs: int | Literal["auto"] = 1
    cluster: str | None = None
    log: LogChoice = "full"
    topics: TopicsChoice = "single"
    rate: float | None = None
    viz_pairs: int = 10
    viz_triangles: int = 1_000_000

    def __post_init__(self) -> None:
        self._check_numbers()
        self._check_counts()
        for name, choices in CHOICES.items():
            self._require(name, getattr(self, name) in choices, f"one of {', '.join(choices)}")
        for name in ("attach_meshes", "strict"):
            self._require(name, isinstance(getattr(self, name), bool), "true or false")
        self._require("cluster", self.cluster is None or isinstance(self.cluster, str), "an address")
        if self.cluster is not None and self.jobs != 1:
            raise OptionError("cluster", "give either jobs or a cluster, not both")
        listed = isinstance(self.mesh_roots, list | tuple)
        named = listed and all(isinstance(root, str | Path) for root in self.mesh_roots)
        self._require("mesh_roots", named, "a list of folders")
        self._put("mesh_roots", tuple(map(Path, self.mesh_roots)))

    def changed(self, **changes: Any) -> Self:
        """Return these options with changes.

        Raises:
            OptionError: for a name that no option has, and for a value that an option cannot have.
        """
        known = [field.name for field in fields(self)]
        for name in changes:
            if name not in known:
                raise OptionError(name, f"a run has no such option{suggestion(name, known)}")
        return replace(self, **changes)

    def _check_numbers(self) -> None:
        """Check the options that are real numbers."""
        for name in ("time_resolution", "contact_tolerance"):
            self._take_number(name, -inf, inf, "a number of seconds")  # the minimum depends on the scene
        self._take_number("margin", 0.0, inf, "0 m or more")
        self._take_number("rate", 0.0, LARGEST_RATE, f"0 to {LARGEST_RATE:g} Hz")
        fraction = self.distance_tolerance
        if fraction != "none":
            wanted = f"none or a fraction from {SMALLEST_FRACTION:g} to 1"
            self._take_number("distance_tolerance", SMALLEST_FRACTION, 1.0, wanted)
            self._require("distance_tolerance", fraction is None or fraction < 1.0, wanted)

    def _check_counts(self) -> None:
        """Check the options that are whole numbers."""
        for name, (least, most) in COUNTS.items():
            self._take_count(name, least, most, f"{least} or more" if most is None else f"{least} to {most}")
        self._take_count("epoch", None, None, "a whole number of nanoseconds")
        if self.jobs != "auto":
            self._take_count("jobs", 1, MOST_JOBS, f"auto, or 1 to {MOST_JOBS}")

    def _take_number(self, name: str, least: float, most: float, wanted: str) -> None:
        """Store a finite number of any numeric type as a float."""
        value = getattr(self, name)
        if value is not None:
            number = _as_float(value)
            self._require(name, least <= number <= most and isfinite(number), wanted)
            self._put(name, number)

    def _take_count(self, name: str, least: int | None, most: int | None, wanted: str) -> None:
        """Store a whole number of any integral type as an int."""
        value = getattr(self, name)
        whole = isinstance(value, Integral) and not isinstance(value, bool)
        number = int(value) if whole else 0
        within = whole and (least is None or least <= number) and (most is None or number <= most)
        self._require(name, within, wanted)
        self._put(name, number)

    def _require(self, name: str, fits: bool, wanted: str) -> None:
        if not fits:
            raise OptionError(name, f"expected {wanted}, got {quoted(getattr(self, name))}")

    def _put(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)


def _as_float(value: object) -> float:
    """Return a number of any type as a float; nan for any other value, and for a number too large for a float."""
    try:
        return float(value) if isinstance(value, Real) and not isinstance(value, bool) else nan
    except OverflowError:
        return nan
