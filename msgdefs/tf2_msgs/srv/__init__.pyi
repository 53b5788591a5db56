# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of tf2_msgs as classes."""

from typing import TypeAlias as _TypeAlias

from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType

class FrameGraphRequest(_Message):
    """tf2_msgs/FrameGraphRequest
    """

    def __init__(self) -> None: ...

class FrameGraphResponse(_Message):
    """tf2_msgs/FrameGraphResponse

    string frame_yaml
    """

    frame_yaml: str
    def __init__(
        self,
        frame_yaml: str = ...,
    ) -> None: ...

class FrameGraph(_ServiceType):
    """tf2_msgs/FrameGraph
    """

    Request: _TypeAlias = FrameGraphRequest
    Response: _TypeAlias = FrameGraphResponse
