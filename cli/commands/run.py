"""`closecall run`: from scene files to certified logs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..application.options import RunOptions
from ..options import FILE_NAME, ConsoleOptions, console_options, misuse_reported, output_options, run_options


@click.command("run")
@click.argument("scenes", nargs=-1, required=True, type=FILE_NAME, metavar="SCENE...")
@output_options
@run_options
@console_options
def command(
    scenes: tuple[Path, ...],
    output: Path | None,
    out_dir: Path | None,
    fail_on: tuple[str, ...],
    as_json: bool,
    quiet: bool,
    verbose: bool,
    **given: Any,
) -> int:
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
    if (output is None) is (out_dir is None):
        raise click.UsageError("Give either -o LOG or --out-dir DIR.")
    with misuse_reported():
        options = RunOptions(**given)
    console = ConsoleOptions(fail_on, as_json, quiet, verbose)
    if out_dir is not None:
        from ..batch import run_many

        return run_many(scenes, out_dir, options, console)
    scene, *others = scenes
    if others:
        raise click.UsageError("Use --out-dir DIR instead of -o for several scenes.")
    assert output is not None
    return _run_one(scene, output, options, console)


def _run_one(scene: Path, output: Path, options: RunOptions, console: ConsoleOptions) -> int:
    """Run one scene; return the exit code."""
    from ...formats.log.container.pipe import STDOUT
    from ..application.run import run
    from ..faults import faults_reported
    from ..progress import ProgressBar
    from ..show import print_json, print_seconds, print_summary, print_warnings

    if output == STDOUT and console.as_json:
        raise click.UsageError("--json and -o - both write to standard output; choose one.")
    with faults_reported(output), misuse_reported():
        result = run(scene, output, options, watcher=ProgressBar(scene.name, console.quiet))
    if not console.quiet:
        print_warnings(result.warnings, result.note)
    if console.as_json:
        print_json({**result.summary, "seconds": result.seconds})
    elif not console.quiet:
        print_summary(result.summary, result.length_unit, to_stderr=output == STDOUT)
    if console.verbose:
        print_seconds(result.seconds)
    return int(result.finds(console.fail_on))
