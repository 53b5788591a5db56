# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of tf2_web_republisher as classes."""

from collections.abc import Sequence as _Sequence

import msgdefs.actionlib_msgs.msg as _actionlib_msgs
import msgdefs.geometry_msgs.msg as _geometry_msgs
import msgdefs.std_msgs.msg as _std_msgs
from rosproto.codec import Message as _Message

class TFArray(_Message):
    """tf2_web_republisher/TFArray

    geometry_msgs/TransformStamped[] transforms
    """

    transforms: list[_geometry_msgs.TransformStamped]
    def __init__(
        self,
        transforms: _Sequence[_geometry_msgs.TransformStamped] = ...,
    ) -> None: ...

class TFSubscriptionAction(_Message):
    """tf2_web_republisher/TFSubscriptionAction
    """

    action_goal: TFSubscriptionActionGoal
    action_result: TFSubscriptionActionResult
    action_feedback: TFSubscriptionActionFeedback
    def __init__(
        self,
        action_goal: TFSubscriptionActionGoal = ...,
        action_result: TFSubscriptionActionResult = ...,
        action_feedback: TFSubscriptionActionFeedback = ...,
    ) -> None: ...

class TFSubscriptionActionFeedback(_Message):
    """tf2_web_republisher/TFSubscriptionActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: TFSubscriptionFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: TFSubscriptionFeedback = ...,
    ) -> None: ...

class TFSubscriptionActionGoal(_Message):
    """tf2_web_republisher/TFSubscriptionActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: TFSubscriptionGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: TFSubscriptionGoal = ...,
    ) -> None: ...

class TFSubscriptionActionResult(_Message):
    """tf2_web_republisher/TFSubscriptionActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: TFSubscriptionResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: TFSubscriptionResult = ...,
    ) -> None: ...

class TFSubscriptionFeedback(_Message):
    """tf2_web_republisher/TFSubscriptionFeedback

    geometry_msgs/TransformStamped[] transforms
    """

    transforms: list[_geometry_msgs.TransformStamped]
    def __init__(
        self,
        transforms: _Sequence[_geometry_msgs.TransformStamped] = ...,
    ) -> None: ...

class TFSubscriptionGoal(_Message):
    """tf2_web_republisher/TFSubscriptionGoal

    # Sends the transforms of some frames as feedback, until it is cancelled.
    string[] source_frames
    string target_frame
    float32 angular_thres   # rad that a frame has to turn before it is sent again
    float32 trans_thres     # m that it has to move
    float32 rate            # Hz
    """

    source_frames: list[str]
    target_frame: str
    angular_thres: float
    trans_thres: float
    rate: float
    def __init__(
        self,
        source_frames: _Sequence[str] = ...,
        target_frame: str = ...,
        angular_thres: float = ...,
        trans_thres: float = ...,
        rate: float = ...,
    ) -> None: ...

class TFSubscriptionResult(_Message):
    """tf2_web_republisher/TFSubscriptionResult
    """

    def __init__(self) -> None: ...
