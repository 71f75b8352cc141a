"""Report pages in headless Chromium: what a person would see there, and what happens when they use it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .viewer import BROWSERS, node


@dataclass(frozen=True)
class PageVisit:
    """A page to be looked at.

    Attributes:
        name: by which the answer is found.
        page: its path.
        steps: what is done with it, as page.mjs has it.
        width: of the window, pixels.
        height: of the window, pixels.
        theme: that the system prefers, dark or light.
        picture: whether a picture of the whole page is kept.
        print: whether it is printed, last.
    """

    name: str
    page: Path
    steps: Sequence[Sequence[Any]] = field(default=())
    width: int = 1300
    height: int = 900
    theme: str = "light"
    picture: bool = False
    print: bool = False


class PageLook:
    """What a page showed at one time."""

    def __init__(self, seen: dict[str, Any]) -> None:
        self.time: float = seen["slider"]
        self.time_told: str = seen["time"]
        self.selected: str = seen["selected"]
        self.now: list[str] = seen["now"]
        self.told: str = seen["told"]
        self.value: Any = seen["value"]
        self._canvases: dict[str, dict[str, Any]] = seen["canvases"]

    def shows(self, canvas: str) -> bool:
        return canvas in self._canvases

    def pixels(self, canvas: str) -> NDArray[np.int16]:
        """Return a canvas as (height, width, 3)."""
        told = self._canvases[canvas]
        data = np.fromfile(told["file"], dtype=np.uint8)
        return data.reshape(told["height"], told["width"], 4)[:, :, :3].astype(np.int16)

    @property
    def scene(self) -> NDArray[np.int16]:
        return self.pixels("scene-canvas")


@dataclass(frozen=True)
class PageSeen:
    """What was seen of one page: as it has just opened, and after each step."""

    looks: Sequence[PageLook]
    lines: Sequence[str]
    requests: Sequence[str]
    drawn_ms: float
    printed_bytes: int
    title: str
    overflow: float

    @cached_property
    def complaints(self) -> list[str]:
        return [line for line in self.lines if not line.startswith(("debug", "log", "info"))]


def visited_pages(visits: Sequence[PageVisit], folder: Path) -> dict[str, PageSeen]:
    """Open every page; pictures go to the folder."""
    browser = next(filter(None, map(shutil.which, BROWSERS)))
    jobs = [asdict(visit) | {"page": str(visit.page)} for visit in visits]
    (folder / "pages").write_text(json.dumps({"browser": browser, "folder": str(folder), "visits": jobs}))
    done = node("page.mjs", folder / "pages")
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    return {
        name: PageSeen(
            looks=[PageLook(look) for look in seen["looks"]],
            lines=seen["lines"],
            requests=seen["requests"],
            drawn_ms=seen["drawn"],
            printed_bytes=seen["printed"],
            title=seen["title"],
            overflow=seen["overflow"],
        )
        for name, seen in json.loads(done.stdout).items()
    }
