"""Trajectory files in the layouts of EuRoC and KITTI, and with several poses at one time."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .draw import Draw
from .rigid import FloatArray
from .sampling import TICK

Poses = list[tuple[FloatArray, Rotation]]
TICK_NANOSECONDS = round(TICK * 1e9)
HEADERS = (
    "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []",
    "timestamp [ns],x,y,z,qw,qx,qy,qz",
    "# a remark",
)


def in_another_layout(draw: Draw, spec: dict[str, Any], clocks: list[int], poses: Poses) -> dict[str, Any]:
    """Write some of the trajectory files again, of another layout or with more poses than times.

    These draws come from a source of their own: all else of a seed stays as it is.

    Args:
        draw: the scene's.
        spec: the motion along a file that is written already.
        clocks: ticks of the file's own clock.
        poses: as many, m.
    """
    rng = np.random.default_rng([draw.seed, draw.files, 7])
    layout = rng.choice([spec["layout"], "euroc", "kitti"], p=[0.4, 0.3, 0.3])
    if layout == spec["layout"]:
        lines = (draw.folder / spec["file"]).read_text(encoding="utf-8").splitlines()
        head, rows = [lines[0]], lines[1:]
        separator = " " if layout == "tum" else ","
        times, rest = map(list, zip(*(row.split(separator, 1) for row in rows), strict=True))
    else:
        spec = {key: value for key, value in spec.items() if key != "units"} | {"layout": str(layout)}
        spec["file"] = f"path_{draw.files}.{layout}"
        head, times, rest = (euroc if layout == "euroc" else kitti)(rng, clocks, poses)
        separator = "," if layout == "euroc" else " "
    if layout == "kitti" and rng.random() < 0.5:
        return by_period(draw, spec, clocks, rest)
    if rng.random() < 0.4:
        spec["duplicates"] = str(rng.choice(["first", "last", "error"]))
        if spec["duplicates"] != "error":
            repeat_times(rng, spec["duplicates"], times, rest)
    if layout == "kitti":
        spec["times"] = f"times_{draw.files}.txt"
        write(draw, spec["times"], times)
        write(draw, spec["file"], rest)
    else:
        write(draw, spec["file"], [*head, *(f"{time}{separator}{row}" for time, row in zip(times, rest, strict=True))])
    return spec


def write(draw: Draw, name: str, lines: list[str]) -> None:
    (draw.folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


def repeat_times(rng: np.random.Generator, duplicates: str, times: list[str], rest: list[str]) -> None:
    """Add a row or two at the time of another, with the pose of a third: after it, or before it if the last counts."""
    for _ in range(int(rng.integers(1, 3))):
        index = int(rng.integers(len(times)))
        place = index + 1 if duplicates == "first" else index
        times.insert(place, times[index])
        rest.insert(place, rest[int(rng.integers(len(rest)))])


def euroc(rng: np.random.Generator, clocks: list[int], poses: Poses) -> tuple[list[str], list[str], list[str]]:
    """Return a header, times and the rest of the rows, some with velocities after the quaternions."""
    more = ",0.1,0.2,0.3" if rng.random() < 0.5 else ""
    head = [HEADERS[i] for i in range(len(HEADERS)) if rng.random() < 0.4]
    times = [str(clock * TICK_NANOSECONDS) for clock in clocks]
    rows = [[*place.tolist(), *turn.as_quat(scalar_first=True).tolist()] for place, turn in poses]
    return head[:1], times, [",".join(map(repr, row)) + more for row in rows]


def kitti(rng: np.random.Generator, clocks: list[int], poses: Poses) -> tuple[list[str], list[str], list[str]]:
    """Return no header, times and matrices by rows, of which some files write rotations to six decimals."""
    decimals = 6 if rng.random() < 0.5 else 17
    turned = [np.round(turn.as_matrix(), decimals) for _, turn in poses]
    rows = [np.column_stack((turn, place)).ravel().tolist() for turn, (place, _) in zip(turned, poses, strict=True)]
    return [], [f"{clock * TICK:.17e}" for clock in clocks], [" ".join(map(repr, row)) for row in rows]


def by_period(draw: Draw, spec: dict[str, Any], clocks: list[int], rows: list[str]) -> dict[str, Any]:
    """Write the matrices at even times from the first of the clocks to the last of them or beyond."""
    steps = len(rows) - 1
    period = -((clocks[0] - clocks[-1]) // steps)
    first = float(spec.get("t0", 0.0)) + (clocks[0] * TICK if spec.get("time_origin") == "zero" else 0.0)
    out = {key: value for key, value in spec.items() if key != "t0"} | {"period": period * TICK}
    write(draw, spec["file"], rows)
    return out | {"t0": first} if first else out
