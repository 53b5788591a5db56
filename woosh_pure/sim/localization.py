"""The simulated localisation: the pose in the map that the robot reports. Pure.

A localised robot knows its pose exactly. Afterwards it uses dead reckoning: the last pose, moved by the
odometry.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from woosh_pure.geometry import Pose2D, normalize_angle
from woosh_pure.sim.body import Body

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
        self._lost_at: tuple[Pose2D, Pose2D] | None = (
            None  # estimated pose and odometry when the localisation was lost
        )

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
        frame = pose.frame.lstrip("/")
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
