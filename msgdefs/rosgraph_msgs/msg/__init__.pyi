# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of rosgraph_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import ClassVar as _ClassVar

import msgdefs.std_msgs.msg as _std_msgs
from rosproto.codec import Message as _Message
from rosproto.time import Duration as _Duration
from rosproto.time import Time as _Time

class Clock(_Message):
    """rosgraph_msgs/Clock

    # Simulated time, published on /clock.

    time clock  # now
    """

    clock: _Time
    def __init__(
        self,
        clock: _Time = ...,
    ) -> None: ...

class Log(_Message):
    """rosgraph_msgs/Log

    # One line of a node's log, published on /rosout.

    byte DEBUG=1
    byte INFO=2
    byte WARN=4
    byte ERROR=8
    byte FATAL=16

    Header header
    byte level       # one of the constants
    string name      # node
    string msg       # the line
    string file      # source file
    string function  # in it
    uint32 line      # in the file
    string[] topics  # what the node publishes
    """

    DEBUG: _ClassVar[int] = 1
    INFO: _ClassVar[int] = 2
    WARN: _ClassVar[int] = 4
    ERROR: _ClassVar[int] = 8
    FATAL: _ClassVar[int] = 16
    header: _std_msgs.Header
    level: int
    name: str
    msg: str
    file: str
    function: str
    line: int
    topics: list[str]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        level: int = ...,
        name: str = ...,
        msg: str = ...,
        file: str = ...,
        function: str = ...,
        line: int = ...,
        topics: _Sequence[str] = ...,
    ) -> None: ...

class TopicStatistics(_Message):
    """rosgraph_msgs/TopicStatistics

    # What a subscriber saw on one link during a window of time.

    string topic
    string node_pub            # publishing node
    string node_sub            # subscribing node
    time window_start
    time window_stop
    int32 delivered_msgs
    int32 dropped_msgs
    int32 traffic              # bytes
    duration period_mean       # between messages
    duration period_stddev
    duration period_max
    duration stamp_age_mean    # from header stamp to arrival; 0 without a header
    duration stamp_age_stddev
    duration stamp_age_max
    """

    topic: str
    node_pub: str
    node_sub: str
    window_start: _Time
    window_stop: _Time
    delivered_msgs: int
    dropped_msgs: int
    traffic: int
    period_mean: _Duration
    period_stddev: _Duration
    period_max: _Duration
    stamp_age_mean: _Duration
    stamp_age_stddev: _Duration
    stamp_age_max: _Duration
    def __init__(
        self,
        topic: str = ...,
        node_pub: str = ...,
        node_sub: str = ...,
        window_start: _Time = ...,
        window_stop: _Time = ...,
        delivered_msgs: int = ...,
        dropped_msgs: int = ...,
        traffic: int = ...,
        period_mean: _Duration = ...,
        period_stddev: _Duration = ...,
        period_max: _Duration = ...,
        stamp_age_mean: _Duration = ...,
        stamp_age_stddev: _Duration = ...,
        stamp_age_max: _Duration = ...,
    ) -> None: ...
