"""`closecall run`: from a scene file to a certified log."""

from __future__ import annotations

from pathlib import Path

import click

from .faults import faults_reported
from .findings import FINDINGS, parse_findings


@click.command("run")
@click.argument("scene", type=click.Path(path_type=Path))
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="The log to write (.mcap).")
@click.option("--time-resolution", type=float, metavar="S", help="Least step of the main loop, s; else the scene's.")
@click.option("--contact-tolerance", type=float, metavar="S", help="Widest bracket of a contact's begin or end, s.")
@click.option("--fail-on", callback=parse_findings, metavar="WHAT", help=f"Exit 1 if found: {','.join(FINDINGS)}.")
@click.option("--epoch", type=int, default=0, show_default=True, metavar="NS", help="Added to every log time, ns.")
@click.option("--compression", type=click.Choice(["zstd", "lz4", "none"]), default="zstd", show_default=True)
@click.option(
    "--attach-meshes/--no-attach-meshes", default=True, help="Keep the mesh files in the log (default), or not."
)
@click.option("--mesh-root", "mesh_roots", multiple=True, type=click.Path(path_type=Path), metavar="DIR",
              help="A folder outside the scene's that meshes may come from; may be repeated.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON instead of a table.")
@click.option("-q", "--quiet", is_flag=True, help="Print no table and no warnings.")
@click.option("-v", "--verbose", is_flag=True, help="Print what was run and what it took as well.")
def command(
    scene: Path,
    output: Path,
    time_resolution: float | None,
    contact_tolerance: float | None,
    fail_on: tuple[str, ...],
    epoch: int,
    compression: str,
    attach_meshes: bool,
    mesh_roots: tuple[Path, ...],
    as_json: bool,
    quiet: bool,
    verbose: bool,
) -> int:
    """Run SCENE and write its certified log.

    Example: closecall run sample_scenes/near_gears/scene.yaml -o gears.mcap --fail-on contact
    """
    from ..formats.log.chunks import Compression
    from ..formats.log.writer import LogOptions
    from .job import run_job
    from .show import print_json, print_seconds, print_summary, print_warnings

    options = LogOptions(Compression(compression), epoch, attach_meshes)
    given = {"time_resolution": time_resolution, "contact_tolerance": contact_tolerance}
    with faults_reported(output):
        result = run_job(scene, output, given, options, mesh_roots)
    if not quiet:
        print_warnings(result.warnings)
    if as_json:
        print_json({**result.summary, "seconds": result.seconds})
    elif not quiet:
        print_summary(result.summary)
    if verbose:
        print_seconds(result.seconds)
    return int(any(pair["verdict"] in fail_on for pair in result.summary["pairs"]))
