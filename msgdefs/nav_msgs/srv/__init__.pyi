# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of nav_msgs as classes."""

from typing import ClassVar as _ClassVar, TypeAlias as _TypeAlias

import msgdefs.geometry_msgs.msg as _geometry_msgs
import msgdefs.nav_msgs.msg as _nav_msgs
from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType

class GetMapRequest(_Message):
    """nav_msgs/GetMapRequest

    # Fetch the current map; also an action of the same name.
    """

    def __init__(self) -> None: ...

class GetMapResponse(_Message):
    """nav_msgs/GetMapResponse

    OccupancyGrid map
    """

    map: _nav_msgs.OccupancyGrid
    def __init__(
        self,
        map: _nav_msgs.OccupancyGrid = ...,
    ) -> None: ...

class GetMap(_ServiceType):
    """nav_msgs/GetMap
    """

    Request: _TypeAlias = GetMapRequest
    Response: _TypeAlias = GetMapResponse

class GetPlanRequest(_Message):
    """nav_msgs/GetPlanRequest

    # Plan a path without driving it.

    geometry_msgs/PoseStamped start  # where from
    geometry_msgs/PoseStamped goal   # where to

    # m around the goal that will do when the goal itself cannot be reached; it becomes position error
    float32 tolerance
    """

    start: _geometry_msgs.PoseStamped
    goal: _geometry_msgs.PoseStamped
    tolerance: float
    def __init__(
        self,
        start: _geometry_msgs.PoseStamped = ...,
        goal: _geometry_msgs.PoseStamped = ...,
        tolerance: float = ...,
    ) -> None: ...

class GetPlanResponse(_Message):
    """nav_msgs/GetPlanResponse

    Path plan  # empty when there is no way
    """

    plan: _nav_msgs.Path
    def __init__(
        self,
        plan: _nav_msgs.Path = ...,
    ) -> None: ...

class GetPlan(_ServiceType):
    """nav_msgs/GetPlan
    """

    Request: _TypeAlias = GetPlanRequest
    Response: _TypeAlias = GetPlanResponse

class LoadMapRequest(_Message):
    """nav_msgs/LoadMapRequest

    # Load a map from a resource.

    string map_url  # for example file:///maps/hall.yaml
    """

    map_url: str
    def __init__(
        self,
        map_url: str = ...,
    ) -> None: ...

class LoadMapResponse(_Message):
    """nav_msgs/LoadMapResponse

    uint8 RESULT_SUCCESS=0
    uint8 RESULT_MAP_DOES_NOT_EXIST=1
    uint8 RESULT_INVALID_MAP_DATA=2
    uint8 RESULT_INVALID_MAP_METADATA=3
    uint8 RESULT_UNDEFINED_FAILURE=255

    OccupancyGrid map                    # only valid with RESULT_SUCCESS
    uint8 result
    """

    RESULT_SUCCESS: _ClassVar[int] = 0
    RESULT_MAP_DOES_NOT_EXIST: _ClassVar[int] = 1
    RESULT_INVALID_MAP_DATA: _ClassVar[int] = 2
    RESULT_INVALID_MAP_METADATA: _ClassVar[int] = 3
    RESULT_UNDEFINED_FAILURE: _ClassVar[int] = 255
    map: _nav_msgs.OccupancyGrid
    result: int
    def __init__(
        self,
        map: _nav_msgs.OccupancyGrid = ...,
        result: int = ...,
    ) -> None: ...

class LoadMap(_ServiceType):
    """nav_msgs/LoadMap
    """

    Request: _TypeAlias = LoadMapRequest
    Response: _TypeAlias = LoadMapResponse

class SetMapRequest(_Message):
    """nav_msgs/SetMapRequest

    # Replace the map.

    OccupancyGrid map
    geometry_msgs/PoseWithCovarianceStamped initial_pose  # pose of the robot in the new map
    """

    map: _nav_msgs.OccupancyGrid
    initial_pose: _geometry_msgs.PoseWithCovarianceStamped
    def __init__(
        self,
        map: _nav_msgs.OccupancyGrid = ...,
        initial_pose: _geometry_msgs.PoseWithCovarianceStamped = ...,
    ) -> None: ...

class SetMapResponse(_Message):
    """nav_msgs/SetMapResponse

    bool success
    """

    success: bool
    def __init__(
        self,
        success: bool = ...,
    ) -> None: ...

class SetMap(_ServiceType):
    """nav_msgs/SetMap
    """

    Request: _TypeAlias = SetMapRequest
    Response: _TypeAlias = SetMapResponse
