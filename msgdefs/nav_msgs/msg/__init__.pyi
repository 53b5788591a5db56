# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of nav_msgs as classes."""

from collections.abc import Sequence as _Sequence

import msgdefs.actionlib_msgs.msg as _actionlib_msgs
import msgdefs.geometry_msgs.msg as _geometry_msgs
import msgdefs.std_msgs.msg as _std_msgs
from msgdefs._fields import Int8Array as _Int8Array
from msgdefs._fields import Integers as _Integers
from rosproto.codec import Message as _Message
from rosproto.time import Time as _Time

class GetMapAction(_Message):
    """nav_msgs/GetMapAction
    """

    action_goal: GetMapActionGoal
    action_result: GetMapActionResult
    action_feedback: GetMapActionFeedback
    def __init__(
        self,
        action_goal: GetMapActionGoal = ...,
        action_result: GetMapActionResult = ...,
        action_feedback: GetMapActionFeedback = ...,
    ) -> None: ...

class GetMapActionFeedback(_Message):
    """nav_msgs/GetMapActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: GetMapFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: GetMapFeedback = ...,
    ) -> None: ...

class GetMapActionGoal(_Message):
    """nav_msgs/GetMapActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: GetMapGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: GetMapGoal = ...,
    ) -> None: ...

class GetMapActionResult(_Message):
    """nav_msgs/GetMapActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: GetMapResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: GetMapResult = ...,
    ) -> None: ...

class GetMapFeedback(_Message):
    """nav_msgs/GetMapFeedback
    """

    def __init__(self) -> None: ...

class GetMapGoal(_Message):
    """nav_msgs/GetMapGoal
    """

    def __init__(self) -> None: ...

class GetMapResult(_Message):
    """nav_msgs/GetMapResult

    OccupancyGrid map
    """

    map: OccupancyGrid
    def __init__(
        self,
        map: OccupancyGrid = ...,
    ) -> None: ...

class GridCells(_Message):
    """nav_msgs/GridCells

    # A set of cells, as costmaps publish them for display.

    Header header
    float32 cell_width           # m
    float32 cell_height          # m
    geometry_msgs/Point[] cells  # centre of each, m
    """

    header: _std_msgs.Header
    cell_width: float
    cell_height: float
    cells: list[_geometry_msgs.Point]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        cell_width: float = ...,
        cell_height: float = ...,
        cells: _Sequence[_geometry_msgs.Point] = ...,
    ) -> None: ...

class MapMetaData(_Message):
    """nav_msgs/MapMetaData

    # What an occupancy grid covers.

    time map_load_time         # when the map was loaded
    float32 resolution         # m per cell
    uint32 width               # cells along x
    uint32 height              # cells along y
    geometry_msgs/Pose origin  # pose of the corner of cell (0, 0) in the map frame, m and rad
    """

    map_load_time: _Time
    resolution: float
    width: int
    height: int
    origin: _geometry_msgs.Pose
    def __init__(
        self,
        map_load_time: _Time = ...,
        resolution: float = ...,
        width: int = ...,
        height: int = ...,
        origin: _geometry_msgs.Pose = ...,
    ) -> None: ...

class OccupancyGrid(_Message):
    """nav_msgs/OccupancyGrid

    # A map in the plane, each cell free or occupied.

    Header header     # frame_id is the map frame
    MapMetaData info

    # Row by row from the origin, (height, width): 0 free to 100 occupied, in percent; -1 unknown.
    int8[] data
    """

    header: _std_msgs.Header
    info: MapMetaData
    data: _Int8Array
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        info: MapMetaData = ...,
        data: _Integers = ...,
    ) -> None: ...

class Odometry(_Message):
    """nav_msgs/Odometry

    # Estimated pose and velocity of a robot.
    # The pose is in header.frame_id ("odom"), the twist in child_frame_id ("base_link").

    Header header
    string child_frame_id                    # frame of the twist
    geometry_msgs/PoseWithCovariance pose
    geometry_msgs/TwistWithCovariance twist
    """

    header: _std_msgs.Header
    child_frame_id: str
    pose: _geometry_msgs.PoseWithCovariance
    twist: _geometry_msgs.TwistWithCovariance
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        child_frame_id: str = ...,
        pose: _geometry_msgs.PoseWithCovariance = ...,
        twist: _geometry_msgs.TwistWithCovariance = ...,
    ) -> None: ...

class Path(_Message):
    """nav_msgs/Path

    # A way to go: poses in order.

    Header header                      # frame and time of the path as a whole
    geometry_msgs/PoseStamped[] poses
    """

    header: _std_msgs.Header
    poses: list[_geometry_msgs.PoseStamped]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        poses: _Sequence[_geometry_msgs.PoseStamped] = ...,
    ) -> None: ...
