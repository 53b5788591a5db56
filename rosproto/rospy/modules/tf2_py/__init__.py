"""tf2_py: tf2's buffer core and exceptions.

The engine is `rosproto.tf`; its results equal tf2's to the last digit, since programs print them. Error
texts, warnings on stderr and rules for names are tf2's.
"""

from ._core import (
    BufferCore,
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)

__all__ = [
    "BufferCore",
    "ConnectivityException",
    "ExtrapolationException",
    "InvalidArgumentException",
    "LookupException",
    "TimeoutException",
    "TransformException",
]
