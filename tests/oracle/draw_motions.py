"""Random motions of every kind that the scene file has, and the trajectory files of some."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .draw import Draw
from .draw_files import in_another_layout
from .rigid import METRES, FloatArray
from .sampling import TICK

Spec = dict[str, Any]


def random_motion(draw: Draw, kind: str | None = None, vigour: float = 1.0) -> Spec:
    """Write a random motion that moves by about `vigour` sizes a second or turns by about a radian.

    Keys stand on multiples of TICK, so that a step's instant is the same number whoever adds `t0`.
    """
    chosen: str = kind or draw.pick(*KINDS)
    spec = {"type": chosen, **MOTIONS[chosen](draw, vigour * draw.size)}
    if chosen not in ("keyframes", "file", "polynomial", "profile") and draw.chance(0.3):
        spec["t0"] = draw.between(-1.0, 2.0)
    with draw.aside():
        for key in MAY_BE_LEFT_OUT.get(chosen, ()):
            if draw.chance(0.2):
                spec.pop(key, None)
        if kind is None and chosen != "file" and draw.chance(0.1):  # it has the most to say
            return random_motion(draw, "file", vigour)
    return spec


MAY_BE_LEFT_OUT = {
    "constant": ("velocity", "angular_velocity"),
    "ballistic": ("velocity", "acceleration"),
    "screw": ("point",),
    "harmonic": ("phase",),
    "swing": ("point", "phase"),
    "profile": ("point",),
    "limits": ("velocity", "max_angular_speed"),
}
"""Keys that are mostly written, by motion; others may be missing as they are drawn."""


def velocity(draw: Draw, speed: float) -> Any:
    return draw.metres(draw.direction() * speed * draw.between(0.3, 1.5))


def spin(draw: Draw) -> Any:
    return draw.radians(draw.direction() * draw.between(0.3, 4.0))


def point(draw: Draw) -> Any:
    return draw.metres(draw.rng.uniform(-0.7, 0.7, 3) * draw.size)


def constant(draw: Draw, reach: float) -> Spec:
    out = {"velocity": velocity(draw, reach), "angular_velocity": spin(draw)}
    if draw.chance(0.4):
        out.pop(draw.pick("velocity", "angular_velocity"))
    return out


def ballistic(draw: Draw, reach: float) -> Spec:
    out = {"velocity": velocity(draw, 1.5 * reach), "acceleration": velocity(draw, 1.5 * reach)}
    return out | {"angular_velocity": spin(draw)} if draw.chance(0.6) else out


def screw(draw: Draw, reach: float) -> Spec:
    out: Spec = {"axis": draw.axis(), "rate": draw.radians(draw.between(-5.0, 5.0))}
    if draw.chance(0.7):
        out["pitch"] = draw.metres(draw.between(-1.0, 1.0) * reach)
    return out | {"point": point(draw)}


def orbit(draw: Draw, reach: float) -> Spec:
    axis = draw.direction()
    start = np.cross(axis, draw.direction())
    out: Spec = {
        "axis": draw.axis(axis),
        "start": draw.axis(start / np.linalg.norm(start)),
        "radius": draw.metres(draw.between(0.2, 1.2) * reach),
        "rate": draw.radians(draw.between(-5.0, 5.0)),
    }
    if draw.chance(0.5):
        out["phase"] = draw.radians(draw.between(-3.0, 3.0))
    return out | {"facing": draw.chance(0.7)} if draw.chance(0.7) else out


def harmonic(draw: Draw, reach: float) -> Spec:
    return {
        "direction": draw.axis(),
        "amplitude": draw.metres(draw.between(0.2, 1.2) * reach),
        "period": draw.between(0.15, 3.0),
        "phase": draw.radians(draw.between(-3.0, 3.0)),
    }


def swing(draw: Draw, _reach: float) -> Spec:
    return {
        "axis": draw.axis(),
        "point": point(draw),
        "amplitude": draw.radians(draw.between(0.3, 3.0)),
        "period": draw.between(0.2, 3.0),
        "phase": draw.radians(draw.between(-3.0, 3.0)),
    }


def polynomial(draw: Draw, reach: float) -> Spec:
    """Write one of degree 1 to 6 about the middle of the time, whose terms reach about as far at both ends.

    Or a single power of a time so long that its coefficient is tiny.
    """
    if draw.chance(0.2):
        long, degree = 10.0 ** draw.between(3.0, 6.0), int(draw.rng.integers(7, 21))
        term = draw.direction() * reach * draw.between(0.3, 1.5) / long**degree
        return {"coefficients": [[0.0] * 3] * degree + [draw.metres(term)], "t0": draw.start - long}
    degree, half = int(draw.rng.integers(1, 7)), 0.5 * (draw.end - draw.start)
    terms = [draw.direction() * reach * draw.between(0.0, 1.5) / half**k for k in range(degree + 1)]
    out: Spec = {"coefficients": [draw.metres(term) for term in terms], "t0": draw.start + half}
    with draw.aside():
        if draw.start == 0.0 and draw.chance(0.2):  # the same about the start, and twice as far at the end
            del out["t0"]
    return out | {"angular_velocity": spin(draw)} if draw.chance(0.5) else out


def profile(draw: Draw, reach: float) -> Spec:
    """Write a slide or a turn that begins within the time, or before it."""
    out: Spec = {"kind": draw.pick("slide", "turn"), "axis": draw.axis()}
    if out["kind"] == "turn":
        unit, write = draw.between(0.5, 3.0), draw.radians
        out["point"] = point(draw)
    else:
        unit, write = reach, draw.metres
    out |= {"from": write(draw.between(-1.0, 1.0) * unit), "to": write(draw.between(-1.0, 1.0) * unit)}
    out["max_velocity"] = write(draw.between(0.3, 3.0) * unit)
    out["max_acceleration"] = write(draw.between(0.5, 10.0) * unit)
    return out | {"t0": draw.between(draw.start - 0.5, draw.end)} if draw.chance(0.8) else out


def keyframes(draw: Draw, reach: float) -> Spec:
    """Write 2 to 6 keys on ticks: over the whole time, or less of it and held or repeated."""
    ticks, outside = spread_ticks(draw, int(draw.rng.integers(0, 5)))
    shift = int(draw.rng.integers(-40, 40)) if draw.chance(0.3) else 0
    keys = wandering_keys(draw, [tick - shift for tick in ticks], reach)
    with draw.aside():
        if draw.chance(0.05):
            keys, outside = keys[:1], {"before": "hold", "after": "hold"}
    out: Spec = {"keys": keys, **outside}
    if shift:
        out["t0"] = shift * TICK
    ways = {"translation": draw.pick("linear", "cubic", "step"), "rotation": draw.pick("slerp", "slerp", "step")}
    if ways != {"translation": "linear", "rotation": "slerp"} or draw.chance(0.5):
        with draw.aside():
            for way, usual in (("translation", "linear"), ("rotation", "slerp")):
                if ways[way] == usual and draw.chance(0.3):
                    del ways[way]
        out["interpolation"] = ways
    if ways.get("translation") == "cubic" and draw.chance(0.5):
        for key in keys:
            key["velocity"] = velocity(draw, 2.0 * reach)
    if draw.chance(0.5):
        for index, key in enumerate(keys):
            if draw.chance(0.7):
                key["name"] = f"key {index}"
    return out


def spread_ticks(draw: Draw, inner: int) -> tuple[list[int], Spec]:
    """Return ticks with `inner` ones between the first and the last, and what is said of the time before and after."""
    begin, end = round(draw.start / TICK), round(draw.end / TICK)
    outside: Spec = {}
    if draw.chance(0.4):
        first, last = begin, end
        if draw.chance(0.6):
            begin = first + int(draw.rng.integers(1, (last - first) // 3))
            outside["before"] = draw.pick("hold", "loop")
        if not outside or draw.chance(0.6):
            end = last - int(draw.rng.integers(1, (last - first) // 2))
            outside["after"] = draw.pick("hold", "loop")
    chosen = draw.rng.choice(np.arange(begin + 1, end), inner, replace=False)
    with draw.aside():
        for side in ("before", "after"):
            if draw.chance(0.2):
                outside.setdefault(side, "error")
    return [begin, *sorted(chosen.tolist()), end], outside


def wandering(draw: Draw, count: int, reach: float) -> list[tuple[FloatArray, Rotation]]:
    """Return poses that wander by about `reach` and turn by less than 150 degrees each."""
    place, rotation = draw.rng.uniform(-0.5, 0.5, 3) * reach, Rotation.identity()
    turning = draw.chance(0.7)
    poses = []
    for _ in range(count):
        poses.append((place, rotation))
        place = place + draw.rng.uniform(-0.7, 0.7, 3) * reach
        if turning:
            rotation = Rotation.from_rotvec(draw.direction() * draw.between(0.1, 2.5)) * rotation
    return poses


def wandering_keys(draw: Draw, ticks: list[int], reach: float) -> list[Spec]:
    """Write keys at these ticks."""
    keys = []
    for tick, (place, rotation) in zip(ticks, wandering(draw, len(ticks), reach), strict=True):
        turn = draw.turn(rotation) if rotation.magnitude() > 0.0 else {}
        pose = {"xyz": draw.metres(place), **turn}
        with draw.aside():
            if draw.chance(0.05):
                pose = {"matrix": draw.matrix(place, rotation)}
            elif draw.chance(0.03):
                del pose["xyz"]
        keys.append({"t": tick * TICK, **pose})
    return keys


def file(draw: Draw, reach: float) -> Spec:
    """Write a trajectory file of 4 to 20 poses, its clock started long before, and the motion along it."""
    ticks, outside = spread_ticks(draw, int(draw.rng.integers(2, 19)))
    first = draw.pick(0, 0, 1_400_000_000 * 64)
    with draw.aside():
        if draw.chance(0.2):  # the scene's own clock
            first = ticks[0]
    clocks = [first + tick - ticks[0] for tick in ticks]
    layout, origin = draw.pick("tum", "csv"), draw.pick("first", "first", "zero")
    out: Spec = {"file": f"path_{draw.files}.{'txt' if layout == 'tum' else 'csv'}", "layout": layout, **outside}
    draw.files += 1
    if origin == "zero" or draw.chance(0.5):
        out["time_origin"] = origin
    start = clocks[0] if origin == "zero" else 0
    if ticks[0] != start:
        out["t0"] = (ticks[0] - start) * TICK
    if draw.chance(0.4):
        out["interpolation"] = {"translation": draw.pick("linear", "cubic")}
    with draw.aside():
        if draw.chance(0.3):
            ways = {"translation": draw.pick("linear", "cubic", "step"), "rotation": draw.pick("slerp", "step")}
            written = draw.pick(("translation", "rotation"), ("translation",), ("rotation",))
            out["interpolation"] = {way: ways[way] for way in written}
        if draw.chance(0.2):
            out["max_gap"] = draw.end - draw.start
    poses = wandering(draw, len(ticks), 0.5 * reach)
    times = [repr(clock * TICK) for clock in clocks]
    if layout == "tum":
        lines = ["# timestamp tx ty tz qx qy qz qw"]
        for time, (place, rotation) in zip(times, poses, strict=True):
            lines.append(" ".join([time, *map(repr, place.tolist()), *map(repr, rotation.as_quat().tolist())]))
    else:
        unit = draw.pick(draw.length, "mm", "m")
        with draw.aside():
            unit = draw.pick(unit, *METRES)
        if unit != draw.length or draw.chance(0.5):
            out["units"] = unit
        lines = csv_lines(draw, times, [(place / METRES[unit], rotation) for place, rotation in poses])
    (draw.folder / out["file"]).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return in_another_layout(draw, out, clocks, poses)


def csv_lines(draw: Draw, times: list[str], poses: list[tuple[FloatArray, Rotation]]) -> list[str]:
    """Return a header and rows: with quaternions, with angles, or with places alone."""
    way = draw.pick("quaternion", "angles", "none")
    columns = {"quaternion": ["qw", "qx", "qy", "qz"], "angles": ["roll", "pitch", "yaw"], "none": []}[way]
    lines = [",".join(["t", "x", "y", "z", *columns])]
    for time, (place, rotation) in zip(times, poses, strict=True):
        x, y, z, w = rotation.as_quat().tolist()
        angles = np.atleast_1d(draw.radians(rotation.as_euler("xyz"))).tolist()
        turn = {"quaternion": [w, x, y, z], "angles": angles, "none": []}[way]
        lines.append(",".join([time, *map(repr, [*place.tolist(), *turn])]))
    return lines


def limits(draw: Draw, reach: float) -> Spec:
    """Write a path of which only the limits are known; the oracle takes one of those within them."""
    speed = reach * draw.between(0.05, 0.4)
    out = {
        "velocity": draw.metres(draw.direction() * speed),
        "max_speed": draw.metres(1.2 * speed),
        "max_acceleration": draw.metres(speed),
        "max_angular_speed": draw.radians(draw.between(0.0, 1.0)),
    }
    with draw.aside():
        if draw.chance(0.3):
            del out[draw.pick("max_speed", "max_acceleration")]
    return out


MOTIONS: dict[str, Callable[[Draw, float], Spec]] = {
    "constant": constant,
    "ballistic": ballistic,
    "screw": screw,
    "orbit": orbit,
    "harmonic": harmonic,
    "swing": swing,
    "polynomial": polynomial,
    "profile": profile,
    "keyframes": keyframes,
    "file": file,
    "limits": limits,
}

KNOWN = tuple(kind for kind in MOTIONS if kind != "limits")
KINDS = (*KNOWN, "keyframes", "keyframes")
"""Motions as a scene takes them unless it names one: of known paths."""
