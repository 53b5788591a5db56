"""The newer rosbridge's action operations in the terms of ROS 1's actionlib: names of types, states of goals.

The operations come from rosbridge for ROS 2, whose clients (roslib, roslibpy, ros-mcp) name an action's type
as `package/action/Name` or `package/Name` and read states by action_msgs/GoalStatus.
"""

from __future__ import annotations

from enum import IntEnum

from rosproto.protocol.goal_status import GoalStatus

__all__ = ["ActionStatus", "action_status", "action_type", "definition_name"]


class ActionStatus(IntEnum):
    """The states of action_msgs/GoalStatus, which `action_result` speaks."""

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
    """The state that a client is told for one of actionlib's; UNKNOWN for a number that is none."""
    try:
        return _OF_GOAL[GoalStatus(status)]
    except ValueError:
        return ActionStatus.UNKNOWN


def definition_name(name: str) -> str:
    """The name of a message or service type as ROS 1 has it, also for ROS 2's `std_msgs/msg/String`.

    Superfluous slashes go, as in rosbridge. What is no such name comes back as it is, for whoever looks it up
    to say so.
    """
    parts = [part for part in name.split("/") if part]
    if len(parts) == 3 and parts[1] in ("msg", "srv", "action"):
        del parts[1]
    return "/".join(parts) if len(parts) == 2 else name


def action_type(name: str) -> str:
    """The action message type for what a client calls the type: `pkg/Name`, `pkg/NameAction` or ROS 2's.

    Also the name of its goal (`MoveBaseGoal`, `MoveBaseActionGoal`), which old pages ask for.
    """
    base = definition_name(name)
    for ending in ("ActionGoal", "Goal", "Action"):
        if base.endswith(ending) and not base.endswith(f"/{ending}"):
            return f"{base[: -len(ending)]}Action"
    return f"{base}Action"
