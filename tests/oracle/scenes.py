"""Random scenes from a seed, written as a scene file with its mesh files: contacts, grazes, containments, chains."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from .couples import contained_couple, grazing_couple
from .draw import TICK, Draw
from .rigid import METRES, RADIANS

Bodies = dict[str, dict[str, Any]]

NOT_YET = frozenset({"t0", "scale", "hold"})
"""What closecall does not read yet, of: `t0`, `scale` of a mesh shape, `hold` (and loop) of keys. To be emptied."""


def write_scene(seed: int, folder: Path, without: frozenset[str] = NOT_YET) -> Path:
    """Write the scene of this seed into the folder and return the scene file, named after the seed.

    What stands in `without` is left out.
    """
    rng = np.random.default_rng(seed)
    start = TICK * int(rng.integers(0, 64)) if rng.random() < 0.3 else 0.0
    draw = Draw(
        seed,
        folder,
        rng,
        str(rng.choice(list(METRES))),
        str(rng.choice(list(RADIANS))),
        float(rng.choice([0.05, 0.3, 1.0, 1.0, 4.0])),
        start,
        start + TICK * int(rng.integers(128, 257)),
        without,
    )
    bodies = random_bodies(draw)
    scene: dict[str, Any] = {
        "closecall": 1,
        "units": {"length": draw.length, "angle": draw.angle},
        "time": {"start": draw.start, "end": draw.end},
        "settings": {"time_resolution": draw.pick(1e-3, 1e-3, 5e-3, 2e-4)},
        "meshes": draw.meshes,
        "bodies": bodies,
    }
    if not draw.meshes:
        del scene["meshes"]
    rules = random_rules(draw, bodies)
    if rules:
        scene["pairs"] = rules
    return write_document(scene, draw)


def write_document(scene: dict[str, Any], draw: Draw) -> Path:
    """Write the document as JSON or YAML; the seed stands in the file's name, and in YAML in its first line."""
    if draw.chance(0.5):
        path = draw.folder / f"seed_{draw.seed}.json"
        path.write_text(json.dumps(scene, indent=1), encoding="utf-8")
        return path
    path = draw.folder / f"seed_{draw.seed}.yaml"
    text = yaml.safe_dump(scene, sort_keys=False, default_flow_style=None, width=110)
    path.write_text(f"# closecall oracle, seed {draw.seed}\n{text}", encoding="utf-8")
    return path


def random_bodies(draw: Draw) -> Bodies:
    """Return 2 to 5 bodies with shapes and a few frames, in shuffled order."""
    wanted = int(draw.rng.integers(2, 6))
    bodies: Bodies = {}
    if draw.chance(0.45):
        bodies |= grazing_couple(draw, common_frame(draw, bodies), "graze")
    if wanted >= 3 and draw.chance(0.25):
        bodies |= contained_couple(draw, common_frame(draw, bodies), "held")
    while sum("shapes" in body for body in bodies.values()) < wanted:
        bodies[f"body_{len(bodies)}"] = random_body(draw, bodies)
    names = list(bodies)
    draw.rng.shuffle(names)
    return {name: bodies[name] for name in names}


def common_frame(draw: Draw, bodies: Bodies) -> str | None:
    """Perhaps add a frame without shapes, moving or fixed, and return its name."""
    if draw.chance(0.4):
        return None
    name = f"frame_{len(bodies)}"
    bodies[name] = {"pose": draw.random_pose(0.5)}
    if draw.chance(0.7):
        bodies[name]["motion"] = draw.motion(vigour=0.5)
    return name


def random_body(draw: Draw, bodies: Bodies) -> dict[str, Any]:
    """Return a body of 1 to 3 shapes, mostly moving, perhaps the child of a body or of a new frame."""
    body: dict[str, Any] = {}
    parents = [name for name in bodies if depth(bodies, name) < 2]
    if parents and draw.chance(0.3):
        body["parent"] = draw.pick(*parents)
    elif draw.chance(0.2):
        frame = common_frame(draw, bodies)
        if frame is not None:
            body["parent"] = frame
    body["pose"] = draw.random_pose(1.3 if "parent" not in body else 0.9)
    body["shapes"] = random_shapes(draw)
    if draw.chance(0.85):
        body["motion"] = draw.motion()
    if draw.chance(0.3):
        body["groups"] = [draw.pick("red", "blue")]
    return body


def depth(bodies: Bodies, name: str) -> int:
    """Return how many ancestors a body has."""
    parent = bodies[name].get("parent")
    return 0 if parent is None else 1 + depth(bodies, parent)


def random_shapes(draw: Draw) -> list[dict[str, Any]]:
    """Return one shape, or several of which all but the first have a pose."""
    count = draw.pick(1, 1, 1, 2, 3)
    shapes = [draw.shape(draw.size * draw.between(0.25, 0.6) / count**0.5) for _ in range(count)]
    for index, shape in enumerate(shapes):
        if index or draw.chance(0.3):
            shape["pose"] = draw.random_pose(0.4)
    return shapes


def random_rules(draw: Draw, bodies: Bodies) -> dict[str, Any]:
    """Return the `pairs` section: perhaps some pairs ignored, some of those checked after all."""
    names = sorted(bodies)
    if not draw.chance(0.35):
        return {}
    one, other = draw.rng.choice(names, 2, replace=False).tolist()
    rules: dict[str, Any] = {"ignore": [{"between": [one, other], "reason": "chosen by lot"}]}
    groups = sorted({group for body in bodies.values() for group in body.get("groups", ())})
    if groups and draw.chance(0.5) and sum(name.startswith("body_") for name in names) > 1:
        rules["ignore"].append({"between": [draw.pick(*groups), "body_*"], "reason": "a group and a glob"})
    if draw.chance(0.3):
        rules["check"] = [{"between": [one, draw.pick(*[name for name in names if name != one])]}]
    return rules
