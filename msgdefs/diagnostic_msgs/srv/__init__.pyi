# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of diagnostic_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import TypeAlias as _TypeAlias

import msgdefs.diagnostic_msgs.msg as _diagnostic_msgs
from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType

class AddDiagnosticsRequest(_Message):
    """diagnostic_msgs/AddDiagnosticsRequest

    string load_namespace
    """

    load_namespace: str
    def __init__(
        self,
        load_namespace: str = ...,
    ) -> None: ...

class AddDiagnosticsResponse(_Message):
    """diagnostic_msgs/AddDiagnosticsResponse

    bool success
    string message
    """

    success: bool
    message: str
    def __init__(
        self,
        success: bool = ...,
        message: str = ...,
    ) -> None: ...

class AddDiagnostics(_ServiceType):
    """diagnostic_msgs/AddDiagnostics
    """

    Request: _TypeAlias = AddDiagnosticsRequest
    Response: _TypeAlias = AddDiagnosticsResponse

class SelfTestRequest(_Message):
    """diagnostic_msgs/SelfTestRequest
    """

    def __init__(self) -> None: ...

class SelfTestResponse(_Message):
    """diagnostic_msgs/SelfTestResponse

    string id
    byte passed
    DiagnosticStatus[] status
    """

    id: str
    passed: int
    status: list[_diagnostic_msgs.DiagnosticStatus]
    def __init__(
        self,
        id: str = ...,
        passed: int = ...,
        status: _Sequence[_diagnostic_msgs.DiagnosticStatus] = ...,
    ) -> None: ...

class SelfTest(_ServiceType):
    """diagnostic_msgs/SelfTest
    """

    Request: _TypeAlias = SelfTestRequest
    Response: _TypeAlias = SelfTestResponse
