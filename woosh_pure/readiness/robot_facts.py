"""What the robot says of itself by its Robot API, beside the reasons that ROS 1 gives. Pure.

The side that speaks against moving wins: reasons are added, and none of ROS that blocks is ended. What ends
is the doubt that nothing was heard yet, because the Robot API also tells an emergency stop that was pressed
before we connected. The doubt about a lost link stays: without that link, verbs would not work.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from rosproto.sentence import say
from woosh_pure.enums import RobotMode, RobotState
from woosh_pure.reasons import Reason, ReasonKey

if TYPE_CHECKING:
    from woosh_pure.robot_api.values import DeviceFacts

PRESSED = "the emergency stop is pressed; find out why, then turn the red button to release it"
MANUAL = "the robot is in {mode} mode; turn its key to automatic"
LOST = "the robot does not know where it is; give it its position"
FAULT = "the robot reports a fault; look at its display"
MAPPING = "the robot is making a map"
OCCUPIED = "the robot is marked as occupied; whoever did it may need it"
NOT_TASKABLE = "the robot takes no task now, and does not say why"
_SAYS_NOTHING = (RobotState.UNDEFINED, RobotState.UNINITIALISED)


def with_robot_facts(reasons: Iterable[Reason], facts: DeviceFacts | None) -> list[Reason]:
    """The reasons of ROS and of the Robot API; `facts` is None if they are not known or too old."""
    found = list(reasons)
    if facts is None:
        return found
    if facts.emergency_stop is not None and facts.robot_state not in _SAYS_NOTHING:
        found = [reason for reason in found if not (reason.key is ReasonKey.UNKNOWN and reason.doubt)]
    said = {reason.key for reason in found}
    return found + [reason for reason in _reasons(facts) if reason.key not in said]


def _reasons(facts: DeviceFacts) -> Iterable[Reason]:
    if facts.emergency_stop:
        yield Reason(ReasonKey.EMERGENCY_STOP, PRESSED)
    elif facts.robot_state is RobotState.FAULT:
        yield Reason(ReasonKey.FAULT, FAULT)
    if facts.robot_mode in (RobotMode.MANUAL, RobotMode.MAINTENANCE):
        yield Reason(ReasonKey.MANUAL_MODE, say(MANUAL, mode=facts.robot_mode))
    if facts.robot_state is RobotState.MAPPING:
        yield Reason(ReasonKey.MAPPING, MAPPING)
    if facts.localised is False:
        yield Reason(ReasonKey.NOT_LOCALISED, LOST, False)
    elif facts.taskable is False and facts.robot_state in (RobotState.IDLE, RobotState.CHARGING):
        yield Reason(ReasonKey.NOT_TASKABLE, NOT_TASKABLE, False)
    if facts.occupied:
        yield Reason(ReasonKey.OCCUPIED, OCCUPIED, False)
