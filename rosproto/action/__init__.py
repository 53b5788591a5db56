"""Actions: long-running goals with feedback and cancelling, over a node (actionlib's protocol)."""

from rosproto.action.client import ActionClient
from rosproto.action.goal_handle import GoalHandle
from rosproto.action.server import ActionServer, ServerGoal
from rosproto.action.types import ActionType, action_type
from rosproto.protocol.goal_client import CommState
from rosproto.protocol.goal_status import GoalStatus

__all__ = [
    "ActionClient",
    "ActionServer",
    "ActionType",
    "CommState",
    "GoalHandle",
    "GoalStatus",
    "ServerGoal",
    "action_type",
]
