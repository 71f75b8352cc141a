"""The options of `closecall run`, as one value."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import click

if TYPE_CHECKING:
    from ..formats.log.message_filter import Choice

#: Verdicts on which a run can fail.
FINDINGS = ("contact", "breach", "unresolved", "possible")

#: Hz, of snapshots. Short runs take the least number, which still shows a curve; long runs take the most.
USUAL_RATE = 30.0
LEAST_SNAPSHOTS, MOST_SNAPSHOTS = 120, 36_000
#: More snapshots than this are refused, if --rate makes so many.
MOST_ASKED = 1_000_000

MOST_JOBS = 1024

#: Units that a length on the command line can have.
LENGTH_UNITS = ("m", "cm", "mm", "um", "in", "ft")

AnyFunction = TypeVar("AnyFunction", bound=Callable[..., Any])


@dataclass(frozen=True, slots=True)
class RunOptions:
    """The options of a run; their help says what each means. Lengths are in m, times in s."""

    output: Path | None
    out_dir: Path | None
    time_resolution: float | None
    contact_tolerance: float | None
    margin: float | None
    distance_tolerance: float | Literal["none"] | None
    fail_on: tuple[str, ...]
    epoch: int
    compression: str
    attach_meshes: bool
    mesh_roots: tuple[Path, ...]
    max_bytes: int
    max_pairs: int
    strict: bool
    broad_phase: str
    jobs: int
    cluster: str | None
    log: str
    topics: str
    rate: float | None
    viz_pairs: int
    viz_triangles: int
    as_json: bool
    quiet: bool
    verbose: bool


def one_or_more_of(allowed: Sequence[str]) -> Callable[[click.Context, click.Parameter, str | None], tuple[str, ...]]:
    """Return a callback that splits a comma-separated choice and checks each part."""

    def chosen(ctx: click.Context, param: click.Parameter, value: str | None) -> tuple[str, ...]:
        parts = tuple(part.strip() for part in value.split(",")) if value is not None else ()
        for part in parts:
            if part not in allowed:
                raise click.BadParameter(f"{part!r} is not one of {', '.join(allowed)}.", ctx, param)
        return parts

    return chosen


def _share(ctx: click.Context, param: click.Parameter, value: str | None) -> float | Literal["none"] | None:
    """Read a share below 1, or none."""
    if value is None:
        return None
    if value == "none":
        return "none"
    try:
        share = float(value)
    except ValueError:
        share = nan
    if not 1e-6 <= share < 1.0:
        raise click.BadParameter(f"expected none, or a share of 1e-6 up to 1, got {value!r}.", ctx, param)
    return share


def _jobs(ctx: click.Context, param: click.Parameter, value: str) -> int:
    """Read a number of processes; auto means as many as there are processors that this one may use."""
    if value == "auto":
        from loky import cpu_count

        return int(cpu_count())
    if not value.isdecimal() or not 1 <= int(value) <= MOST_JOBS:
        raise click.BadParameter(f"expected auto, or 1 to {MOST_JOBS}, got {value!r}.", ctx, param)
    return int(value)


def _rate(ctx: click.Context, param: click.Parameter, value: float | None) -> float | None:
    """Check that the rate is a number that can be kept."""
    if value is not None and not 0.0 <= value <= 1e6:
        raise click.BadParameter(f"expected 0 to 1e6 Hz, got {value}.", ctx, param)
    return value


class _FileName(click.Path):
    """The name of a file or folder, as a path."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path; an empty name, as of a shell's variable that is not set, is none."""
        if value == "":
            self.fail("expected a name, got an empty one.", param, ctx)
        return super().convert(value, param, ctx)


class _Length(click.types.FloatParamType):
    """A length >= 0 such as 2mm, as metres; a number without a unit is in metres."""

    name = "length"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the length in m; a default is one already."""
        from ..formats.scene.quantities.lengths import read_length

        if isinstance(value, float):
            return value
        try:
            length = read_length(value)
        except ValueError:
            self.fail(f"expected a length such as 2mm (units: {', '.join(LENGTH_UNITS)}), got {value!r}.", param, ctx)
        if length < 0.0:
            self.fail(f"expected 0 or more, got {value!r}.", param, ctx)
        return length


LENGTH = _Length()
#: Only the name is checked here; reading or writing checks the file.
FILE_NAME = _FileName(path_type=Path, readable=False)
_CHOICE_OPTIONS = (
    click.option("--topic", "topics", multiple=True, metavar="GLOB", help="Select topics ('/spans', '/viz/*')."),
    click.option("--pair", "pairs", multiple=True, metavar="GLOB", help="Select pairs ('arm|*') or bodies ('tool*')."),
    click.option("--from", "start", type=float, metavar="S", help="Start at this scene time, in seconds."),
    click.option("--to", "end", type=float, metavar="S", help="End at this scene time, in seconds."),
)
_SCENE_OPTIONS = (
    click.option(
        "--mesh-root",
        "mesh_roots",
        multiple=True,
        type=FILE_NAME,
        metavar="DIR",
        help="Allow the scene to use files in this folder too.",
    ),
    click.option(
        "--max-bytes",
        type=click.IntRange(1),
        default=64 * 2**20,
        show_default=True,
        help="Refuse a larger scene file.",
    ),
    click.option(
        "--max-pairs",
        type=click.IntRange(1),
        default=5_000_000,
        show_default=True,
        help="Refuse more pairs than this when no broad phase is used.",
    ),
    click.option("--strict", is_flag=True, help="Treat warnings about the scene as errors."),
)
_OPTIONS = (
    click.option(
        "-o", "--output", type=FILE_NAME, metavar="LOG", help="Write the log to this file; - means standard output."
    ),
    click.option("--out-dir", type=FILE_NAME, metavar="DIR", help="Write one log per scene into this folder."),
    click.option("--time-resolution", type=float, metavar="S", help="Set the minimum step, in seconds."),
    click.option(
        "--contact-tolerance",
        type=float,
        metavar="S",
        help="Set the maximum width of the bracket around the begin or end of a contact, in seconds.",
    ),
    click.option(
        "--margin",
        type=LENGTH,
        metavar="LENGTH",
        help="Report pairs closer than this as breaches: 2mm, 0.08in; a bare number is in metres.",
    ),
    click.option(
        "--distance-tolerance",
        callback=_share,
        metavar="FRACTION",
        help="Certify each minimum distance to within this fraction of it; none skips the search.  [default: 0.01]",
    ),
    click.option(
        "--fail-on",
        callback=one_or_more_of(FINDINGS),
        metavar="VERDICTS",
        help=f"Exit with 1 if a pair has one of these verdicts: {','.join(FINDINGS)}.",
    ),
    click.option(
        "--epoch",
        type=int,
        default=0,
        show_default=True,
        metavar="NS",
        help="Add this offset to all log times, in nanoseconds.",
    ),
    click.option(
        "--compression",
        type=click.Choice(["zstd", "lz4", "none"]),
        default="zstd",
        show_default=True,
        help="Compress the log with this method.",
    ),
    click.option(
        "--attach-meshes/--no-attach-meshes",
        default=True,
        show_default=True,
        help="Attach the mesh files to the log.",
    ),
    *_SCENE_OPTIONS,
    click.option(
        "--broad-phase",
        type=click.Choice(["auto", "on", "off"]),
        default="auto",
        show_default=True,
        help="Clear distant pairs by their swept boxes; auto does so for scenes with more than 1000 pairs.",
    ),
    click.option(
        "-j",
        "--jobs",
        default="1",
        show_default=True,
        callback=_jobs,
        metavar="N",
        help="Share the pairs among N processes; auto starts one per processor. The log does not depend on N.",
    ),
    click.option("--cluster", metavar="ADDRESS", help="Share the pairs among the workers of this Dask scheduler."),
    click.option(
        "--log",
        type=click.Choice(["full", "certificate"]),
        default="full",
        show_default=True,
        help="Choose the content of the log; certificate omits the data for viewers.",
    ),
    click.option(
        "--topics",
        type=click.Choice(["single", "body"]),
        default="single",
        show_default=True,
        help="Write distances to a single topic, or to one topic per body.",
    ),
    click.option(
        "--rate",
        type=float,
        show_default=f"{USUAL_RATE:g}; higher below {LEAST_SNAPSHOTS / USUAL_RATE:g} s of scene time, "
        f"lower above {MOST_SNAPSHOTS / USUAL_RATE:g} s, for at most {MOST_SNAPSHOTS} snapshots",
        metavar="HZ",
        callback=_rate,
        help="Take this many snapshots per second for viewers; 0 takes them only at contacts.",
    ),
    click.option(
        "--viz-pairs",
        type=click.IntRange(1, 1000),
        default=10,
        show_default=True,
        help="Show this many of the closest pairs in each snapshot.",
    ),
    click.option(
        "--viz-triangles",
        type=click.IntRange(0),
        default=1_000_000,
        show_default=True,
        help="Draw at most this many triangles; draw the remaining bodies as boxes.",
    ),
    click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON."),
    click.option("-q", "--quiet", is_flag=True, help="Print only errors."),
    click.option("-v", "--verbose", is_flag=True, help="Also print the time that each stage took."),
)


def run_options(function: AnyFunction) -> AnyFunction:
    """Add the options of a run to a command, which takes them as keywords of `RunOptions`."""
    return _with(_OPTIONS, function)


def scene_options(function: AnyFunction) -> AnyFunction:
    """Add the options of reading a scene to a command: mesh_roots, max_bytes, max_pairs, strict."""
    return _with(_SCENE_OPTIONS, function)


def choice_options(function: AnyFunction) -> AnyFunction:
    """Add the options that say which messages of a log are wanted: topics, pairs, start, end."""
    return _with(_CHOICE_OPTIONS, function)


def choice_of(topics: tuple[str, ...], pairs: tuple[str, ...], start: float | None, end: float | None) -> Choice:
    """Return what the options of a choice say.

    Raises:
        click.BadParameter: for an interval that ends before it begins.
    """
    from ..formats.log.message_filter import Choice

    low, high = -inf if start is None else start, inf if end is None else end
    if not low <= high:
        raise click.BadParameter(f"expected --from before --to, got {start} and {end}.", param_hint="--from")
    return Choice(topics, pairs, low, high)


def _with(options: Sequence[Callable[[AnyFunction], AnyFunction]], function: AnyFunction) -> AnyFunction:
    for option in reversed(options):
        function = option(function)
    return function
