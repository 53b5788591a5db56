# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of dynamic_reconfigure as classes."""

from typing import TypeAlias as _TypeAlias

import msgdefs.dynamic_reconfigure.msg as _dynamic_reconfigure
from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType

class ReconfigureRequest(_Message):
    """dynamic_reconfigure/ReconfigureRequest

    Config config
    """

    config: _dynamic_reconfigure.Config
    def __init__(
        self,
        config: _dynamic_reconfigure.Config = ...,
    ) -> None: ...

class ReconfigureResponse(_Message):
    """dynamic_reconfigure/ReconfigureResponse

    Config config
    """

    config: _dynamic_reconfigure.Config
    def __init__(
        self,
        config: _dynamic_reconfigure.Config = ...,
    ) -> None: ...

class Reconfigure(_ServiceType):
    """dynamic_reconfigure/Reconfigure
    """

    Request: _TypeAlias = ReconfigureRequest
    Response: _TypeAlias = ReconfigureResponse
