# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of control_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import TypeAlias as _TypeAlias

from msgdefs._fields import Float64Array as _Float64Array
from msgdefs._fields import Floats as _Floats
from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType
from rosproto.time import Time as _Time

class QueryCalibrationStateRequest(_Message):
    """control_msgs/QueryCalibrationStateRequest
    """

    def __init__(self) -> None: ...

class QueryCalibrationStateResponse(_Message):
    """control_msgs/QueryCalibrationStateResponse

    bool is_calibrated
    """

    is_calibrated: bool
    def __init__(
        self,
        is_calibrated: bool = ...,
    ) -> None: ...

class QueryCalibrationState(_ServiceType):
    """control_msgs/QueryCalibrationState
    """

    Request: _TypeAlias = QueryCalibrationStateRequest
    Response: _TypeAlias = QueryCalibrationStateResponse

class QueryTrajectoryStateRequest(_Message):
    """control_msgs/QueryTrajectoryStateRequest

    time time
    """

    time: _Time
    def __init__(
        self,
        time: _Time = ...,
    ) -> None: ...

class QueryTrajectoryStateResponse(_Message):
    """control_msgs/QueryTrajectoryStateResponse

    string[] name
    float64[] position
    float64[] velocity
    float64[] acceleration
    """

    name: list[str]
    position: _Float64Array
    velocity: _Float64Array
    acceleration: _Float64Array
    def __init__(
        self,
        name: _Sequence[str] = ...,
        position: _Floats = ...,
        velocity: _Floats = ...,
        acceleration: _Floats = ...,
    ) -> None: ...

class QueryTrajectoryState(_ServiceType):
    """control_msgs/QueryTrajectoryState
    """

    Request: _TypeAlias = QueryTrajectoryStateRequest
    Response: _TypeAlias = QueryTrajectoryStateResponse
