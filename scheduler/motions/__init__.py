"""The motions: one law a file, with sound bounds on how far its points get."""

from .ballistic import Ballistic, Constant
from .delayed import Delayed
from .harmonic import Harmonic, Swing
from .key_interpolation import Translation
from .keyframes import Keyframes
from .looped import Looped
from .motion import Axis, Fixed, Interval, LeverArms, Motion, Rates, Smooth
from .orbit import Orbit
from .polynomial import Polynomial
from .screw import Screw
from .trapezoid import Trapezoid
from .unknown_path import Limits

__all__ = [
    "Axis",
    "Ballistic",
    "Constant",
    "Delayed",
    "Fixed",
    "Harmonic",
    "Interval",
    "Keyframes",
    "LeverArms",
    "Limits",
    "Looped",
    "Motion",
    "Orbit",
    "Polynomial",
    "Rates",
    "Screw",
    "Smooth",
    "Swing",
    "Translation",
    "Trapezoid",
]
