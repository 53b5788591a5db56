# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of tf2_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import ClassVar as _ClassVar

import msgdefs.actionlib_msgs.msg as _actionlib_msgs
import msgdefs.geometry_msgs.msg as _geometry_msgs
import msgdefs.std_msgs.msg as _std_msgs
from rosproto.codec import Message as _Message
from rosproto.time import Duration as _Duration
from rosproto.time import Time as _Time

class LookupTransformAction(_Message):
    """tf2_msgs/LookupTransformAction
    """

    action_goal: LookupTransformActionGoal
    action_result: LookupTransformActionResult
    action_feedback: LookupTransformActionFeedback
    def __init__(
        self,
        action_goal: LookupTransformActionGoal = ...,
        action_result: LookupTransformActionResult = ...,
        action_feedback: LookupTransformActionFeedback = ...,
    ) -> None: ...

class LookupTransformActionFeedback(_Message):
    """tf2_msgs/LookupTransformActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: LookupTransformFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: LookupTransformFeedback = ...,
    ) -> None: ...

class LookupTransformActionGoal(_Message):
    """tf2_msgs/LookupTransformActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: LookupTransformGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: LookupTransformGoal = ...,
    ) -> None: ...

class LookupTransformActionResult(_Message):
    """tf2_msgs/LookupTransformActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: LookupTransformResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: LookupTransformResult = ...,
    ) -> None: ...

class LookupTransformFeedback(_Message):
    """tf2_msgs/LookupTransformFeedback
    """

    def __init__(self) -> None: ...

class LookupTransformGoal(_Message):
    """tf2_msgs/LookupTransformGoal

    string target_frame
    string source_frame
    time source_time
    duration timeout
    time target_time
    string fixed_frame
    bool advanced
    """

    target_frame: str
    source_frame: str
    source_time: _Time
    timeout: _Duration
    target_time: _Time
    fixed_frame: str
    advanced: bool
    def __init__(
        self,
        target_frame: str = ...,
        source_frame: str = ...,
        source_time: _Time = ...,
        timeout: _Duration = ...,
        target_time: _Time = ...,
        fixed_frame: str = ...,
        advanced: bool = ...,
    ) -> None: ...

class LookupTransformResult(_Message):
    """tf2_msgs/LookupTransformResult

    geometry_msgs/TransformStamped transform
    TF2Error error
    """

    transform: _geometry_msgs.TransformStamped
    error: TF2Error
    def __init__(
        self,
        transform: _geometry_msgs.TransformStamped = ...,
        error: TF2Error = ...,
    ) -> None: ...

class TF2Error(_Message):
    """tf2_msgs/TF2Error

    uint8 NO_ERROR = 0
    uint8 LOOKUP_ERROR = 1
    uint8 CONNECTIVITY_ERROR = 2
    uint8 EXTRAPOLATION_ERROR = 3
    uint8 INVALID_ARGUMENT_ERROR = 4
    uint8 TIMEOUT_ERROR = 5
    uint8 TRANSFORM_ERROR = 6

    uint8 error
    string error_string
    """

    NO_ERROR: _ClassVar[int] = 0
    LOOKUP_ERROR: _ClassVar[int] = 1
    CONNECTIVITY_ERROR: _ClassVar[int] = 2
    EXTRAPOLATION_ERROR: _ClassVar[int] = 3
    INVALID_ARGUMENT_ERROR: _ClassVar[int] = 4
    TIMEOUT_ERROR: _ClassVar[int] = 5
    TRANSFORM_ERROR: _ClassVar[int] = 6
    error: int
    error_string: str
    def __init__(
        self,
        error: int = ...,
        error_string: str = ...,
    ) -> None: ...

class TFMessage(_Message):
    """tf2_msgs/TFMessage

    geometry_msgs/TransformStamped[] transforms
    """

    transforms: list[_geometry_msgs.TransformStamped]
    def __init__(
        self,
        transforms: _Sequence[_geometry_msgs.TransformStamped] = ...,
    ) -> None: ...
