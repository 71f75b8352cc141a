"""How a run starts with a mesh of 1.3 million triangles, shown by one body and by 50, in each kind of file.

`python -m benchmarks.start_up [SUBDIVISIONS]` runs the installed command for a tenth of a second of bodies that fly
past a plate, without least distances and snapshots, and prints what the child took. With 6 SUBDIVISIONS the mesh has 82
thousand triangles, with 8 (the default) 1.3 million.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import trimesh

from .command import run_command
from .scene_file import write_scene_file
from .table import Row

KINDS = ("stl", "obj", "ply", "glb")
COUNTS = (1, 50)
#: m: the edge of the cube that each body has to itself, on the average; it is 2 m wide.
ROOM = 10.0
#: CPU s, for some seconds of a processor of its own: FCL's tree alone takes five.
MOST = 20.0


def write_scene(folder: Path, kind: str, count: int) -> Path:
    """Write the scene of so many bodies that show `mesh` in a file of this kind."""
    rng = np.random.default_rng(0)
    half = 0.5 * ROOM * count ** (1.0 / 3.0)
    bodies = {
        f"body_{index}": {
            "pose": {"xyz": rng.uniform(-half, half, 3).round(3).tolist()},
            "shapes": [{"mesh": "bumpy"}],
            "motion": {
                "type": "constant",
                "velocity": rng.normal(0.0, 0.5, 3).round(3).tolist(),
                "angular_velocity": rng.normal(0.0, 0.5, 3).round(3).tolist(),
            },
        }
        for index in range(count)
    }
    plate = {"pose": {"xyz": [0, 0, -half - 2.0]}, "shapes": [{"box": [2.0 * half, 2.0 * half, 1.0]}]}
    mesh = {"file": f"mesh.{kind}", **({"up": "y"} if kind == "glb" else {})}
    return write_scene_file(folder / f"{kind}_{count}.json", 0.1, {"bumpy": mesh}, {"plate": plate, **bodies})


def rows(subdivisions: int) -> Iterator[Row]:
    """Yield the rows of the table, one a kind of file and number of bodies."""
    mesh = trimesh.creation.icosphere(subdivisions)
    x, y, z = mesh.vertices.T
    mesh.vertices *= (1.0 + 0.05 * np.sin(9.0 * x) * np.sin(7.0 * y) * np.cos(8.0 * z))[:, None]
    with TemporaryDirectory() as name:
        folder = Path(name)
        for kind in KINDS:
            mesh.export(folder / f"mesh.{kind}")
            for count in COUNTS:
                scene = write_scene(folder, kind, count)
                ran = run_command(scene, folder / "out.mcap", "--rate", "0", "--distance-tolerance", "none")
                load = ran.told["seconds"]["load"] * ran.cpu / ran.wall
                case = f"{len(mesh.faces)} triangles in {kind.upper()}, {count} bod{'y' if count == 1 else 'ies'}"
                measured = f"{ran.cpu:.1f} CPU s, {load:.1f} of them before the first wakeup, {ran.memory:.0f} MB"
                yield Row(f"{case}, 0.1 s", measured, f"within {MOST:g} s", ran.cpu <= MOST)


if __name__ == "__main__":
    for row in rows(int(sys.argv[1]) if len(sys.argv) > 1 else 8):
        print(row.markdown(), flush=True)
