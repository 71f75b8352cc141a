"""What travels in a log beside its messages: names that readers look for, and inputs that prove the run."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict

from ....scheduler.model.scene import Settings
from ...scene.loaded import InputFile, LoadedScene
from ..errors import LogError

# Metadata records: the first is there from the start, so that an unfinished log tells what it is.
METADATA_AT_START = "closecall/start"
METADATA = "closecall"

# Key of the second record: what could not be read of the log that this is a part of. There is no summary then.
LOST = "lost"

# Attachments. Mesh files are `mesh/<sha256>`, trajectory files `trajectory/<sha256>`.
SCENE = "scene"
SETTINGS = "settings.json"
SUMMARY = "summary.json"
LAYOUT = "layout.json"


def input_files(loaded: LoadedScene) -> list[tuple[str, InputFile]]:
    """Return the files that the scene refers to, each with its kind, "mesh" or "trajectory"."""
    meshes = [("mesh", file) for file in loaded.mesh_files]
    return meshes + [("trajectory", file) for file in loaded.trajectory_files]


def settings_json(settings: Settings) -> str:
    """Return the settings in SI, under the scene file's keys."""
    return json.dumps(asdict(settings), sort_keys=True, allow_nan=False)


def input_bytes(file: InputFile) -> bytes:
    """Return a file's bytes, the same that were loaded.

    Raises:
        LogError: when the file has gone or has changed since.
    """
    try:
        data = file.path.read_bytes()
    except OSError as error:
        remedy = "restore it, or run with --no-attach-meshes"
        raise LogError(file.path, f"cannot read: {error.strerror or error}", remedy) from error
    if hashlib.sha256(data).hexdigest() != file.sha256:
        raise LogError(file.path, "changed while the run was starting", "run again")
    return data
