"""What `closecall check` prints of a scene."""

from __future__ import annotations

import json
from collections.abc import Container, Sequence
from math import isfinite
from typing import Any

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..formats.scene.loaded import LoadedScene
from ..scheduler.motions import Ballistic, Delayed, Looped
from ..scheduler.pair import Pair
from ..scheduler.scene import Body, Scene

#: Rows of the table for people.
MOST_ROWS = 40


def understood(loaded: LoadedScene, pairs: Sequence[Pair]) -> dict[str, Any]:
    """Return what was understood: SI units, null for what is not there."""
    scene, settings = loaded.scene, loaded.settings
    files = {file.name for file in loaded.trajectory_files}
    return {
        "time": [scene.start, scene.end],
        "settings": {
            "time_resolution": settings.time_resolution,
            "contact_tolerance": settings.contact_tolerance,
            "margin": settings.margin,
            "distance_tolerance": settings.distance_tolerance,
        },
        "bodies": [_body(scene, body, files) for body in scene.bodies],
        "pairs": len(pairs),
        "margins": sorted({pair.margin for pair in pairs}),
        "files": [
            {"name": file.name, "path": str(file.path)} for file in (*loaded.mesh_files, *loaded.trajectory_files)
        ],
        "warnings": list(loaded.warnings),
    }


def print_understood(loaded: LoadedScene, pairs: Sequence[Pair]) -> None:
    """Print the bodies as a table, then pairs and times."""
    scene, settings = loaded.scene, loaded.settings
    console = Console(highlight=False)
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("body", "parent", "motion", "shapes", "triangles", "size"):
        table.add_column(column, justify="right" if column == "triangles" else "left", overflow="fold")
    files = {file.name for file in loaded.trajectory_files}
    for body in scene.bodies[:MOST_ROWS]:
        told = _body(scene, body, files)
        size = "" if told["size"] is None else f"{told['size']:.4g} m"
        shapes = str(len(body.shapes) or "")
        row = (told["name"], told["parent"] or "", told["motion"], shapes, str(told["triangles"] or ""), size)
        table.add_row(*map(Text, row))
    console.print(table)
    if len(scene.bodies) > MOST_ROWS:
        console.print(f"... and {len(scene.bodies) - MOST_ROWS} more bodies")
    margins = sorted({pair.margin for pair in pairs if pair.margin > 0.0})
    within = f", margins {', '.join(f'{margin:.6g}' for margin in margins[:5])} m" if margins else ""
    console.print(f"{len(scene.bodies)} bodies, {len(pairs)} pairs to check{within}")
    console.print(f"from {scene.start:g} to {scene.end:g} s, time resolution {settings.time_resolution:g} s")


def print_ignores(scene: Scene, pairs: Sequence[Pair]) -> None:
    """Print the pairs that touch when both bodies are first there, as the scene's `pairs` section."""
    touching = [pair for pair in pairs if pair.look_inside(pair.measure(pair.start)).touching]
    if not touching:
        click.echo("no pair touches at the start", err=True)
        return
    click.echo("pairs:\n  ignore:")
    for pair in touching:
        names = ", ".join(_in_yaml(scene.bodies[body].name) for body in (pair.key.a, pair.key.b))
        click.echo(f"    - {{between: [{names}], reason: touching at {pair.start:g} s}}")


def _in_yaml(name: str) -> str:
    """Return a name in double quotes, what does not print or YAML would not have raw as its number."""
    quoted = json.dumps(name, ensure_ascii=False)
    return "".join(c if c.isprintable() else f"\\U{ord(c):08X}" for c in quoted)


def _body(scene: Scene, body: Body, files: Container[str]) -> dict[str, Any]:
    """Return what is told of a body; those whose names are in `files` move along a trajectory file."""
    triangles = sum(len(shape.mesh.triangles) for shape in body.shapes if shape.radius == 0.0)
    return {
        "name": body.name,
        "parent": None if body.parent is None else scene.bodies[body.parent].name,
        "motion": "file" if body.name in files else _motion_name(body),
        "shapes": len(body.shapes),
        "triangles": triangles,
        "chord_error": body.chord_error,
        "size": _size(body),
        "exists": list(body.exists) if all(map(isfinite, body.exists)) else None,
    }


def _motion_name(body: Body) -> str:
    """Return the law of a body's motion, as the scene file calls it."""
    motion = body.motion.motion if isinstance(body.motion, Delayed) else body.motion
    if isinstance(motion, Ballistic) and not any(motion.acceleration):
        return "constant"
    return "keyframes" if isinstance(motion, Looped) else type(motion).__name__.lower()


def _size(body: Body) -> float | None:
    """Return the diameter (m) of a ball around the body, None for a frame without shapes."""
    from ..scheduler.narrow_phase import body_extent

    return 2.0 * body_extent(body).ball.radius if body.shapes else None
