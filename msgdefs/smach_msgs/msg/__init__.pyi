# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of smach_msgs as classes."""

from collections.abc import Sequence as _Sequence

import msgdefs.std_msgs.msg as _std_msgs
from rosproto.codec import Message as _Message

class SmachContainerInitialStatusCmd(_Message):
    """smach_msgs/SmachContainerInitialStatusCmd

    string path
    string[] initial_states
    string local_data
    """

    path: str
    initial_states: list[str]
    local_data: str
    def __init__(
        self,
        path: str = ...,
        initial_states: _Sequence[str] = ...,
        local_data: str = ...,
    ) -> None: ...

class SmachContainerStatus(_Message):
    """smach_msgs/SmachContainerStatus

    Header header
    string path
    string[] initial_states
    string[] active_states
    string local_data
    string info
    """

    header: _std_msgs.Header
    path: str
    initial_states: list[str]
    active_states: list[str]
    local_data: str
    info: str
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        path: str = ...,
        initial_states: _Sequence[str] = ...,
        active_states: _Sequence[str] = ...,
        local_data: str = ...,
        info: str = ...,
    ) -> None: ...

class SmachContainerStructure(_Message):
    """smach_msgs/SmachContainerStructure

    Header header
    string path
    string[] children
    string[] internal_outcomes
    string[] outcomes_from
    string[] outcomes_to
    string[] container_outcomes
    """

    header: _std_msgs.Header
    path: str
    children: list[str]
    internal_outcomes: list[str]
    outcomes_from: list[str]
    outcomes_to: list[str]
    container_outcomes: list[str]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        path: str = ...,
        children: _Sequence[str] = ...,
        internal_outcomes: _Sequence[str] = ...,
        outcomes_from: _Sequence[str] = ...,
        outcomes_to: _Sequence[str] = ...,
        container_outcomes: _Sequence[str] = ...,
    ) -> None: ...
