# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of actionlib as classes."""

from typing import ClassVar as _ClassVar

import msgdefs.actionlib_msgs.msg as _actionlib_msgs
import msgdefs.std_msgs.msg as _std_msgs
from rosproto.codec import Message as _Message
from rosproto.time import Duration as _Duration

class TestAction(_Message):
    """actionlib/TestAction
    """

    action_goal: TestActionGoal
    action_result: TestActionResult
    action_feedback: TestActionFeedback
    def __init__(
        self,
        action_goal: TestActionGoal = ...,
        action_result: TestActionResult = ...,
        action_feedback: TestActionFeedback = ...,
    ) -> None: ...

class TestActionFeedback(_Message):
    """actionlib/TestActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: TestFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: TestFeedback = ...,
    ) -> None: ...

class TestActionGoal(_Message):
    """actionlib/TestActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: TestGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: TestGoal = ...,
    ) -> None: ...

class TestActionResult(_Message):
    """actionlib/TestActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: TestResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: TestResult = ...,
    ) -> None: ...

class TestFeedback(_Message):
    """actionlib/TestFeedback

    int32 feedback
    """

    feedback: int
    def __init__(
        self,
        feedback: int = ...,
    ) -> None: ...

class TestGoal(_Message):
    """actionlib/TestGoal

    int32 goal
    """

    goal: int
    def __init__(
        self,
        goal: int = ...,
    ) -> None: ...

class TestRequestAction(_Message):
    """actionlib/TestRequestAction
    """

    action_goal: TestRequestActionGoal
    action_result: TestRequestActionResult
    action_feedback: TestRequestActionFeedback
    def __init__(
        self,
        action_goal: TestRequestActionGoal = ...,
        action_result: TestRequestActionResult = ...,
        action_feedback: TestRequestActionFeedback = ...,
    ) -> None: ...

class TestRequestActionFeedback(_Message):
    """actionlib/TestRequestActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: TestRequestFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: TestRequestFeedback = ...,
    ) -> None: ...

class TestRequestActionGoal(_Message):
    """actionlib/TestRequestActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: TestRequestGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: TestRequestGoal = ...,
    ) -> None: ...

class TestRequestActionResult(_Message):
    """actionlib/TestRequestActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: TestRequestResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: TestRequestResult = ...,
    ) -> None: ...

class TestRequestFeedback(_Message):
    """actionlib/TestRequestFeedback
    """

    def __init__(self) -> None: ...

class TestRequestGoal(_Message):
    """actionlib/TestRequestGoal

    int32 TERMINATE_SUCCESS=0
    int32 TERMINATE_ABORTED=1
    int32 TERMINATE_REJECTED=2
    int32 TERMINATE_LOSE=3
    int32 TERMINATE_DROP=4
    int32 TERMINATE_EXCEPTION=5

    int32 terminate_status
    bool ignore_cancel
    string result_text
    int32 the_result
    bool is_simple_client
    duration delay_accept
    duration delay_terminate
    duration pause_status
    """

    TERMINATE_SUCCESS: _ClassVar[int] = 0
    TERMINATE_ABORTED: _ClassVar[int] = 1
    TERMINATE_REJECTED: _ClassVar[int] = 2
    TERMINATE_LOSE: _ClassVar[int] = 3
    TERMINATE_DROP: _ClassVar[int] = 4
    TERMINATE_EXCEPTION: _ClassVar[int] = 5
    terminate_status: int
    ignore_cancel: bool
    result_text: str
    the_result: int
    is_simple_client: bool
    delay_accept: _Duration
    delay_terminate: _Duration
    pause_status: _Duration
    def __init__(
        self,
        terminate_status: int = ...,
        ignore_cancel: bool = ...,
        result_text: str = ...,
        the_result: int = ...,
        is_simple_client: bool = ...,
        delay_accept: _Duration = ...,
        delay_terminate: _Duration = ...,
        pause_status: _Duration = ...,
    ) -> None: ...

class TestRequestResult(_Message):
    """actionlib/TestRequestResult

    int32 the_result
    bool is_simple_server
    """

    the_result: int
    is_simple_server: bool
    def __init__(
        self,
        the_result: int = ...,
        is_simple_server: bool = ...,
    ) -> None: ...

class TestResult(_Message):
    """actionlib/TestResult

    int32 result
    """

    result: int
    def __init__(
        self,
        result: int = ...,
    ) -> None: ...

class TwoIntsAction(_Message):
    """actionlib/TwoIntsAction
    """

    action_goal: TwoIntsActionGoal
    action_result: TwoIntsActionResult
    action_feedback: TwoIntsActionFeedback
    def __init__(
        self,
        action_goal: TwoIntsActionGoal = ...,
        action_result: TwoIntsActionResult = ...,
        action_feedback: TwoIntsActionFeedback = ...,
    ) -> None: ...

class TwoIntsActionFeedback(_Message):
    """actionlib/TwoIntsActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: TwoIntsFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: TwoIntsFeedback = ...,
    ) -> None: ...

class TwoIntsActionGoal(_Message):
    """actionlib/TwoIntsActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: TwoIntsGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: TwoIntsGoal = ...,
    ) -> None: ...

class TwoIntsActionResult(_Message):
    """actionlib/TwoIntsActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: TwoIntsResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: TwoIntsResult = ...,
    ) -> None: ...

class TwoIntsFeedback(_Message):
    """actionlib/TwoIntsFeedback
    """

    def __init__(self) -> None: ...

class TwoIntsGoal(_Message):
    """actionlib/TwoIntsGoal

    int64 a
    int64 b
    """

    a: int
    b: int
    def __init__(
        self,
        a: int = ...,
        b: int = ...,
    ) -> None: ...

class TwoIntsResult(_Message):
    """actionlib/TwoIntsResult

    int64 sum
    """

    sum: int
    def __init__(
        self,
        sum: int = ...,
    ) -> None: ...
