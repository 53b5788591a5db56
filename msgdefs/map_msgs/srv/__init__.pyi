# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of map_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import TypeAlias as _TypeAlias

import msgdefs.map_msgs.msg as _map_msgs
import msgdefs.nav_msgs.msg as _nav_msgs
import msgdefs.sensor_msgs.msg as _sensor_msgs
import msgdefs.std_msgs.msg as _std_msgs
from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType

class GetMapROIRequest(_Message):
    """map_msgs/GetMapROIRequest

    float64 x
    float64 y
    float64 l_x
    float64 l_y
    """

    x: float
    y: float
    l_x: float
    l_y: float
    def __init__(
        self,
        x: float = ...,
        y: float = ...,
        l_x: float = ...,
        l_y: float = ...,
    ) -> None: ...

class GetMapROIResponse(_Message):
    """map_msgs/GetMapROIResponse

    nav_msgs/OccupancyGrid sub_map
    """

    sub_map: _nav_msgs.OccupancyGrid
    def __init__(
        self,
        sub_map: _nav_msgs.OccupancyGrid = ...,
    ) -> None: ...

class GetMapROI(_ServiceType):
    """map_msgs/GetMapROI
    """

    Request: _TypeAlias = GetMapROIRequest
    Response: _TypeAlias = GetMapROIResponse

class GetPointMapRequest(_Message):
    """map_msgs/GetPointMapRequest
    """

    def __init__(self) -> None: ...

class GetPointMapResponse(_Message):
    """map_msgs/GetPointMapResponse

    sensor_msgs/PointCloud2 map
    """

    map: _sensor_msgs.PointCloud2
    def __init__(
        self,
        map: _sensor_msgs.PointCloud2 = ...,
    ) -> None: ...

class GetPointMap(_ServiceType):
    """map_msgs/GetPointMap
    """

    Request: _TypeAlias = GetPointMapRequest
    Response: _TypeAlias = GetPointMapResponse

class GetPointMapROIRequest(_Message):
    """map_msgs/GetPointMapROIRequest

    float64 x
    float64 y
    float64 z
    float64 r
    float64 l_x
    float64 l_y
    float64 l_z
    """

    x: float
    y: float
    z: float
    r: float
    l_x: float
    l_y: float
    l_z: float
    def __init__(
        self,
        x: float = ...,
        y: float = ...,
        z: float = ...,
        r: float = ...,
        l_x: float = ...,
        l_y: float = ...,
        l_z: float = ...,
    ) -> None: ...

class GetPointMapROIResponse(_Message):
    """map_msgs/GetPointMapROIResponse

    sensor_msgs/PointCloud2 sub_map
    """

    sub_map: _sensor_msgs.PointCloud2
    def __init__(
        self,
        sub_map: _sensor_msgs.PointCloud2 = ...,
    ) -> None: ...

class GetPointMapROI(_ServiceType):
    """map_msgs/GetPointMapROI
    """

    Request: _TypeAlias = GetPointMapROIRequest
    Response: _TypeAlias = GetPointMapROIResponse

class ProjectedMapsInfoRequest(_Message):
    """map_msgs/ProjectedMapsInfoRequest

    ProjectedMapInfo[] projected_maps_info
    """

    projected_maps_info: list[_map_msgs.ProjectedMapInfo]
    def __init__(
        self,
        projected_maps_info: _Sequence[_map_msgs.ProjectedMapInfo] = ...,
    ) -> None: ...

class ProjectedMapsInfoResponse(_Message):
    """map_msgs/ProjectedMapsInfoResponse
    """

    def __init__(self) -> None: ...

class ProjectedMapsInfo(_ServiceType):
    """map_msgs/ProjectedMapsInfo
    """

    Request: _TypeAlias = ProjectedMapsInfoRequest
    Response: _TypeAlias = ProjectedMapsInfoResponse

class SaveMapRequest(_Message):
    """map_msgs/SaveMapRequest

    std_msgs/String filename
    """

    filename: _std_msgs.String
    def __init__(
        self,
        filename: _std_msgs.String = ...,
    ) -> None: ...

class SaveMapResponse(_Message):
    """map_msgs/SaveMapResponse
    """

    def __init__(self) -> None: ...

class SaveMap(_ServiceType):
    """map_msgs/SaveMap
    """

    Request: _TypeAlias = SaveMapRequest
    Response: _TypeAlias = SaveMapResponse

class SetMapProjectionsRequest(_Message):
    """map_msgs/SetMapProjectionsRequest
    """

    def __init__(self) -> None: ...

class SetMapProjectionsResponse(_Message):
    """map_msgs/SetMapProjectionsResponse

    ProjectedMapInfo[] projected_maps_info
    """

    projected_maps_info: list[_map_msgs.ProjectedMapInfo]
    def __init__(
        self,
        projected_maps_info: _Sequence[_map_msgs.ProjectedMapInfo] = ...,
    ) -> None: ...

class SetMapProjections(_ServiceType):
    """map_msgs/SetMapProjections
    """

    Request: _TypeAlias = SetMapProjectionsRequest
    Response: _TypeAlias = SetMapProjectionsResponse
