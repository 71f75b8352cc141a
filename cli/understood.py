"""The output of `closecall check`: how a scene was read."""

from __future__ import annotations

import json
from collections.abc import Container, Iterator, Sequence
from itertools import islice
from math import degrees, inf, isfinite
from typing import Any

import numpy as np

from ..formats.log.container.clock import coarseness_told
from ..formats.scene.loaded import LoadedScene
from ..formats.scene.quantities.lengths import length_number, length_text
from ..formats.scene.text.errors import counted
from ..scheduler.geometry.arrays import IntArray
from ..scheduler.model.pair_count import count_pairs
from ..scheduler.model.scene import Body, Mesh, Scene
from ..scheduler.motions import Ballistic, Delayed, Keyframes, Looped, Trapezoid
from ..scheduler.pairs.pair import Pair
from ..scheduler.pairs.pair_factory import ignored_pairs
from .show import console_for, print_rows
from .terminal import cell, say

#: Rows of the table for people.
MOST_ROWS = 40
#: Ignored pairs in the output.
MOST_NAMED = 8
#: Intervals between knots that a search for the top speed visits. A motion with more has no top speed in the output.
MOST_STRETCHES = 20_000

# The names that the scene file has for classes of other names.
_MOTION_NAMES: dict[type, str] = {Looped: "keyframes", Trapezoid: "profile"}


def understood(loaded: LoadedScene, pairs: int, margins: list[float]) -> dict[str, Any]:
    """Return how a scene was read, in SI units for JSON; absent values are null.

    Args:
        loaded: the scene.
        pairs: how many pairs a run checks.
        margins: of these pairs, m.
    """
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
        "pairs": pairs,
        "pairs_possible": _possible(scene),
        "ignored": [f"{scene.bodies[a].name}|{scene.bodies[b].name}" for a, b in ignored_pairs(scene)],
        "margins": margins,
        "meshes": [_mesh(mesh) for mesh in _file_meshes(loaded)],
        "files": [
            {"name": file.name, "path": str(file.path)} for file in (*loaded.mesh_files, *loaded.trajectory_files)
        ],
        "warnings": list(loaded.warnings),
    }


def print_understood(loaded: LoadedScene, pairs: int, margins: list[float]) -> None:
    """Print the bodies as a table, then pairs and times, with lengths in the unit of the scene."""
    scene, settings, unit = loaded.scene, loaded.settings, loaded.length_unit
    console = console_for()
    rows, recorded = [], []
    files = {file.name for file in loaded.trajectory_files}
    for body in scene.bodies[:MOST_ROWS]:
        told = _body(scene, body, files)
        size = "" if told["size"] is None else _lengths(told["size"], unit)
        recorded += _recorded_lines(told)
        rows.append([*map(cell, (told["name"], told["parent"] or "", _motion(told, unit), _shapes(told), size))])
    print_rows(console, ("body", "parent", "motion", "shapes (triangles)", "size"), rows)
    if len(scene.bodies) > MOST_ROWS:
        console.print(f"... and {counted(len(scene.bodies) - MOST_ROWS, 'more body', 'more bodies')}")
    for line in (*recorded, *islice(_enclosed(loaded), MOST_ROWS)):
        console.print(cell(line))
    bodies, possible, ignored = (
        counted(len(scene.bodies), "body", "bodies"),
        _possible(scene),
        count_pairs(scene).ignored,
    )
    others = f"; {ignored} ignored: {_named_ignored(scene, ignored)}" if ignored else ""
    if still := possible - pairs - ignored:
        others += f"; {still} never move relative to each other, or never exist at the same time"
    console.print(f"{bodies}, {pairs} of {counted(possible, 'pair')} to check{others}")
    margins = [margin for margin in margins if margin > 0.0]
    if margins:
        more = f" and {len(margins) - 5} more" if len(margins) > 5 else ""
        console.print(f"margins {', '.join(length_number(margin, unit) for margin in margins[:5])} {unit}{more}")
    console.print(f"from {scene.start:g} to {scene.end:g} s, time resolution {settings.time_resolution:g} s")
    coarse = coarseness_told(settings.contact_tolerance, scene.start, scene.end)
    if coarse:
        console.print(f"note: {coarse}")


def _file_meshes(loaded: LoadedScene) -> list[Mesh]:
    """Return the meshes from files that shapes show, in the order of the bodies; each once, at each scale."""
    shown = {shape.mesh: None for body in loaded.scene.bodies for shape in body.shapes}
    files = {file.name for file in loaded.mesh_files}
    return [mesh for mesh in shown if mesh.name in files]


def _mesh(mesh: Mesh) -> dict[str, Any]:
    """Return the solids and cavities of a mesh; each cavity with its size (m) and the size of the solid around it."""
    return {
        "name": mesh.name,
        "solids": len(mesh.solids),
        "cavities": [
            {"size": _spans(mesh, cavity), "around": _spans(mesh, solid.skin)}
            for solid in mesh.solids
            for cavity in solid.cavities
        ],
    }


def _spans(mesh: Mesh, triangles: IntArray) -> list[float]:
    """Return the lengths (m) of the box around triangles of a mesh."""
    lengths: list[float] = np.ptp(mesh.vertices[triangles], axis=(0, 1)).tolist()
    return lengths


def _enclosed(loaded: LoadedScene) -> Iterator[str]:
    """Yield one line per mesh file with its solids, and one line per cavity."""
    for told in map(_mesh, _file_meshes(loaded)):
        cavities = f", {counted(len(told['cavities']), 'cavity', 'cavities')}" if told["cavities"] else ""
        solids = counted(told["solids"], "solid") if told["solids"] else "a surface that encloses no solid"
        yield f"mesh {told['name']}: {solids}{cavities}"
        for cavity in told["cavities"]:
            size, around = (_lengths(cavity[key], loaded.length_unit) for key in ("size", "around"))
            yield f"mesh {told['name']}: cavity of {size} in a solid of {around}"


def _lengths(lengths: list[float], unit: str) -> str:
    """Return three lengths (m) as text in `unit`."""
    return " x ".join(length_number(length, unit, 3) for length in lengths) + f" {unit}"


def _named_ignored(scene: Scene, count: int) -> str:
    """Return the names of the first of so many ignored pairs."""
    first = islice(ignored_pairs(scene), min(count, MOST_NAMED))
    names = [f"{scene.bodies[a].name}|{scene.bodies[b].name}" for a, b in first]
    return ", ".join(names) + (f" and {count - MOST_NAMED} more" if count > MOST_NAMED else "")


def _possible(scene: Scene) -> int:
    """Return how many pairs of bodies with shapes there are."""
    solid = sum(bool(body.shapes) for body in scene.bodies)
    return solid * (solid - 1) // 2


def _motion(told: dict[str, Any], unit: str) -> str:
    """Return the law of a body's motion with its top speeds, except unknown and zero speeds; lengths are in `unit`."""
    speed, turning = told["top_speed"], told["top_angular_speed"]
    parts = (
        told["motion"],
        f"{length_text(speed, unit, 3)}/s" if speed else "",
        f"{degrees(turning):.3g} deg/s" if turning else "",
    )
    return ", ".join(filter(None, parts))


def _shapes(told: dict[str, Any]) -> str:
    """Return the number of shapes and of triangles of a body; spheres and capsules have no triangles."""
    triangles = f" ({told['triangles']})" if told["triangles"] else ""
    return f"{told['shapes'] or ''}{triangles}"


def print_ignores(scene: Scene, pairs: Sequence[Pair]) -> None:
    """Print, as a `pairs` section, the pairs that touch when both bodies first exist."""
    touching = [pair for pair in pairs if pair.look_inside(pair.measure(pair.start)).touching]
    if not touching:
        say("no checked pair touches at the start", to_stderr=True)
        return
    say("pairs:")
    say("  ignore:")
    for pair in touching:
        names = ", ".join(_in_yaml(scene.bodies[body].name) for body in (pair.key.a, pair.key.b))
        say(f"    - {{between: [{names}], reason: touching at {pair.start:g} s}}")


def _in_yaml(name: str) -> str:
    """Return a name in double quotes for YAML, with an escape for each character that is not printable."""
    quoted = json.dumps(name, ensure_ascii=False)
    return "".join(c if c.isprintable() else f"\\U{ord(c):08X}" for c in quoted)


def _body(scene: Scene, body: Body, files: Container[str]) -> dict[str, Any]:
    """Return how a body was read; bodies named in `files` follow a trajectory file."""
    speeds = [speed if isfinite(speed) else None for speed in _top_speeds(scene, body)]
    triangles = sum(len(shape.mesh.triangles) for shape in body.shapes if shape.radius == 0.0)
    return {
        "name": body.name,
        "parent": None if body.parent is None else scene.bodies[body.parent].name,
        "motion": "file" if body.name in files else _motion_name(body),
        "recorded": _recorded(body) if body.name in files else None,
        "top_speed": speeds[0],
        "top_angular_speed": speeds[1],
        "shapes": len(body.shapes),
        "triangles": triangles,
        "chord_error": body.chord_error,
        "size": _size(body),
        "exists": list(body.exists) if all(map(isfinite, body.exists)) else None,
    }


def _recorded(body: Body) -> dict[str, Any] | None:
    """Return the poses of a trajectory file: their count, first and last scene time (s), rate and largest gap (s).

    The rate is one over the median time between poses, in Hz. With a single pose there is neither rate nor gap.
    """
    keys = body.motion.keys if isinstance(body.motion, Looped) else body.motion
    if not isinstance(keys, Keyframes):
        return None
    gaps = np.diff(keys.times)
    widest = int(np.argmax(gaps > (1.0 - 1e-9) * gaps.max())) if len(gaps) else 0  # the first of equal gaps
    return {
        "poses": len(keys.times),
        "time": [float(keys.times[0]), float(keys.times[-1])],
        "rate": float(1.0 / np.median(gaps)) if len(gaps) else None,
        "largest_gap": float(gaps[widest]) if len(gaps) else None,
        "largest_gap_from": float(keys.times[widest]) if len(gaps) else None,
    }


def _recorded_lines(told: dict[str, Any]) -> list[str]:
    """Return the line about a body's trajectory file, if it has one."""
    recorded = told["recorded"]
    if recorded is None:
        return []
    first, last = recorded["time"]
    text = f"{told['name']}: {counted(recorded['poses'], 'recorded pose')} from {first:.6g} to {last:.6g} s"
    if recorded["rate"] is None:
        return [text]
    largest = f"largest gap {recorded['largest_gap']:.3g} s, after {recorded['largest_gap_from']:.6g} s"
    return [f"{text} ({last - first:.6g} s), {recorded['rate']:.4g} Hz, {largest}"]


def _motion_name(body: Body) -> str:
    """Return the law of a body's motion, as the scene file calls it."""
    motion = body.motion.motion if isinstance(body.motion, Delayed) else body.motion
    if isinstance(motion, Ballistic) and not any(motion.acceleration):
        return "constant"
    return _MOTION_NAMES.get(type(motion)) or type(motion).__name__.lower()


def _top_speeds(scene: Scene, body: Body) -> tuple[float, float]:
    """Return upper bounds on the speed (m/s) of a body's origin and on its turning (rad/s), both in its parent.

    inf where there is no such bound, both for a motion with too many knots. Jumps have no speed.
    """
    time, end = max(scene.start, body.exists[0]), min(scene.end, body.exists[1])
    speed = turning = 0.0
    for _ in range(MOST_STRETCHES):
        knot = min(body.motion.knot_after(time), end)
        rates = body.motion.rates(time, knot - time)
        speed, turning, time = max(speed, rates.speed), max(turning, rates.angular_speed), knot
        if time >= end:
            return speed, turning
    return inf, inf


def _size(body: Body) -> list[float] | None:
    """Return the lengths (m) of the box around a body along its own x, y, z; None for a frame without shapes."""
    if not body.shapes:
        return None
    lows, highs = [], []
    for shape in body.shapes:
        points = shape.mesh.vertices @ shape.pose[:3, :3].T + shape.pose[:3, 3]
        lows.append(points.min(axis=0) - shape.radius)
        highs.append(points.max(axis=0) + shape.radius)
    lengths: list[float] = (np.max(highs, axis=0) - np.min(lows, axis=0)).tolist()
    return lengths
