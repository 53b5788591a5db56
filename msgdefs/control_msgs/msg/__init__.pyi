# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of control_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import ClassVar as _ClassVar

import msgdefs.actionlib_msgs.msg as _actionlib_msgs
import msgdefs.geometry_msgs.msg as _geometry_msgs
import msgdefs.std_msgs.msg as _std_msgs
import msgdefs.trajectory_msgs.msg as _trajectory_msgs
from msgdefs._fields import Float64Array as _Float64Array
from msgdefs._fields import Floats as _Floats
from rosproto.codec import Message as _Message
from rosproto.time import Duration as _Duration

class FollowJointTrajectoryAction(_Message):
    """control_msgs/FollowJointTrajectoryAction
    """

    action_goal: FollowJointTrajectoryActionGoal
    action_result: FollowJointTrajectoryActionResult
    action_feedback: FollowJointTrajectoryActionFeedback
    def __init__(
        self,
        action_goal: FollowJointTrajectoryActionGoal = ...,
        action_result: FollowJointTrajectoryActionResult = ...,
        action_feedback: FollowJointTrajectoryActionFeedback = ...,
    ) -> None: ...

class FollowJointTrajectoryActionFeedback(_Message):
    """control_msgs/FollowJointTrajectoryActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: FollowJointTrajectoryFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: FollowJointTrajectoryFeedback = ...,
    ) -> None: ...

class FollowJointTrajectoryActionGoal(_Message):
    """control_msgs/FollowJointTrajectoryActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: FollowJointTrajectoryGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: FollowJointTrajectoryGoal = ...,
    ) -> None: ...

class FollowJointTrajectoryActionResult(_Message):
    """control_msgs/FollowJointTrajectoryActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: FollowJointTrajectoryResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: FollowJointTrajectoryResult = ...,
    ) -> None: ...

class FollowJointTrajectoryFeedback(_Message):
    """control_msgs/FollowJointTrajectoryFeedback

    Header header
    string[] joint_names
    trajectory_msgs/JointTrajectoryPoint desired
    trajectory_msgs/JointTrajectoryPoint actual
    trajectory_msgs/JointTrajectoryPoint error
    """

    header: _std_msgs.Header
    joint_names: list[str]
    desired: _trajectory_msgs.JointTrajectoryPoint
    actual: _trajectory_msgs.JointTrajectoryPoint
    error: _trajectory_msgs.JointTrajectoryPoint
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        joint_names: _Sequence[str] = ...,
        desired: _trajectory_msgs.JointTrajectoryPoint = ...,
        actual: _trajectory_msgs.JointTrajectoryPoint = ...,
        error: _trajectory_msgs.JointTrajectoryPoint = ...,
    ) -> None: ...

class FollowJointTrajectoryGoal(_Message):
    """control_msgs/FollowJointTrajectoryGoal

    trajectory_msgs/JointTrajectory trajectory
    JointTolerance[] path_tolerance
    JointTolerance[] goal_tolerance
    duration goal_time_tolerance
    """

    trajectory: _trajectory_msgs.JointTrajectory
    path_tolerance: list[JointTolerance]
    goal_tolerance: list[JointTolerance]
    goal_time_tolerance: _Duration
    def __init__(
        self,
        trajectory: _trajectory_msgs.JointTrajectory = ...,
        path_tolerance: _Sequence[JointTolerance] = ...,
        goal_tolerance: _Sequence[JointTolerance] = ...,
        goal_time_tolerance: _Duration = ...,
    ) -> None: ...

class FollowJointTrajectoryResult(_Message):
    """control_msgs/FollowJointTrajectoryResult

    int32 error_code
    int32 SUCCESSFUL=0
    int32 INVALID_GOAL=-1
    int32 INVALID_JOINTS=-2
    int32 OLD_HEADER_TIMESTAMP=-3
    int32 PATH_TOLERANCE_VIOLATED=-4
    int32 GOAL_TOLERANCE_VIOLATED=-5
    string error_string
    """

    SUCCESSFUL: _ClassVar[int] = 0
    INVALID_GOAL: _ClassVar[int] = -1
    INVALID_JOINTS: _ClassVar[int] = -2
    OLD_HEADER_TIMESTAMP: _ClassVar[int] = -3
    PATH_TOLERANCE_VIOLATED: _ClassVar[int] = -4
    GOAL_TOLERANCE_VIOLATED: _ClassVar[int] = -5
    error_code: int
    error_string: str
    def __init__(
        self,
        error_code: int = ...,
        error_string: str = ...,
    ) -> None: ...

class GripperCommand(_Message):
    """control_msgs/GripperCommand

    float64 position
    float64 max_effort
    """

    position: float
    max_effort: float
    def __init__(
        self,
        position: float = ...,
        max_effort: float = ...,
    ) -> None: ...

class GripperCommandAction(_Message):
    """control_msgs/GripperCommandAction
    """

    action_goal: GripperCommandActionGoal
    action_result: GripperCommandActionResult
    action_feedback: GripperCommandActionFeedback
    def __init__(
        self,
        action_goal: GripperCommandActionGoal = ...,
        action_result: GripperCommandActionResult = ...,
        action_feedback: GripperCommandActionFeedback = ...,
    ) -> None: ...

class GripperCommandActionFeedback(_Message):
    """control_msgs/GripperCommandActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: GripperCommandFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: GripperCommandFeedback = ...,
    ) -> None: ...

class GripperCommandActionGoal(_Message):
    """control_msgs/GripperCommandActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: GripperCommandGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: GripperCommandGoal = ...,
    ) -> None: ...

class GripperCommandActionResult(_Message):
    """control_msgs/GripperCommandActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: GripperCommandResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: GripperCommandResult = ...,
    ) -> None: ...

class GripperCommandFeedback(_Message):
    """control_msgs/GripperCommandFeedback

    float64 position
    float64 effort
    bool stalled
    bool reached_goal
    """

    position: float
    effort: float
    stalled: bool
    reached_goal: bool
    def __init__(
        self,
        position: float = ...,
        effort: float = ...,
        stalled: bool = ...,
        reached_goal: bool = ...,
    ) -> None: ...

class GripperCommandGoal(_Message):
    """control_msgs/GripperCommandGoal

    GripperCommand command
    """

    command: GripperCommand
    def __init__(
        self,
        command: GripperCommand = ...,
    ) -> None: ...

class GripperCommandResult(_Message):
    """control_msgs/GripperCommandResult

    float64 position
    float64 effort
    bool stalled
    bool reached_goal
    """

    position: float
    effort: float
    stalled: bool
    reached_goal: bool
    def __init__(
        self,
        position: float = ...,
        effort: float = ...,
        stalled: bool = ...,
        reached_goal: bool = ...,
    ) -> None: ...

class JointControllerState(_Message):
    """control_msgs/JointControllerState

    Header header
    float64 set_point
    float64 process_value
    float64 process_value_dot
    float64 error
    float64 time_step
    float64 command
    float64 p
    float64 i
    float64 d
    float64 i_clamp
    bool antiwindup
    """

    header: _std_msgs.Header
    set_point: float
    process_value: float
    process_value_dot: float
    error: float
    time_step: float
    command: float
    p: float
    i: float
    d: float
    i_clamp: float
    antiwindup: bool
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        set_point: float = ...,
        process_value: float = ...,
        process_value_dot: float = ...,
        error: float = ...,
        time_step: float = ...,
        command: float = ...,
        p: float = ...,
        i: float = ...,
        d: float = ...,
        i_clamp: float = ...,
        antiwindup: bool = ...,
    ) -> None: ...

class JointJog(_Message):
    """control_msgs/JointJog

    Header header
    string[] joint_names
    float64[] displacements
    float64[] velocities
    float64 duration
    """

    header: _std_msgs.Header
    joint_names: list[str]
    displacements: _Float64Array
    velocities: _Float64Array
    duration: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        joint_names: _Sequence[str] = ...,
        displacements: _Floats = ...,
        velocities: _Floats = ...,
        duration: float = ...,
    ) -> None: ...

class JointTolerance(_Message):
    """control_msgs/JointTolerance

    string name
    float64 position
    float64 velocity
    float64 acceleration
    """

    name: str
    position: float
    velocity: float
    acceleration: float
    def __init__(
        self,
        name: str = ...,
        position: float = ...,
        velocity: float = ...,
        acceleration: float = ...,
    ) -> None: ...

class JointTrajectoryAction(_Message):
    """control_msgs/JointTrajectoryAction
    """

    action_goal: JointTrajectoryActionGoal
    action_result: JointTrajectoryActionResult
    action_feedback: JointTrajectoryActionFeedback
    def __init__(
        self,
        action_goal: JointTrajectoryActionGoal = ...,
        action_result: JointTrajectoryActionResult = ...,
        action_feedback: JointTrajectoryActionFeedback = ...,
    ) -> None: ...

class JointTrajectoryActionFeedback(_Message):
    """control_msgs/JointTrajectoryActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: JointTrajectoryFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: JointTrajectoryFeedback = ...,
    ) -> None: ...

class JointTrajectoryActionGoal(_Message):
    """control_msgs/JointTrajectoryActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: JointTrajectoryGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: JointTrajectoryGoal = ...,
    ) -> None: ...

class JointTrajectoryActionResult(_Message):
    """control_msgs/JointTrajectoryActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: JointTrajectoryResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: JointTrajectoryResult = ...,
    ) -> None: ...

class JointTrajectoryControllerState(_Message):
    """control_msgs/JointTrajectoryControllerState

    Header header
    string[] joint_names
    trajectory_msgs/JointTrajectoryPoint desired
    trajectory_msgs/JointTrajectoryPoint actual
    trajectory_msgs/JointTrajectoryPoint error
    """

    header: _std_msgs.Header
    joint_names: list[str]
    desired: _trajectory_msgs.JointTrajectoryPoint
    actual: _trajectory_msgs.JointTrajectoryPoint
    error: _trajectory_msgs.JointTrajectoryPoint
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        joint_names: _Sequence[str] = ...,
        desired: _trajectory_msgs.JointTrajectoryPoint = ...,
        actual: _trajectory_msgs.JointTrajectoryPoint = ...,
        error: _trajectory_msgs.JointTrajectoryPoint = ...,
    ) -> None: ...

class JointTrajectoryFeedback(_Message):
    """control_msgs/JointTrajectoryFeedback
    """

    def __init__(self) -> None: ...

class JointTrajectoryGoal(_Message):
    """control_msgs/JointTrajectoryGoal

    trajectory_msgs/JointTrajectory trajectory
    """

    trajectory: _trajectory_msgs.JointTrajectory
    def __init__(
        self,
        trajectory: _trajectory_msgs.JointTrajectory = ...,
    ) -> None: ...

class JointTrajectoryResult(_Message):
    """control_msgs/JointTrajectoryResult
    """

    def __init__(self) -> None: ...

class PidState(_Message):
    """control_msgs/PidState

    Header header
    duration timestep
    float64 error
    float64 error_dot
    float64 p_error
    float64 i_error
    float64 d_error
    float64 p_term
    float64 i_term
    float64 d_term
    float64 i_max
    float64 i_min
    float64 output
    """

    header: _std_msgs.Header
    timestep: _Duration
    error: float
    error_dot: float
    p_error: float
    i_error: float
    d_error: float
    p_term: float
    i_term: float
    d_term: float
    i_max: float
    i_min: float
    output: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        timestep: _Duration = ...,
        error: float = ...,
        error_dot: float = ...,
        p_error: float = ...,
        i_error: float = ...,
        d_error: float = ...,
        p_term: float = ...,
        i_term: float = ...,
        d_term: float = ...,
        i_max: float = ...,
        i_min: float = ...,
        output: float = ...,
    ) -> None: ...

class PointHeadAction(_Message):
    """control_msgs/PointHeadAction
    """

    action_goal: PointHeadActionGoal
    action_result: PointHeadActionResult
    action_feedback: PointHeadActionFeedback
    def __init__(
        self,
        action_goal: PointHeadActionGoal = ...,
        action_result: PointHeadActionResult = ...,
        action_feedback: PointHeadActionFeedback = ...,
    ) -> None: ...

class PointHeadActionFeedback(_Message):
    """control_msgs/PointHeadActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: PointHeadFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: PointHeadFeedback = ...,
    ) -> None: ...

class PointHeadActionGoal(_Message):
    """control_msgs/PointHeadActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: PointHeadGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: PointHeadGoal = ...,
    ) -> None: ...

class PointHeadActionResult(_Message):
    """control_msgs/PointHeadActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: PointHeadResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: PointHeadResult = ...,
    ) -> None: ...

class PointHeadFeedback(_Message):
    """control_msgs/PointHeadFeedback

    float64 pointing_angle_error
    """

    pointing_angle_error: float
    def __init__(
        self,
        pointing_angle_error: float = ...,
    ) -> None: ...

class PointHeadGoal(_Message):
    """control_msgs/PointHeadGoal

    geometry_msgs/PointStamped target
    geometry_msgs/Vector3 pointing_axis
    string pointing_frame
    duration min_duration
    float64 max_velocity
    """

    target: _geometry_msgs.PointStamped
    pointing_axis: _geometry_msgs.Vector3
    pointing_frame: str
    min_duration: _Duration
    max_velocity: float
    def __init__(
        self,
        target: _geometry_msgs.PointStamped = ...,
        pointing_axis: _geometry_msgs.Vector3 = ...,
        pointing_frame: str = ...,
        min_duration: _Duration = ...,
        max_velocity: float = ...,
    ) -> None: ...

class PointHeadResult(_Message):
    """control_msgs/PointHeadResult
    """

    def __init__(self) -> None: ...

class SingleJointPositionAction(_Message):
    """control_msgs/SingleJointPositionAction
    """

    action_goal: SingleJointPositionActionGoal
    action_result: SingleJointPositionActionResult
    action_feedback: SingleJointPositionActionFeedback
    def __init__(
        self,
        action_goal: SingleJointPositionActionGoal = ...,
        action_result: SingleJointPositionActionResult = ...,
        action_feedback: SingleJointPositionActionFeedback = ...,
    ) -> None: ...

class SingleJointPositionActionFeedback(_Message):
    """control_msgs/SingleJointPositionActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: SingleJointPositionFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: SingleJointPositionFeedback = ...,
    ) -> None: ...

class SingleJointPositionActionGoal(_Message):
    """control_msgs/SingleJointPositionActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: SingleJointPositionGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: SingleJointPositionGoal = ...,
    ) -> None: ...

class SingleJointPositionActionResult(_Message):
    """control_msgs/SingleJointPositionActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: SingleJointPositionResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: SingleJointPositionResult = ...,
    ) -> None: ...

class SingleJointPositionFeedback(_Message):
    """control_msgs/SingleJointPositionFeedback

    Header header
    float64 position
    float64 velocity
    float64 error
    """

    header: _std_msgs.Header
    position: float
    velocity: float
    error: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        position: float = ...,
        velocity: float = ...,
        error: float = ...,
    ) -> None: ...

class SingleJointPositionGoal(_Message):
    """control_msgs/SingleJointPositionGoal

    float64 position
    duration min_duration
    float64 max_velocity
    """

    position: float
    min_duration: _Duration
    max_velocity: float
    def __init__(
        self,
        position: float = ...,
        min_duration: _Duration = ...,
        max_velocity: float = ...,
    ) -> None: ...

class SingleJointPositionResult(_Message):
    """control_msgs/SingleJointPositionResult
    """

    def __init__(self) -> None: ...
