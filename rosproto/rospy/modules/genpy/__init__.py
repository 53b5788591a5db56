"""genpy's run-time names, for generated message code and for programs that import them."""

from . import base, rostime
from .message import (
    DeserializationError,
    Message,
    MessageException,
    SerializationError,
    struct_I,
)
from .rostime import Duration, Time, TVal

__all__ = [
    "DeserializationError",
    "Duration",
    "Message",
    "MessageException",
    "SerializationError",
    "TVal",
    "Time",
    "base",
    "rostime",
    "struct_I",
]
