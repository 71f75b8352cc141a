"""What the viewer's topics cost: 10,000 bodies of 320 triangles (4 models) for 5 s, at 30 snapshots a second and at 0.

`python -m benchmarks.viewer_cost [BODIES [LOG]]` prints, per rate, the CPU seconds that the parts take and the file's
size; the log with all topics at 30 Hz is kept as LOG, to be opened. Snapshots are made here, without pairs: what is
timed is the log alone.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np
import trimesh

from closecall.formats.log.viewer.viewer import Viewer, ViewerOptions
from closecall.formats.log.writer import LogOptions, LogWriter
from closecall.formats.scene.loaded import LoadedScene
from closecall.scheduler.model.events import Snapshot
from closecall.scheduler.model.scene import Body, Mesh, PairRules, Scene, Settings, Shape
from closecall.scheduler.model.world_poses import WorldPoses
from closecall.scheduler.motions import Constant
from closecall.scheduler.snapshots.schedule import tick_times
from closecall.scheduler.snapshots.snapshot import existing

SECONDS = 5.0


def scene_of(bodies: int) -> Scene:
    """Return tumbling rocks on a square, of four models."""
    rng = np.random.default_rng(0)
    rocks = []
    for index in range(4):
        ball = trimesh.creation.icosphere(subdivisions=2)
        vertices = ball.vertices * rng.uniform(0.7, 1.0, (len(ball.vertices), 1))
        rocks.append(Shape(Mesh(f"rock {index}", vertices, ball.faces.astype(np.int64), True), 0.0, np.eye(4)))
    out = []
    for index in range(bodies):
        pose = np.eye(4)
        pose[:3, 3] = (*rng.uniform(-300.0, 300.0, 2), 0.0)
        velocity, turning = rng.normal(size=(2, 3)).tolist()
        out.append(Body(f"rock_{index}", None, pose, Constant(tuple(velocity), tuple(turning)), (rocks[index % 4],)))
    return Scene(tuple(out), 0.0, SECONDS, PairRules())


def snapshots(scene: Scene, rate: float) -> list[Snapshot]:
    """Return the scene at the ticks of `rate` Hz."""
    times = list(tick_times(scene.start, scene.end, rate))
    poses, there = WorldPoses(scene.bodies), existing(scene, scene.start)
    return [Snapshot(time, poses.at(time), there, (), 0, None) for time in times]


def timed(work: Callable[[], object]) -> float:
    """Return the seconds that some work takes."""
    began = process_time()
    work()
    return process_time() - began


def written(path: Path, loaded: LoadedScene, shown: list[Snapshot], options: LogOptions) -> tuple[float, int]:
    """Write a log; return the seconds and its bytes."""

    def write() -> None:
        with LogWriter(path, loaded, loaded.settings, 0, options) as log:
            for snapshot in shown:
                log.write(snapshot)

    return timed(write), path.stat().st_size


def main() -> None:
    """Print the table."""
    bodies = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    scene = scene_of(bodies)
    viewer = Viewer(scene, ViewerOptions())
    began = process_time()
    ticks = snapshots(scene, 30.0)
    print(f"{bodies} bodies of 320 triangles, {len(ticks)} snapshots at 30 Hz")
    for remark in viewer.remarks:
        print(f"  {remark}")
    print(f"  poses         {process_time() - began:8.3f} s, the snapshots' own part")
    print(f"  viewer made   {timed(lambda: Viewer(scene, ViewerOptions())):8.3f} s")
    print(f"  opening       {timed(lambda: list(viewer.opening(0))):8.3f} s")
    packing = timed(lambda: [list(viewer.shown(tick, round(tick.time * 1e9))) for tick in ticks])
    print(f"  snapshots     {packing:8.3f} s  {1e6 * packing / (len(ticks) * bodies):.2f} us a body and snapshot")
    with TemporaryDirectory() as folder:
        path = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(folder) / "out.mcap"
        loaded = LoadedScene(Path(folder) / "scene.yaml", b"closecall: 1\n", scene, Settings(), (), ())
        print("log                          seconds        MB")
        full = LogOptions(viewer=ViewerOptions())
        for name, shown, options in (
            ("certificate", [], LogOptions()),
            ("viewer, rate 0", [], full),
            ("viewer, rate 30", ticks, full),
        ):
            seconds, size = written(path, loaded, shown, options)
            print(f"{name:<28} {seconds:7.3f} {size / 1e6:9.3f}")


if __name__ == "__main__":
    main()
