"""Maps newer rosbridge's action operations to ROS 1's actionlib: names of types and states of goals.

The operations come from rosbridge for ROS 2. Its clients (roslib, roslibpy, ros-mcp) write an action's type
as `package/action/Name` or `package/Name`, and expect the states of action_msgs/GoalStatus.
"""

from __future__ import annotations

from enum import IntEnum

from rosproto.protocol.goal_status import GoalStatus

__all__ = ["ActionStatus", "action_status", "action_type", "definition_name"]


class ActionStatus(IntEnum):
    """The states of action_msgs/GoalStatus, as used in `action_result`."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6


_OF_GOAL = {
    GoalStatus.PENDING: ActionStatus.ACCEPTED,
    GoalStatus.ACTIVE: ActionStatus.EXECUTING,
    GoalStatus.PREEMPTING: ActionStatus.CANCELING,
    GoalStatus.RECALLING: ActionStatus.CANCELING,
    GoalStatus.SUCCEEDED: ActionStatus.SUCCEEDED,
    GoalStatus.PREEMPTED: ActionStatus.CANCELED,
    GoalStatus.RECALLED: ActionStatus.CANCELED,
    GoalStatus.ABORTED: ActionStatus.ABORTED,
    GoalStatus.REJECTED: ActionStatus.ABORTED,
    GoalStatus.LOST: ActionStatus.UNKNOWN,
}


def action_status(status: int) -> ActionStatus:
    """The state reported to a client for one of actionlib's; UNKNOWN for any other number."""
    try:
        return _OF_GOAL[GoalStatus(status)]
    except ValueError:
        return ActionStatus.UNKNOWN


def definition_name(name: str) -> str:
    """The name of a message or service type in ROS 1's form, also from ROS 2's `std_msgs/msg/String`.

    Extra slashes are removed, as in rosbridge. Anything else is returned unchanged, and looking it up then
    reports the error.
    """
    parts = [part for part in name.split("/") if part]
    if len(parts) == 3 and parts[1] in ("msg", "srv", "action"):
        del parts[1]
    return "/".join(parts) if len(parts) == 2 else name


def action_type(name: str) -> str:
    """The action message type for a client's name of it: `pkg/Name`, `pkg/NameAction` or ROS 2's form.

    Also accepts the name of its goal (`MoveBaseGoal`, `MoveBaseActionGoal`), which old pages use.
    """
    base = definition_name(name)
    for ending in ("ActionGoal", "Goal", "Action"):
        if base.endswith(ending) and not base.endswith(f"/{ending}"):
            return f"{base[: -len(ending)]}Action"
    return f"{base}Action"
