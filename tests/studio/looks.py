"""What Foxglove Studio showed: the text of its panels, the picture of its 3D panel, the lines of its console."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

NOISE = (
    r"(?i).*\bfonts?\b|.*OTS parsing error",
    # Studio builds its 3D panel anew while the layout is set, and the panel tells what it has been given back.
    r"warn: Disposing renderer$",
    r"warn: Panel action resulted in identical config",
    # It complains until the first frame has come; where none comes, nothing is drawn, which the looks tell.
    r'warn: \[general > followTf\] Frame "\w+" not found$',
    r"warn: \[layers > \w+\] Missing transform from frame <world> to frame <\(none\)>$",
)


class Look:
    """What Studio showed at one time.

    Attributes:
        time: of day, as Studio tells it.
        page: the picture of the whole page, as PNG, where pictures were asked for.
    """

    def __init__(self, seen: Mapping[str, Any]) -> None:
        self.time: str = seen["time"]
        self._panels: dict[str, dict[str, Any]] = seen["panels"]
        self._scene: dict[str, Any] = seen["scene"]
        self.page = Path(self._scene["file"]).with_suffix(".png")

    def panel(self, kind: str) -> dict[str, Any]:
        """Return the only panel of a kind."""
        (found,) = (panel for name, panel in self._panels.items() if name.startswith(f"{kind}!"))
        return found

    def text(self, kind: str) -> str:
        return str(self.panel(kind)["text"])

    @property
    def picture(self) -> NDArray[np.uint8]:
        """The picture of the 3D panel, (height, width, 3)."""
        pixels = np.fromfile(self._scene["file"], dtype=np.uint8)
        return np.ascontiguousarray(pixels.reshape(self._scene["height"], self._scene["width"], 4)[:, :, :3])

    @cached_property
    def scene(self) -> NDArray[np.int16]:
        """The same, to reckon with, without the buttons at its right."""
        return self.picture[:, :-60].astype(np.int16)

    @property
    def background(self) -> NDArray[np.int64]:
        """The colour that the 3D panel has most of."""
        colours, counts = np.unique(packed(self.scene), return_counts=True)
        return np.asarray(colours[counts.argmax()] >> np.array((16, 8, 0)) & 255)

    @property
    def bodies(self) -> NDArray[np.bool_]:
        """Where the picture is neither background nor thin, as the grid's lines and the labels' letters are."""
        return thick(differs(self.scene, self.background))

    @property
    def red(self) -> int:
        """How many pixels are as red as colliding bodies."""
        red, green, blue = np.moveaxis(self.scene, -1, 0)
        return int(np.count_nonzero((red > 110) & (red > 2 * green) & (red > 2 * blue)))


@dataclass(frozen=True)
class Visit:
    """What Studio showed of one log: as it has just opened, and after each seek."""

    looks: Sequence[Look]
    problems: str
    painted: frozenset[str]
    opening: Sequence[str]
    console: Sequence[str]

    @property
    def complaints(self) -> list[str]:
        """Lines of the console that tell of something wrong."""
        return _complaints([*self.opening, *self.console])


def _complaints(lines: Sequence[str]) -> list[str]:
    wrong = [line for line in lines if not re.match(r"debug|log|info", line)]
    return [line for line in wrong if not any(re.match(pattern, line) for pattern in NOISE)]


def differs(picture: NDArray[np.int16], other: NDArray[Any]) -> NDArray[np.bool_]:
    return np.asarray((np.abs(picture - other) > 20).any(axis=-1))


def packed(picture: NDArray[np.int16]) -> NDArray[np.int64]:
    """Return colours as one number each."""
    return picture.astype(np.int64) @ np.array((1 << 16, 1 << 8, 1))


def thick(area: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the pixels whose eight neighbours belong to the area too."""
    inner = area.copy()
    for rows in (-1, 0, 1):
        for columns in (-1, 0, 1):
            inner &= np.roll(area, (rows, columns), axis=(0, 1))
    return inner
