"""Foxglove Studio in headless Chromium, on 127.0.0.1 alone: one browser looks at logs as a person would.

`tests/studio/install FOLDER` gets what this needs, and CLOSECALL_STUDIO_DIR names the folder.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlencode

from .looks import Look, Visit
from .server import served

HERE = Path(__file__).parent
FOLDER = os.environ.get("CLOSECALL_STUDIO_DIR", "")
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def _missing() -> str | None:
    """Tell what hinders the viewer, if anything does."""
    if not FOLDER:
        return "CLOSECALL_STUDIO_DIR names no folder, as tests/studio/install fills it"
    if shutil.which("node") is None:
        return "node is not installed"
    if not any(map(shutil.which, BROWSERS)):
        return "chromium is not installed"
    for name, version in json.loads((HERE / "package.json").read_text())["dependencies"].items():
        package = Path(FOLDER, "node_modules", name, "package.json")
        if not package.exists() or json.loads(package.read_text())["version"] != version:
            return f"the npm package {name} {version} is not in {FOLDER}"
    return None


MISSING = _missing()


@dataclass(frozen=True)
class Job:
    """A log to be looked at.

    Attributes:
        name: by which the answer is found.
        log: its path.
        layout: as JSON.
        seeks: shares of the run at which to look.
        theme: dark or light.
        pictures: whether pictures of the whole page are taken, in place of asking for charts and problems.
    """

    name: str
    log: Path
    layout: bytes
    seeks: Sequence[float] = field(default=())
    theme: str = "dark"
    pictures: bool = False


def node(script: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    """Run a script of this folder."""
    command = ["node", str(HERE / script), *map(str, arguments)]
    environment = os.environ | {"CLOSECALL_STUDIO_DIR": str(Path(FOLDER).resolve())}
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600)


def visited(jobs: Sequence[Job], folder: Path) -> dict[str, Visit]:
    """Open every log in Studio; pictures go to the folder."""
    visits = []
    for job in jobs:
        shutil.copy(job.log, folder / f"{job.name}.mcap")
        (folder / f"{job.name}.json").write_bytes(job.layout)
    with served({"/modules/": Path(FOLDER, "node_modules"), "/logs/": folder, "/": HERE}) as site:
        for job in jobs:
            query = {
                "ds": "remote-file",
                "ds.url": f"{site}/logs/{job.name}.mcap",
                "layout": f"/logs/{job.name}.json",
                "theme": job.theme,
            }
            address = f"{site}/index.html?{urlencode(query)}"
            visits.append({"name": job.name, "address": address, "seeks": list(job.seeks), "pictures": job.pictures})
        browser = next(filter(None, map(shutil.which, BROWSERS)))
        (folder / "visits").write_text(json.dumps({"browser": browser, "folder": str(folder), "visits": visits}))
        done = node("look.mjs", folder / "visits")
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    return {
        name: Visit(
            looks=[Look(look) for look in seen["looks"]],
            problems=seen["problems"],
            painted=frozenset(seen["painted"]),
            opening=seen["opening"],
            console=seen["console"],
        )
        for name, seen in json.loads(done.stdout).items()
    }
