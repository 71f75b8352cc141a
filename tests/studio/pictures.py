"""The pictures of the samples in docs/pictures, as Foxglove Studio shows them.

    python -m tests.studio.pictures [NAME...]

from the project's folder, with CLOSECALL_STUDIO_DIR as tests/studio/install fills it. `samples/NAME.png` is the 3D
panel alone, at the sample's most telling moment, in 64 colours, as a README's pictures should be small; `arm_pick.png`
and `asteroids.png` show the whole layout, and `report.png`, in Chromium, the beginning of the report of REPORTED.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

from .logs import NAMES, Log, logs_of_samples
from .pages import PageVisit, visited_pages
from .viewer import MISSING, Job, visited

PICTURES = Path(__file__).parents[2] / "docs" / "pictures"
COLOURS = 64

REPORTED = "asteroids"
REPORT_SIZE = (1400, 1210)
REPORT_COLOURS = 256


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


def picture_report(log: Log, folder: Path) -> None:
    """Make the picture of a log's report, amid its first contact."""
    page = folder / "report.html"
    subprocess.run([sys.executable, "-m", "closecall", "report", str(log.path), "-o", str(page)], check=True)
    width, height = REPORT_SIZE
    steps = [("click", "#after"), ("slide", moment(log)), ("evaluate", "scrollTo(0, 0)")]
    visited_pages([PageVisit("report", page, steps, width=width, height=height, picture=True)], folder)
    begin = Image.open(folder / "report.png").convert("RGB").crop((0, 0, width, height))
    small = begin.quantize(REPORT_COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    small.save(PICTURES / "report.png", optimize=True)


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
            small = Image.fromarray(look.picture).quantize(COLOURS, dither=Image.Dither.NONE)
            small.save(PICTURES / "samples" / f"{name}.png", optimize=True)
            whole = PICTURES / f"{name}.png"
            if whole.exists():
                shutil.copy(look.page, whole)
        if REPORTED in names:
            picture_report(logs[REPORTED], Path(folder))


if __name__ == "__main__":
    main()
