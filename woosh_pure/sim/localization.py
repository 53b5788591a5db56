"""Where the simulated robot believes it is, in the map. Pure.

Located, it knows its pose exactly. Lost, it goes on by dead reckoning: from the pose it last believed, by
what its odometry says since.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from woosh_pure.geometry import Pose2D, normalize_angle
from woosh_pure.sim.body import Body

_LOCATED, _LOST, _STARTED, _NOT_THERE = 130103000000, 130103000012, 130103000021, 140201000022
_NEAR, _NEAR_ANGLE = 1.0, 0.6  # m, rad: a hint this near to the truth lets the localisation converge


class Localization:
    """The localisation of a simulated robot.

    Attributes:
        located: Whether it knows where it is.
        running: Whether the localisation runs (/start_localization).
    """

    def __init__(self, body: Body, located: bool, report: Callable[[int], None]) -> None:
        self.located = located
        self.running = True
        self._body = body
        self._report = report
        self._lost_at: tuple[Pose2D, Pose2D] | None = None  # pose believed, and odometry, when it was lost

    @property
    def pose(self) -> Pose2D:
        """What the localisation says; dead reckoning while the robot is lost."""
        if self._lost_at is None:
            pose = self._body.pose
            return Pose2D(pose.x, pose.y, normalize_angle(pose.yaw))
        belief, odometry = self._lost_at
        return _composed(belief, odometry, self._body.odometry)

    def in_map(self, pose: Pose2D) -> Pose2D | None:
        """A pose of a command, in the map; None for a frame this robot does not have."""
        frame = pose.frame.lstrip("/")
        if frame == "map":
            return pose
        if frame == "base_link":
            return self.pose.transformed(pose.x, pose.y, pose.yaw)
        if frame == "odom":
            return _composed(self.pose, self._body.odometry, replace(pose, frame="odom"))
        return None

    def take_hint(self, pose: Pose2D) -> bool:
        """A hint where the robot is: near the truth the localisation converges, otherwise nothing changes.

        Returns:
            Whether it was taken.
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
        """Run again, beginning where the robot believes it is."""
        if not self.running:
            self.running = True
            self._report(_STARTED)
            self.take_hint(self.pose)

    def lose(self) -> None:
        """The robot no longer knows where it is."""
        self._lost_at = (self.pose, self._body.odometry)
        self.located = False
        self._report(_LOST)


def _composed(belief: Pose2D, odometry_then: Pose2D, odometry_now: Pose2D) -> Pose2D:
    dx, dy = odometry_now.x - odometry_then.x, odometry_now.y - odometry_then.y
    c, s = math.cos(-odometry_then.yaw), math.sin(-odometry_then.yaw)
    return belief.transformed(c * dx - s * dy, s * dx + c * dy, odometry_then.angle_to(odometry_now))
