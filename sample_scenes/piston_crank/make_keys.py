"""Print the keys of the piston and of the rod, every 10 degrees of crank, as they stand in scene.yaml.

Run it from anywhere: python make_keys.py
"""

from __future__ import annotations

from math import asin, cos, degrees, radians, sin, sqrt

CRANK, ROD = 43.0, 145.0
"""mm: the crank's radius and the rod's length between its eyes."""

RATE = 10_000.0
"""deg/s of the crank: 10 degrees in 1 ms."""

NAMES = {0: "top dead centre", 90: "down stroke", 180: "bottom dead centre", 270: "up stroke", 360: "next top"}


def piston(angle: float) -> tuple[float, float]:
    """Return the height (mm) and velocity (mm/s) of the piston's pin at a crank angle (deg) after top dead centre."""
    turn = radians(angle)
    across, rod = CRANK * sin(turn), sqrt(ROD**2 - (CRANK * sin(turn)) ** 2)
    return CRANK * cos(turn) + rod, radians(RATE) * -across * (1.0 + CRANK * cos(turn) / rod)


def rod(angle: float) -> float:
    """Return the rod's turn (deg) about y against the piston."""
    return -degrees(asin(CRANK * sin(radians(angle)) / ROD))


if __name__ == "__main__":
    print("        # piston")
    for angle in range(0, 361, 10):
        height, velocity = piston(angle)
        name = f", name: {NAMES[angle]}" if angle in NAMES else ""
        row = f"{{t: {angle / RATE:.3f}, xyz: [0, 0, {height:.6f}], velocity: [0, 0, {velocity + 0.0:.3f}]{name}}}"
        print(f"        - {row.replace('-0.000]', '0.000]')}")
    print("        # rod")
    for angle in range(0, 361, 10):
        row = f"{{t: {angle / RATE:.3f}, rpy: [0, {rod(angle) + 0.0:.6f}, 0]}}"
        print(f"        - {row.replace('-0.000000', '0.000000')}")
