# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of actionlib_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import ClassVar as _ClassVar

import msgdefs.std_msgs.msg as _std_msgs
from rosproto.codec import Message as _Message
from rosproto.time import Time as _Time

class GoalID(_Message):
    """actionlib_msgs/GoalID

    # Names one goal of an action.

    time stamp  # when it was made; in a cancel request: all goals up to this time, 0 for none
    string id   # unique among all clients; empty in a cancel request means all
    """

    stamp: _Time
    id: str
    def __init__(
        self,
        stamp: _Time = ...,
        id: str = ...,
    ) -> None: ...

class GoalStatus(_Message):
    """actionlib_msgs/GoalStatus

    # How far a goal has come.

    uint8 PENDING=0     # received, not yet begun
    uint8 ACTIVE=1      # being worked on
    uint8 PREEMPTED=2   # cancelled after it had begun; final
    uint8 SUCCEEDED=3   # reached; final
    uint8 ABORTED=4     # given up by the server; final
    uint8 REJECTED=5    # refused without being begun; final
    uint8 PREEMPTING=6  # cancel received while active
    uint8 RECALLING=7   # cancel received while pending
    uint8 RECALLED=8    # cancelled before it had begun; final
    uint8 LOST=9        # the client lost sight of it; never sent by a server

    GoalID goal_id
    uint8 status        # one of the constants
    string text         # for a person
    """

    PENDING: _ClassVar[int] = 0
    ACTIVE: _ClassVar[int] = 1
    PREEMPTED: _ClassVar[int] = 2
    SUCCEEDED: _ClassVar[int] = 3
    ABORTED: _ClassVar[int] = 4
    REJECTED: _ClassVar[int] = 5
    PREEMPTING: _ClassVar[int] = 6
    RECALLING: _ClassVar[int] = 7
    RECALLED: _ClassVar[int] = 8
    LOST: _ClassVar[int] = 9
    goal_id: GoalID
    status: int
    text: str
    def __init__(
        self,
        goal_id: GoalID = ...,
        status: int = ...,
        text: str = ...,
    ) -> None: ...

class GoalStatusArray(_Message):
    """actionlib_msgs/GoalStatusArray

    # All goals a server knows, finished ones for a few seconds. Sent at a steady rate, also when
    # empty.

    Header header
    GoalStatus[] status_list
    """

    header: _std_msgs.Header
    status_list: list[GoalStatus]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status_list: _Sequence[GoalStatus] = ...,
    ) -> None: ...
