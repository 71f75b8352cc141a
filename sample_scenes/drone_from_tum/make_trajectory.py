"""Write slalom.tum: where a drone flies, 20 times a second, as a motion capture system would record it.

Each line is t x y z qx qy qz qw, in s and m. Run it from anywhere: python make_trajectory.py
"""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin
from pathlib import Path

START = 1_700_000_000
"""s since 1970, as recordings have it."""

STEPS, RATE = 200, 20
"""Lines after the first, and lines per second."""

GRAVITY = 9.81
"""m/s^2."""


def place(t: float) -> tuple[float, float, float]:
    """Return the drone's place (m): along x at 1.5 m/s, weaving by 1.2 m in 6 s, bobbing by 0.15 m in 5 s."""
    return 1.5 * t, 1.2 * sin(pi * t / 3.0), 1.6 + 0.15 * sin(0.4 * pi * t)


def attitude(t: float) -> tuple[float, float, float, float]:
    """Return the quaternion (x, y, z, w): the nose along the course, banked so that the thrust bears the path.

    The turn about the vertical by the course comes first, then the least turn that brings the drone's z to the thrust.
    """
    course = atan2(0.4 * pi * cos(pi * t / 3.0), 1.5)
    across = -1.2 * (pi / 3.0) ** 2 * sin(pi * t / 3.0)
    up = GRAVITY - 0.15 * (0.4 * pi) ** 2 * sin(0.4 * pi * t)
    lean = 0.5 * atan2(-across, up)  # about x, half of it
    turn = 0.5 * course
    x, y, z, w = sin(lean) * cos(turn), -sin(lean) * sin(turn), cos(lean) * sin(turn), cos(lean) * cos(turn)
    size = hypot(x, y, z, w)
    return x / size, y / size, z / size, w / size


if __name__ == "__main__":
    lines = ["# t x y z qx qy qz qw\n"]
    for step in range(STEPS + 1):
        t = step / RATE
        numbers = " ".join(f"{value + 0.0:.6f}" for value in (*place(t), *attitude(t)))
        lines.append(
            f"{START + step // RATE}.{step % RATE * (100 // RATE):02d} {numbers}\n".replace("-0.000000", "0.000000")
        )
    (Path(__file__).parent / "slalom.tum").write_text("".join(lines), encoding="ascii", newline="\n")
