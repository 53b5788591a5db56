# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of tf as classes."""

from typing import TypeAlias as _TypeAlias

from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType

class FrameGraphRequest(_Message):
    """tf/FrameGraphRequest
    """

    def __init__(self) -> None: ...

class FrameGraphResponse(_Message):
    """tf/FrameGraphResponse

    string dot_graph
    """

    dot_graph: str
    def __init__(
        self,
        dot_graph: str = ...,
    ) -> None: ...

class FrameGraph(_ServiceType):
    """tf/FrameGraph
    """

    Request: _TypeAlias = FrameGraphRequest
    Response: _TypeAlias = FrameGraphResponse
