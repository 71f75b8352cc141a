"""Against the usual way: 40 bumpy bodies of 1,280 triangles (780 pairs) for 5 s, stepped at 1 ms by other libraries.

`python -m benchmarks.peers [BODIES [SECONDS [SHARE]]]` runs the installed command with its default options in a child,
and steps the same bodies along the same motions with each peer that is installed (`pip install 'closecall[peers]'` adds
coal and MuJoCo). A peer is timed on every SHARE-th step (50), spread over the whole run; its row says what all steps
take at that pace. Poses are made before the clock starts. Ratios are the peer's CPU time over that of the whole
command, and over that of its scheduling alone: the child's CPU time by the share of `seconds.schedule` in its total.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import fcl
import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from .command import Ran, run_command
from .rocks import Rocks
from .table import Row

STEP = 1e-3
"""s: the time resolution of the command, and the step of its peers."""

BRACKET = 1e-6
"""s: how well the command knows when a contact begins and ends."""

Step = Callable[[np.ndarray], object]
"""Takes poses (n, 4, 4), and answers for that instant."""


def fcl_model(rocks: Rocks) -> Any:
    """Return FCL's model of the mesh."""
    model = fcl.BVHModel()
    model.beginModel(len(rocks.mesh.vertices), len(rocks.mesh.faces))
    model.addSubModel(rocks.mesh.vertices, rocks.mesh.faces)
    model.endModel()
    return model


def fcl_exact(rocks: Rocks, count: int) -> Step:
    """python-fcl: the exact distance of every pair."""
    objects = [fcl.CollisionObject(fcl_model(rocks), fcl.Transform()) for _ in range(count)]
    request = fcl.DistanceRequest(enable_nearest_points=True)

    def step(poses: np.ndarray) -> object:
        for one, pose in zip(objects, poses, strict=True):
            one.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
        return [fcl.distance(a, b, request, fcl.DistanceResult()) for a, b in combinations(objects, 2)]

    return step


def fcl_manager(rocks: Rocks, count: int) -> Step:
    """python-fcl's AABB-tree manager: whether any two collide, yes or no; nothing of the others."""
    objects = [fcl.CollisionObject(fcl_model(rocks), fcl.Transform()) for _ in range(count)]
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
    return _coal_distances(_coal_model(rocks), count)


def coal_hulls(rocks: Rocks, count: int) -> Step:
    """coal: the distance of every pair's convex hulls, by GJK."""
    model = _coal_model(rocks)
    model.buildConvexHull(True, "Qt")
    return _coal_distances(model.convex, count)


def mujoco_contacts(rocks: Rocks, count: int) -> Step:
    """MuJoCo: the contacts of convex hulls, as each of its steps finds them."""
    import mujoco

    model, data, place = _mujoco_bodies(rocks, count)

    def step(poses: np.ndarray) -> object:
        place(poses)
        mujoco.mj_collision(model, data)
        return data.ncon

    return step


def mujoco_distances(rocks: Rocks, count: int) -> Step:
    """MuJoCo: the distance of every pair's convex hulls."""
    import mujoco

    model, data, place = _mujoco_bodies(rocks, count)

    def step(poses: np.ndarray) -> object:
        place(poses)
        return [mujoco.mj_geomDistance(model, data, a, b, 1e3, None) for a, b in combinations(range(count), 2)]

    return step


@dataclass(frozen=True, slots=True)
class Peer:
    """A library's usual way: how to begin with it, what it lacks, and how many times the command's CPU time is asked.

    Attributes:
        whole, schedule: at 1 ms, against the whole command and against its scheduling.
        fine: at 1 us, against the whole command.
    """

    name: str
    begin: Callable[[Rocks, int], Step]
    lacks: str
    whole: float | None = None
    schedule: float | None = None
    fine: float | None = None


PEERS = (
    Peer("python-fcl, all pairs, exact", fcl_exact, "samples alone", 400.0, 1000.0),
    Peer("coal, all pairs, exact", coal_exact, "samples alone", 400.0, 1000.0),
    Peer("python-fcl, AABB-tree manager", fcl_manager, "samples alone, yes or no", fine=200.0),
    Peer("trimesh CollisionManager", trimesh_manager, "samples alone, the least distance of all pairs"),
    Peer("coal, all pairs, hulls", coal_hulls, "samples alone, of hulls"),
    Peer("MuJoCo, distances of all pairs", mujoco_distances, "samples alone, of hulls"),
    Peer("MuJoCo, contacts", mujoco_contacts, "samples alone, of hulls, yes or no"),
)


def _coal_model(rocks: Rocks) -> Any:
    import coal

    model = coal.BVHModelOBBRSS()
    model.beginModel(len(rocks.mesh.faces), len(rocks.mesh.vertices))
    vertices = coal.StdVec_Vec3s()
    vertices.extend([np.array(vertex) for vertex in rocks.mesh.vertices])
    triangles = coal.StdVec_Triangle()
    triangles.extend([coal.Triangle(*map(int, face)) for face in rocks.mesh.faces])
    model.addSubModel(vertices, triangles)
    model.endModel()
    return model


def _coal_distances(model: Any, count: int) -> Step:
    import coal

    request = coal.DistanceRequest()

    def step(poses: np.ndarray) -> object:
        placed = [coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in poses]
        return [
            coal.distance(model, placed[a], model, placed[b], request, coal.DistanceResult())
            for a, b in combinations(range(count), 2)
        ]

    return step


def _mujoco_bodies(rocks: Rocks, count: int) -> tuple[Any, Any, Callable[[np.ndarray], None]]:
    """Return a model of free bodies, its data, and what moves them to poses (n, 4, 4)."""
    import mujoco

    spec = mujoco.MjSpec()
    mesh = spec.add_mesh(name="rock")
    mesh.uservert = np.asarray(rocks.mesh.vertices).reshape(-1)
    mesh.userface = np.asarray(rocks.mesh.faces).reshape(-1)
    for index in range(count):
        body = spec.worldbody.add_body(name=f"rock_{index}")
        body.add_freejoint()
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="rock")
    model = spec.compile()
    data = mujoco.MjData(model)

    def place(poses: np.ndarray) -> None:
        coordinates = data.qpos.reshape(count, 7)
        coordinates[:, :3] = poses[:, :3, 3]
        coordinates[:, 3:] = np.roll(Rotation.from_matrix(poses[:, :3, :3]).as_quat(), 1, axis=1)
        mujoco.mj_kinematics(model, data)

    return model, data, place


def command(rocks: Rocks, seconds: float, *options: str) -> Ran:
    """Run the command on the rocks, with its default options and these."""
    with TemporaryDirectory() as name:
        scene = rocks.write(Path(name), seconds)
        return run_command(scene, scene.with_suffix(".mcap"), *options)


def paced(step: Step, instants: list[np.ndarray]) -> float:
    """Return the CPU seconds a step, over some instants."""
    step(instants[0])
    began = process_time()
    for poses in instants:
        step(poses)
    return (process_time() - began) / len(instants)


def paces(rocks: Rocks, count: int, seconds: float, share: int) -> Iterator[tuple[Peer, float]]:
    """Yield each installed peer with its CPU seconds a step."""
    steps = round(seconds / STEP)
    instants = [rocks.poses(k * STEP) for k in range(0, steps + 1, share)]
    for peer in PEERS:
        try:
            step = peer.begin(rocks, count)
        except ImportError:
            continue
        yield peer, paced(step, instants)


def rows(count: int, seconds: float, share: int) -> Iterator[Row]:
    """Yield the rows of the table: the command against each peer."""
    rocks = Rocks(count)
    ran = command(rocks, seconds)
    scheduling = schedule_cpu(ran)
    yield Row(f"{count} rocks, {len(ran.told['pairs'])} pairs, {seconds:g} s", f"{ran.cpu:.2f} CPU s")
    for peer, pace in paces(rocks, count, seconds, share):
        coarse, fine = pace * seconds / STEP, pace * seconds / BRACKET
        case = f"{peer.name} ({peer.lacks})"
        yield _ratio(f"{case}, 1 ms, against the whole command", coarse / ran.cpu, peer.whole)
        if peer.schedule is not None:
            yield _ratio(f"{case}, 1 ms, against scheduling", coarse / scheduling, peer.schedule)
        if peer.fine is not None:
            yield _ratio(f"{case}, 1 us, against the whole command", fine / ran.cpu, peer.fine)


def schedule_cpu(ran: Ran) -> float:
    """Return the CPU seconds that went into scheduling."""
    seconds = ran.told["seconds"]
    return float(ran.cpu * seconds["schedule"] / seconds["total"])


def _ratio(case: str, ratio: float, target: float | None) -> Row:
    if target is None:
        return Row(case, f"{ratio:.1f} times")
    return Row(case, f"{ratio:.0f} times", f"at least {target:.0f}", ratio >= target)


def main(count: int = 40, seconds: float = 5.0, share: int = 50) -> None:
    """Print what each takes."""
    rocks = Rocks(count)
    ran = command(rocks, seconds)
    pairs, steps = len(ran.told["pairs"]), seconds / STEP
    contacts = sum(len(pair["contacts"]) for pair in ran.told["pairs"])
    print(f"{count} bodies, {pairs} pairs, {contacts} contacts in {seconds} s, 1 of {share} steps timed")
    print(f"{'closecall run':32}{ran.cpu:10.2f} s CPU; wall-clock seconds {ran.told['seconds']}")
    print(f"{'':32}{'at 1 ms':>10}{'x run':>8}{'x schedule':>12}{'at 1 us':>12}{'x run':>10}  gives")
    for peer, pace in paces(rocks, count, seconds, share):
        coarse, fine = pace * steps, pace * seconds / BRACKET
        ratios = f"{coarse / ran.cpu:8.1f}{coarse / schedule_cpu(ran):12.1f}{fine:12.0f}{fine / ran.cpu:10.0f}"
        print(f"{peer.name:32}{coarse:10.1f}{ratios}  {peer.lacks}")


if __name__ == "__main__":
    kinds = (int, float, int)
    main(*(kind(text) for kind, text in zip(kinds, sys.argv[1:], strict=False)))
