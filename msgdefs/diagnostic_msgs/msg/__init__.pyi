# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of diagnostic_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import ClassVar as _ClassVar

import msgdefs.std_msgs.msg as _std_msgs
from rosproto.codec import Message as _Message

class DiagnosticArray(_Message):
    """diagnostic_msgs/DiagnosticArray

    # States of components at one time.

    Header header
    DiagnosticStatus[] status
    """

    header: _std_msgs.Header
    status: list[DiagnosticStatus]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _Sequence[DiagnosticStatus] = ...,
    ) -> None: ...

class DiagnosticStatus(_Message):
    """diagnostic_msgs/DiagnosticStatus

    # State of one component.

    byte OK=0
    byte WARN=1
    byte ERROR=2
    byte STALE=3

    byte level          # OK, WARN, ERROR or STALE
    string name         # of the component
    string message      # for a person
    string hardware_id  # of the device
    KeyValue[] values   # facts behind it
    """

    OK: _ClassVar[int] = 0
    WARN: _ClassVar[int] = 1
    ERROR: _ClassVar[int] = 2
    STALE: _ClassVar[int] = 3
    level: int
    name: str
    message: str
    hardware_id: str
    values: list[KeyValue]
    def __init__(
        self,
        level: int = ...,
        name: str = ...,
        message: str = ...,
        hardware_id: str = ...,
        values: _Sequence[KeyValue] = ...,
    ) -> None: ...

class KeyValue(_Message):
    """diagnostic_msgs/KeyValue

    # One fact.

    string key
    string value
    """

    key: str
    value: str
    def __init__(
        self,
        key: str = ...,
        value: str = ...,
    ) -> None: ...
