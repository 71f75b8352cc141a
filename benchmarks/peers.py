"""Against the usual way: 40 bumpy bodies of 1,280 triangles (780 pairs) for 5 s, stepped at 1 ms by other libraries.

`python -m benchmarks.peers [BODIES [SECONDS [SHARE]]]` runs the installed command with its default options in a child,
and steps the same bodies along the same motions with each peer that is installed (`pip install coal` adds one). A peer
is timed on every SHARE-th step (50), spread over the whole run; its row says what all steps take at that pace. Poses
are made before the clock starts. The ratio is the peer's CPU time over that of the whole command.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from itertools import combinations
from pathlib import Path
from subprocess import PIPE, Popen
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import fcl
import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

STEP = 1e-3
"""s: the time resolution of the command, and the step of its peers."""

BRACKET = 1e-6
"""s: how well the command knows when a contact begins and ends."""

Step = Callable[[np.ndarray], object]
"""Takes poses (n, 4, 4), and answers for that instant."""


class Rocks:
    """Bumpy bodies that fly straight through a cube and spin.

    Attributes:
        mesh: 1,280 triangles.
        velocities, turnings: (n, 3) m/s and rad/s.
    """

    def __init__(self, count: int) -> None:
        """Draw them, the same each time."""
        rng = np.random.default_rng(0)
        self.mesh = trimesh.creation.icosphere(subdivisions=3)
        self.mesh.vertices *= rng.uniform(0.9, 1.0, (len(self.mesh.vertices), 1))
        self._places = rng.uniform(-6.0, 6.0, (count, 3)).round(6)
        self.velocities = rng.normal(0.0, 0.8, (count, 3)).round(6)
        self.turnings = rng.normal(0.0, 1.0, (count, 3)).round(6)

    def poses(self, time: float) -> np.ndarray:
        """Return world_from_body (n, 4, 4) at a time (s)."""
        poses = np.tile(np.eye(4), (len(self._places), 1, 1))
        poses[:, :3, :3] = Rotation.from_rotvec(self.turnings * time).as_matrix()
        poses[:, :3, 3] = self._places + self.velocities * time
        return poses

    def write(self, folder: Path, seconds: float) -> Path:
        """Write the scene file."""
        self.mesh.export(folder / "rock.stl")
        bodies = {
            f"rock_{index}": {
                "pose": {"xyz": place.tolist()},
                "shapes": [{"mesh": "rock"}],
                "motion": {"type": "constant", "velocity": v.tolist(), "angular_velocity": w.tolist()},
            }
            for index, (place, v, w) in enumerate(zip(self._places, self.velocities, self.turnings, strict=True))
        }
        scene = {
            "closecall": 1,
            "units": {"length": "m", "angle": "rad"},
            "time": {"start": 0, "end": seconds},
            "meshes": {"rock": {"file": "rock.stl", "units": "m"}},
            "bodies": bodies,
        }
        path = folder / "scene.json"
        path.write_text(json.dumps(scene))
        return path


def fcl_exact(rocks: Rocks, count: int) -> Step:
    """python-fcl: the exact distance of every pair."""
    objects = [fcl.CollisionObject(_fcl_model(rocks), fcl.Transform()) for _ in range(count)]
    request = fcl.DistanceRequest(enable_nearest_points=True)

    def step(poses: np.ndarray) -> object:
        for one, pose in zip(objects, poses, strict=True):
            one.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
        return [fcl.distance(a, b, request, fcl.DistanceResult()) for a, b in combinations(objects, 2)]

    return step


def fcl_manager(rocks: Rocks, count: int) -> Step:
    """python-fcl's AABB-tree manager: whether any two collide, yes or no; nothing of the others."""
    objects = [fcl.CollisionObject(_fcl_model(rocks), fcl.Transform()) for _ in range(count)]
    manager = fcl.DynamicAABBTreeCollisionManager()
    manager.registerObjects(objects)
    manager.setup()

    def step(poses: np.ndarray) -> object:
        for one, pose in zip(objects, poses, strict=True):
            one.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
        manager.update()
        data = fcl.CollisionData(request=fcl.CollisionRequest(num_max_contacts=100))
        manager.collide(data, fcl.defaultCollisionCallback)
        return data.result.is_collision

    return step


def trimesh_manager(rocks: Rocks, count: int) -> Step:
    """trimesh's CollisionManager: the least distance of all pairs alone."""
    manager = trimesh.collision.CollisionManager()
    for index in range(count):
        manager.add_object(str(index), rocks.mesh)

    def step(poses: np.ndarray) -> object:
        for index, pose in enumerate(poses):
            manager.set_transform(str(index), pose)
        return manager.min_distance_internal()

    return step


def coal_exact(rocks: Rocks, count: int) -> Step:
    """coal: the exact distance of every pair."""
    import coal

    model = coal.BVHModelOBBRSS()
    model.beginModel(len(rocks.mesh.faces), len(rocks.mesh.vertices))
    vertices = coal.StdVec_Vec3s()
    vertices.extend([np.array(vertex) for vertex in rocks.mesh.vertices])
    triangles = coal.StdVec_Triangle()
    triangles.extend([coal.Triangle(*map(int, face)) for face in rocks.mesh.faces])
    model.addSubModel(vertices, triangles)
    model.endModel()
    request = coal.DistanceRequest()

    def step(poses: np.ndarray) -> object:
        placed = [coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in poses]
        return [
            coal.distance(model, placed[a], model, placed[b], request, coal.DistanceResult())
            for a, b in combinations(range(count), 2)
        ]

    return step


PEERS: tuple[tuple[str, Callable[[Rocks, int], Step], str], ...] = (
    ("python-fcl, all pairs, exact", fcl_exact, "samples alone"),
    ("coal, all pairs, exact", coal_exact, "samples alone"),
    ("python-fcl, AABB-tree manager", fcl_manager, "samples alone, yes or no"),
    ("trimesh CollisionManager", trimesh_manager, "samples alone, the least of all pairs"),
)


def command(rocks: Rocks, seconds: float) -> tuple[float, dict[str, Any]]:
    """Run the command in a child; return its CPU seconds and its JSON."""
    with TemporaryDirectory() as name:
        scene = rocks.write(Path(name), seconds)
        child = Popen(
            [sys.executable, "-m", "closecall", "run", str(scene), "-o", str(scene.with_suffix(".mcap")), "--json"],
            stdout=PIPE,
        )
        assert child.stdout is not None
        told = json.loads(child.stdout.read())
        _, status, usage = os.wait4(child.pid, 0)
    assert status == 0
    return usage.ru_utime + usage.ru_stime, told


def paced(step: Step, instants: list[np.ndarray]) -> float:
    """Return the CPU seconds a step, over some instants."""
    step(instants[0])
    began = process_time()
    for poses in instants:
        step(poses)
    return (process_time() - began) / len(instants)


def rows(rocks: Rocks, count: int, seconds: float, share: int) -> Iterator[tuple[str, float, str]]:
    """Yield each installed peer's name, CPU seconds a step and what it does not say."""
    steps = round(seconds / STEP)
    instants = [rocks.poses(k * STEP) for k in range(0, steps + 1, share)]
    for name, peer, lacking in PEERS:
        try:
            step = peer(rocks, count)
        except ImportError:
            continue
        yield name, paced(step, instants), lacking


def _fcl_model(rocks: Rocks) -> Any:
    model = fcl.BVHModel()
    model.beginModel(len(rocks.mesh.vertices), len(rocks.mesh.faces))
    model.addSubModel(rocks.mesh.vertices, rocks.mesh.faces)
    model.endModel()
    return model


def main(count: int = 40, seconds: float = 5.0, share: int = 50) -> None:
    """Print the table."""
    rocks = Rocks(count)
    whole, told = command(rocks, seconds)
    pairs, steps = len(told["pairs"]), seconds / STEP
    contacts = sum(len(pair["contacts"]) for pair in told["pairs"])
    print(f"{count} bodies, {pairs} pairs, {contacts} contacts in {seconds} s, 1 of {share} steps timed")
    print(f"{'closecall run':32}{whole:10.2f} s CPU; wall-clock seconds {told['seconds']}")
    print(f"{'':32}{'at 1 ms':>10}{'x run':>8}{'at 1 us':>12}{'x run':>10}  gives")
    for name, pace, lacking in rows(rocks, count, seconds, share):
        coarse, fine = pace * steps, pace * seconds / BRACKET
        print(f"{name:32}{coarse:10.1f}{coarse / whole:8.1f}{fine:12.0f}{fine / whole:10.0f}  {lacking}")


if __name__ == "__main__":
    kinds = (int, float, int)
    main(*(kind(text) for kind, text in zip(kinds, sys.argv[1:], strict=False)))
