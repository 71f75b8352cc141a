"""The motions, each with sound bounds on how far its points get."""

from .ballistic import Ballistic, Constant
from .base import Axis, Fixed, Motion, Rates, Reach
from .keyframes import Keyframes
from .oscillation import Harmonic, Swing
from .screw import Screw

__all__ = [
    "Axis",
    "Ballistic",
    "Constant",
    "Fixed",
    "Harmonic",
    "Keyframes",
    "Motion",
    "Rates",
    "Reach",
    "Screw",
    "Swing",
]
