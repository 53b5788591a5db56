# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of topic_tools as classes."""

from collections.abc import Sequence as _Sequence
from typing import TypeAlias as _TypeAlias

from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType

class DemuxAddRequest(_Message):
    """topic_tools/DemuxAddRequest

    string topic
    """

    topic: str
    def __init__(
        self,
        topic: str = ...,
    ) -> None: ...

class DemuxAddResponse(_Message):
    """topic_tools/DemuxAddResponse
    """

    def __init__(self) -> None: ...

class DemuxAdd(_ServiceType):
    """topic_tools/DemuxAdd
    """

    Request: _TypeAlias = DemuxAddRequest
    Response: _TypeAlias = DemuxAddResponse

class DemuxDeleteRequest(_Message):
    """topic_tools/DemuxDeleteRequest

    string topic
    """

    topic: str
    def __init__(
        self,
        topic: str = ...,
    ) -> None: ...

class DemuxDeleteResponse(_Message):
    """topic_tools/DemuxDeleteResponse
    """

    def __init__(self) -> None: ...

class DemuxDelete(_ServiceType):
    """topic_tools/DemuxDelete
    """

    Request: _TypeAlias = DemuxDeleteRequest
    Response: _TypeAlias = DemuxDeleteResponse

class DemuxListRequest(_Message):
    """topic_tools/DemuxListRequest
    """

    def __init__(self) -> None: ...

class DemuxListResponse(_Message):
    """topic_tools/DemuxListResponse

    string[] topics
    """

    topics: list[str]
    def __init__(
        self,
        topics: _Sequence[str] = ...,
    ) -> None: ...

class DemuxList(_ServiceType):
    """topic_tools/DemuxList
    """

    Request: _TypeAlias = DemuxListRequest
    Response: _TypeAlias = DemuxListResponse

class DemuxSelectRequest(_Message):
    """topic_tools/DemuxSelectRequest

    string topic
    """

    topic: str
    def __init__(
        self,
        topic: str = ...,
    ) -> None: ...

class DemuxSelectResponse(_Message):
    """topic_tools/DemuxSelectResponse

    string prev_topic
    """

    prev_topic: str
    def __init__(
        self,
        prev_topic: str = ...,
    ) -> None: ...

class DemuxSelect(_ServiceType):
    """topic_tools/DemuxSelect
    """

    Request: _TypeAlias = DemuxSelectRequest
    Response: _TypeAlias = DemuxSelectResponse

class MuxAddRequest(_Message):
    """topic_tools/MuxAddRequest

    string topic
    """

    topic: str
    def __init__(
        self,
        topic: str = ...,
    ) -> None: ...

class MuxAddResponse(_Message):
    """topic_tools/MuxAddResponse
    """

    def __init__(self) -> None: ...

class MuxAdd(_ServiceType):
    """topic_tools/MuxAdd
    """

    Request: _TypeAlias = MuxAddRequest
    Response: _TypeAlias = MuxAddResponse

class MuxDeleteRequest(_Message):
    """topic_tools/MuxDeleteRequest

    string topic
    """

    topic: str
    def __init__(
        self,
        topic: str = ...,
    ) -> None: ...

class MuxDeleteResponse(_Message):
    """topic_tools/MuxDeleteResponse
    """

    def __init__(self) -> None: ...

class MuxDelete(_ServiceType):
    """topic_tools/MuxDelete
    """

    Request: _TypeAlias = MuxDeleteRequest
    Response: _TypeAlias = MuxDeleteResponse

class MuxListRequest(_Message):
    """topic_tools/MuxListRequest
    """

    def __init__(self) -> None: ...

class MuxListResponse(_Message):
    """topic_tools/MuxListResponse

    string[] topics
    """

    topics: list[str]
    def __init__(
        self,
        topics: _Sequence[str] = ...,
    ) -> None: ...

class MuxList(_ServiceType):
    """topic_tools/MuxList
    """

    Request: _TypeAlias = MuxListRequest
    Response: _TypeAlias = MuxListResponse

class MuxSelectRequest(_Message):
    """topic_tools/MuxSelectRequest

    string topic
    """

    topic: str
    def __init__(
        self,
        topic: str = ...,
    ) -> None: ...

class MuxSelectResponse(_Message):
    """topic_tools/MuxSelectResponse

    string prev_topic
    """

    prev_topic: str
    def __init__(
        self,
        prev_topic: str = ...,
    ) -> None: ...

class MuxSelect(_ServiceType):
    """topic_tools/MuxSelect
    """

    Request: _TypeAlias = MuxSelectRequest
    Response: _TypeAlias = MuxSelectResponse
