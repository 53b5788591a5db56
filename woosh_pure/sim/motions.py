"""Motions of the simulated base: `PathMotion` follows a path, `StepMotion` a list of steps. Pure: each
returns a velocity for the next `dt`.

Every motion ends in exactly one final state; its owner reads `state` and `code` afterwards.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import Enum

from woosh_pure.enums import StepMode
from woosh_pure.geometry import Pose2D, Velocity, normalize_angle
from woosh_pure.motion.steps import Step
from woosh_pure.sim.body import Body


class MotionState(Enum):
    """The state of a motion, or how it ended."""

    RUNNING = "running"
    PAUSED = "paused"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"
    REPLACED = "replaced"

    @property
    def is_final(self) -> bool:
        """Whether it has ended."""
        return self not in (MotionState.RUNNING, MotionState.PAUSED)


class Motion:
    """Base of the motions.

    Attributes:
        owner: The source of the command ("move_base", "step", "task").
        state: See `MotionState`.
        code: Status code of the end; 0 while it runs.
        blocked_for: Seconds of waiting for an obstacle.
    """

    def __init__(self, owner: str) -> None:
        self.owner = owner
        self.state = MotionState.RUNNING
        self.code = 0
        self.blocked_for = 0.0

    def command(self, body: Body, dt: float) -> Velocity:
        """Velocity for the next `dt` s; called only while RUNNING."""
        raise NotImplementedError

    def update(self, body: Body, dt: float) -> None:
        """Update the motion by what the body did in the last `dt` s."""

    def pause(self) -> None:
        """Pause."""
        self.state = MotionState.PAUSED

    def resume(self) -> None:
        """Resume."""
        self.state = MotionState.RUNNING

    def end(self, state: MotionState, code: int = 0) -> None:
        """Set the final state; later calls change nothing."""
        if not self.state.is_final:
            self.state, self.code = state, code


class PathMotion(Motion):
    """Follows way points: turns towards the next one, drives, and turns to the final yaw at the end.

    Attributes:
        path: Remaining way points; the last one is the goal.
        speed: Highest forward speed, m/s.
        too_close_for: Seconds of standing too close to something to go on as planned.
        clear: Whether the straight line between two places is free, so that a corner may be cut.
    """

    POSITION_TOLERANCE = 0.01
    YAW_TOLERANCE = 0.005

    def __init__(
        self, owner: str, path: Sequence[Pose2D], speed: float, *, point_by_point: bool = False
    ) -> None:
        super().__init__(owner)
        self.goal = path[-1]
        self.path = list(path[1:]) or list(path)
        self.speed = speed
        self.point_by_point = point_by_point
        self.too_close_for = 0.0
        self.clear: Callable[[Pose2D, Pose2D], bool] = lambda a, b: True
        self._turning = False

    def command(self, body: Body, dt: float) -> Velocity:
        pose = body.pose
        self._drop_passed(pose)
        target = self.path[0]
        distance = math.hypot(target.x - pose.x, target.y - pose.y)
        last = len(self.path) == 1
        if last and distance <= self.POSITION_TOLERANCE:
            return self._turn_to_goal(pose, body, dt)
        bearing = normalize_angle(math.atan2(target.y - pose.y, target.x - pose.x) - pose.yaw)
        if abs(bearing) > (0.02 if self._turning else 0.6):
            self._turning = True
            return Velocity(0.0, 0.0, _profile(bearing, 1.0, body.limits.angular_acceleration, dt))
        self._turning = False
        # Corners are driven slowly: only a part of the next leg counts.
        vx = _profile(distance if last else distance + 0.1, self.speed, body.limits.acceleration, dt) * max(
            math.cos(bearing), 0.0
        )
        return Velocity(vx, 0.0, max(-1.0, min(1.0, 2.5 * bearing)) if distance > 0.05 else 0.0)

    def _drop_passed(self, pose: Pose2D) -> None:
        while len(self.path) > 1:
            away = math.hypot(self.path[0].x - pose.x, self.path[0].y - pose.y)
            near = not self.point_by_point and away < 0.25
            if not (away < 0.05 or (near and self.clear(pose, self.path[1]))):
                break
            self.path.pop(0)

    def _turn_to_goal(self, pose: Pose2D, body: Body, dt: float) -> Velocity:
        rest = normalize_angle(self.goal.yaw - pose.yaw)
        if abs(rest) <= self.YAW_TOLERANCE and body.velocity.is_standing(0.02, 0.05):
            self.end(MotionState.DONE)
            return Velocity()
        return Velocity(0.0, 0.0, _profile(rest, 1.0, body.limits.angular_acceleration, dt))


class StepMotion(Motion):
    """Carries out a list of steps by dead reckoning.

    Attributes:
        steps: All steps of the goal.
        index: Index of the current step.
        avoid: Whether obstacles stop it.
    """

    def __init__(self, steps: Sequence[Step], *, avoid: bool = True) -> None:
        super().__init__("step")
        self.steps = list(steps)
        self.index = 0
        self.avoid = avoid
        self._travelled = 0.0

    @property
    def current(self) -> Step:
        """The current step; the last one when all are done."""
        return self.steps[min(self.index, len(self.steps) - 1)]

    @property
    def percent(self) -> float:
        """Completed part of the current step, 0 to 100."""
        if self.index >= len(self.steps):
            return 100.0
        whole = abs(self.current.data)
        # The base may still brake from a motion the other way: below 0 %, for a tiny step beyond any float32.
        return 100.0 if whole == 0 else min(100.0, max(0.0, 100.0 * self._travelled / whole))

    @property
    def rest(self) -> float:
        """What is left of the current step, m or rad."""
        return abs(self.current.data) - self._travelled

    def command(self, body: Body, dt: float) -> Velocity:
        step, rest = self.current, self.rest
        rotating = step.mode is StepMode.ROTATE
        limits = body.limits
        # Brake a little more gently than the drives can, so that the target is not passed.
        slow_down = 0.8 * (limits.angular_acceleration if rotating else limits.acceleration)
        speed = _profile(rest, step.highest_speed, slow_down, dt)
        d = step.direction()
        return Velocity(d.vx * speed, d.vy * speed, d.wz * speed)

    def coast(self, body: Body, dt: float) -> None:
        """Add the travelled distance; also while the body stops after a pause."""
        v, d = body.velocity, self.current.direction()
        self._travelled += (v.vx * d.vx + v.vy * d.vy + v.wz * d.wz) * dt

    def update(self, body: Body, dt: float) -> None:
        v = body.velocity
        self.coast(body, dt)
        if self.rest < 5e-4 and v.is_standing(0.02, 0.02):
            self.index += 1
            self._travelled = 0.0
            if self.index >= len(self.steps):
                self.end(MotionState.DONE, 130701000000)

    def remaining_steps(self) -> list[Step]:
        """The rest of the current step, and all later steps."""
        if self.index >= len(self.steps):
            return []
        step = self.current
        rest = math.copysign(max(0.0, self.rest), step.data)
        return [Step(step.mode, rest, step.speed, step.angle), *self.steps[self.index + 1 :]]


def _profile(rest: float, limit: float, deceleration: float, dt: float) -> float:
    """The highest signed speed from which the base can stop within `rest`."""
    size = abs(rest)
    return math.copysign(min(limit, math.sqrt(2.0 * deceleration * size), size / dt), rest)
