"""actionlib: action clients and servers over rospy."""

from .action_client import (
    ActionClient,
    ClientGoalHandle,
    CommState,
    CommStateMachine,
    GoalID,
    GoalManager,
    GoalStatus,
    GoalStatusArray,
    TerminalState,
    get_name_of_constant,
)
from .action_server import ActionServer
from .exceptions import ActionException
from .server_goal_handle import ServerGoalHandle
from .simple_action_client import SimpleActionClient, SimpleGoalState
from .simple_action_server import SimpleActionServer
