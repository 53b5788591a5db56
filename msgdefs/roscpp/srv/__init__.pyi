# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of roscpp as classes."""

from collections.abc import Sequence as _Sequence
from typing import TypeAlias as _TypeAlias

import msgdefs.roscpp.msg as _roscpp
from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType

class EmptyRequest(_Message):
    """roscpp/EmptyRequest
    """

    def __init__(self) -> None: ...

class EmptyResponse(_Message):
    """roscpp/EmptyResponse
    """

    def __init__(self) -> None: ...

class Empty(_ServiceType):
    """roscpp/Empty
    """

    Request: _TypeAlias = EmptyRequest
    Response: _TypeAlias = EmptyResponse

class GetLoggersRequest(_Message):
    """roscpp/GetLoggersRequest
    """

    def __init__(self) -> None: ...

class GetLoggersResponse(_Message):
    """roscpp/GetLoggersResponse

    Logger[] loggers
    """

    loggers: list[_roscpp.Logger]
    def __init__(
        self,
        loggers: _Sequence[_roscpp.Logger] = ...,
    ) -> None: ...

class GetLoggers(_ServiceType):
    """roscpp/GetLoggers
    """

    Request: _TypeAlias = GetLoggersRequest
    Response: _TypeAlias = GetLoggersResponse

class SetLoggerLevelRequest(_Message):
    """roscpp/SetLoggerLevelRequest

    string logger
    string level
    """

    logger: str
    level: str
    def __init__(
        self,
        logger: str = ...,
        level: str = ...,
    ) -> None: ...

class SetLoggerLevelResponse(_Message):
    """roscpp/SetLoggerLevelResponse
    """

    def __init__(self) -> None: ...

class SetLoggerLevel(_ServiceType):
    """roscpp/SetLoggerLevel
    """

    Request: _TypeAlias = SetLoggerLevelRequest
    Response: _TypeAlias = SetLoggerLevelResponse
