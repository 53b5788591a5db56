"""Maps type names and goal states of rosbridge's action operations, which are ROS 2's, to actionlib's.

The operations come from rosbridge for ROS 2. Its clients (roslib, roslibpy, ros-mcp) write an action's type
as `package/action/Name` or `package/Name`, and expect the states of action_msgs/GoalStatus.
"""

from __future__ import annotations

from enum import IntEnum

from rosproto.gateway.values import definition_name
from rosproto.protocol.goal_status import GoalStatus


class ActionStatus(IntEnum):
    """The states of action_msgs/GoalStatus, as used in `action_result`."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6


_OF_GOAL: dict[int, ActionStatus] = {
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
    """The state for a client, from actionlib's; UNKNOWN for any other number."""
    return _OF_GOAL.get(status, ActionStatus.UNKNOWN)


def action_type(name: str) -> str:
    """The action message type for a client's type name: `pkg/Name`, `pkg/NameAction` or ROS 2's form.

    Old pages use the type of the goal (`MoveBaseGoal`, `MoveBaseActionGoal`).
    """
    base = definition_name(name)
    for ending in ("ActionGoal", "Goal", "Action"):
        if base.endswith(ending) and not base.endswith(f"/{ending}"):
            return f"{base[: -len(ending)]}Action"
    return f"{base}Action"
