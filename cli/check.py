"""`closecall check`: what a scene says, before it is run."""

from __future__ import annotations

from pathlib import Path

import click

from .faults import faults_reported
from .options import scene_options


@click.command("check")
@click.argument("scene", type=click.Path(path_type=Path, readable=False))
@scene_options
@click.option("--suggest-ignores", is_flag=True, help="Print pairs that touch at the start, ready to paste.")
@click.option("--json", "as_json", is_flag=True, help="Print what was understood as JSON.")
@click.option("-q", "--quiet", is_flag=True, help="Print faults alone.")
def command(
    scene: Path,
    mesh_roots: tuple[Path, ...],
    max_bytes: int,
    max_pairs: int,
    strict: bool,
    suggest_ignores: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Check SCENE and tell what was understood: bodies, triangles, pairs, warnings.

    Example: closecall check scene.yaml --suggest-ignores
    """
    from ..formats.scene.reader import read_scene
    from ..scheduler.narrow_phase import NarrowPhase
    from .job import paired
    from .show import print_json, print_warnings
    from .understood import print_ignores, print_understood, understood

    with faults_reported():
        loaded = read_scene(scene, mesh_roots, max_bytes)
        narrow_phase = NarrowPhase(loaded.scene.bodies)
        loaded, pairs = paired(loaded, narrow_phase, loaded.settings, max_pairs, strict)
        if quiet:
            return 0
        print_warnings(loaded.warnings)
        if suggest_ignores:
            print_ignores(loaded.scene, pairs)
        elif as_json:
            print_json(understood(loaded, pairs))
        else:
            print_understood(loaded, pairs)
    return 0
