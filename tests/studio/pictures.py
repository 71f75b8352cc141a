"""The pictures of the samples in docs/pictures, as Foxglove Studio shows them.

    python -m tests.studio.pictures [NAME...]

from the project's folder, with CLOSECALL_STUDIO_DIR as tests/studio/install fills it. `samples/NAME.png` is the 3D
panel alone, at the sample's most telling moment, in 64 colours, as a README's pictures should be small; `arm_pick.png`
and `asteroids.png` show the whole layout.
"""

from __future__ import annotations

import shutil
import struct
import sys
import zlib
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from .logs import NAMES, Log, logs_of_samples
from .viewer import MISSING, Job, visited

PICTURES = Path(__file__).parents[2] / "docs" / "pictures"
COLOURS = 64


def moment(log: Log) -> float:
    """Return the share of the run amid the first contact that begins in it, else of where the worst pair is nearest."""
    begun = [(first, last) for _, first, last in log.contacts if first > log.time(0.0)]
    if begun:
        first, last = begun[0]
        return log.share(0.5 * (first + last))
    rank = ("contact", "breach", "unresolved", "possible", "clear")
    measured = [pair for pair in log.summary["pairs"] if pair["distance"]["upper"] is not None]
    if not measured:
        return 0.5
    worst = min(measured, key=lambda pair: (rank.index(pair["verdict"]), pair["distance"]["upper"]))
    return log.share(worst["distance"]["time"])


def png(picture: NDArray[np.uint8]) -> bytes:
    """Return a picture (height, width, 3) as a PNG with a palette of COLOURS."""
    height, width, _ = picture.shape
    coarse, where, counts = np.unique((picture >> 2).reshape(-1, 3), axis=0, return_inverse=True, return_counts=True)
    palette = _palette(coarse.astype(np.float64) * 4.0 + 2.0, counts)
    apart = ((coarse[:, None].astype(np.float64) * 4.0 + 2.0 - palette[None]) ** 2).sum(axis=2)
    rows = apart.argmin(axis=1)[where.reshape(-1)].astype(np.uint8).reshape(height, width)
    lines = np.hstack((np.zeros((height, 1), np.uint8), rows)).tobytes()
    head = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    colours = palette.round().astype(np.uint8).tobytes()
    parts = ((b"IHDR", head), (b"PLTE", colours), (b"IDAT", zlib.compress(lines, 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, data) for kind, data in parts)


def _palette(colours: NDArray[np.float64], counts: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return at most COLOURS colours: boxes of colours cut in two where they spread most, by median."""
    boxes = [np.arange(len(colours))]
    while len(boxes) < COLOURS:
        spreads = [float(np.ptp(colours[box], axis=0).max() * np.sqrt(counts[box].sum())) for box in boxes]
        widest = int(np.argmax(spreads))
        if spreads[widest] == 0.0:
            break
        box = boxes.pop(widest)
        axis = int(np.ptp(colours[box], axis=0).argmax())
        box = box[np.argsort(colours[box, axis], kind="stable")]
        cut = int(np.clip(np.searchsorted(np.cumsum(counts[box]), 0.5 * counts[box].sum()), 1, len(box) - 1))
        boxes += [box[:cut], box[cut:]]
    return np.array([np.average(colours[box], axis=0, weights=counts[box]) for box in boxes])


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def main() -> None:
    """Make the pictures of the samples named, or of all."""
    if MISSING:
        sys.exit(MISSING)
    names = sys.argv[1:] or NAMES
    with TemporaryDirectory() as logs_folder, TemporaryDirectory() as folder:
        logs = logs_of_samples(Path(logs_folder), names)
        jobs = [
            Job(name, log.path, log.attachments["layout.json"], [moment(log)], pictures=True)
            for name, log in logs.items()
        ]
        (PICTURES / "samples").mkdir(exist_ok=True)
        for name, visit in visited(jobs, Path(folder)).items():
            look = visit.looks[-1]
            (PICTURES / "samples" / f"{name}.png").write_bytes(png(look.scene.astype(np.uint8)))
            whole = PICTURES / f"{name}.png"
            if whole.exists():
                shutil.copy(look.page, whole)


if __name__ == "__main__":
    main()
