"""The motions between a body and an ancestor frame, composed: the body's pose, and bounds on how far its points get."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np

from ..geometry.arrays import FloatArray
from ..geometry.transform import crossed, mapped, translation_of, turned
from ..geometry.vector import ZERO, Vector, add, cross, distance_to_line, dot, norm, scale, subtract
from ..model.body_tree import ancestors
from ..model.extent import Ball, Extent
from ..model.scene import Body
from ..motions import Axis, Fixed, Interval, LeverArms, Limits, Motion, Rates
from ..motions.acceleration_set import STILL, AccelerationSet, across, ball, shared

_WORLD: FloatArray = np.eye(4)
_AT_REST = Rates(0.0, STILL, 0.0, 0.0)


class Part(Enum):
    """Which points of a body are meant: all, those that span it before they are rounded, or the middle of its ball."""

    WHOLE = auto()
    CORE = auto()
    CENTRE = auto()


class Twist(NamedTuple):
    """A frame's motion at one time: its origin's place (m) and velocity (m/s), and its angular velocity (rad/s)."""

    origin: Vector
    velocity: Vector
    angular_velocity: Vector

    def of(self, point: Vector) -> Vector:
        """Return the velocity (m/s) of a point (m) that moves with the frame."""
        return add(self.velocity, cross(self.angular_velocity, subtract(point, self.origin)))

    def at(self, points: FloatArray) -> FloatArray:
        """Return the velocities (..., 3) m/s of points (..., 3) m that move with the frame."""
        arms = points - np.array(self.origin)
        return np.array(self.velocity) + crossed(np.array(self.angular_velocity), arms)

    def along(self, directions: FloatArray, points: FloatArray) -> FloatArray:
        """Return the velocities (d, n) m/s along directions (d, 3) of points (n, 3) m that move with the frame."""
        arms = points - np.array(self.origin)
        turning = crossed(directions, np.array(self.angular_velocity))
        along: FloatArray = (directions @ np.array(self.velocity))[:, None] + turning @ arms.T
        return along


_STILL = Twist(ZERO, ZERO, ZERO)


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """A motion and its rest frame, seen from the moved frame of the joint above (4x4, above_from_rest).

    `terms` are the lengths (m) of the translations of the fixed poses that `rest` is the product of: they may cancel in
    it, but their rounding does not.
    """

    rest: FloatArray
    motion: Motion
    terms: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class ChainState:
    """A chain at one time.

    Attributes:
        pose: 4x4, ancestor_from_body.
        centre: of the body's ball, in the ancestor's frame.
        reaches: of the body's points in each joint's moved frame, everything below frozen at `time`.
        frames: 4x4 a joint, ancestor_from_rest of it.
        twist: how the last moved frame moves in the ancestor's frame.
    """

    time: float
    pose: FloatArray
    centre: Vector
    reaches: tuple[LeverArms, ...]
    frames: tuple[FloatArray, ...]
    twist: Twist


class Chain:
    """The motions that carry a body relative to an ancestor, outermost first."""

    def __init__(
        self, joints: tuple[Joint, ...], tail: FloatArray, extent: Extent, tail_terms: tuple[float, ...] = ()
    ) -> None:
        """Join `joints`; `tail` is the last moved frame's view of the body (4x4), `tail_terms` as those of a joint."""
        self.joints = joints
        self._tail_terms = tail_terms
        self.tail = tail
        self._rests = [_plain(joint.rest) for joint in joints]
        self._end = _plain(tail)
        self._moment: ChainState | None = None  # returned last, with the rates returned last
        self._rates: tuple[ChainState, float, Rates] | None = None
        self.ball = extent.ball
        self.extent = extent
        self._last_centre = mapped(tail, extent.ball.centre)
        self._last_reach = _exact_reach(joints[-1].motion.axis, tail, extent) if joints else None

    def at(self, t: float) -> ChainState:
        """Return the chain's pose and reaches at t; those asked for last are kept, for other pairs of the body."""
        if self._moment is None or self._moment.time != t:
            self._moment = self._placed(t) if self.joints else self._still
        return self._moment

    def _placed(self, t: float) -> ChainState:
        placed = [_joined(rest, joint.motion.pose(t)) for rest, joint in zip(self._rests, self.joints, strict=True)]
        reaches: list[LeverArms] = []
        centre = self._last_centre
        for joint, pose in zip(reversed(self.joints), reversed(placed), strict=True):
            reaches.append(_ball_reach(joint.motion.axis, centre, self.ball.radius) if reaches else self._own_reach)
            centre = mapped(pose, centre)
        frames: list[FloatArray] = []
        above, twist = _WORLD, _STILL
        for rest, joint, pose in zip(self._rests, self.joints, placed, strict=True):
            frames.append(_joined(above, rest))
            twist = _carried(twist, above, pose, frames[-1], joint.motion.velocities(t))
            above = _joined(above, pose)
        twist = twist._replace(origin=translation_of(above))
        return ChainState(t, _joined(above, self._end), centre, tuple(reversed(reaches)), tuple(frames), twist)

    def displacement(self, state: ChainState, duration: float) -> float:
        """Return D >= |x(t + s) - x(t)| (m) of every point of the body in the ancestor's frame, 0 <= s <= duration.

        Exact telescoping over the joints, each with the reach of the points while everything below is frozen.
        """
        total = 0.0
        for joint, reach in zip(self.joints, state.reaches, strict=True):
            total += joint.motion.displacement(state.time, duration, reach)
        return total

    def path_length(self, state: ChainState, duration: float) -> float:
        """Return L >= the arc length (m) of any point of the body in the ancestor's frame over [t, t + duration].

        The speed that a joint gives a point depends on where the joints below have carried it by then: the reach of
        each joint grows by their displacement.
        """
        total = below = 0.0
        for joint, reach in zip(reversed(self.joints), reversed(state.reaches), strict=True):
            grown = LeverArms(reach.radius + below, reach.axis_radius + below)
            total += joint.motion.path_length(state.time, duration, grown)
            below += joint.motion.displacement(state.time, duration, reach)
        return total

    def rates(self, state: ChainState, duration: float) -> Rates:
        """Return suprema over [t, t + duration] of the last moved frame's rates in the ancestor's frame.

        Those asked for last are kept.
        """
        if self._rates is None or self._rates[0] is not state or self._rates[1] != duration:
            self._rates = state, duration, self._rates_of(state, duration)
        return self._rates[2]

    def _rates_of(self, state: ChainState, duration: float) -> Rates:
        """Return the rates, composed from the outermost joint on.

        Row `chain, speeds`: V = V_P + W_P L + V', A = A_P + (al_P + W_P^2) L + 2 W_P V' + A', and so on, L the
        farthest that the child's origin gets from its parent's. Where nothing above turns, directions stay as they are;
        where all that turns above does so about one axis, what is added by turning lies across it.
        """
        first = _in_frame(self.joints[0], state.frames[0], state.time, duration) if self.joints else _AT_REST
        speed, varying, spin, spin_up, steady, axis = first
        for joint, frame in zip(self.joints[1:], state.frames[1:], strict=True):
            rates = _in_frame(joint, frame, state.time, duration)
            if spin == 0.0:
                speed, axis = speed + rates.speed, rates.axis
                steady, varying = add(steady, rates.steady), varying.plus(rates.varying)
            else:
                arm = norm(translation_of(joint.rest @ joint.motion.pose(state.time)))
                arm += joint.motion.displacement(state.time, duration, origin_reach(joint.motion))
                by_turning = (spin_up + spin**2) * arm + 2.0 * spin * rates.speed
                along, rest = _turned_with(axis, rates.steady, rates.varying)
                speed += spin * arm + rates.speed
                steady, varying = add(steady, along), varying.plus(rest).plus(across(axis, by_turning))
                if rates.angular_speed > 0.0:
                    axis = shared(axis, rates.axis)
            spin_up += rates.angular_acceleration + spin * rates.angular_speed
            spin += rates.angular_speed
        return Rates(speed, varying, spin, spin_up, steady, axis)

    def fastest(self, twist: Twist) -> float:
        """Return above the speed (m/s) of every point of the body and of the terms that it is the sum of."""
        return norm(twist.velocity) + norm(twist.angular_velocity) * self.radius(Part.WHOLE)

    def radius(self, part: Part) -> float:
        """Return the farthest (m) that a point of a part of the body lies from the last moved frame's origin."""
        return self._radii[part]

    @cached_property
    def _radii(self) -> dict[Part, float]:
        if not self.joints:
            return dict.fromkeys(Part, 0.0)
        placed = self.extent.points @ self.tail[:3, :3].T + self.tail[:3, 3]
        core = float(np.max(np.linalg.norm(placed, axis=1)))
        return {Part.WHOLE: self._own_reach.radius, Part.CORE: core, Part.CENTRE: norm(self._last_centre)}

    @cached_property
    def middle(self) -> Chain:
        """The chain of the middle of the body's ball alone."""
        centre = self.ball.centre
        return Chain(self.joints, self.tail, Extent(np.array([centre]), np.zeros(1), Ball(centre, 0.0)))

    def knot_after(self, t: float) -> float:
        """Return the first time > t at which a rate of any joint jumps (inf: none)."""
        return min((joint.motion.knot_after(t) for joint in self.joints), default=inf)

    def stop_after(self, t: float) -> float:
        """Return the first time > t at which the pair must wake for a jump of any joint (inf: none)."""
        return min((joint.motion.stop_after(t) for joint in self.joints), default=inf)

    def rounding(self, times: Interval) -> float:
        """Return how far (m) floating point may misplace a point of the body at any of the times.

        8 eps times the size of every term of every pose, with the points' reach for the radius of each turn.
        """
        reach = norm(self.ball.centre) + self.ball.radius
        size = 0.0
        for term in reversed(self._tail_terms):
            reach += term
            size += reach
        for joint in reversed(self.joints):
            size += joint.motion.rounding_scale(times, reach) + reach
            reach += joint.motion.extent(times)
            for term in reversed(joint.terms):
                reach += term
                size += reach
        return 8.0 * float(np.finfo(float).eps) * (size + reach)

    @property
    def _own_reach(self) -> LeverArms:
        assert self._last_reach is not None
        return self._last_reach

    @cached_property
    def _still(self) -> ChainState:
        return ChainState(0.0, self.tail, self._last_centre, (), (), _STILL)


def _plain(pose: FloatArray) -> FloatArray:
    """Return a 4x4 pose, `_WORLD` itself where it is equal to that."""
    return _WORLD if np.array_equal(pose, _WORLD) else pose


def _joined(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return one @ other, 4x4 each."""
    if one is _WORLD:
        return other
    return one if other is _WORLD else one @ other


def _turned(frame: FloatArray, vector: Vector) -> Vector:
    return vector if frame is _WORLD else turned(frame, vector)


def _carried(
    twist: Twist, above: FloatArray, placed: FloatArray, frame: FloatArray, velocities: tuple[Vector, Vector]
) -> Twist:
    """Return the twist of a frame that moves with `velocities` (m/s, rad/s) in `frame`, carried by the one above.

    Args:
        twist: of the frame above.
        above, placed, frame: 4x4, ancestor_from_above, above_from_moved, ancestor_from_rest.
        velocities: of the moved frame in its rest frame.
    """
    velocity, angular_velocity = (_turned(frame, vector) for vector in velocities)
    if above is _WORLD:
        return Twist(ZERO, velocity, angular_velocity)
    arm = turned(above, translation_of(placed))
    v = add(add(twist.velocity, cross(twist.angular_velocity, arm)), velocity)
    return Twist(twist.origin, v, add(twist.angular_velocity, angular_velocity))


def _in_frame(joint: Joint, frame: FloatArray, t: float, duration: float) -> Rates:
    """Return a joint's rates over [t, t + duration] in the frame that `frame` (4x4) maps its rest frame to."""
    rates = joint.motion.rates(t, duration)
    if frame is _WORLD:
        return rates
    axis = None if rates.axis is None else turned(frame, rates.axis)
    return rates._replace(varying=rates.varying.turned(frame), steady=turned(frame, rates.steady), axis=axis)


def _turned_with(axis: Vector | None, steady: Vector, varying: AccelerationSet) -> tuple[Vector, AccelerationSet]:
    """Return what stays steady of a frame's vectors while it turns about an axis (None: any), and where the rest is."""
    if axis is None:
        return ZERO, ball(norm(steady) + varying.norm_bound)
    along = scale(dot(axis, steady), axis)
    return along, varying.swept_about(axis).plus(across(axis, norm(subtract(steady, along))))


def origin_reach(motion: Motion) -> LeverArms:
    """Return the reach of the moved frame's origin alone."""
    axis = motion.axis
    return LeverArms(0.0, 0.0 if axis is None else distance_to_line(ZERO, axis.point, axis.direction))


def chain_to(bodies: tuple[Body, ...], body: int, ancestor: int | None, extent: Extent) -> Chain:
    """Return the chain of `body` seen from `ancestor` (None: the world), motionless stretches multiplied together.

    A frame whose path is unknown stands at its rest pose.
    """
    joints: list[Joint] = []
    fixed = np.eye(4)
    line = ancestors(bodies, body)
    stretch = line if ancestor is None else line[: line.index(ancestor)]
    terms: list[float] = []
    for index in reversed(stretch):
        fixed = fixed @ bodies[index].pose
        terms.append(norm(translation_of(bodies[index].pose)))
        if not isinstance(bodies[index].motion, Fixed | Limits):
            joints.append(Joint(fixed, bodies[index].motion, tuple(terms)))
            fixed, terms = np.eye(4), []
    return Chain(tuple(joints), fixed, extent, tuple(terms))


def _exact_reach(axis: Axis | None, tail: FloatArray, extent: Extent) -> LeverArms:
    """Return the reach of the body's own points in the last moved frame."""
    points = extent.points @ tail[:3, :3].T + tail[:3, 3]
    radius = float(np.max(np.linalg.norm(points, axis=1) + extent.radii))
    if axis is None:
        return LeverArms(radius, radius)
    arms = crossed(points - np.array(axis.point), np.array(axis.direction))
    return LeverArms(radius, float(np.max(np.linalg.norm(arms, axis=1) + extent.radii)))


def _ball_reach(axis: Axis | None, centre: Vector, radius: float) -> LeverArms:
    """Return the reach of a ball."""
    farthest = norm(centre) + radius
    if axis is None:
        return LeverArms(farthest, farthest)
    return LeverArms(farthest, distance_to_line(centre, axis.point, axis.direction) + radius)
