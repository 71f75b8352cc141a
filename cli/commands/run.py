"""`closecall run`: from scene files to certified logs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from ..options import FILE_NAME, RunOptions, run_options


@click.command("run")
@click.argument("scenes", nargs=-1, required=True, type=FILE_NAME, metavar="SCENE...")
@run_options
def command(scenes: tuple[Path, ...], **given: Any) -> int:
    """Run SCENE and write a certified log. With --out-dir, run several scenes.

    For every pair and every instant the log states what is proved: clear, breach, contact, possible or unresolved.

    \b
    Examples:
      closecall run scene.yaml -o out.mcap
      closecall run scene.yaml -o out.mcap --margin 2mm --fail-on contact,breach
      closecall run sample_scenes/spinning_bar/scene.yaml scene.yaml --out-dir logs --log certificate
      closecall run scene.yaml -o - --log certificate > out.mcap
      closecall run scene.yaml -o out.mcap --json
    """
    options = RunOptions(**given)
    if (options.output is None) is (options.out_dir is None):
        raise click.UsageError("Give either -o LOG or --out-dir DIR.")
    if options.jobs > 1 and options.cluster is not None:
        raise click.UsageError("Give either --jobs or --cluster.")
    if options.out_dir is not None:
        from ..batch import run_many

        return run_many(scenes, options.out_dir, options)
    scene, *others = scenes
    if others:
        raise click.UsageError("Use --out-dir DIR instead of -o for several scenes.")
    assert options.output is not None
    return _run_one(scene, options.output, options)


def options_of(scene: Path, output: Path, words: Sequence[str]) -> RunOptions:
    """Return the options of a run of one scene, written as on the command line.

    Raises:
        click.UsageError: for words that are not options of a run.
    """
    context = command.make_context("closecall run", [str(scene), "-o", str(output), *words])
    return RunOptions(**{name: value for name, value in context.params.items() if name != "scenes"})


def _run_one(scene: Path, output: Path, options: RunOptions) -> int:
    """Run one scene; return the exit code."""
    from ...formats.log.container.pipe import STDOUT
    from ..faults import faults_reported
    from ..job import run_job
    from ..show import print_json, print_seconds, print_summary, print_warnings

    if output == STDOUT and options.as_json:
        raise click.UsageError("--json and -o - both write to standard output; choose one.")
    with faults_reported(output):
        result = run_job(scene, output, options)
    if not options.quiet:
        print_warnings(result.warnings, result.note)
    if options.as_json:
        print_json({**result.summary, "seconds": result.seconds})
    elif not options.quiet:
        print_summary(result.summary, result.length_unit, to_stderr=output == STDOUT)
    if options.verbose:
        print_seconds(result.seconds)
    return int(result.finds(options.fail_on))
