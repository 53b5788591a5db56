# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of trajectory_msgs as classes."""

from collections.abc import Sequence as _Sequence

import msgdefs.geometry_msgs.msg as _geometry_msgs
import msgdefs.std_msgs.msg as _std_msgs
from msgdefs._fields import Float64Array as _Float64Array
from msgdefs._fields import Floats as _Floats
from rosproto.codec import Message as _Message
from rosproto.time import Duration as _Duration

class JointTrajectory(_Message):
    """trajectory_msgs/JointTrajectory

    Header header
    string[] joint_names
    JointTrajectoryPoint[] points
    """

    header: _std_msgs.Header
    joint_names: list[str]
    points: list[JointTrajectoryPoint]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        joint_names: _Sequence[str] = ...,
        points: _Sequence[JointTrajectoryPoint] = ...,
    ) -> None: ...

class JointTrajectoryPoint(_Message):
    """trajectory_msgs/JointTrajectoryPoint

    # Where joints are to be at one time; each array as long as joint_names or empty.

    float64[] positions
    float64[] velocities
    float64[] accelerations
    float64[] effort
    duration time_from_start  # after the start of the trajectory
    """

    positions: _Float64Array
    velocities: _Float64Array
    accelerations: _Float64Array
    effort: _Float64Array
    time_from_start: _Duration
    def __init__(
        self,
        positions: _Floats = ...,
        velocities: _Floats = ...,
        accelerations: _Floats = ...,
        effort: _Floats = ...,
        time_from_start: _Duration = ...,
    ) -> None: ...

class MultiDOFJointTrajectory(_Message):
    """trajectory_msgs/MultiDOFJointTrajectory

    Header header
    string[] joint_names
    MultiDOFJointTrajectoryPoint[] points
    """

    header: _std_msgs.Header
    joint_names: list[str]
    points: list[MultiDOFJointTrajectoryPoint]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        joint_names: _Sequence[str] = ...,
        points: _Sequence[MultiDOFJointTrajectoryPoint] = ...,
    ) -> None: ...

class MultiDOFJointTrajectoryPoint(_Message):
    """trajectory_msgs/MultiDOFJointTrajectoryPoint

    geometry_msgs/Transform[] transforms
    geometry_msgs/Twist[] velocities
    geometry_msgs/Twist[] accelerations
    duration time_from_start
    """

    transforms: list[_geometry_msgs.Transform]
    velocities: list[_geometry_msgs.Twist]
    accelerations: list[_geometry_msgs.Twist]
    time_from_start: _Duration
    def __init__(
        self,
        transforms: _Sequence[_geometry_msgs.Transform] = ...,
        velocities: _Sequence[_geometry_msgs.Twist] = ...,
        accelerations: _Sequence[_geometry_msgs.Twist] = ...,
        time_from_start: _Duration = ...,
    ) -> None: ...
