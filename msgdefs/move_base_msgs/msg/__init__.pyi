# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of move_base_msgs as classes."""

import msgdefs.actionlib_msgs.msg as _actionlib_msgs
import msgdefs.geometry_msgs.msg as _geometry_msgs
import msgdefs.std_msgs.msg as _std_msgs
from rosproto.codec import Message as _Message

class MoveBaseAction(_Message):
    """move_base_msgs/MoveBaseAction
    """

    action_goal: MoveBaseActionGoal
    action_result: MoveBaseActionResult
    action_feedback: MoveBaseActionFeedback
    def __init__(
        self,
        action_goal: MoveBaseActionGoal = ...,
        action_result: MoveBaseActionResult = ...,
        action_feedback: MoveBaseActionFeedback = ...,
    ) -> None: ...

class MoveBaseActionFeedback(_Message):
    """move_base_msgs/MoveBaseActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: MoveBaseFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: MoveBaseFeedback = ...,
    ) -> None: ...

class MoveBaseActionGoal(_Message):
    """move_base_msgs/MoveBaseActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: MoveBaseGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: MoveBaseGoal = ...,
    ) -> None: ...

class MoveBaseActionResult(_Message):
    """move_base_msgs/MoveBaseActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: MoveBaseResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: MoveBaseResult = ...,
    ) -> None: ...

class MoveBaseFeedback(_Message):
    """move_base_msgs/MoveBaseFeedback

    geometry_msgs/PoseStamped base_position
    """

    base_position: _geometry_msgs.PoseStamped
    def __init__(
        self,
        base_position: _geometry_msgs.PoseStamped = ...,
    ) -> None: ...

class MoveBaseGoal(_Message):
    """move_base_msgs/MoveBaseGoal

    geometry_msgs/PoseStamped target_pose
    """

    target_pose: _geometry_msgs.PoseStamped
    def __init__(
        self,
        target_pose: _geometry_msgs.PoseStamped = ...,
    ) -> None: ...

class MoveBaseResult(_Message):
    """move_base_msgs/MoveBaseResult
    """

    def __init__(self) -> None: ...

class RecoveryStatus(_Message):
    """move_base_msgs/RecoveryStatus

    geometry_msgs/PoseStamped pose_stamped
    uint16 current_recovery_number
    uint16 total_number_of_recoveries
    string recovery_behavior_name
    """

    pose_stamped: _geometry_msgs.PoseStamped
    current_recovery_number: int
    total_number_of_recoveries: int
    recovery_behavior_name: str
    def __init__(
        self,
        pose_stamped: _geometry_msgs.PoseStamped = ...,
        current_recovery_number: int = ...,
        total_number_of_recoveries: int = ...,
        recovery_behavior_name: str = ...,
    ) -> None: ...
