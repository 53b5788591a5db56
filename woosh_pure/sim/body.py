"""The moving base: kinematics with acceleration limits, odometry that drifts. Pure: `step(dt)`."""

from __future__ import annotations

import math
import random
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

    def place(self, pose: Pose2D) -> None:
        """Put the robot at another pose, standing."""
        self.pose = replace(pose, yaw=normalize_angle(pose.yaw))
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


def _towards(value: float, wanted: float, most: float) -> float:
    return value + min(max(wanted - value, -most), most)


def _clip(value: float, most: float) -> float:
    return min(max(value, -most), most)
