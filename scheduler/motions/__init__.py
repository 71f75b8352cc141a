"""The motions, each with sound bounds on how far its points get."""

from .ballistic import Ballistic, Constant
from .base import Axis, Fixed, Interval, Motion, Rates, Reach, Smooth
from .delayed import Delayed
from .hermite import Translation
from .keyframes import Keyframes
from .limits import Limits
from .looped import Looped
from .orbit import Orbit
from .oscillation import Harmonic, Swing
from .polynomial import Polynomial
from .profile import Profile
from .screw import Screw

__all__ = [
    "Axis",
    "Ballistic",
    "Constant",
    "Delayed",
    "Fixed",
    "Harmonic",
    "Interval",
    "Keyframes",
    "Limits",
    "Looped",
    "Motion",
    "Orbit",
    "Polynomial",
    "Profile",
    "Rates",
    "Reach",
    "Screw",
    "Smooth",
    "Swing",
    "Translation",
]
