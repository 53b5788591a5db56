"""The moving base, with acceleration limits and an odometry that drifts; and its localisation: the pose in
the map that the robot reports. Pure.

A localised robot knows its pose exactly. Afterwards it uses dead reckoning: the last pose, moved by the
odometry.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, replace

from woosh_pure.geometry import Pose2D, Velocity, normalize_angle


@dataclass(frozen=True, slots=True)
class BodyLimits:
    """Limits of the drives.

    Attributes:
        linear, angular: Highest speeds, m/s and rad/s.
        acceleration, angular_acceleration: Of a smoothed command, m/s² and rad/s².
        hard_acceleration, hard_angular_acceleration: Of an unsmoothed command and of an emergency stop.
        omnidirectional: Whether it can move sideways.
    """

    linear: float = 1.5
    angular: float = 2.0
    acceleration: float = 0.6
    angular_acceleration: float = 1.5
    hard_acceleration: float = 3.0
    hard_angular_acceleration: float = 6.0
    omnidirectional: bool = False


class Body:
    """True pose and velocity, and the odometry.

    Attributes:
        pose: True pose in the map.
        velocity: True velocity.
        odometry: Pose in the odom frame by wheels and IMU; drifts slowly.
        wheel_odometry: Pose by wheels alone; drifts more.
        distance: Metres travelled.
    """

    def __init__(self, pose: Pose2D, limits: BodyLimits, rng: random.Random, drift: float = 0.01) -> None:
        self.pose = pose
        self.velocity = Velocity()
        self.limits = limits
        self.odometry = Pose2D(0.0, 0.0, 0.0, "odom")
        self.wheel_odometry = Pose2D(0.0, 0.0, 0.0, "odom")
        self.distance = 0.0
        # A systematic error, such as a worn wheel, drawn once, so that equal seeds give equal runs.
        self._scale = 1.0 + rng.uniform(-drift, drift)
        self._turn_scale = 1.0 + rng.uniform(-drift, drift)

    def approach(self, wanted: Velocity, dt: float, *, hard: bool = False) -> None:
        """Change the velocity towards `wanted` as far as the drives can in `dt` s."""
        self.velocity = self.approached(self.velocity, wanted, dt, hard=hard)

    def approached(self, v: Velocity, wanted: Velocity, dt: float, *, hard: bool = False) -> Velocity:
        """A velocity after `dt` s with `wanted` commanded."""
        m = self.limits
        linear = (m.hard_acceleration if hard else m.acceleration) * dt
        angular = (m.hard_angular_acceleration if hard else m.angular_acceleration) * dt
        return Velocity(
            _towards(v.vx, _clip(wanted.vx, m.linear), linear),
            _towards(v.vy, _clip(wanted.vy, m.linear), linear) if m.omnidirectional else 0.0,
            _towards(v.wz, _clip(wanted.wz, m.angular), angular),
        )

    def moved(self, dt: float) -> Pose2D:
        """The pose after `dt` s at the present velocity."""
        return integrate(self.pose, self.velocity, dt)

    def advance(self, dt: float) -> None:
        """Move for `dt` s and update the odometry."""
        v = self.velocity
        self.pose = self.moved(dt)
        self.distance += math.hypot(v.vx, v.vy) * dt
        self.odometry = integrate(self.odometry, self._felt(v, 0.1), dt)
        self.wheel_odometry = integrate(self.wheel_odometry, self._felt(v, 1.0), dt)

    def _felt(self, v: Velocity, share: float) -> Velocity:
        linear = 1.0 + (self._scale - 1.0) * share
        return Velocity(v.vx * linear, v.vy * linear, v.wz * (1.0 + (self._turn_scale - 1.0) * share))

    def block(self) -> None:
        """Set the velocity to zero at once, after a collision."""
        self.velocity = Velocity()


def integrate(pose: Pose2D, v: Velocity, dt: float) -> Pose2D:
    """The pose after `dt` s at a velocity."""
    # Mid-point rule: exact for straight lines and for turning in place, good enough for 20 ms of an arc.
    middle = pose.yaw + v.wz * dt / 2.0
    c, s = math.cos(middle), math.sin(middle)
    return replace(
        pose,
        x=pose.x + (c * v.vx - s * v.vy) * dt,
        y=pose.y + (s * v.vx + c * v.vy) * dt,
        yaw=normalize_angle(pose.yaw + v.wz * dt),
    )


def _towards(value: float, wanted: float, limit: float) -> float:
    return value + min(max(wanted - value, -limit), limit)


def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


# -- localisation --------------------------------------------------------------------------------------------

_LOCATED, _LOST, _STARTED, _NOT_THERE = 130103000000, 130103000012, 130103000021, 140201000022
_NEAR, _NEAR_ANGLE = 1.0, 0.6  # m, rad: the localisation converges from a hint within these


class Localization:
    """The localisation of a simulated robot.

    Attributes:
        located: Whether the robot is localised.
        running: Whether the localisation runs (/start_localization).
    """

    def __init__(self, body: Body, located: bool, report: Callable[[int], None]) -> None:
        self.located = located
        self.running = True
        self._body = body
        self._report = report
        # Estimated pose and odometry when the localisation was lost.
        self._lost_at: tuple[Pose2D, Pose2D] | None = None

    @property
    def pose(self) -> Pose2D:
        """The estimated pose; dead reckoning while the localisation is lost."""
        if self._lost_at is None:
            pose = self._body.pose
            return Pose2D(pose.x, pose.y, normalize_angle(pose.yaw))
        belief, odometry = self._lost_at
        return _composed(belief, odometry, self._body.odometry)

    def in_map(self, pose: Pose2D) -> Pose2D | None:
        """Convert a pose to the map frame; None for an unknown frame."""
        frame = pose.frame
        if frame == "map":
            return pose
        if frame == "base_link":
            return self.pose.transformed(pose.x, pose.y, pose.yaw)
        if frame == "odom":
            return _composed(self.pose, self._body.odometry, replace(pose, frame="odom"))
        return None

    def apply_pose_hint(self, pose: Pose2D) -> bool:
        """Localise from a pose hint. The localisation converges near the true pose; else nothing changes.

        Returns:
            Whether it has converged.
        """
        truth = self._body.pose
        near = math.hypot(pose.x - truth.x, pose.y - truth.y) < _NEAR
        if not (near and abs(pose.angle_to(truth)) < _NEAR_ANGLE and self.running):
            self._report(_NOT_THERE)
            return False
        self.located, self._lost_at = True, None
        self._report(_LOCATED)
        return True

    def start(self) -> None:
        """Start the localisation at the estimated pose."""
        if not self.running:
            self.running = True
            self._report(_STARTED)
            self.apply_pose_hint(self.pose)

    def lose(self) -> None:
        """Lose the localisation."""
        self._lost_at = (self.pose, self._body.odometry)
        self.located = False
        self._report(_LOST)


def _composed(belief: Pose2D, odometry_then: Pose2D, odometry_now: Pose2D) -> Pose2D:
    dx, dy = odometry_now.x - odometry_then.x, odometry_now.y - odometry_then.y
    c, s = math.cos(-odometry_then.yaw), math.sin(-odometry_then.yaw)
    return belief.transformed(c * dx - s * dy, s * dx + c * dy, odometry_then.angle_to(odometry_now))
