# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of std_srvs as classes."""

from typing import TypeAlias as _TypeAlias

from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType

class EmptyRequest(_Message):
    """std_srvs/EmptyRequest
    """

    def __init__(self) -> None: ...

class EmptyResponse(_Message):
    """std_srvs/EmptyResponse
    """

    def __init__(self) -> None: ...

class Empty(_ServiceType):
    """std_srvs/Empty
    """

    Request: _TypeAlias = EmptyRequest
    Response: _TypeAlias = EmptyResponse

class SetBoolRequest(_Message):
    """std_srvs/SetBoolRequest

    # Switch something on or off.

    bool data  # true: on, start, enable
    """

    data: bool
    def __init__(
        self,
        data: bool = ...,
    ) -> None: ...

class SetBoolResponse(_Message):
    """std_srvs/SetBoolResponse

    bool success    # whether it was done
    string message  # why not, or what else there is to say
    """

    success: bool
    message: str
    def __init__(
        self,
        success: bool = ...,
        message: str = ...,
    ) -> None: ...

class SetBool(_ServiceType):
    """std_srvs/SetBool
    """

    Request: _TypeAlias = SetBoolRequest
    Response: _TypeAlias = SetBoolResponse

class TriggerRequest(_Message):
    """std_srvs/TriggerRequest

    # Make something happen that needs no arguments.
    """

    def __init__(self) -> None: ...

class TriggerResponse(_Message):
    """std_srvs/TriggerResponse

    bool success    # whether it was done
    string message  # why not, or what else there is to say
    """

    success: bool
    message: str
    def __init__(
        self,
        success: bool = ...,
        message: str = ...,
    ) -> None: ...

class Trigger(_ServiceType):
    """std_srvs/Trigger
    """

    Request: _TypeAlias = TriggerRequest
    Response: _TypeAlias = TriggerResponse
