"""What the chassis tells, gathered as `ChassisFacts`: every feed calls back, nothing is polled."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rosproto.errors import RosError
from woosh_pure.chassis import Chassis
from woosh_pure.enums import RobotMode
from woosh_pure.fleet.chassis_facts import ChassisFacts
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.vehicle_limits import AgvPosition
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.reasons import ReasonKey
from woosh_pure.values import Parameters

_SEVERE = 3  # level of a fault
SILENT_AFTER = 1.5
"""Seconds without pose and velocity after which the robot is lost; both come several times a second."""
MOST_CORNERS = 100
"""Of the path in a state."""
STILL = 0.3
"""Seconds for which velocities must be those of a robot that stands before it counts as standing."""


def operating_mode(robot_mode: int, *, owner: str = "") -> str:
    """The operating mode (6.10.6) of a robot_mode: 2 is manual, 3 maintenance; a local driver who has the
    robot makes it MANUAL, whatever its key says."""
    if robot_mode == 3:
        return "SERVICE"
    return "MANUAL" if robot_mode == 2 or owner else "AUTOMATIC"


class ChassisMonitor:
    """The facts of one chassis.

    Args:
        chassis: The chassis.
        facts: What is kept true.
        moved: Called when a pose or a velocity has come, in a feed's thread; must not wait.
        told: Called when anything else has come that may change mode, faults or battery; likewise.
        described: Called when the parameters of the drives have come, for the factsheet; likewise.
        planned: Called when a path has come; likewise.
    """

    def __init__(
        self,
        chassis: Chassis,
        facts: ChassisFacts,
        moved: Callable[[], object],
        told: Callable[[], object],
        described: Callable[[], object],
        planned: Callable[[], object],
    ) -> None:
        self._chassis, self._facts, self._moved, self._told = chassis, facts, moved, told
        self._described, self._planned = described, planned
        self.parameters: Parameters | None = None
        self._ends: list[Callable[[], None]] = []
        self.heard = 0.0
        self._still_since: float | None = (
            None  # from when on all velocities were those of a robot that stands
        )
        self._measured = 0.0  # when the newest velocity came
        self._opened = 0.0
        self.mode = "SERVICE"
        self.blocked = ""

    def open(self) -> None:
        """Start listening; the feeds connect by themselves, also to a chassis that appears later."""
        self._opened = time.monotonic()
        chassis = self._chassis
        self._ends = [
            chassis.pose.on(self._on_pose, connect=False),
            chassis.measured_velocity.on(self._on_velocity, connect=False),
            chassis.battery.on(self._on_battery, connect=False),
            chassis.parameters.on(self._on_parameters, connect=False),
            chassis.feed("plan").on(self._on_path, connect=False),
            chassis.status.on(self._on_told, connect=False),
            chassis.status_code.on(self._on_told, connect=False),
        ]

    def close(self) -> None:
        """Stop listening."""
        for end in self._ends:
            end()
        self._ends = []

    @property
    def silent(self) -> bool:
        """Whether nothing has been heard of the robot; it has twice the time before its first message."""
        return time.monotonic() - (self.heard or self._opened + SILENT_AFTER) >= SILENT_AFTER

    def silence(self) -> Problem:
        """The error for a robot of which nothing is heard."""
        text = f"nothing was heard of the chassis at {self._chassis.master_uri} for {SILENT_AFTER:g} s"
        hint = "check the robot and its network; it may go on with what it was told"
        return Problem(ErrorType.ROBOT_LOST, text, (), Level.FATAL, hint)

    def _on_pose(self, pose: Pose2D) -> None:
        self._facts.position = AgvPosition(pose.x, pose.y, pose.yaw, self._facts.map_id)
        self._hear()

    def _on_velocity(self, velocity: Velocity) -> None:
        self._facts.velocity = (velocity.vx, velocity.vy, velocity.wz)
        now = time.monotonic()
        if self._facts.moving:
            self._still_since = None
        elif self._still_since is None:
            self._still_since = now
        self._measured = now
        self._hear()

    def stood(self, after: float) -> bool:
        """Whether it was measured standing for `STILL` seconds, all of them after a time of the monotonic
        clock, and up to the newest velocity."""
        since = self._still_since
        return since is not None and self._measured - max(since, after) >= STILL

    def _hear(self) -> None:
        self.heard = time.monotonic()
        self._moved()

    def _on_battery(self, battery: Any) -> None:
        facts = self._facts
        before = (facts.percent is None, facts.charging)
        facts.percent, facts.voltage = float(battery.percent), battery.voltage
        facts.charging = battery.charging
        if before != (False, facts.charging):
            self._told()

    def _on_parameters(self, parameters: Parameters) -> None:
        if parameters != self.parameters:
            self.parameters = parameters
            self._described()

    def _on_path(self, path: Any) -> None:
        """Thinned: a state of a few kilobytes has room for it. One in another frame is no way on the map."""
        poses, frame = path.poses, path.header.frame_id.lstrip("/")
        kept = [*poses[: -1 : max(1, -(-len(poses) // MOST_CORNERS))], *poses[-1:]]
        points = ((pose.pose.position.x, pose.pose.position.y) for pose in kept)
        self._facts.path = tuple(points) if frame in ("map", "") else ()
        self._planned()

    def _on_told(self, value: Any) -> None:
        self._told()

    def refresh(self, owner: str = "") -> None:
        """Mode, faults, emergency stop and localisation, as they are known now; must not be called in a feed.

        Args:
            owner: A local driver who has the robot; "" while nobody has.
        """
        facts = self._facts
        try:
            readiness, faults = self._chassis.readiness(), self._chassis.faults
        except RosError:
            return  # closed, or its master is gone: the silence tells
        keys = {reason.key for reason in readiness.reasons}
        facts.emergency_stop = ReasonKey.EMERGENCY_STOP in keys
        facts.bumper = ReasonKey.BUMPER in keys
        facts.located = facts.position is not None and ReasonKey.NOT_LOCALISED not in keys
        facts.faults = tuple((str(each), bool(each.level >= _SEVERE)) for each in faults)
        status = self._chassis.status.known
        mode = RobotMode.UNDEFINED if status is None else status.value.robot_mode
        if ReasonKey.MANUAL_MODE in keys and mode is RobotMode.UNDEFINED:
            mode = RobotMode.MANUAL
        self.mode = operating_mode(int(mode), owner=owner)
        self.blocked = readiness.sentence() if readiness.refuses else ""
