"""What is measured of a chassis: `ChassisMonitor` keeps the `ChassisFacts` up to date by the chassis's feeds;
`StandingCheck` makes sure that the robot stands;
`EdgeSpeedMonitor` tells whether a drive keeps to the maxSpeed of its edge.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable
from typing import Any

from rosproto.codec import DynamicMessage
from rosproto.errors import RosError
from woosh_pure.chassis import Chassis, components_of
from woosh_pure.enums import RobotMode
from woosh_pure.fleet.chassis_facts import ChassisFacts
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.events import Drive
from woosh_pure.fleet.order.vehicle_limits import AgvPosition
from woosh_pure.geometry import Footprint, Pose2D, Velocity
from woosh_pure.reasons import ReasonKey
from woosh_pure.values import Battery, Parameters

_SEVERE = 3  # level of a fault
SILENT_AFTER = 1.5
"""Seconds without pose and velocity after which contact is lost; both arrive several times a second."""
MAX_CORNERS = 100
"""Most corners of the path in a state."""
STILL = 0.3
"""Seconds without motion after which the robot counts as standing."""
_STANDING_SECONDS = 3.0  # for one attempt to measure that


def operating_mode(robot_mode: int, *, owner: str = "") -> str:
    """The operating mode (6.10.6) for a robot_mode: 2 is manual, 3 maintenance. With a local driver (`owner`)
    it is MANUAL."""
    if robot_mode == 3:
        return "SERVICE"
    return "MANUAL" if robot_mode == 2 or owner else "AUTOMATIC"


class ChassisMonitor:
    """Updates the facts of one chassis. Its callbacks are called in a feed's thread and must not block.

    Args:
        chassis: The chassis.
        facts: The facts to update.
        on_motion: Called for each pose and velocity.
        on_path: Called for each planned path.
        flag: Called with "status" when mode, faults or battery may have changed, and with "parameters" when
            the driving parameters have changed.
    """

    def __init__(
        self,
        chassis: Chassis,
        facts: ChassisFacts,
        on_motion: Callable[[], object],
        on_path: Callable[[], object],
        flag: Callable[[str], object],
    ) -> None:
        self._chassis, self._facts = chassis, facts
        self._motion_changed, self._path_changed, self._flag = on_motion, on_path, flag
        self.parameters: Parameters | None = None
        self._ends: list[Callable[[], None]] = []
        self.heard = 0.0
        self._still_since: float | None = None  # since when all velocities were zero
        self._measured = 0.0  # time of the newest velocity
        self._opened = 0.0
        self.mode = "SERVICE"
        self.blocked = ""

    def open(self) -> None:
        """Start listening. The feeds also connect to a chassis that is started later."""
        self._opened = time.monotonic()
        chassis = self._chassis
        self._ends = [
            chassis.pose.on(self._on_pose, connect=False),
            chassis.measured_velocity.on(self._on_velocity, connect=False),
            chassis.battery.on(self._on_battery, connect=False),
            chassis.parameters.on(self._on_parameters, connect=False),
            chassis.feed("plan").on(self._on_path, connect=False),
            chassis.status.on(lambda status: self._flag("status"), connect=False),
            chassis.status_code.on(lambda code: self._flag("status"), connect=False),
        ]

    def close(self) -> None:
        """Stop listening."""
        for end in self._ends:
            end()
        self._ends = []

    @property
    def silent(self) -> bool:
        """Whether contact is lost; the first message may take twice as long."""
        return time.monotonic() - (self.heard or self._opened + SILENT_AFTER) >= SILENT_AFTER

    def silence_problem(self) -> Problem:
        """The problem to report when contact is lost."""
        text = f"nothing was heard of the chassis at {self._chassis.master_uri} for {SILENT_AFTER:g} s"
        hint = "check the robot and its network; it may go on with what it was told"
        return Problem(ErrorType.ROBOT_LOST, text, level=Level.FATAL, hint=hint)

    def _on_pose(self, pose: Pose2D) -> None:
        self._facts.position = AgvPosition(pose.x, pose.y, pose.yaw, self._facts.map_id)
        self._note_contact()

    def _on_velocity(self, velocity: Velocity) -> None:
        self._facts.velocity = (velocity.vx, velocity.vy, velocity.wz)
        now = time.monotonic()
        if self._facts.moving:
            self._still_since = None
        elif self._still_since is None:
            self._still_since = now
        self._measured = now
        self._note_contact()

    def still_since(self, start: float) -> float | None:
        """Since when all velocities have been zero, at the earliest since `start`; None if they are not, or
        none has arrived after it. By their arrival: in a slow network they may be older."""
        since = self._still_since
        return None if since is None or self._measured <= start else max(since, start)

    def _note_contact(self) -> None:
        self.heard = time.monotonic()
        self._motion_changed()

    def _on_battery(self, battery: Battery) -> None:
        facts = self._facts
        before = (facts.percent is None, facts.charging)
        facts.percent, facts.voltage = float(battery.percent), battery.voltage if battery.measured else None
        facts.charging = battery.charging
        if before != (False, facts.charging):
            self._flag("status")

    def _on_parameters(self, parameters: Parameters) -> None:
        if parameters != self.parameters:
            self.parameters = parameters
            self._flag("parameters")

    def _on_path(self, path: DynamicMessage) -> None:
        """Keep at most `MAX_CORNERS` corners; a path in another frame than the map is ignored."""
        poses, frame = path.poses, path.header.frame_id.lstrip("/")
        step = math.ceil(len(poses) / MAX_CORNERS) or 1
        kept = [*poses[:-1:step], *poses[-1:]]  # with the last one, whatever the step
        points = ((pose.pose.position.x, pose.pose.position.y) for pose in kept)
        self._facts.path = tuple(points) if frame in ("map", "") else ()
        self._path_changed()

    def refresh(self, owner: str = "") -> None:
        """Update mode, faults, emergency stop and localisation. Must not be called in a feed's callback.

        Args:
            owner: The local driver; "" if there is none.
        """
        facts = self._facts
        try:
            readiness, faults = self._chassis.readiness(), self._chassis.faults
        except RosError:
            return  # closed, or its master is gone: reported as lost contact
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
        self.blocked = str(readiness) if readiness.refuses else ""


class StandingCheck:
    """Makes sure that a robot whose velocities are zero stands, by velocities that it sends from then on.

    Args:
        chassis: The chassis.
        done: Called when it was measured standing, in another thread.

    Attributes:
        since: The `still_since` for which it was measured.
    """

    def __init__(self, chassis: Chassis, done: Callable[[], object]) -> None:
        self._chassis, self._done = chassis, done
        self._thread: threading.Thread | None = None
        self.since: float | None = None

    def begin(self, since: float) -> None:
        """Measure in a thread, unless one does already; returns at once."""
        if self._thread is None or not self._thread.is_alive():
            self._thread = threading.Thread(
                target=self._measure, args=(since,), name="woosh:standing", daemon=True
            )
            self._thread.start()

    def _measure(self, since: float) -> None:
        feeds = components_of(self._chassis).feeds
        if feeds.wait_standing(_STANDING_SECONDS, steady=STILL):
            self.since = since
            self._done()


# -- the maxSpeed of an edge ---------------------------------------------------------------------------------

_SLOWING_SECONDS = 2.0  # from the start of a drive, for the robot to slow down to the speed of its edge
_EXCEEDED_SECONDS = 0.3  # before a drive counts as too fast
_FACTOR, _MARGIN = 1.1, 0.05  # overshoot of the controller that is tolerated: of the limit, and m/s


def speed_above_limit(drive: Drive | None, velocity: tuple[float, float, float] | None) -> float:
    """The speed in m/s if it exceeds the maxSpeed of the edge, else 0.

    Args:
        drive: The drive under way.
        velocity: vx, vy in m/s, wz in rad/s; None if it is not known.
    """
    limit = 0.0 if drive is None or drive.edge is None else float(drive.edge.options.get("maxSpeed", 0.0))
    speed = 0.0 if velocity is None else math.hypot(velocity[0], velocity[1])
    return speed if limit and speed > _FACTOR * limit + _MARGIN else 0.0


class EdgeSpeedMonitor:
    """Detects drives that stay above the maxSpeed of their edge."""

    def __init__(self) -> None:
        self._began = 0.0
        self._above_since: float | None = None

    def must_check(self, drive: Drive | None, velocity: tuple[float, float, float] | None) -> bool:
        """Whether the speed is above the limit, or was at the last check."""
        return self._above_since is not None or speed_above_limit(drive, velocity) > 0.0

    def drive_began(self, now: float) -> None:
        """Start the time in which the robot may slow down; `now` is monotonic."""
        self._began = now

    def check(
        self, drive: Drive | None, velocity: tuple[float, float, float] | None, now: float
    ) -> str | None:
        """Return what is wrong if the drive has been too fast for too long, else None."""
        speed = speed_above_limit(drive, velocity)
        if not speed:
            self._above_since = None
            return None
        if self._above_since is None:
            self._above_since = max(now, self._began + _SLOWING_SECONDS)
        if now - self._above_since < _EXCEEDED_SECONDS:
            return None
        assert drive is not None
        assert drive.edge is not None
        limit = drive.edge.options["maxSpeed"]
        return f"it drove at {speed:.2f} m/s, and edge {drive.edge.id} allows {limit:g} m/s; it is halted"


# -- the footprint -------------------------------------------------------------------------------------------

_OUTLINES = ("/move_base/global_costmap", "/move_base/local_costmap")


def navigation_footprint(chassis: Chassis) -> tuple[tuple[float, float], ...]:
    """The footprint in the parameters of the chassis's navigation, in m in base_link; empty if there is none.

    The parameters are those of costmap_2d: `footprint`, a list of corners or its text, or `robot_radius`.
    """
    for space in _OUTLINES:
        try:
            corners = _parameter(chassis, f"{space}/footprint")
            if isinstance(corners, str):
                corners = json.loads(corners.replace("(", "[").replace(")", "]"))
            if corners:
                return Footprint.from_points(corners).points
            radius = _parameter(chassis, f"{space}/robot_radius")
            if radius:
                return Footprint.circle(float(radius)).points
        except (RosError, ValueError, TypeError):
            continue
    return ()


def _parameter(chassis: Chassis, name: str) -> Any:
    try:
        return chassis.node.params[name]
    except KeyError:
        return None
