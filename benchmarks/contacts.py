"""What contacts cost: 40 bodies for 5 s, 10 of them resting on what they touch, 10 sliding or rolling on it.

`python -m benchmarks.contacts [SECONDS]` runs the scene three times at 1 ms: with every contact measured at each step
("before"), with contacts that sleep, and the same without the search for least distances. It prints, per run, wakeups
per second of contact (resting and sliding apart), exact queries, the share of time left unresolved, and CPU seconds.
"""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any
from unittest.mock import patch

import numpy as np
import trimesh

from closecall.formats.scene.reader import read_scene
from closecall.scheduler.model.events import Bound, Level, PairKey, Reason, Span, Verdict, Wakeup
from closecall.scheduler.narrow.narrow_phase import NarrowPhase
from closecall.scheduler.pairs.contact import ContactSleep
from closecall.scheduler.pairs.pair_factory import pairs_that_might_collide
from closecall.scheduler.run import run

from .scene_file import write_scene_file

SHAPES: tuple[dict[str, Any], ...] = (
    {"box": [0.3, 0.2, 0.2]},
    {"cylinder": {"radius": 0.1, "length": 0.2}},
    {"sphere": 0.1},
    {"capsule": {"radius": 0.1, "length": 0.3}, "pose": {"rpy": [0, np.pi / 2, 0]}},
    {"mesh": "rock"},
)
DEPTHS = (0.0, 1e-3)
"""m, how deep the bodies stand in what they touch: just touching, and one millimetre."""

SLIDES: tuple[dict[str, Any], ...] = (
    {"type": "constant", "velocity": [0.3, 0.1, 0]},
    {"type": "harmonic", "direction": [1, 0, 0], "amplitude": 0.4, "period": 2.0},
    {"type": "profile", "kind": "slide", "axis": [0, 1, 0], "from": 0, "to": 1.5, "max_velocity": 0.6,
     "max_acceleration": 1.0},
    {"type": "orbit", "axis": [0, 0, 1], "start": [1, 0, 0], "radius": 0.3, "rate": 1.5,
     "facing": True},
    {"type": "constant", "velocity": [0.2, 0, 0], "angular_velocity": [0, 0, 2.0]},
)  # fmt: skip


def rock() -> trimesh.Trimesh:
    """Return a bumpy ball of 320 triangles with a flat foot, about 0.2 m wide, 0.1 m above its foot."""
    ball = trimesh.creation.icosphere(subdivisions=2)
    vertices = ball.vertices * np.random.default_rng(0).uniform(0.85, 1.0, (len(ball.vertices), 1)) * 0.12
    vertices[:, 2] = np.maximum(vertices[:, 2], -0.1)
    return trimesh.Trimesh(vertices, ball.faces, process=False)


def table() -> trimesh.Trimesh:
    """Return a plate of 12 m whose upper face is at z = 0, cut into triangles of 0.25 m."""
    plate = trimesh.creation.box((12.0, 12.0, 1.0)).apply_translation((0.0, 0.0, -0.5))
    return plate.subdivide_to_size(0.36)


def bodies() -> dict[str, Any]:
    """Return a table, ten bodies that rest (half of them on a belt they ride on), ten that slide, and 18 in flight."""
    rng = np.random.default_rng(1)
    rides = {"type": "constant", "velocity": [0.5, 0, 0]}
    found: dict[str, Any] = {
        "table": {"shapes": [{"mesh": "table"}]},
        "belt": {"shapes": [{"box": [12, 1, 1], "pose": {"xyz": [0, 8, -0.5]}}], "motion": rides},
    }
    for index in range(10):
        x, shape, depth = index - 5.0, SHAPES[index % 5], DEPTHS[index // 5]
        rests = {"type": "keyframes", "keys": [{"t": 0}, {"t": 9}]}
        found[f"resting_{index}"] = {
            "pose": {"xyz": [x, 8.0 if index % 2 else -5.0, 0.1 - depth]},
            "shapes": [shape],
            "motion": rides if index % 2 else rests,
        }
        found[f"sliding_{index}"] = {
            "pose": {"xyz": [x, 0.0, 0.1 - depth]},
            "shapes": [shape],
            "motion": SLIDES[(index + index // 5) % 5],
        }
    for index in range(18):
        found[f"flying_{index}"] = {
            "pose": {"xyz": [*rng.uniform(-5, 5, 2).tolist(), float(rng.uniform(0.5, 3.0))]},
            "shapes": [SHAPES[index % 5]],
            "motion": {
                "type": "harmonic", "direction": [1, 0, 0], "amplitude": 1.0, "period": float(rng.uniform(1, 4)),
            },
        }  # fmt: skip
    return found


def measured(scene: Path, sleeps: bool, refines: bool) -> None:
    """Run the scene and print one row."""
    loaded = read_scene(scene)
    settings = loaded.settings if refines else replace(loaded.settings, distance_tolerance=None)
    narrow_phase = NarrowPhase(loaded.scene.bodies)
    pairs = pairs_that_might_collide(loaded.scene, narrow_phase, settings.margin)
    names = [body.name for body in loaded.scene.bodies]
    wakeups: Counter[str] = Counter()
    seconds: Counter[str] = Counter()
    time: Counter[Verdict] = Counter()
    exact = minimum = 0

    def kind(pair: PairKey) -> str:
        return next(k for k in ("flying", "sliding", "resting") if k in names[pair.a] + names[pair.b])

    began = process_time()
    awake = (0.0, Bound.TIME_RESOLUTION)
    with patch.object(ContactSleep, "sleep", ContactSleep.sleep if sleeps else lambda self, touching, horizon: awake):
        for event in run(pairs, settings):
            if isinstance(event, Span):
                time[event.verdict] += event.end - event.start
                if event.verdict is Verdict.CONTACT:
                    seconds[kind(event.pair)] += event.end - event.start
            elif isinstance(event, Wakeup):
                exact += event.level is Level.MESH
                minimum += event.reason is Reason.MINIMUM
                if event.reason is Reason.CONTACT:
                    wakeups[kind(event.pair)] += 1
    spent = process_time() - began
    shares = [wakeups[name] / seconds[name] for name in ("resting", "sliding")]
    unresolved = time[Verdict.UNRESOLVED] / sum(time.values())
    title = f"{'sleeping' if sleeps else 'polled'}{'' if refines else ', no minima'}"
    print(
        f"{title:22}{shares[0]:10.1f}{shares[1]:10.1f}{exact:12}{minimum:12}{unresolved:12.1e}{spent:9.2f}", flush=True
    )


def main() -> None:
    """Print the table."""
    end = float(sys.argv[1]) if len(sys.argv) > 1 else 5.0
    with TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.json"
        meshes = {"rock": rock(), "table": table()}
        for name, mesh in meshes.items():
            mesh.export(scene.with_name(f"{name}.obj"))
        write_scene_file(scene, end, {name: {"file": f"{name}.obj"} for name in meshes}, bodies())
        print(f"{'':22}{'resting/s':>10}{'sliding/s':>10}{'exact':>12}{'minima':>12}{'unresolved':>12}{'CPU s':>9}")
        for sleeps, refines in ((False, True), (True, True), (True, False)):
            measured(scene, sleeps, refines)


if __name__ == "__main__":
    main()
