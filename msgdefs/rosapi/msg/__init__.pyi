# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of rosapi as classes."""

from collections.abc import Sequence as _Sequence

from msgdefs._fields import Int32Array as _Int32Array
from msgdefs._fields import Integers as _Integers
from rosproto.codec import Message as _Message

class TypeDef(_Message):
    """rosapi/TypeDef

    string type
    string[] fieldnames
    string[] fieldtypes
    int32[] fieldarraylen
    string[] examples
    string[] constnames
    string[] constvalues
    """

    type: str
    fieldnames: list[str]
    fieldtypes: list[str]
    fieldarraylen: _Int32Array
    examples: list[str]
    constnames: list[str]
    constvalues: list[str]
    def __init__(
        self,
        type: str = ...,
        fieldnames: _Sequence[str] = ...,
        fieldtypes: _Sequence[str] = ...,
        fieldarraylen: _Integers = ...,
        examples: _Sequence[str] = ...,
        constnames: _Sequence[str] = ...,
        constvalues: _Sequence[str] = ...,
    ) -> None: ...
