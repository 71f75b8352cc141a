"""`closecall check`: what a scene says, before it is run."""

from __future__ import annotations

from pathlib import Path

import click

from .faults import faults_reported
from .options import FILE_NAME, scene_options


@click.command("check")
@click.argument("scene", type=FILE_NAME)
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

    \b
    Examples:
      closecall check scene.yaml
      closecall check scene.yaml --suggest-ignores
    """
    from ..formats.scene.reader import read_scene
    from ..scheduler.broad_phase import near_at_start
    from ..scheduler.narrow_phase import NarrowPhase
    from ..scheduler.pairing import Pairing
    from .job import FEW_PAIRS, counted_pairs, require_few
    from .show import print_json, print_warnings
    from .understood import print_ignores, print_understood, understood

    with faults_reported():
        loaded = read_scene(scene, mesh_roots, max_bytes)
        pairing = Pairing(loaded.scene, NarrowPhase(loaded.scene.bodies), loaded.settings.margin)
        loaded, total = counted_pairs(loaded, strict)
        if total > FEW_PAIRS:
            pairs = near_at_start(pairing)
            margins = {loaded.settings.margin, *(margin for _, margin in loaded.scene.rules.margins)}
        else:
            require_few(loaded, total, max_pairs)
            pairs = tuple(pairing.all())
            margins = {pair.margin for pair in pairs}
        if quiet:
            return 0
        print_warnings(loaded.warnings)
        if suggest_ignores:
            print_ignores(loaded.scene, pairs)
        elif as_json:
            print_json(understood(loaded, total, sorted(margins)))
        else:
            print_understood(loaded, total, sorted(margins))
    return 0
