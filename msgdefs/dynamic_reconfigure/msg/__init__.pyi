# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of dynamic_reconfigure as classes."""

from collections.abc import Sequence as _Sequence
from typing import ClassVar as _ClassVar

from rosproto.codec import Message as _Message

class BoolParameter(_Message):
    """dynamic_reconfigure/BoolParameter

    string name
    bool value
    """

    name: str
    value: bool
    def __init__(
        self,
        name: str = ...,
        value: bool = ...,
    ) -> None: ...

class Config(_Message):
    """dynamic_reconfigure/Config

    BoolParameter[] bools
    IntParameter[] ints
    StrParameter[] strs
    DoubleParameter[] doubles
    GroupState[] groups
    """

    bools: list[BoolParameter]
    ints: list[IntParameter]
    strs: list[StrParameter]
    doubles: list[DoubleParameter]
    groups: list[GroupState]
    def __init__(
        self,
        bools: _Sequence[BoolParameter] = ...,
        ints: _Sequence[IntParameter] = ...,
        strs: _Sequence[StrParameter] = ...,
        doubles: _Sequence[DoubleParameter] = ...,
        groups: _Sequence[GroupState] = ...,
    ) -> None: ...

class ConfigDescription(_Message):
    """dynamic_reconfigure/ConfigDescription

    Group[] groups
    Config max
    Config min
    Config dflt
    """

    groups: list[Group]
    max: Config
    min: Config
    dflt: Config
    def __init__(
        self,
        groups: _Sequence[Group] = ...,
        max: Config = ...,
        min: Config = ...,
        dflt: Config = ...,
    ) -> None: ...

class DoubleParameter(_Message):
    """dynamic_reconfigure/DoubleParameter

    string name
    float64 value
    """

    name: str
    value: float
    def __init__(
        self,
        name: str = ...,
        value: float = ...,
    ) -> None: ...

class Group(_Message):
    """dynamic_reconfigure/Group

    string name
    string type
    ParamDescription[] parameters
    int32 parent
    int32 id
    """

    name: str
    type: str
    parameters: list[ParamDescription]
    parent: int
    id: int
    def __init__(
        self,
        name: str = ...,
        type: str = ...,
        parameters: _Sequence[ParamDescription] = ...,
        parent: int = ...,
        id: int = ...,
    ) -> None: ...

class GroupState(_Message):
    """dynamic_reconfigure/GroupState

    string name
    bool state
    int32 id
    int32 parent
    """

    name: str
    state: bool
    id: int
    parent: int
    def __init__(
        self,
        name: str = ...,
        state: bool = ...,
        id: int = ...,
        parent: int = ...,
    ) -> None: ...

class IntParameter(_Message):
    """dynamic_reconfigure/IntParameter

    string name
    int32 value
    """

    name: str
    value: int
    def __init__(
        self,
        name: str = ...,
        value: int = ...,
    ) -> None: ...

class ParamDescription(_Message):
    """dynamic_reconfigure/ParamDescription

    string name
    string type
    uint32 level
    string description
    string edit_method
    """

    name: str
    type: str
    level: int
    description: str
    edit_method: str
    def __init__(
        self,
        name: str = ...,
        type: str = ...,
        level: int = ...,
        description: str = ...,
        edit_method: str = ...,
    ) -> None: ...

class SensorLevels(_Message):
    """dynamic_reconfigure/SensorLevels

    byte RECONFIGURE_CLOSE=3
    byte RECONFIGURE_STOP=1
    byte RECONFIGURE_RUNNING=0
    """

    RECONFIGURE_CLOSE: _ClassVar[int] = 3
    RECONFIGURE_STOP: _ClassVar[int] = 1
    RECONFIGURE_RUNNING: _ClassVar[int] = 0
    def __init__(self) -> None: ...

class StrParameter(_Message):
    """dynamic_reconfigure/StrParameter

    string name
    string value
    """

    name: str
    value: str
    def __init__(
        self,
        name: str = ...,
        value: str = ...,
    ) -> None: ...
