"""Reads a robot's state as values for clients: the parts of the snapshot, the path, the pose of the laser.
No function waits unless its docstring says so.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import rosproto.tf  # noqa: F401 (`in_base` needs it, and nothing is imported once the robot is driven)
from woosh_pure.enums import RobotState
from woosh_pure.geometry import Pose2D
from woosh_pure.readings import in_base, known_path
from woosh_pure.reasons import ReasonKey
from woosh_pure.values.state import LaserScan
from woosh_pure.web.robot import Robot
from woosh_pure.web.snapshot import (
    ages,
    faults_part,
    lease_part,
    points_part,
    pose_part,
    readiness_part,
    state_parts,
)

MAX_POINTS = 500
BRAKING_SECONDS = 1.0
"""A robot that moves for this long after a drive by hand has not stopped yet: it drives along no path."""


def slow_parts(robot: Robot) -> dict[str, object]:
    """Return the parts that are requested a few times a second. Blocks for a moment the first time."""
    readiness, faults = robot.chassis.readiness(), robot.chassis.faults
    return {
        "activity": activity(robot),
        "readiness": readiness_part(readiness),
        "faults": faults_part(faults),
        "goals": [goal.as_json() for goal in robot.goals.all()[-10:]],
        "recordings": [one.as_json() for one in robot.recordings.all()],
        "missions": robot.missions.part(),
    }


def snapshot(robot: Robot) -> dict[str, object]:
    """The whole state at once. Blocks the first time."""
    robot.listen()
    readings = robot.readings()
    pose = readings["pose"]
    return {
        "robot": robot.name,
        "time": round(time.time(), 3),
        **state_parts(readings),
        "pose": None if pose is None else pose_part(pose.value),
        **slow_parts(robot),
        "lease": lease_part(robot.chassis.lease.state),
        "driver": robot.manual_drive.driver,
        "ages": ages(readings),
    }


def path_points(robot: Robot) -> list[list[float]]:
    """Return the path being driven, thinned for a screen; empty once the motion is over.

    The navigation goes on publishing its last path, and does not report its end.
    """
    path = known_path(robot.chassis) if _under_way(robot) else []
    step = max(1, math.ceil(len(path) / MAX_POINTS))
    thinned = path[::step]
    if path and thinned[-1] is not path[-1]:
        thinned.append(path[-1])
    return points_part((pose.x, pose.y) for pose in thinned)


def activity(robot: Robot) -> str | None:
    """What the robot does: `driven` by hand, `under way`, or else its own state; None if it has not reported.

    A robot calls itself idle while it is driven by velocity, or by a goal of the navigation.
    """
    status = robot.feed("status").known
    state = RobotState.UNDEFINED if status is None else status.value.robot_state
    if robot.manual_drive.driver is not None:
        return "driven"
    if state in (RobotState.UNDEFINED, RobotState.IDLE) and _under_way(robot):
        return "under way"
    return None if status is None else str(state)


def _under_way(robot: Robot) -> bool:
    """Whether the robot drives along a path: a goal of any client is under way, or the robot moves."""
    if robot.goals.running or any(reason.key in _BUSY for reason in robot.chassis.readiness().reasons):
        return True
    velocity = robot.feed("velocity").known
    if velocity is None or velocity.age > 1.0 or robot.manual_drive.driver is not None:
        return False
    brakes = velocity.received < robot.manual_drive.ended + BRAKING_SECONDS
    return not (brakes or velocity.value.is_standing())


_BUSY = (ReasonKey.BUSY, ReasonKey.OTHER_CLIENT)


class Mounting(NamedTuple):
    """How the laser is mounted: its pose in base_link, and whether it is upside down."""

    pose: Pose2D
    turned: bool

    def angles(self, scan: LaserScan) -> tuple[float, float]:
        """First angle and step, seen from above."""
        sign = -1.0 if self.turned else 1.0
        return sign * scan.angle_min, sign * scan.angle_increment


def laser_mounting(robot: Robot, scan: LaserScan) -> Mounting:
    """Return the mounting from the static transforms; without one, the robot's centre. Sends no request."""
    corners: NDArray[np.float64] = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    origin, ahead, left = in_base(robot.chassis, corners, scan.frame)[:, :2]
    x, y = ahead - origin, left - origin
    turned = float(x[0] * y[1] - x[1] * y[0]) < 0.0
    pose = Pose2D(float(origin[0]), float(origin[1]), math.atan2(float(x[1]), float(x[0])))
    return Mounting(pose, turned)
