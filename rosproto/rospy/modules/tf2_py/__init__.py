"""tf2_py: the buffer core of tf2 and its exceptions.

The engine is that of `rosproto.tf`, whose arithmetic is tf2's, to the last digit: programs print what they
look up. The texts of errors, the warnings on stderr and what counts as a name are tf2's here.
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
