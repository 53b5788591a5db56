"""tf2_py: the buffer core of tf2 and its exceptions.

Not `rosproto.tf`: programs print what they look up, so that the order of the arithmetic, the texts of the
errors and what counts as reachable are tf2's here, to the last digit.
"""

from ._core import BufferCore
from ._errors import (
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
