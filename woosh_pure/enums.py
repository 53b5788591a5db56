"""The chassis's numbers as enums. An unknown number is kept under the name UNKNOWN_<n>.

Source: woosh_msgs 1.1.4 and the vendor's interface page; members marked "manual" come from the vendor's
later manual and were not seen on this interface.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TypeVar

from rosproto.coercion import whole
from rosproto.sentence import both, say

__all__ = [
    "COLOURS",
    "ActionState",
    "ActionType",
    "ChargeMode",
    "ChargeStatus",
    "Direction",
    "ExecutionMode",
    "LedState",
    "NavDirection",
    "NavigationMode",
    "RobotMode",
    "RobotState",
    "StepControlMode",
    "StepMode",
    "TaskCommand",
    "TaskState",
    "TaskType",
    "WorkMode",
]

_E = TypeVar("_E", bound="_OpenIntEnum")


class _OpenIntEnum(IntEnum):
    """An enum that firmware may extend: an unknown number becomes a pseudo-member instead of an error."""

    @classmethod
    def _missing_(cls: type[_E], value: object) -> _E:
        number = whole(value)
        if number is None:
            members = say("one of: {names}", names=[f"{cls.__name__}.{m.name}" for m in cls])
            raise ValueError(
                both(say("{value!r} is not a valid {noun}", value=value, noun=cls.__name__), members)
            )
        member = int.__new__(cls, number)
        member._name_ = f"UNKNOWN_{number}"
        member._value_ = number
        return member

    @property
    def known(self) -> bool:
        """False for a number without a name in this version."""
        return not self.name.startswith("UNKNOWN_")

    def __str__(self) -> str:
        return self.name.lower().replace("_", " ")


class TaskType(_OpenIntEnum):
    """RobotStatus.task_type, ExecTask.task_type."""

    UNDEFINED = 0
    PICK = 1
    PARK = 2
    CHARGE = 3
    CARRY = 4


class TaskState(_OpenIntEnum):
    """RobotStatus.task_state."""

    UNDEFINED = 0
    INITIALISING = 1  # manual
    PREPARED = 2  # manual
    RUNNING = 3
    PAUSED = 4
    WAITING_FOR_ACTION = 5
    WAITING_FOR_TASK = 6  # manual
    COMPLETED = 7
    CANCELLED = 8
    FAILED = 9

    @property
    def is_final(self) -> bool:
        """True when the task is over, with any outcome."""
        return self in (TaskState.COMPLETED, TaskState.CANCELLED, TaskState.FAILED)

    @property
    def is_under_way(self) -> bool:
        """True while the task runs, is paused, or waits."""
        return self in (TaskState.RUNNING, TaskState.PAUSED, TaskState.WAITING_FOR_ACTION)


class ActionType(_OpenIntEnum):
    """RobotStatus.action_type: what the task is doing just now."""

    UNDEFINED = 0
    NAVIGATION = 1
    STEP_CONTROL = 2
    SECONDARY_POSITIONING_ENTER = 3
    SECONDARY_POSITIONING_LEAVE = 4
    CARRY_ACTION = 5
    WAIT = 6
    CHARGE = 7


class ActionState(_OpenIntEnum):
    """RobotStatus.action_state."""

    UNDEFINED = 0
    RUNNING = 1
    WARNING = 2
    CANCELLED = 3
    DONE = 4
    FAILED = 5
    PAUSED = 10
    TRAFFIC_CONTROLLED = 11


class RobotState(_OpenIntEnum):
    """RobotStatus.robot_state, ExecTask.statusCode."""

    UNDEFINED = 0
    UNINITIALISED = 1
    IDLE = 2
    PARKING = 3
    IN_TASK = 4
    WARNING = 5
    FAULT = 6
    FOLLOWING = 7  # manual
    CHARGING = 8
    MAPPING = 9


class RobotMode(_OpenIntEnum):
    """RobotStatus.robot_mode."""

    UNDEFINED = 0
    AUTOMATIC = 1
    MANUAL = 2
    MAINTENANCE = 3


class WorkMode(_OpenIntEnum):
    """RobotStatus.work_mode."""

    UNDEFINED = 0
    DEPLOYMENT = 1
    TASK = 2
    DISPATCH = 3


class ChargeMode(_OpenIntEnum):
    """Battery.chargeMode: how charging was started."""

    MANUAL = 0
    AUTOMATIC = 1


class ChargeStatus(_OpenIntEnum):
    """Battery.chargeStatus."""

    NOT_CHARGING = 0
    CHARGING = 1


class TaskCommand(_OpenIntEnum):
    """ExecTask.task_exect."""

    EXECUTE = 1
    PAUSE = 2
    RESUME = 3
    CANCEL = 4
    INTERRUPT_WAIT = 6


class Direction(_OpenIntEnum):
    """ExecTask.direction: UNDEFINED unless something is loaded or unloaded."""

    UNDEFINED = 0
    LOAD = 1
    UNLOAD = 2


class ExecutionMode(_OpenIntEnum):
    """MoveBaseGoal.execution_mode: how a given path is driven."""

    FREE = 0
    POINT_BY_POINT = 1


class StepControlMode(_OpenIntEnum):
    """StepControlGoal.mode (the vendor writes EXCUTE and RESUM)."""

    CANCEL = 0
    EXECUTE = 1
    PAUSE = 2
    RESUME = 3


class StepMode(_OpenIntEnum):
    """StepControl.executeMode."""

    STRAIGHT = 1
    ROTATE = 2
    LATERAL = 3
    DIAGONAL = 4


class NavigationMode(_OpenIntEnum):
    """NavigationModeGoal.navigation_mode: what is done about an obstacle on the way."""

    FUZZY_AVOIDANCE = 0
    PRECISE_AVOIDANCE = 1
    STOP_AND_WAIT = 2
    WAIT_THEN_AVOID = 3


class NavDirection(_OpenIntEnum):
    """NavigationModeGoal.nav_dir."""

    CHASSIS_DECIDES = 0
    FORWARD = 1
    BACKWARD = 2
    ALONG_PATH = 3


class LedState(_OpenIntEnum):
    """LED.normal: what the light strip shows."""

    NONE = 0x00
    LOW_BATTERY = 0x42
    FOLLOWING = 0x60
    FORWARD = 0x80
    RIGHT_TURN = 0x81
    LEFT_TURN = 0x82
    STARTING = 0x83
    STOPPED_WAITING = 0x84
    TRAFFIC_PAUSED = 0x85
    WARNING = 0xA0
    TASK_RUNNING = 0xA1
    TASK_PAUSED = 0xA2
    IDLE = 0xA3
    INITIALISING = 0xA4
    OFFLINE = 0xA5
    PICKING = 0xF0
    PICKING_DONE = 0xF1
    NORMAL = 0xFF


COLOURS = {
    "red": 0xFF0000, "orange": 0xFF8000, "yellow": 0xFFFF00, "green": 0x00FF00,
    "cyan": 0x00FFFF, "blue": 0x0000FF, "purple": 0x8000FF, "white": 0xFFFFFF,
}  # fmt: skip
"""Colours of the light strips by name, 24-bit RGB."""
