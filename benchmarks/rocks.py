"""The bodies that peers are compared on: bumpy rocks of 1,280 triangles that fly through a cube and spin."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from .scene_file import write_scene_file


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
        return write_scene_file(folder / "scene.json", seconds, {"rock": {"file": "rock.stl"}}, bodies)
