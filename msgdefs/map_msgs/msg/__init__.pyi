# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of map_msgs as classes."""

from typing import ClassVar as _ClassVar

import msgdefs.nav_msgs.msg as _nav_msgs
import msgdefs.sensor_msgs.msg as _sensor_msgs
import msgdefs.std_msgs.msg as _std_msgs
from msgdefs._fields import Int8Array as _Int8Array
from msgdefs._fields import Integers as _Integers
from rosproto.codec import Message as _Message

class OccupancyGridUpdate(_Message):
    """map_msgs/OccupancyGridUpdate

    std_msgs/Header header
    int32 x
    int32 y
    uint32 width
    uint32 height
    int8[] data
    """

    header: _std_msgs.Header
    x: int
    y: int
    width: int
    height: int
    data: _Int8Array
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        x: int = ...,
        y: int = ...,
        width: int = ...,
        height: int = ...,
        data: _Integers = ...,
    ) -> None: ...

class PointCloud2Update(_Message):
    """map_msgs/PointCloud2Update

    uint32 ADD=0
    uint32 DELETE=1

    Header header
    uint32 type
    sensor_msgs/PointCloud2 points
    """

    ADD: _ClassVar[int] = 0
    DELETE: _ClassVar[int] = 1
    header: _std_msgs.Header
    type: int
    points: _sensor_msgs.PointCloud2
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        type: int = ...,
        points: _sensor_msgs.PointCloud2 = ...,
    ) -> None: ...

class ProjectedMap(_Message):
    """map_msgs/ProjectedMap

    nav_msgs/OccupancyGrid map
    float64 min_z
    float64 max_z
    """

    map: _nav_msgs.OccupancyGrid
    min_z: float
    max_z: float
    def __init__(
        self,
        map: _nav_msgs.OccupancyGrid = ...,
        min_z: float = ...,
        max_z: float = ...,
    ) -> None: ...

class ProjectedMapInfo(_Message):
    """map_msgs/ProjectedMapInfo

    string frame_id
    float64 x
    float64 y
    float64 width
    float64 height
    float64 min_z
    float64 max_z
    """

    frame_id: str
    x: float
    y: float
    width: float
    height: float
    min_z: float
    max_z: float
    def __init__(
        self,
        frame_id: str = ...,
        x: float = ...,
        y: float = ...,
        width: float = ...,
        height: float = ...,
        min_z: float = ...,
        max_z: float = ...,
    ) -> None: ...
