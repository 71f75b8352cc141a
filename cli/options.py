"""The options of the commands, as click reads them. `RunOptions` holds the defaults of a run and checks its values."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from .application.errors import OptionError
from .application.options import CHOICES, COUNTS, FEW_PAIRS, RunOptions
from .application.rate import LEAST_SNAPSHOTS, MOST_SNAPSHOTS, USUAL_RATE

if TYPE_CHECKING:
    from ..formats.log.message_filter import Choice

#: Verdicts on which a run can fail.
FINDINGS = ("contact", "breach", "unresolved", "possible")

DEFAULTS = RunOptions()

AnyFunction = TypeVar("AnyFunction", bound=Callable[..., Any])


@dataclass(frozen=True, slots=True)
class ConsoleOptions:
    """What `closecall run` prints, and the verdicts on which it exits with 1. The help says what each option means."""

    fail_on: tuple[str, ...]
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


def _or_word(number: type[int] | type[float]) -> Callable[[str], float | str]:
    """Return a function that reads a number and returns any other word unchanged; `RunOptions` checks both."""

    def read(value: str) -> float | str:
        try:
            return number(value)
        except ValueError:
            return value

    return read


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
        from ..formats.scene.quantities.units import METRES

        if isinstance(value, float):
            return value
        try:
            length = read_length(value)
        except ValueError:
            self.fail(f"expected a length such as 2mm (units: {', '.join(METRES)}), got {value!r}.", param, ctx)
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
        type=click.IntRange(*COUNTS["max_bytes"]),
        default=DEFAULTS.max_bytes,
        show_default=True,
        help="Refuse a larger scene file.",
    ),
    click.option(
        "--max-pairs",
        type=click.IntRange(*COUNTS["max_pairs"]),
        default=DEFAULTS.max_pairs,
        show_default=True,
        help="Refuse more pairs than this when no broad phase is used.",
    ),
    click.option("--strict", is_flag=True, help="Treat warnings about the scene as errors."),
)
_OUTPUT_OPTIONS = (
    click.option(
        "-o", "--output", type=FILE_NAME, metavar="LOG", help="Write the log to this file; - means standard output."
    ),
    click.option("--out-dir", type=FILE_NAME, metavar="DIR", help="Write one log per scene into this folder."),
)
_RUN_OPTIONS = (
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
        type=_or_word(float),
        metavar="FRACTION",
        help="Certify each minimum distance to within this fraction of it; none skips the search.  [default: 0.01]",
    ),
    click.option(
        "--epoch",
        type=int,
        default=DEFAULTS.epoch,
        show_default=True,
        metavar="NS",
        help="Add this offset to all log times, in nanoseconds.",
    ),
    click.option(
        "--compression",
        type=click.Choice(CHOICES["compression"]),
        default=DEFAULTS.compression,
        show_default=True,
        help="Compress the log with this method.",
    ),
    click.option(
        "--attach-meshes/--no-attach-meshes",
        default=DEFAULTS.attach_meshes,
        show_default=True,
        help="Attach the mesh files to the log.",
    ),
    *_SCENE_OPTIONS,
    click.option(
        "--broad-phase",
        type=click.Choice(CHOICES["broad_phase"]),
        default=DEFAULTS.broad_phase,
        show_default=True,
        help=f"Clear distant pairs by their swept boxes; auto does so for scenes with more than {FEW_PAIRS} pairs.",
    ),
    click.option(
        "-j",
        "--jobs",
        type=_or_word(int),
        default=DEFAULTS.jobs,
        show_default=True,
        metavar="N",
        help="Share the pairs among N processes; auto starts one per processor. The log does not depend on N.",
    ),
    click.option("--cluster", metavar="ADDRESS", help="Share the pairs among the workers of this Dask scheduler."),
    click.option(
        "--log",
        type=click.Choice(CHOICES["log"]),
        default=DEFAULTS.log,
        show_default=True,
        help="Choose the content of the log; certificate omits the data for viewers.",
    ),
    click.option(
        "--topics",
        type=click.Choice(CHOICES["topics"]),
        default=DEFAULTS.topics,
        show_default=True,
        help="Write distances to a single topic, or to one topic per body.",
    ),
    click.option(
        "--rate",
        type=float,
        show_default=f"{USUAL_RATE:g}; higher below {LEAST_SNAPSHOTS / USUAL_RATE:g} s of scene time, "
        f"lower above {MOST_SNAPSHOTS / USUAL_RATE:g} s, for at most {MOST_SNAPSHOTS} snapshots",
        metavar="HZ",
        help="Take this many snapshots per second for viewers; 0 takes them only at contacts.",
    ),
    click.option(
        "--viz-pairs",
        type=click.IntRange(*COUNTS["viz_pairs"]),
        default=DEFAULTS.viz_pairs,
        show_default=True,
        help="Show this many of the closest pairs in each snapshot.",
    ),
    click.option(
        "--viz-triangles",
        type=click.IntRange(*COUNTS["viz_triangles"]),
        default=DEFAULTS.viz_triangles,
        show_default=True,
        help="Draw at most this many triangles; draw the remaining bodies as boxes.",
    ),
)
_CONSOLE_OPTIONS = (
    click.option(
        "--fail-on",
        callback=one_or_more_of(FINDINGS),
        metavar="VERDICTS",
        help=f"Exit with 1 if a pair has one of these verdicts: {','.join(FINDINGS)}.",
    ),
    click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON."),
    click.option("-q", "--quiet", is_flag=True, help="Print only errors."),
    click.option("-v", "--verbose", is_flag=True, help="Also print the time that each stage took."),
)


def output_options(function: AnyFunction) -> AnyFunction:
    """Add the options that say where logs go to a command: output, out_dir."""
    return _with(_OUTPUT_OPTIONS, function)


def run_options(function: AnyFunction) -> AnyFunction:
    """Add the options of a run to a command, which takes them as keywords of `RunOptions`."""
    return _with(_RUN_OPTIONS, function)


def console_options(function: AnyFunction) -> AnyFunction:
    """Add the options of the console to a command, which takes them as keywords of `ConsoleOptions`."""
    return _with(_CONSOLE_OPTIONS, function)


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


def options_of(words: Sequence[str]) -> RunOptions:
    """Return the options of a run, written as on the command line.

    Raises:
        click.UsageError: for words that are not options of a run.
    """
    parser = run_options(click.Command("closecall run", add_help_option=False))
    with parser.make_context(parser.name, list(words)) as context, misuse_reported():
        return RunOptions(**context.params)


@contextmanager
def misuse_reported() -> Iterator[None]:
    """Turn an option error into a usage error of the current command line.

    Raises:
        click.BadParameter: for a value that an option of a run cannot have.
    """
    try:
        yield
    except OptionError as error:
        raise misuse(error) from error


def misuse(error: OptionError) -> click.BadParameter:
    """Return an option error as click words it: with the name of the option on the command line."""
    context = click.get_current_context()
    (option,) = (option for option in context.command.params if option.name == error.option)
    return click.BadParameter(f"{error.problem}.", context, option)


def _with(options: Sequence[Callable[[AnyFunction], AnyFunction]], function: AnyFunction) -> AnyFunction:
    for option in reversed(options):
        function = option(function)
    return function
