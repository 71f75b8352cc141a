"""Motions as written to the scheduler's motions: SI units, unit axes, their own time made the scene's."""

from __future__ import annotations

import math

from ....scheduler.model.scene import least_duration
from ....scheduler.motions import (
    Ballistic,
    Constant,
    Delayed,
    Fixed,
    Harmonic,
    Interval,
    Limits,
    Motion,
    Orbit,
    Polynomial,
    Screw,
    Swing,
    Trapezoid,
)
from ..grammar.motions import (
    BallisticMotion,
    ConstantMotion,
    FileMotion,
    HarmonicMotion,
    KeyframesMotion,
    LimitsMotion,
    MotionChoice,
    OrbitMotion,
    PolynomialMotion,
    ProfileMotion,
    ScrewMotion,
    SwingMotion,
)
from ..limits import FARTHEST_PLACE, PERPENDICULAR_TOLERANCE
from ..loaded import InputFile, KeyNames
from ..quantities.poses import Vector, unit_vector
from ..quantities.units import Scale
from ..text.document import Findings
from ..text.errors import Where, quoted
from ..text.folder import Folder
from .keyed_motions import PathReader

SmoothMotion = (
    ConstantMotion | BallisticMotion | ScrewMotion | OrbitMotion | HarmonicMotion | SwingMotion | PolynomialMotion
)


class MotionReader:
    """The motions of one scene.

    Attributes:
        paths: of keyframes and files.
    """

    def __init__(self, folder: Folder, scale: Scale, findings: Findings, time: Interval) -> None:
        """Take where trajectory files may lie, the file's units, what takes the faults, and the scene's time."""
        self.paths = PathReader(folder, scale, findings, least_duration(*time))
        self._time = time
        self._scale = scale
        self._findings = findings

    @property
    def files(self) -> tuple[InputFile, ...]:
        """The trajectory files read so far, by the body that moves so."""
        return tuple(self.paths.files)

    @property
    def key_names(self) -> dict[str, KeyNames]:
        """The named keys read so far, by the body that moves by them."""
        return self.paths.key_names

    def motion(self, part: MotionChoice | None, body: str, needed: Interval) -> Motion:
        """Return a body's motion in SI; faults are recorded, and a motion with one may come back as Fixed.

        Args:
            part: as the grammar read it; None is a body without motion.
            body: its name, as written.
            needed: s, when its frame must be known.
        """
        where: Where = ("bodies", body, "motion")
        motion = self._motion(part, body, where, needed)
        farthest = motion.extent(self._time)
        if not farthest <= FARTHEST_PLACE:
            problem = f"the motion's terms add up to {farthest:.2g} m within the scene's time"
            self._findings.fault(where, f"{problem}, expected at most {FARTHEST_PLACE:g} m")
        return motion

    def _motion(self, part: MotionChoice | None, body: str, where: Where, needed: Interval) -> Motion:
        match part:
            case None:
                return Fixed()
            case KeyframesMotion():
                return self.paths.keyframes(part, body, needed)
            case FileMotion():
                return self.paths.trajectory(part, body, needed)
            case ProfileMotion():
                return self._profile(part, where)
            case LimitsMotion():
                return self._limits(part, where)
            case _:
                motion = self._smooth(part, where)
                return motion if part.t0 == 0.0 else Delayed(motion, part.t0)

    def _smooth(
        self,
        part: SmoothMotion,
        where: Where,
    ) -> Motion:
        scale = self._scale
        match part:
            case ConstantMotion():
                return Constant(scale.lengths(part.velocity), scale.angles(part.angular_velocity))
            case BallisticMotion():
                velocity, acceleration = scale.lengths(part.velocity), scale.lengths(part.acceleration)
                return Ballistic(velocity, acceleration, scale.angles(part.angular_velocity))
            case ScrewMotion():
                axis = self._unit(part.axis, (*where, "axis"))
                return Screw(axis, scale.lengths(part.point), scale.angle(part.rate), scale.length(part.pitch))
            case OrbitMotion():
                return self._orbit(part, where)
            case HarmonicMotion():
                direction = self._unit(part.direction, (*where, "direction"))
                return Harmonic(direction, scale.length(part.amplitude), part.period, scale.angle(part.phase))
            case SwingMotion():
                axis, point = self._unit(part.axis, (*where, "axis")), scale.lengths(part.point)
                return Swing(axis, point, scale.angle(part.amplitude), part.period, scale.angle(part.phase))
            case PolynomialMotion():
                coefficients = tuple(scale.lengths(one) for one in part.coefficients)
                return Polynomial(coefficients, scale.angles(part.angular_velocity))

    def _orbit(self, part: OrbitMotion, where: Where) -> Orbit:
        axis, start = self._unit(part.axis, (*where, "axis")), self._unit(part.start, (*where, "start"))
        along = sum(a * s for a, s in zip(axis, start, strict=True))
        if abs(along) > PERPENDICULAR_TOLERANCE:
            angle = math.degrees(math.acos(max(-1.0, min(1.0, along))))
            problem = f"expected a direction perpendicular to the axis, got one at {angle:.6g} degrees to it"
            self._findings.fault((*where, "start"), problem)
            return Orbit(axis, start, 1.0, 0.0, 0.0, False)
        x, y, z = (s - along * a for a, s in zip(axis, start, strict=True))
        length = math.hypot(x, y, z)
        radius, rate = self._scale.length(part.radius), self._scale.angle(part.rate)
        start = (x / length, y / length, z / length)
        return Orbit(axis, start, radius, rate, self._scale.angle(part.phase), part.facing)

    def _profile(self, part: ProfileMotion, where: Where) -> Motion:
        turns = part.kind == "turn"
        scaled = self._scale.angle if turns else self._scale.length
        if not turns and "point" in part.model_fields_set:
            self._findings.fault((*where, "point"), "a slide has no point, leave the key out (or is it a turn?)")
        return Trapezoid(
            turns,
            self._unit(part.axis, (*where, "axis")),
            self._scale.lengths(part.point),
            scaled(part.begin),
            scaled(part.end),
            scaled(part.max_velocity),
            scaled(part.max_acceleration),
            part.t0,
        )

    def _limits(self, part: LimitsMotion, where: Where) -> Motion:
        if part.max_speed is None and part.max_acceleration is None:
            problem = "nothing limits how far it gets, expected max_speed or max_acceleration"
            self._findings.fault(where, problem)
            return Fixed()
        speed = math.hypot(*part.velocity)
        fastest = math.inf if part.max_speed is None else part.max_speed
        if speed > fastest:
            problem = f"expected a speed up to max_speed, {quoted(fastest)}, got {quoted(speed)}"
            self._findings.fault((*where, "velocity"), problem)
        acceleration = math.inf if part.max_acceleration is None else part.max_acceleration
        return Limits(part.t0, *map(self._scale.length, (speed, fastest, acceleration)))

    def _unit(self, vector: Vector, where: Where) -> Vector:
        return unit_vector(vector, where, self._findings)
