"""`closecall check`: validate scenes without running them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..faults import faults_reported, report
from ..options import FILE_NAME, scene_options

if TYPE_CHECKING:
    from ...formats.scene.loaded import LoadedScene
    from ...scheduler.pairs.pair import Pair


@click.command("check")
@click.argument("scenes", nargs=-1, required=True, type=FILE_NAME, metavar="SCENE...")
@scene_options
@click.option(
    "--suggest-ignores",
    is_flag=True,
    help="Print the pairs that touch at the start as a `pairs` section for the scene.",
)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON how the scene was read.")
@click.option("-q", "--quiet", is_flag=True, help="Print only errors.")
def command(
    scenes: tuple[Path, ...],
    mesh_roots: tuple[Path, ...],
    max_bytes: int,
    max_pairs: int,
    strict: bool,
    suggest_ignores: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Validate SCENE and print how it was read: bodies, shapes, pairs, times and warnings.

    \b
    Examples:
      closecall check scene.yaml
      closecall check scene.yaml sample_scenes/spinning_bar/scene.yaml -q
      closecall check scene.yaml --suggest-ignores
    """
    from ...formats.scene.text.errors import SceneError
    from ..application.scenes import load
    from ..show import print_json, print_warnings
    from ..terminal import say
    from ..understood import print_ignores, print_understood, understood

    many, told, code = len(scenes) > 1, [], 0
    with faults_reported():
        for scene in scenes:
            try:
                loaded, total, pairs, margins = _checked(
                    load(scene, mesh_roots=mesh_roots, max_bytes=max_bytes), strict, max_pairs
                )
            except SceneError as fault:
                report(fault, None)
                code = 2
                told.append(_as_json(scene, None))
                continue
            if quiet:
                continue
            print_warnings(loaded.warnings)
            if as_json:
                told.append(_as_json(scene, understood(loaded, total, margins)))
                continue
            if many:
                say(f"{'# ' if suggest_ignores else ''}{scene}")
            if suggest_ignores:
                print_ignores(loaded.scene, pairs)
            else:
                print_understood(loaded, total, margins)
        if as_json and not quiet:
            if many:
                print_json({"scenes": told})
            elif told[0]["understood"] is not None:
                print_json(told[0]["understood"])
    return code


def _checked(
    loaded: LoadedScene, strict: bool, max_pairs: int
) -> tuple[LoadedScene, int, tuple[Pair, ...], list[float]]:
    """Return the scene with all warnings, how many pairs it checks, pairs that may touch at the start, and margins (m).

    Raises:
        SceneError: for more pairs than `max_pairs`, and under `strict` for any warning.
    """
    from ...scheduler.broad.broad_phase import near_at_start
    from ...scheduler.narrow.narrow_phase import NarrowPhase
    from ...scheduler.pairs.pair_factory import PairFactory
    from ..application.options import FEW_PAIRS
    from ..application.scenes import counted_pairs, require_few

    factory = PairFactory(loaded.scene, NarrowPhase(loaded.scene.bodies), loaded.settings.margin)
    loaded, total = counted_pairs(loaded, strict)
    if total > FEW_PAIRS:
        pairs = tuple(near_at_start(factory))
        margins = {loaded.settings.margin, *(margin for _, margin in loaded.scene.rules.margins)}
    else:
        require_few(loaded, total, max_pairs)
        pairs = tuple(factory.all())
        margins = {pair.margin for pair in pairs}
    return loaded, total, pairs, sorted(margins)


def _as_json(scene: Path, understood: dict[str, Any] | None) -> dict[str, Any]:
    """Return the JSON value of one scene: how it was read, or null if it is refused."""
    return {"scene": str(scene), "exit": 2 if understood is None else 0, "understood": understood}
