"""Random scenes from a seed, written as a scene file with its mesh files: contacts, grazes, containments, chains."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from .couples import contained_couple, grazing_couple
from .draw import Draw
from .draw_motions import random_motion
from .rigid import METRES, RADIANS
from .sampling import TICK

Bodies = dict[str, dict[str, Any]]


def write_scene(seed: int, folder: Path) -> Path:
    """Write the scene of this seed into the folder and return the scene file, named after the seed."""
    draw = begun(seed, folder)
    return write_document(random_scene(draw), draw)


def random_scene(draw: Draw) -> dict[str, Any]:
    """Return the document of a random scene, whose meshes and trajectories are written."""
    bodies = random_bodies(draw)
    return scene_of(draw, bodies, random_rules(draw, bodies))


def begun(seed: int, folder: Path) -> Draw:
    """Return what a scene is drawn from: its random source, units, size and time."""
    rng = np.random.default_rng(seed)
    start = TICK * int(rng.integers(-64, 64)) if rng.random() < 0.3 else 0.0
    return Draw(
        seed,
        folder,
        rng,
        str(rng.choice(list(METRES))),
        str(rng.choice(list(RADIANS))),
        float(rng.choice([0.05, 0.3, 1.0, 1.0, 4.0])),
        start,
        start + TICK * int(rng.integers(128, 257)),
    )


def scene_of(draw: Draw, bodies: Bodies, rules: dict[str, Any]) -> dict[str, Any]:
    """Return the document of bodies and their `pairs` section."""
    settings: dict[str, Any] = {"time_resolution": draw.pick(1e-3, 1e-3, 5e-3, 2e-4)}
    with draw.aside():
        if settings["time_resolution"] == 1e-3 and draw.chance(0.3):  # which is the default
            settings = {}
        if draw.chance(0.1):
            settings["distance_tolerance"] = draw.pick("none", 0.1, 0.003)
    if draw.chance(0.3):
        settings["contact_tolerance"] = draw.pick(1e-5, 1e-7)
    if draw.chance(0.4):
        settings["margin"] = draw.metres(random_margin(draw))
    scene: dict[str, Any] = {
        "closecall": 1,
        "units": {"length": draw.length, "angle": draw.angle},
        "time": {"start": draw.start, "end": draw.end},
        "settings": settings,
        "meshes": draw.meshes,
        "bodies": bodies,
    }
    for empty in ("settings", "meshes"):
        if not scene[empty]:
            del scene[empty]
    with draw.aside():
        if draw.chance(0.1):
            scene = {"$schema": "closecall.schema.json", **scene}
    return scene | {"pairs": rules} if rules else scene


def random_margin(draw: Draw) -> float:
    """Return m: from a thousandth to a third of the size."""
    return draw.size * 10.0 ** draw.between(-3.0, -0.5)


def write_document(scene: dict[str, Any], draw: Draw) -> Path:
    """Write the document as JSON or YAML; the seed stands in the file's name, and in YAML in its first line."""
    if draw.chance(0.5):
        path = draw.folder / f"seed_{draw.seed}.json"
        path.write_text(json.dumps(scene, indent=1), encoding="utf-8")
        return path
    path = draw.folder / f"seed_{draw.seed}.yaml"
    unshared = json.loads(json.dumps(scene))  # YAML would write what stands twice as an anchor and an alias
    text = yaml.safe_dump(unshared, sort_keys=False, default_flow_style=None, width=110)
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
        bodies[name]["motion"] = random_motion(draw, vigour=0.5)
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
        body["motion"] = random_motion(draw)
    with draw.aside():
        if draw.chance(0.05):
            body["motion"] = random_motion(draw, "limits")
        if draw.chance(0.05) and "parent" in body:
            del body["pose"]
    if draw.chance(0.3):
        body["groups"] = [draw.pick("red", "blue")]
    if draw.chance(0.15):
        body["exists"] = random_existence(draw)
    return body


def random_existence(draw: Draw) -> list[float]:
    """Write from when to when a body exists: a part of the time, perhaps from before it or until after it."""
    length = draw.end - draw.start
    begin = draw.start + draw.pick(-0.5, draw.between(0.0, 0.7)) * length
    end = max(begin, draw.start) + draw.pick(2.0, draw.between(0.1, 0.6)) * length
    return [round(begin / TICK) * TICK, end]


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
    """Return the `pairs` section: some pairs ignored, or all but some; some checked after all; margins of their own."""
    names = sorted(bodies)
    groups = sorted({group for body in bodies.values() for group in body.get("groups", ())})
    rules: dict[str, Any] = {}
    if draw.chance(0.15):
        rules["default"] = "ignore"
        rules["check"] = [{"between": [draw.pick(*names), "*"]}, {"between": two(draw, names)}]
    elif draw.chance(0.35):
        one, other = two(draw, names)
        rules["ignore"] = [{"between": [one, other], "reason": "chosen by lot"}]
        if groups and draw.chance(0.5) and sum(name.startswith("body_") for name in names) > 1:
            rules["ignore"].append({"between": [draw.pick(*groups), "body_*"], "reason": "a group and a glob"})
        if draw.chance(0.3):
            rules["check"] = [{"between": [one, draw.pick(*[name for name in names if name != one])]}]
    if draw.chance(0.4):
        sides = [two(draw, names), [draw.pick(*names), "*"]]
        if sum(name[-2] == "_" for name in names) > 1:
            sides.append([draw.pick(*names, *groups), "*_?"])
        chosen = draw.rng.permutation(len(sides))[: int(draw.rng.integers(1, 4))]
        sides = [sides[i] for i in chosen]
        rules["margins"] = [{"between": side, "margin": draw.metres(random_margin(draw))} for side in sides]
    elif draw.chance(0.1):
        rules["margins"] = [{"between": ["*", "*"], "margin": 0}]
    with draw.aside():
        if draw.chance(0.1):
            rules.setdefault("default", "check")
        for rule in rules.get("margins", ()):
            if draw.chance(0.2):
                rule["reason"] = "a narrow passage"
    return rules


def two(draw: Draw, names: list[str]) -> list[str]:
    """Return two different names."""
    return draw.rng.choice(names, 2, replace=False).tolist()
