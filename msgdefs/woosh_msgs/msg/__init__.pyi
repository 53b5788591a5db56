# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of woosh_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import ClassVar as _ClassVar

import msgdefs.actionlib_msgs.msg as _actionlib_msgs
import msgdefs.geometry_msgs.msg as _geometry_msgs
import msgdefs.nav_msgs.msg as _nav_msgs
import msgdefs.sensor_msgs.msg as _sensor_msgs
import msgdefs.std_msgs.msg as _std_msgs
from msgdefs._fields import Float32Array as _Float32Array
from msgdefs._fields import Floats as _Floats
from msgdefs._fields import Int32Array as _Int32Array
from msgdefs._fields import Integers as _Integers
from msgdefs._fields import Octets as _Octets
from msgdefs._fields import UInt8Array as _UInt8Array
from rosproto.codec import Message as _Message

class ArTagPose(_Message):
    """woosh_msgs/ArTagPose

    # A recognised AR tag.

    geometry_msgs/Point distination  # target point that goes with the tag (vendor's spelling), m
    geometry_msgs/Pose tag_pose      # of the tag, m
    int32 tag_id                     # number of the tag
    """

    distination: _geometry_msgs.Point
    tag_pose: _geometry_msgs.Pose
    tag_id: int
    def __init__(
        self,
        distination: _geometry_msgs.Point = ...,
        tag_pose: _geometry_msgs.Pose = ...,
        tag_id: int = ...,
    ) -> None: ...

class ArTags(_Message):
    """woosh_msgs/ArTags

    # AR tags recognised at one time.

    Header header
    ArTagPose[] ArTags
    """

    header: _std_msgs.Header
    ArTags: list[ArTagPose]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        ArTags: _Sequence[ArTagPose] = ...,
    ) -> None: ...

class ArTrackAction(_Message):
    """woosh_msgs/ArTrackAction
    """

    action_goal: ArTrackActionGoal
    action_result: ArTrackActionResult
    action_feedback: ArTrackActionFeedback
    def __init__(
        self,
        action_goal: ArTrackActionGoal = ...,
        action_result: ArTrackActionResult = ...,
        action_feedback: ArTrackActionFeedback = ...,
    ) -> None: ...

class ArTrackActionFeedback(_Message):
    """woosh_msgs/ArTrackActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: ArTrackFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: ArTrackFeedback = ...,
    ) -> None: ...

class ArTrackActionGoal(_Message):
    """woosh_msgs/ArTrackActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: ArTrackGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: ArTrackGoal = ...,
    ) -> None: ...

class ArTrackActionResult(_Message):
    """woosh_msgs/ArTrackActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: ArTrackResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: ArTrackResult = ...,
    ) -> None: ...

class ArTrackChargeAction(_Message):
    """woosh_msgs/ArTrackChargeAction
    """

    action_goal: ArTrackChargeActionGoal
    action_result: ArTrackChargeActionResult
    action_feedback: ArTrackChargeActionFeedback
    def __init__(
        self,
        action_goal: ArTrackChargeActionGoal = ...,
        action_result: ArTrackChargeActionResult = ...,
        action_feedback: ArTrackChargeActionFeedback = ...,
    ) -> None: ...

class ArTrackChargeActionFeedback(_Message):
    """woosh_msgs/ArTrackChargeActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: ArTrackChargeFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: ArTrackChargeFeedback = ...,
    ) -> None: ...

class ArTrackChargeActionGoal(_Message):
    """woosh_msgs/ArTrackChargeActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: ArTrackChargeGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: ArTrackChargeGoal = ...,
    ) -> None: ...

class ArTrackChargeActionResult(_Message):
    """woosh_msgs/ArTrackChargeActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: ArTrackChargeResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: ArTrackChargeResult = ...,
    ) -> None: ...

class ArTrackChargeFeedback(_Message):
    """woosh_msgs/ArTrackChargeFeedback

    uint64 statusCode  # error code
    """

    statusCode: int
    def __init__(
        self,
        statusCode: int = ...,
    ) -> None: ...

class ArTrackChargeGoal(_Message):
    """woosh_msgs/ArTrackChargeGoal

    # Drive to the charger by AR tags.
    # Units are what names and values suggest; the vendor does not document them.

    int32 START=0
    int32 PAUSE=1
    int32 RESUME=2

    int32 type                    # START, PAUSE or RESUME
    int32[] id_range              # tags to recognise
    float32[] marker_to_aimpoint  # from the tag to the point in front of the charger, m
    float32[] aimpoint_to_target  # from there to the charger, m
    """

    START: _ClassVar[int] = 0
    PAUSE: _ClassVar[int] = 1
    RESUME: _ClassVar[int] = 2
    type: int
    id_range: _Int32Array
    marker_to_aimpoint: _Float32Array
    aimpoint_to_target: _Float32Array
    def __init__(
        self,
        type: int = ...,
        id_range: _Integers = ...,
        marker_to_aimpoint: _Floats = ...,
        aimpoint_to_target: _Floats = ...,
    ) -> None: ...

class ArTrackChargeResult(_Message):
    """woosh_msgs/ArTrackChargeResult

    int32 SUCCESS=0
    int32 FAIL=1
    int32 CANCEL=2

    int32 result            # SUCCESS, FAIL or CANCEL
    float32 enter_distance  # m
    uint64 statusCode       # error code
    """

    SUCCESS: _ClassVar[int] = 0
    FAIL: _ClassVar[int] = 1
    CANCEL: _ClassVar[int] = 2
    result: int
    enter_distance: float
    statusCode: int
    def __init__(
        self,
        result: int = ...,
        enter_distance: float = ...,
        statusCode: int = ...,
    ) -> None: ...

class ArTrackFeedback(_Message):
    """woosh_msgs/ArTrackFeedback

    uint64 statusCode  # error code
    """

    statusCode: int
    def __init__(
        self,
        statusCode: int = ...,
    ) -> None: ...

class ArTrackGoal(_Message):
    """woosh_msgs/ArTrackGoal

    # Recognise AR tags.

    int32 START=0
    int32 PAUSE=1
    int32 RESUME=2

    int32 type        # START, PAUSE or RESUME
    int32[] id_range  # tags to recognise
    """

    START: _ClassVar[int] = 0
    PAUSE: _ClassVar[int] = 1
    RESUME: _ClassVar[int] = 2
    type: int
    id_range: _Int32Array
    def __init__(
        self,
        type: int = ...,
        id_range: _Integers = ...,
    ) -> None: ...

class ArTrackResult(_Message):
    """woosh_msgs/ArTrackResult

    int32 SUCCESS=0
    int32 FAIL=1
    int32 CANCEL=2

    int32 result           # SUCCESS, FAIL or CANCEL
    int32 tag_number       # tags recognised
    ArTagPose[] ArTagPose
    uint64 statusCode      # error code
    """

    SUCCESS: _ClassVar[int] = 0
    FAIL: _ClassVar[int] = 1
    CANCEL: _ClassVar[int] = 2
    result: int
    tag_number: int
    ArTagPose: list[_ArTagPose]
    statusCode: int
    def __init__(
        self,
        result: int = ...,
        tag_number: int = ...,
        ArTagPose: _Sequence[_ArTagPose] = ...,
        statusCode: int = ...,
    ) -> None: ...

class ArmAction(_Message):
    """woosh_msgs/ArmAction
    """

    action_goal: ArmActionGoal
    action_result: ArmActionResult
    action_feedback: ArmActionFeedback
    def __init__(
        self,
        action_goal: ArmActionGoal = ...,
        action_result: ArmActionResult = ...,
        action_feedback: ArmActionFeedback = ...,
    ) -> None: ...

class ArmActionFeedback(_Message):
    """woosh_msgs/ArmActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: ArmFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: ArmFeedback = ...,
    ) -> None: ...

class ArmActionGoal(_Message):
    """woosh_msgs/ArmActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: ArmGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: ArmGoal = ...,
    ) -> None: ...

class ArmActionResult(_Message):
    """woosh_msgs/ArmActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: ArmResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: ArmResult = ...,
    ) -> None: ...

class ArmFeedback(_Message):
    """woosh_msgs/ArmFeedback

    int8 feedback      # 4 paused, 5 resumed
    uint8 excute_type
    uint64 statusCode  # error code
    """

    feedback: int
    excute_type: int
    statusCode: int
    def __init__(
        self,
        feedback: int = ...,
        excute_type: int = ...,
        statusCode: int = ...,
    ) -> None: ...

class ArmGoal(_Message):
    """woosh_msgs/ArmGoal

    # Fetch or feed material with the arm.

    # task_type
    uint8 FETCHING=0   # fetch material
    uint8 FEEDING=1    # feed material
    uint8 RESETING=2   # back to the start

    # excute_type
    uint8 CANCEL=0
    uint8 EXCUTE=1
    uint8 PAUSE=2
    uint8 RESUM=3

    uint8 task_type    # FETCHING, FEEDING or RESETING
    uint8 excute_type  # CANCEL, EXCUTE, PAUSE or RESUM
    string task_name   # which of the taught tasks
    """

    FETCHING: _ClassVar[int] = 0
    FEEDING: _ClassVar[int] = 1
    RESETING: _ClassVar[int] = 2
    CANCEL: _ClassVar[int] = 0
    EXCUTE: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    RESUM: _ClassVar[int] = 3
    task_type: int
    excute_type: int
    task_name: str
    def __init__(
        self,
        task_type: int = ...,
        excute_type: int = ...,
        task_name: str = ...,
    ) -> None: ...

class ArmResult(_Message):
    """woosh_msgs/ArmResult

    uint8 CANCLE=1
    uint8 SUCCESS=2
    uint8 FAILED=3

    uint64 statusCode  # error code
    uint8 result       # CANCLE, SUCCESS or FAILED
    """

    CANCLE: _ClassVar[int] = 1
    SUCCESS: _ClassVar[int] = 2
    FAILED: _ClassVar[int] = 3
    statusCode: int
    result: int
    def __init__(
        self,
        statusCode: int = ...,
        result: int = ...,
    ) -> None: ...

class AutoDock2Action(_Message):
    """woosh_msgs/AutoDock2Action
    """

    action_goal: AutoDock2ActionGoal
    action_result: AutoDock2ActionResult
    action_feedback: AutoDock2ActionFeedback
    def __init__(
        self,
        action_goal: AutoDock2ActionGoal = ...,
        action_result: AutoDock2ActionResult = ...,
        action_feedback: AutoDock2ActionFeedback = ...,
    ) -> None: ...

class AutoDock2ActionFeedback(_Message):
    """woosh_msgs/AutoDock2ActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: AutoDock2Feedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: AutoDock2Feedback = ...,
    ) -> None: ...

class AutoDock2ActionGoal(_Message):
    """woosh_msgs/AutoDock2ActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: AutoDock2Goal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: AutoDock2Goal = ...,
    ) -> None: ...

class AutoDock2ActionResult(_Message):
    """woosh_msgs/AutoDock2ActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: AutoDock2Result
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: AutoDock2Result = ...,
    ) -> None: ...

class AutoDock2Feedback(_Message):
    """woosh_msgs/AutoDock2Feedback

    int8 EXECUTING=1
    int8 PAUSE=2
    int8 ILLEGAL_GOAL=1
    int8 LEGAL_GOAL=2

    uint64 err_msg       # error code
    int8 status          # EXECUTING or PAUSE
    int8 feedback        # ILLEGAL_GOAL or LEGAL_GOAL
    """

    EXECUTING: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    ILLEGAL_GOAL: _ClassVar[int] = 1
    LEGAL_GOAL: _ClassVar[int] = 2
    err_msg: int
    status: int
    feedback: int
    def __init__(
        self,
        err_msg: int = ...,
        status: int = ...,
        feedback: int = ...,
    ) -> None: ...

class AutoDock2Goal(_Message):
    """woosh_msgs/AutoDock2Goal

    # Drive into or out of a place that the laser recognises by its shape.

    # board_shape
    int8 ALL_SHAPE=0
    int8 VL_SHAPE=1
    int8 PARALLEL_SHAPE=2
    int8 CONVEX_SHAPE=3
    int8 NARROW_PASSAGE_SHAPE=4
    int8 ELEVATOR_SHAPE=5
    int8 RECTANGLE_SHAPE=6

    # type
    int8 ENTER=0
    int8 PAUSE=1
    int8 RESUM=2
    int8 LEAVE=3
    int8 RESET=4

    # dock_direction
    int8 BACKWARD=0
    int8 FRONTWARD=1

    string tag_no                    # of the target
    int8 board_shape                 # one of *_SHAPE
    int8 type                        # ENTER, PAUSE, RESUM, LEAVE or RESET
    int8 dock_direction              # BACKWARD or FRONTWARD
    geometry_msgs/Pose2D targetPose  # for a narrow passage its exit point; m and rad
    """

    ALL_SHAPE: _ClassVar[int] = 0
    VL_SHAPE: _ClassVar[int] = 1
    PARALLEL_SHAPE: _ClassVar[int] = 2
    CONVEX_SHAPE: _ClassVar[int] = 3
    NARROW_PASSAGE_SHAPE: _ClassVar[int] = 4
    ELEVATOR_SHAPE: _ClassVar[int] = 5
    RECTANGLE_SHAPE: _ClassVar[int] = 6
    ENTER: _ClassVar[int] = 0
    PAUSE: _ClassVar[int] = 1
    RESUM: _ClassVar[int] = 2
    LEAVE: _ClassVar[int] = 3
    RESET: _ClassVar[int] = 4
    BACKWARD: _ClassVar[int] = 0
    FRONTWARD: _ClassVar[int] = 1
    tag_no: str
    board_shape: int
    type: int
    dock_direction: int
    targetPose: _geometry_msgs.Pose2D
    def __init__(
        self,
        tag_no: str = ...,
        board_shape: int = ...,
        type: int = ...,
        dock_direction: int = ...,
        targetPose: _geometry_msgs.Pose2D = ...,
    ) -> None: ...

class AutoDock2Result(_Message):
    """woosh_msgs/AutoDock2Result

    int8 CANCLE=1
    int8 SUCCESS=2
    int8 FAILED=3
    uint8 EMPTY=0
    uint8 LEFT=1
    uint8 RIGHT=2
    uint8 FRONT=3
    uint8 BACK=4

    uint64 err_msg           # error code
    int8 result              # CANCLE, SUCCESS or FAILED
    uint8 feature_direction  # where the shape was seen
    """

    CANCLE: _ClassVar[int] = 1
    SUCCESS: _ClassVar[int] = 2
    FAILED: _ClassVar[int] = 3
    EMPTY: _ClassVar[int] = 0
    LEFT: _ClassVar[int] = 1
    RIGHT: _ClassVar[int] = 2
    FRONT: _ClassVar[int] = 3
    BACK: _ClassVar[int] = 4
    err_msg: int
    result: int
    feature_direction: int
    def __init__(
        self,
        err_msg: int = ...,
        result: int = ...,
        feature_direction: int = ...,
    ) -> None: ...

class AutoDockAction(_Message):
    """woosh_msgs/AutoDockAction
    """

    action_goal: AutoDockActionGoal
    action_result: AutoDockActionResult
    action_feedback: AutoDockActionFeedback
    def __init__(
        self,
        action_goal: AutoDockActionGoal = ...,
        action_result: AutoDockActionResult = ...,
        action_feedback: AutoDockActionFeedback = ...,
    ) -> None: ...

class AutoDockActionFeedback(_Message):
    """woosh_msgs/AutoDockActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: AutoDockFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: AutoDockFeedback = ...,
    ) -> None: ...

class AutoDockActionGoal(_Message):
    """woosh_msgs/AutoDockActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: AutoDockGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: AutoDockGoal = ...,
    ) -> None: ...

class AutoDockActionResult(_Message):
    """woosh_msgs/AutoDockActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: AutoDockResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: AutoDockResult = ...,
    ) -> None: ...

class AutoDockFeedback(_Message):
    """woosh_msgs/AutoDockFeedback

    int32 EXECUTING=1
    int32 PAUSE=2
    int32 ILLEGAL_GOAL=3

    uint64 err_msg        # error code
    int32 status          # EXECUTING or PAUSE
    int32 feedback
    """

    EXECUTING: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    ILLEGAL_GOAL: _ClassVar[int] = 3
    err_msg: int
    status: int
    feedback: int
    def __init__(
        self,
        err_msg: int = ...,
        status: int = ...,
        feedback: int = ...,
    ) -> None: ...

class AutoDockGoal(_Message):
    """woosh_msgs/AutoDockGoal

    # Drive under or out of a shelf, or to a station.
    # Units are what names and values suggest; the vendor does not document them.

    # type
    int32 START=0
    int32 PAUSE=1
    int32 RESUM=2
    int32 LEAVE=3
    int32 RESET=4

    # lift_type
    int32 UP=0
    int32 DOWN=1

    string tag_no                    # of the target
    int32 type                       # START, PAUSE, RESUM, LEAVE or RESET
    int32 lift_type                  # UP or DOWN
    float32 leave_distance           # m; -999 is special (not documented)
    geometry_msgs/Pose2D targetPose  # m and rad
    """

    START: _ClassVar[int] = 0
    PAUSE: _ClassVar[int] = 1
    RESUM: _ClassVar[int] = 2
    LEAVE: _ClassVar[int] = 3
    RESET: _ClassVar[int] = 4
    UP: _ClassVar[int] = 0
    DOWN: _ClassVar[int] = 1
    tag_no: str
    type: int
    lift_type: int
    leave_distance: float
    targetPose: _geometry_msgs.Pose2D
    def __init__(
        self,
        tag_no: str = ...,
        type: int = ...,
        lift_type: int = ...,
        leave_distance: float = ...,
        targetPose: _geometry_msgs.Pose2D = ...,
    ) -> None: ...

class AutoDockResult(_Message):
    """woosh_msgs/AutoDockResult

    int32 CANCLE=1
    int32 SUCCESS=2
    int32 FAILED=3
    uint8 LEFT=11
    uint8 RIGHT=12
    uint8 FRONT=13
    uint8 BACK=14

    uint64 err_msg          # error code
    int32 result            # CANCLE, SUCCESS or FAILED
    uint8 roller_direction  # LEFT, RIGHT, FRONT or BACK
    """

    CANCLE: _ClassVar[int] = 1
    SUCCESS: _ClassVar[int] = 2
    FAILED: _ClassVar[int] = 3
    LEFT: _ClassVar[int] = 11
    RIGHT: _ClassVar[int] = 12
    FRONT: _ClassVar[int] = 13
    BACK: _ClassVar[int] = 14
    err_msg: int
    result: int
    roller_direction: int
    def __init__(
        self,
        err_msg: int = ...,
        result: int = ...,
        roller_direction: int = ...,
    ) -> None: ...

class BMS(_Message):
    """woosh_msgs/BMS

    # Raw data of the battery management system, published on /driver_base/bms.
    # Units are what names and values suggest; the vendor does not document them.

    Header header
    uint32 BMSStatus
    float32 current          # A
    float32 voltageMax       # highest cell, V
    float32 voltageMin       # lowest cell, V
    float32 voltageTotal     # V
    float32 temperatureMax   # degrees Celsius
    float32 temperatureMin   # degrees Celsius
    uint16 chargeCycle       # charges so far
    float32 capacityResidue  # left, A h
    float32 capacityTotal    # A h
    uint8 switchStatus
    """

    header: _std_msgs.Header
    BMSStatus: int
    current: float
    voltageMax: float
    voltageMin: float
    voltageTotal: float
    temperatureMax: float
    temperatureMin: float
    chargeCycle: int
    capacityResidue: float
    capacityTotal: float
    switchStatus: int
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        BMSStatus: int = ...,
        current: float = ...,
        voltageMax: float = ...,
        voltageMin: float = ...,
        voltageTotal: float = ...,
        temperatureMax: float = ...,
        temperatureMin: float = ...,
        chargeCycle: int = ...,
        capacityResidue: float = ...,
        capacityTotal: float = ...,
        switchStatus: int = ...,
    ) -> None: ...

class Battery(_Message):
    """woosh_msgs/Battery

    # State of the battery, published on /battery. The vendor's page has bmsStatus before the cell
    # voltages; on the wire it is last.
    # Units are what names and values suggest; the vendor does not document them.

    uint8 manualMode=0       # charged by hand
    uint8 autoMode=1         # charged at the dock
    uint8 discharge=0
    uint8 charging=1

    Header header
    uint8 submodule          # number of the battery module
    uint8 batteryPercentage  # charge, 0 to 100 %
    uint8 chargeMode         # manualMode or autoMode
    uint8 chargeStatus       # discharge (not charging) or charging
    float32 batteryVoltage   # V
    float32 batteryCurrent   # A
    float32 timeRemain       # time left; the unit is not documented
    int8 tempMax             # warmest cell, degrees Celsius
    int8 tempMin             # coldest cell, degrees Celsius
    float32 capacityRemain   # left, A h
    float32 capacityFull     # when full, A h
    float32 capacityDesign   # when new, A h
    uint16 chargeCycle       # charges so far
    uint16 batteryCycle      # full cycles so far
    float32 cellVoltageMax   # highest cell, V
    float32 cellVoltageMin   # lowest cell, V
    uint32 bmsStatus
    """

    manualMode: _ClassVar[int] = 0
    autoMode: _ClassVar[int] = 1
    discharge: _ClassVar[int] = 0
    charging: _ClassVar[int] = 1
    header: _std_msgs.Header
    submodule: int
    batteryPercentage: int
    chargeMode: int
    chargeStatus: int
    batteryVoltage: float
    batteryCurrent: float
    timeRemain: float
    tempMax: int
    tempMin: int
    capacityRemain: float
    capacityFull: float
    capacityDesign: float
    chargeCycle: int
    batteryCycle: int
    cellVoltageMax: float
    cellVoltageMin: float
    bmsStatus: int
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        submodule: int = ...,
        batteryPercentage: int = ...,
        chargeMode: int = ...,
        chargeStatus: int = ...,
        batteryVoltage: float = ...,
        batteryCurrent: float = ...,
        timeRemain: float = ...,
        tempMax: int = ...,
        tempMin: int = ...,
        capacityRemain: float = ...,
        capacityFull: float = ...,
        capacityDesign: float = ...,
        chargeCycle: int = ...,
        batteryCycle: int = ...,
        cellVoltageMax: float = ...,
        cellVoltageMin: float = ...,
        bmsStatus: int = ...,
    ) -> None: ...

class Beacon(_Message):
    """woosh_msgs/Beacon

    # One measurement of a radio beacon.
    # Units are what names and values suggest; the vendor does not document them.

    Header header                   # frame_id is the receiver on the robot
    uint8 submodule                 # number of the receiver
    uint32 beaconID                 # as a number
    string beaconIDStr              # as a text
    geometry_msgs/Point32 position  # of the beacon in the world, m
    float32 range                   # distance, m
    float32 bearing                 # direction, rad
    float32 max_range               # m
    uint8 batteryPercentage         # of the beacon, 0 to 100 %
    uint16 group                    # beacons that belong together
    """

    header: _std_msgs.Header
    submodule: int
    beaconID: int
    beaconIDStr: str
    position: _geometry_msgs.Point32
    range: float
    bearing: float
    max_range: float
    batteryPercentage: int
    group: int
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        submodule: int = ...,
        beaconID: int = ...,
        beaconIDStr: str = ...,
        position: _geometry_msgs.Point32 = ...,
        range: float = ...,
        bearing: float = ...,
        max_range: float = ...,
        batteryPercentage: int = ...,
        group: int = ...,
    ) -> None: ...

class Beacons(_Message):
    """woosh_msgs/Beacons

    # Beacons measured at one time.

    Header header
    Beacon[] beacons
    """

    header: _std_msgs.Header
    beacons: list[Beacon]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        beacons: _Sequence[Beacon] = ...,
    ) -> None: ...

class Ble_status(_Message):
    """woosh_msgs/Ble_status

    # State of the Bluetooth link.

    bool isConnected
    bool isPaired
    bool onPairing       # pairing is going on
    string target_mac    # address of the other device
    string target_magic  # its identification
    """

    isConnected: bool
    isPaired: bool
    onPairing: bool
    target_mac: str
    target_magic: str
    def __init__(
        self,
        isConnected: bool = ...,
        isPaired: bool = ...,
        onPairing: bool = ...,
        target_mac: str = ...,
        target_magic: str = ...,
    ) -> None: ...

class Charge(_Message):
    """woosh_msgs/Charge

    # Sets the way of charging.

    uint8 manualMode=0  # by hand
    uint8 autoMode=1    # at the dock

    uint8 chargeMode    # manualMode or autoMode
    """

    manualMode: _ClassVar[int] = 0
    autoMode: _ClassVar[int] = 1
    chargeMode: int
    def __init__(
        self,
        chargeMode: int = ...,
    ) -> None: ...

class ChargeControlAction(_Message):
    """woosh_msgs/ChargeControlAction
    """

    action_goal: ChargeControlActionGoal
    action_result: ChargeControlActionResult
    action_feedback: ChargeControlActionFeedback
    def __init__(
        self,
        action_goal: ChargeControlActionGoal = ...,
        action_result: ChargeControlActionResult = ...,
        action_feedback: ChargeControlActionFeedback = ...,
    ) -> None: ...

class ChargeControlActionFeedback(_Message):
    """woosh_msgs/ChargeControlActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: ChargeControlFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: ChargeControlFeedback = ...,
    ) -> None: ...

class ChargeControlActionGoal(_Message):
    """woosh_msgs/ChargeControlActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: ChargeControlGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: ChargeControlGoal = ...,
    ) -> None: ...

class ChargeControlActionResult(_Message):
    """woosh_msgs/ChargeControlActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: ChargeControlResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: ChargeControlResult = ...,
    ) -> None: ...

class ChargeControlFeedback(_Message):
    """woosh_msgs/ChargeControlFeedback

    int8 feedback
    uint8 executeMode
    """

    feedback: int
    executeMode: int
    def __init__(
        self,
        feedback: int = ...,
        executeMode: int = ...,
    ) -> None: ...

class ChargeControlGoal(_Message):
    """woosh_msgs/ChargeControlGoal

    # Connect to the charger.

    # mode
    uint8 CANCEL=0
    uint8 EXCUTE=1
    uint8 PAUSE=2
    uint8 RESUM=3

    # executeMode
    uint8 FRONT=1
    uint8 BACK=2

    # connectMode
    uint8 NONE=0
    uint8 CHECK=1
    uint8 PROCESSCTRL=2

    uint8 mode           # CANCEL, EXCUTE, PAUSE or RESUM (vendor's spelling)
    uint8 executeMode    # FRONT or BACK
    uint8 connectMode    # NONE, CHECK or PROCESSCTRL
    """

    CANCEL: _ClassVar[int] = 0
    EXCUTE: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    RESUM: _ClassVar[int] = 3
    FRONT: _ClassVar[int] = 1
    BACK: _ClassVar[int] = 2
    NONE: _ClassVar[int] = 0
    CHECK: _ClassVar[int] = 1
    PROCESSCTRL: _ClassVar[int] = 2
    mode: int
    executeMode: int
    connectMode: int
    def __init__(
        self,
        mode: int = ...,
        executeMode: int = ...,
        connectMode: int = ...,
    ) -> None: ...

class ChargeControlResult(_Message):
    """woosh_msgs/ChargeControlResult

    int8 result        # 1 success, negative failure
    uint8 executeMode
    """

    result: int
    executeMode: int
    def __init__(
        self,
        result: int = ...,
        executeMode: int = ...,
    ) -> None: ...

class Field(_Message):
    """woosh_msgs/Field

    # An area of the map with its own driving rules.
    # Units are what names and values suggest; the vendor does not document them.

    uint32 id

    # 0 two-way lane, 1 single lane, 2 one-way lane, 3 intersection, 4 narrow passage, 5 localisation
    # area, 6 slope, 7 odometry-only area
    int32 type
    float32 slope_angle        # rad
    NavFieldPoint slope_arrow  # direction of the slope
    int32 capacity             # vehicles that may be in it
    float32 wait_time_out      # s, for nav_mode 3

    # 0 loose avoidance, 1 precise avoidance, 2 stop and wait, 3 stop and wait with a time-out, 10
    # narrow passage, 11 magnetic strip, 12 QR code
    int32 nav_mode
    float32 max_speed          # m/s, 0 means no limit
    int32 direction            # of travel
    float32 radius             # m
    float32 offset             # m
    NavFieldPoint[] vertex     # corners
    NavFieldPoint[] nav_pos    # points of the way through
    NavFieldPoint entry        # where it is entered
    NavFieldPoint extrance     # where it is left (vendor's spelling)
    """

    id: int
    type: int
    slope_angle: float
    slope_arrow: NavFieldPoint
    capacity: int
    wait_time_out: float
    nav_mode: int
    max_speed: float
    direction: int
    radius: float
    offset: float
    vertex: list[NavFieldPoint]
    nav_pos: list[NavFieldPoint]
    entry: NavFieldPoint
    extrance: NavFieldPoint
    def __init__(
        self,
        id: int = ...,
        type: int = ...,
        slope_angle: float = ...,
        slope_arrow: NavFieldPoint = ...,
        capacity: int = ...,
        wait_time_out: float = ...,
        nav_mode: int = ...,
        max_speed: float = ...,
        direction: int = ...,
        radius: float = ...,
        offset: float = ...,
        vertex: _Sequence[NavFieldPoint] = ...,
        nav_pos: _Sequence[NavFieldPoint] = ...,
        entry: NavFieldPoint = ...,
        extrance: NavFieldPoint = ...,
    ) -> None: ...

class Follower(_Message):
    """woosh_msgs/Follower

    # Measurement of a tag that a person carries for the robot to follow.
    # Units are what names and values suggest; the vendor does not document them.

    Header header
    uint8 seq           # counter of the tag
    int8 rssiFirst      # signal strength of the first path
    int8 rssiAll        # signal strength
    uint8 battery       # of the tag
    uint8 keys          # bits of pressed keys
    uint16 tagID        # number of the tag
    float32 distance    # m
    float32 angle       # rad
    uint8 anchorStatus
    uint8 quality       # of the measurement
    """

    header: _std_msgs.Header
    seq: int
    rssiFirst: int
    rssiAll: int
    battery: int
    keys: int
    tagID: int
    distance: float
    angle: float
    anchorStatus: int
    quality: int
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        seq: int = ...,
        rssiFirst: int = ...,
        rssiAll: int = ...,
        battery: int = ...,
        keys: int = ...,
        tagID: int = ...,
        distance: float = ...,
        angle: float = ...,
        anchorStatus: int = ...,
        quality: int = ...,
    ) -> None: ...

class GraphEdge(_Message):
    """woosh_msgs/GraphEdge

    # A way between two markers.
    # Units are what names and values suggest; the vendor does not document them.

    uint32 source        # marker it begins at
    uint32 target        # marker it ends at
    uint32 field_id      # area it lies in, 0 for none
    float32 weight       # cost for planning
    float32 busy_level   # how much it is used
    float32 path_length  # m
    nav_msgs/Path path
    """

    source: int
    target: int
    field_id: int
    weight: float
    busy_level: float
    path_length: float
    path: _nav_msgs.Path
    def __init__(
        self,
        source: int = ...,
        target: int = ...,
        field_id: int = ...,
        weight: float = ...,
        busy_level: float = ...,
        path_length: float = ...,
        path: _nav_msgs.Path = ...,
    ) -> None: ...

class GraphVertex(_Message):
    """woosh_msgs/GraphVertex

    # A marker as a node of the way graph.

    NavFieldPoint mark
    int32 field_id      # area it lies in, 0 for none
    """

    mark: NavFieldPoint
    field_id: int
    def __init__(
        self,
        mark: NavFieldPoint = ...,
        field_id: int = ...,
    ) -> None: ...

class IO(_Message):
    """woosh_msgs/IO

    # State of one digital input or output.

    Header header
    uint8 module     # 0x01 chassis keys, 0x02 motor, 0x03 alarm, 0x81 photoelectric sensor
    uint8 submodule  # number of the module
    uint8 id         # in the module; alarm: 0 beeper, 1 red, 2 yellow, 3 green, 4 laser
    uint8 status     # 0 default, 1 triggered, 2 stopped
    """

    header: _std_msgs.Header
    module: int
    submodule: int
    id: int
    status: int
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        module: int = ...,
        submodule: int = ...,
        id: int = ...,
        status: int = ...,
    ) -> None: ...

class IOModule(_Message):
    """woosh_msgs/IOModule

    # State of all lines of one module.

    Header header
    uint8 module     # as in IO
    uint8 submodule  # number of the module
    uint8 num        # lines
    uint32 status
    """

    header: _std_msgs.Header
    module: int
    submodule: int
    num: int
    status: int
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        module: int = ...,
        submodule: int = ...,
        num: int = ...,
        status: int = ...,
    ) -> None: ...

class IOModuleControl(_Message):
    """woosh_msgs/IOModuleControl

    # Sets lines of one module.

    uint8 mode
    uint8 module     # as in IO
    uint8 submodule
    uint32 mask
    """

    mode: int
    module: int
    submodule: int
    mask: int
    def __init__(
        self,
        mode: int = ...,
        module: int = ...,
        submodule: int = ...,
        mask: int = ...,
    ) -> None: ...

class IOs(_Message):
    """woosh_msgs/IOs

    # States of digital inputs and outputs.

    Header header
    IO[] IOs
    """

    header: _std_msgs.Header
    IOs: list[IO]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        IOs: _Sequence[IO] = ...,
    ) -> None: ...

class Information(_Message):
    """woosh_msgs/Information

    # What the chassis is, published on /information.

    Header header
    string hardwareVersion
    string softwareVersion
    string IAPSoftwareVersion  # version of the boot loader
    string movebaseType        # type of the base
    Parameter parameter        # its geometry and limits
    """

    header: _std_msgs.Header
    hardwareVersion: str
    softwareVersion: str
    IAPSoftwareVersion: str
    movebaseType: str
    parameter: Parameter
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        hardwareVersion: str = ...,
        softwareVersion: str = ...,
        IAPSoftwareVersion: str = ...,
        movebaseType: str = ...,
        parameter: Parameter = ...,
    ) -> None: ...

class JoystickConfig(_Message):
    """woosh_msgs/JoystickConfig

    # Limits for driving by joystick.
    # Units are what names and values suggest; the vendor does not document them.

    float32 maxLinear   # m/s
    float32 maxAngular  # rad/s
    """

    maxLinear: float
    maxAngular: float
    def __init__(
        self,
        maxLinear: float = ...,
        maxAngular: float = ...,
    ) -> None: ...

class LED(_Message):
    """woosh_msgs/LED

    # Drives the light strip, on /rgbled and /rgbled_shelf. The meanings are from the vendor's
    # interface page.

    uint8 submodule  # 0 all, 1 to 8 one module
    uint8 urgency    # 0x00 none, 0xFF maintenance
    uint8 abnormal   # 0x00 none, 0xFF fault

    # 0x00 none, 0x42 low battery, 0x60 following, 0x80 forward, 0x81 right turn, 0x82 left turn, 0x83
    # starting from rest, 0x84 stopped and waiting, 0x85 held by traffic control, 0xA0 warning, 0xA1
    # task running, 0xA2 task paused, 0xA3 idle, 0xA4 initialising, 0xA5 offline, 0xF0 picking, 0xF1
    # picking done (both of one customer), 0xFF normal
    uint8 normal
    uint32 color     # 24-bit RGB, 0xRRGGBB
    """

    submodule: int
    urgency: int
    abnormal: int
    normal: int
    color: int
    def __init__(
        self,
        submodule: int = ...,
        urgency: int = ...,
        abnormal: int = ...,
        normal: int = ...,
        color: int = ...,
    ) -> None: ...

class LiftControl2Action(_Message):
    """woosh_msgs/LiftControl2Action
    """

    action_goal: LiftControl2ActionGoal
    action_result: LiftControl2ActionResult
    action_feedback: LiftControl2ActionFeedback
    def __init__(
        self,
        action_goal: LiftControl2ActionGoal = ...,
        action_result: LiftControl2ActionResult = ...,
        action_feedback: LiftControl2ActionFeedback = ...,
    ) -> None: ...

class LiftControl2ActionFeedback(_Message):
    """woosh_msgs/LiftControl2ActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: LiftControl2Feedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: LiftControl2Feedback = ...,
    ) -> None: ...

class LiftControl2ActionGoal(_Message):
    """woosh_msgs/LiftControl2ActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: LiftControl2Goal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: LiftControl2Goal = ...,
    ) -> None: ...

class LiftControl2ActionResult(_Message):
    """woosh_msgs/LiftControl2ActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: LiftControl2Result
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: LiftControl2Result = ...,
    ) -> None: ...

class LiftControl2Feedback(_Message):
    """woosh_msgs/LiftControl2Feedback

    int8 feedback
    float32 height  # m
    """

    feedback: int
    height: float
    def __init__(
        self,
        feedback: int = ...,
        height: float = ...,
    ) -> None: ...

class LiftControl2Goal(_Message):
    """woosh_msgs/LiftControl2Goal

    # Move a lift that is driven by time.
    # Units are what names and values suggest; the vendor does not document them.

    uint8 CANCEL=0
    uint8 EXCUTE=1
    uint8 PAUSE=2
    uint8 RESUM=3

    uint8 mode      # CANCEL, EXCUTE, PAUSE or RESUM (vendor's spelling)
    float32 height  # m
    """

    CANCEL: _ClassVar[int] = 0
    EXCUTE: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    RESUM: _ClassVar[int] = 3
    mode: int
    height: float
    def __init__(
        self,
        mode: int = ...,
        height: float = ...,
    ) -> None: ...

class LiftControl2Result(_Message):
    """woosh_msgs/LiftControl2Result

    int8 result     # 1 success, negative failure
    float32 height  # m
    """

    result: int
    height: float
    def __init__(
        self,
        result: int = ...,
        height: float = ...,
    ) -> None: ...

class LiftControl3Action(_Message):
    """woosh_msgs/LiftControl3Action
    """

    action_goal: LiftControl3ActionGoal
    action_result: LiftControl3ActionResult
    action_feedback: LiftControl3ActionFeedback
    def __init__(
        self,
        action_goal: LiftControl3ActionGoal = ...,
        action_result: LiftControl3ActionResult = ...,
        action_feedback: LiftControl3ActionFeedback = ...,
    ) -> None: ...

class LiftControl3ActionFeedback(_Message):
    """woosh_msgs/LiftControl3ActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: LiftControl3Feedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: LiftControl3Feedback = ...,
    ) -> None: ...

class LiftControl3ActionGoal(_Message):
    """woosh_msgs/LiftControl3ActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: LiftControl3Goal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: LiftControl3Goal = ...,
    ) -> None: ...

class LiftControl3ActionResult(_Message):
    """woosh_msgs/LiftControl3ActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: LiftControl3Result
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: LiftControl3Result = ...,
    ) -> None: ...

class LiftControl3Feedback(_Message):
    """woosh_msgs/LiftControl3Feedback

    int8 feedback
    uint32 flags    # bit 7 position unreliable, bit 5 lower limit, bit 4 upper limit
    float32 height  # m
    """

    feedback: int
    flags: int
    height: float
    def __init__(
        self,
        feedback: int = ...,
        flags: int = ...,
        height: float = ...,
    ) -> None: ...

class LiftControl3Goal(_Message):
    """woosh_msgs/LiftControl3Goal

    # Move a lift with a position sensor.
    # Units are what names and values suggest; the vendor does not document them.

    # mode
    uint8 CANCEL=0
    uint8 EXCUTE=1
    uint8 PAUSE=2
    uint8 RESUM=3

    # execmode
    uint8 EXEC_QUERY=0
    uint8 EXEC_ABSOLUTE=1
    uint8 EXEC_RELATIVE=2
    uint8 EXEC_CALIBRATION=3
    uint8 EXEC_TESTMODE=5

    uint8 mode                # CANCEL, EXCUTE, PAUSE or RESUM (vendor's spelling)
    uint8 execmode            # one of EXEC_*
    float32 speed             # m/s
    float32 height            # m
    """

    CANCEL: _ClassVar[int] = 0
    EXCUTE: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    RESUM: _ClassVar[int] = 3
    EXEC_QUERY: _ClassVar[int] = 0
    EXEC_ABSOLUTE: _ClassVar[int] = 1
    EXEC_RELATIVE: _ClassVar[int] = 2
    EXEC_CALIBRATION: _ClassVar[int] = 3
    EXEC_TESTMODE: _ClassVar[int] = 5
    mode: int
    execmode: int
    speed: float
    height: float
    def __init__(
        self,
        mode: int = ...,
        execmode: int = ...,
        speed: float = ...,
        height: float = ...,
    ) -> None: ...

class LiftControl3Result(_Message):
    """woosh_msgs/LiftControl3Result

    int8 result     # 1 success, negative failure
    uint32 flags    # bit 7 position unreliable, bit 5 lower limit, bit 4 upper limit
    float32 height  # m
    """

    result: int
    flags: int
    height: float
    def __init__(
        self,
        result: int = ...,
        flags: int = ...,
        height: float = ...,
    ) -> None: ...

class LiftControlAction(_Message):
    """woosh_msgs/LiftControlAction
    """

    action_goal: LiftControlActionGoal
    action_result: LiftControlActionResult
    action_feedback: LiftControlActionFeedback
    def __init__(
        self,
        action_goal: LiftControlActionGoal = ...,
        action_result: LiftControlActionResult = ...,
        action_feedback: LiftControlActionFeedback = ...,
    ) -> None: ...

class LiftControlActionFeedback(_Message):
    """woosh_msgs/LiftControlActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: LiftControlFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: LiftControlFeedback = ...,
    ) -> None: ...

class LiftControlActionGoal(_Message):
    """woosh_msgs/LiftControlActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: LiftControlGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: LiftControlGoal = ...,
    ) -> None: ...

class LiftControlActionResult(_Message):
    """woosh_msgs/LiftControlActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: LiftControlResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: LiftControlResult = ...,
    ) -> None: ...

class LiftControlFeedback(_Message):
    """woosh_msgs/LiftControlFeedback

    int8 feedback
    uint8 executeMode
    """

    feedback: int
    executeMode: int
    def __init__(
        self,
        feedback: int = ...,
        executeMode: int = ...,
    ) -> None: ...

class LiftControlGoal(_Message):
    """woosh_msgs/LiftControlGoal

    # Move the lift up or down.

    # mode
    uint8 CANCEL=0
    uint8 EXCUTE=1
    uint8 PAUSE=2
    uint8 RESUM=3

    # executeMode
    uint8 UP=1
    uint8 DOWN=2

    uint8 mode         # CANCEL, EXCUTE, PAUSE or RESUM (vendor's spelling)
    uint8 executeMode  # UP or DOWN
    """

    CANCEL: _ClassVar[int] = 0
    EXCUTE: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    RESUM: _ClassVar[int] = 3
    UP: _ClassVar[int] = 1
    DOWN: _ClassVar[int] = 2
    mode: int
    executeMode: int
    def __init__(
        self,
        mode: int = ...,
        executeMode: int = ...,
    ) -> None: ...

class LiftControlResult(_Message):
    """woosh_msgs/LiftControlResult

    int8 result        # 1 success, negative failure
    uint8 executeMode
    """

    result: int
    executeMode: int
    def __init__(
        self,
        result: int = ...,
        executeMode: int = ...,
    ) -> None: ...

class Log(_Message):
    """woosh_msgs/Log

    # Drive log, for the vendor's own analysis.
    # Units are what names and values suggest; the vendor does not document them.

    Header header
    float32 linearX           # commanded, m/s
    float32 linearY           # commanded, m/s
    float32 angularZ          # commanded, rad/s
    float32 odometryX         # m
    float32 odometryY         # m
    float32 odometryTheta     # rad
    float32 odometryImuTheta  # with the IMU, rad
    float32 odometryLinearX   # measured, m/s
    float32 odometryLinearY   # measured, m/s
    float32 odometryAngularZ  # measured, rad/s
    float32 pwmLeft           # to the motor
    float32 pwmRight          # to the motor
    float32 rSpeedLeft        # of the wheel
    float32 rSpeedRight       # of the wheel
    int64 pulseLeft           # encoder pulses
    int64 pulseRight          # encoder pulses
    uint8 errorType
    uint8 errorStatus
    """

    header: _std_msgs.Header
    linearX: float
    linearY: float
    angularZ: float
    odometryX: float
    odometryY: float
    odometryTheta: float
    odometryImuTheta: float
    odometryLinearX: float
    odometryLinearY: float
    odometryAngularZ: float
    pwmLeft: float
    pwmRight: float
    rSpeedLeft: float
    rSpeedRight: float
    pulseLeft: int
    pulseRight: int
    errorType: int
    errorStatus: int
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        linearX: float = ...,
        linearY: float = ...,
        angularZ: float = ...,
        odometryX: float = ...,
        odometryY: float = ...,
        odometryTheta: float = ...,
        odometryImuTheta: float = ...,
        odometryLinearX: float = ...,
        odometryLinearY: float = ...,
        odometryAngularZ: float = ...,
        pwmLeft: float = ...,
        pwmRight: float = ...,
        rSpeedLeft: float = ...,
        rSpeedRight: float = ...,
        pulseLeft: int = ...,
        pulseRight: int = ...,
        errorType: int = ...,
        errorStatus: int = ...,
    ) -> None: ...

class Magnetism(_Message):
    """woosh_msgs/Magnetism

    # A reading of a magnetic strip sensor.
    # Units are what names and values suggest; the vendor does not document them.

    Header header
    uint8 submodule  # number of the sensor
    uint8 pointNum   # sensing points
    uint32 status
    float32 bias     # of the strip from the middle
    """

    header: _std_msgs.Header
    submodule: int
    pointNum: int
    status: int
    bias: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        submodule: int = ...,
        pointNum: int = ...,
        status: int = ...,
        bias: float = ...,
    ) -> None: ...

class Magnetisms(_Message):
    """woosh_msgs/Magnetisms

    # Readings of magnetic strip sensors.

    Header header
    Magnetism[] magnetisms
    """

    header: _std_msgs.Header
    magnetisms: list[Magnetism]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        magnetisms: _Sequence[Magnetism] = ...,
    ) -> None: ...

class Manekineko(_Message):
    """woosh_msgs/Manekineko

    # Moves the two arms of the waving cat.

    uint8 LeftMode
    float32 LeftRadian            # rad
    float32 LeftAngularVelocity   # rad/s
    uint8 RightMode
    float32 RightRadian           # rad
    float32 RightAngularVelocity  # rad/s
    """

    LeftMode: int
    LeftRadian: float
    LeftAngularVelocity: float
    RightMode: int
    RightRadian: float
    RightAngularVelocity: float
    def __init__(
        self,
        LeftMode: int = ...,
        LeftRadian: float = ...,
        LeftAngularVelocity: float = ...,
        RightMode: int = ...,
        RightRadian: float = ...,
        RightAngularVelocity: float = ...,
    ) -> None: ...

class MapModifyData(_Message):
    """woosh_msgs/MapModifyData

    # One edit of the map.

    Header header
    int8 action               # 0 draw a point, 1 draw a line, 2 erase, 3 crop
    geometry_msgs/Pose start
    geometry_msgs/Pose end
    """

    header: _std_msgs.Header
    action: int
    start: _geometry_msgs.Pose
    end: _geometry_msgs.Pose
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        action: int = ...,
        start: _geometry_msgs.Pose = ...,
        end: _geometry_msgs.Pose = ...,
    ) -> None: ...

class ModeConfig(_Message):
    """woosh_msgs/ModeConfig

    # Sets a mode of the chassis.

    uint8 mode
    uint8 status
    """

    mode: int
    status: int
    def __init__(
        self,
        mode: int = ...,
        status: int = ...,
    ) -> None: ...

class MoveBaseAction(_Message):
    """woosh_msgs/MoveBaseAction
    """

    action_goal: MoveBaseActionGoal
    action_result: MoveBaseActionResult
    action_feedback: MoveBaseActionFeedback
    def __init__(
        self,
        action_goal: MoveBaseActionGoal = ...,
        action_result: MoveBaseActionResult = ...,
        action_feedback: MoveBaseActionFeedback = ...,
    ) -> None: ...

class MoveBaseActionFeedback(_Message):
    """woosh_msgs/MoveBaseActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: MoveBaseFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: MoveBaseFeedback = ...,
    ) -> None: ...

class MoveBaseActionGoal(_Message):
    """woosh_msgs/MoveBaseActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: MoveBaseGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: MoveBaseGoal = ...,
    ) -> None: ...

class MoveBaseActionResult(_Message):
    """woosh_msgs/MoveBaseActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: MoveBaseResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: MoveBaseResult = ...,
    ) -> None: ...

class MoveBaseFeedback(_Message):
    """woosh_msgs/MoveBaseFeedback

    geometry_msgs/PoseStamped base_position  # current pose of the robot
    int64 nav_state                          # state of the navigation
    """

    base_position: _geometry_msgs.PoseStamped
    nav_state: int
    def __init__(
        self,
        base_position: _geometry_msgs.PoseStamped = ...,
        nav_state: int = ...,
    ) -> None: ...

class MoveBaseGoal(_Message):
    """woosh_msgs/MoveBaseGoal

    # Navigate to a pose. target_pose is always needed, also with a path.

    geometry_msgs/PoseStamped[] poses      # path in the map frame, empty to let the robot plan
    geometry_msgs/PoseStamped target_pose  # in the map frame
    uint8 execution_mode                   # 0 free, 1 visit the points one by one
    """

    poses: list[_geometry_msgs.PoseStamped]
    target_pose: _geometry_msgs.PoseStamped
    execution_mode: int
    def __init__(
        self,
        poses: _Sequence[_geometry_msgs.PoseStamped] = ...,
        target_pose: _geometry_msgs.PoseStamped = ...,
        execution_mode: int = ...,
    ) -> None: ...

class MoveBaseResult(_Message):
    """woosh_msgs/MoveBaseResult
    """

    def __init__(self) -> None: ...

class MultiMapNavigationAction(_Message):
    """woosh_msgs/MultiMapNavigationAction
    """

    action_goal: MultiMapNavigationActionGoal
    action_result: MultiMapNavigationActionResult
    action_feedback: MultiMapNavigationActionFeedback
    def __init__(
        self,
        action_goal: MultiMapNavigationActionGoal = ...,
        action_result: MultiMapNavigationActionResult = ...,
        action_feedback: MultiMapNavigationActionFeedback = ...,
    ) -> None: ...

class MultiMapNavigationActionFeedback(_Message):
    """woosh_msgs/MultiMapNavigationActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: MultiMapNavigationFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: MultiMapNavigationFeedback = ...,
    ) -> None: ...

class MultiMapNavigationActionGoal(_Message):
    """woosh_msgs/MultiMapNavigationActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: MultiMapNavigationGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: MultiMapNavigationGoal = ...,
    ) -> None: ...

class MultiMapNavigationActionResult(_Message):
    """woosh_msgs/MultiMapNavigationActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: MultiMapNavigationResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: MultiMapNavigationResult = ...,
    ) -> None: ...

class MultiMapNavigationFeedback(_Message):
    """woosh_msgs/MultiMapNavigationFeedback

    int32 wormhole_feedback  # 1 the point of the map change is reached, 0 failed
    """

    wormhole_feedback: int
    def __init__(
        self,
        wormhole_feedback: int = ...,
    ) -> None: ...

class MultiMapNavigationGoal(_Message):
    """woosh_msgs/MultiMapNavigationGoal

    # Navigate to a pose on another map.

    string map_name                        # map of the target
    geometry_msgs/PoseStamped target_pose
    """

    map_name: str
    target_pose: _geometry_msgs.PoseStamped
    def __init__(
        self,
        map_name: str = ...,
        target_pose: _geometry_msgs.PoseStamped = ...,
    ) -> None: ...

class MultiMapNavigationResult(_Message):
    """woosh_msgs/MultiMapNavigationResult

    int32 result  # 1 reached, 0 failed
    """

    result: int
    def __init__(
        self,
        result: int = ...,
    ) -> None: ...

class NavFieldPoint(_Message):
    """woosh_msgs/NavFieldPoint

    # A point of an area or of the way graph.

    geometry_msgs/Point pt  # of the marker, m
    uint32 id               # of the marker
    """

    pt: _geometry_msgs.Point
    id: int
    def __init__(
        self,
        pt: _geometry_msgs.Point = ...,
        id: int = ...,
    ) -> None: ...

class NavFields(_Message):
    """woosh_msgs/NavFields

    # All areas of a map.

    Field[] fields
    """

    fields: list[Field]
    def __init__(
        self,
        fields: _Sequence[Field] = ...,
    ) -> None: ...

class NavMode(_Message):
    """woosh_msgs/NavMode

    # Tells that the robot has entered or left an area with its own driving rules. The field `in` is a
    # Python keyword: use getattr(msg, "in").

    uint32 id                # of the area

    # 0 two-way lane, 1 single lane, 2 one-way lane, 3 intersection, 4 narrow passage, 5 localisation
    # area, 6 slope, 7 odometry-only area, 8 automatic door, 9 speed limit
    int32 type
    int8 triggered_mode      # 0 entered a polygon, 1 left a polygon, 2 entered a circle, 3 left a circle
    geometry_msgs/Point in   # entry point, m
    geometry_msgs/Point out  # exit point, m
    """

    id: int
    type: int
    triggered_mode: int
    # in: _geometry_msgs.Point  # a Python keyword: getattr(message, "in")
    out: _geometry_msgs.Point
    def __init__(
        self,
        id: int = ...,
        type: int = ...,
        triggered_mode: int = ...,
        out: _geometry_msgs.Point = ...,
        **others: object,
    ) -> None: ...

class NavPath(_Message):
    """woosh_msgs/NavPath

    # A path with where it comes from.

    nav_msgs/Path path
    uint32 path_type        # 0 updated by move_base, 1 sent back
    uint32 path_check_code
    """

    path: _nav_msgs.Path
    path_type: int
    path_check_code: int
    def __init__(
        self,
        path: _nav_msgs.Path = ...,
        path_type: int = ...,
        path_check_code: int = ...,
    ) -> None: ...

class NavigationModeAction(_Message):
    """woosh_msgs/NavigationModeAction
    """

    action_goal: NavigationModeActionGoal
    action_result: NavigationModeActionResult
    action_feedback: NavigationModeActionFeedback
    def __init__(
        self,
        action_goal: NavigationModeActionGoal = ...,
        action_result: NavigationModeActionResult = ...,
        action_feedback: NavigationModeActionFeedback = ...,
    ) -> None: ...

class NavigationModeActionFeedback(_Message):
    """woosh_msgs/NavigationModeActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: NavigationModeFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: NavigationModeFeedback = ...,
    ) -> None: ...

class NavigationModeActionGoal(_Message):
    """woosh_msgs/NavigationModeActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: NavigationModeGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: NavigationModeGoal = ...,
    ) -> None: ...

class NavigationModeActionResult(_Message):
    """woosh_msgs/NavigationModeActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: NavigationModeResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: NavigationModeResult = ...,
    ) -> None: ...

class NavigationModeFeedback(_Message):
    """woosh_msgs/NavigationModeFeedback

    geometry_msgs/PoseStamped base_position  # current pose of the robot
    """

    base_position: _geometry_msgs.PoseStamped
    def __init__(
        self,
        base_position: _geometry_msgs.PoseStamped = ...,
    ) -> None: ...

class NavigationModeGoal(_Message):
    """woosh_msgs/NavigationModeGoal

    # Set how obstacles are met while navigating.

    uint32 id                # of the lane (area)
    uint8 navigation_mode    # 0 loose avoidance, 1 precise avoidance, 2 stop and wait, 3 wait, then avoid

    # s. With mode 3: greater than 0, otherwise mode 3 counts as 1; the vendor's page allows 0
    float32 waiting_timeout
    float32 max_speed        # m/s, 0 or less keeps the configured one
    bool permitted_passage   # a changed path may be followed
    uint32 capacity          # vehicles in the lane
    uint32 nav_dir           # 0 the robot decides, 1 forward, 2 backward, 3 along the path
    """

    id: int
    navigation_mode: int
    waiting_timeout: float
    max_speed: float
    permitted_passage: bool
    capacity: int
    nav_dir: int
    def __init__(
        self,
        id: int = ...,
        navigation_mode: int = ...,
        waiting_timeout: float = ...,
        max_speed: float = ...,
        permitted_passage: bool = ...,
        capacity: int = ...,
        nav_dir: int = ...,
    ) -> None: ...

class NavigationModeResult(_Message):
    """woosh_msgs/NavigationModeResult

    int32 result  # 1 success, 0 failure
    """

    result: int
    def __init__(
        self,
        result: int = ...,
    ) -> None: ...

class Obstacle(_Message):
    """woosh_msgs/Obstacle

    # Obstacles as point clouds.

    Header header
    sensor_msgs/PointCloud2[] obstacl_pointclouds  # vendor's spelling
    """

    header: _std_msgs.Header
    obstacl_pointclouds: list[_sensor_msgs.PointCloud2]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        obstacl_pointclouds: _Sequence[_sensor_msgs.PointCloud2] = ...,
    ) -> None: ...

class OdomCtrolAvoidObstacleAction(_Message):
    """woosh_msgs/OdomCtrolAvoidObstacleAction
    """

    action_goal: OdomCtrolAvoidObstacleActionGoal
    action_result: OdomCtrolAvoidObstacleActionResult
    action_feedback: OdomCtrolAvoidObstacleActionFeedback
    def __init__(
        self,
        action_goal: OdomCtrolAvoidObstacleActionGoal = ...,
        action_result: OdomCtrolAvoidObstacleActionResult = ...,
        action_feedback: OdomCtrolAvoidObstacleActionFeedback = ...,
    ) -> None: ...

class OdomCtrolAvoidObstacleActionFeedback(_Message):
    """woosh_msgs/OdomCtrolAvoidObstacleActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: OdomCtrolAvoidObstacleFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: OdomCtrolAvoidObstacleFeedback = ...,
    ) -> None: ...

class OdomCtrolAvoidObstacleActionGoal(_Message):
    """woosh_msgs/OdomCtrolAvoidObstacleActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: OdomCtrolAvoidObstacleGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: OdomCtrolAvoidObstacleGoal = ...,
    ) -> None: ...

class OdomCtrolAvoidObstacleActionResult(_Message):
    """woosh_msgs/OdomCtrolAvoidObstacleActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: OdomCtrolAvoidObstacleResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: OdomCtrolAvoidObstacleResult = ...,
    ) -> None: ...

class OdomCtrolAvoidObstacleFeedback(_Message):
    """woosh_msgs/OdomCtrolAvoidObstacleFeedback

    int32 EXECUTING=1
    int32 PAUSE=2
    int32 OBSTACLE_AVOIDING=10
    int32 AVOID_SUCCESS=11
    int32 ILLEGAL_GOAL=12

    float32 percent             # of the way done
    uint64 err_msg              # error code
    int32 status                # one of EXECUTING to ILLEGAL_GOAL
    int32 feedback
    """

    EXECUTING: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    OBSTACLE_AVOIDING: _ClassVar[int] = 10
    AVOID_SUCCESS: _ClassVar[int] = 11
    ILLEGAL_GOAL: _ClassVar[int] = 12
    percent: float
    err_msg: int
    status: int
    feedback: int
    def __init__(
        self,
        percent: float = ...,
        err_msg: int = ...,
        status: int = ...,
        feedback: int = ...,
    ) -> None: ...

class OdomCtrolAvoidObstacleGoal(_Message):
    """woosh_msgs/OdomCtrolAvoidObstacleGoal

    # Move by odometry and watch for obstacles.
    # Units are what names and values suggest; the vendor does not document them.

    int32 STRAIGHT=0
    int32 ROTATE=1
    int32 PAUSE=2
    int32 RESUM=3

    float32 arg                           # m or rad, by arg_type; negative is backward
    float32 speed                         # m/s or rad/s
    int32 arg_type                        # STRAIGHT, ROTATE, PAUSE or RESUM
    int32 useMoveAvoid                    # 0 obstacle avoidance on, 1 off
    float32 close_obstacleDetect_percent  # of the way after which detection stops, default 100
    float32 xMax                          # watched area ahead, m
    float32 xMin                          # m
    float32 yMax                          # m
    float32 yMin                          # m
    """

    STRAIGHT: _ClassVar[int] = 0
    ROTATE: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    RESUM: _ClassVar[int] = 3
    arg: float
    speed: float
    arg_type: int
    useMoveAvoid: int
    close_obstacleDetect_percent: float
    xMax: float
    xMin: float
    yMax: float
    yMin: float
    def __init__(
        self,
        arg: float = ...,
        speed: float = ...,
        arg_type: int = ...,
        useMoveAvoid: int = ...,
        close_obstacleDetect_percent: float = ...,
        xMax: float = ...,
        xMin: float = ...,
        yMax: float = ...,
        yMin: float = ...,
    ) -> None: ...

class OdomCtrolAvoidObstacleResult(_Message):
    """woosh_msgs/OdomCtrolAvoidObstacleResult

    int32 CANCLE=1
    int32 SUCCESS=2
    int32 FAILED=3

    uint64 err_msg              # error code
    int32 result                # CANCLE, SUCCESS or FAILED
    float32 remaining_distance  # m
    """

    CANCLE: _ClassVar[int] = 1
    SUCCESS: _ClassVar[int] = 2
    FAILED: _ClassVar[int] = 3
    err_msg: int
    result: int
    remaining_distance: float
    def __init__(
        self,
        err_msg: int = ...,
        result: int = ...,
        remaining_distance: float = ...,
    ) -> None: ...

class Parameter(_Message):
    """woosh_msgs/Parameter

    # Geometry and limits of the base, published on /driver_base/parameter. The vendor's page has
    # pulsePerCircle as float32 and another order of the same size: decoded by that, the values are
    # wrong without an error.
    # Units are what names and values suggest; the vendor does not document them.

    Header header
    float32 wheelPerimeter      # m
    float32 wheelDistant        # between the wheels, m
    float32 ratioLeft           # reduction of the left drive
    float32 ratioRight          # reduction of the right drive
    uint32 pulsePerCircle       # encoder pulses per turn
    float32 maxRPM              # of the motor, 1/min
    float32 minSpeed            # m/s
    float32 maxLinear           # m/s
    float32 maxAngular          # rad/s
    float32 joystickMaxLinear   # m/s
    float32 joystickMaxAngular  # rad/s
    float32 maxSpeed            # m/s
    """

    header: _std_msgs.Header
    wheelPerimeter: float
    wheelDistant: float
    ratioLeft: float
    ratioRight: float
    pulsePerCircle: int
    maxRPM: float
    minSpeed: float
    maxLinear: float
    maxAngular: float
    joystickMaxLinear: float
    joystickMaxAngular: float
    maxSpeed: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        wheelPerimeter: float = ...,
        wheelDistant: float = ...,
        ratioLeft: float = ...,
        ratioRight: float = ...,
        pulsePerCircle: int = ...,
        maxRPM: float = ...,
        minSpeed: float = ...,
        maxLinear: float = ...,
        maxAngular: float = ...,
        joystickMaxLinear: float = ...,
        joystickMaxAngular: float = ...,
        maxSpeed: float = ...,
    ) -> None: ...

class Path_info(_Message):
    """woosh_msgs/Path_info

    # All paths of a map.

    mono_path[] mono_paths
    bidirect_path[] bidirect_paths
    """

    mono_paths: list[mono_path]
    bidirect_paths: list[bidirect_path]
    def __init__(
        self,
        mono_paths: _Sequence[mono_path] = ...,
        bidirect_paths: _Sequence[bidirect_path] = ...,
    ) -> None: ...

class PathesGraph(_Message):
    """woosh_msgs/PathesGraph

    # Way graph of a map.

    GraphVertex[] vertices
    GraphEdge[] edges
    """

    vertices: list[GraphVertex]
    edges: list[GraphEdge]
    def __init__(
        self,
        vertices: _Sequence[GraphVertex] = ...,
        edges: _Sequence[GraphEdge] = ...,
    ) -> None: ...

class PeripheralConfig(_Message):
    """woosh_msgs/PeripheralConfig

    # Configures a device on the chassis.

    uint8 deviceType
    uint16 deviceNum
    uint16 setNum
    uint8[] config    # device specific bytes
    """

    deviceType: int
    deviceNum: int
    setNum: int
    config: _UInt8Array
    def __init__(
        self,
        deviceType: int = ...,
        deviceNum: int = ...,
        setNum: int = ...,
        config: _Octets = ...,
    ) -> None: ...

class RFID(_Message):
    """woosh_msgs/RFID

    # A read RFID tag.

    Header header
    uint8 submodule  # number of the reader
    uint16 rfidType  # kind of tag
    uint16 rfid      # number of the tag
    uint8 flag
    uint8 signal     # strength
    """

    header: _std_msgs.Header
    submodule: int
    rfidType: int
    rfid: int
    flag: int
    signal: int
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        submodule: int = ...,
        rfidType: int = ...,
        rfid: int = ...,
        flag: int = ...,
        signal: int = ...,
    ) -> None: ...

class RFIDs(_Message):
    """woosh_msgs/RFIDs

    # Read RFID tags.

    Header header
    RFID[] RFIDs
    """

    header: _std_msgs.Header
    RFIDs: list[RFID]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        RFIDs: _Sequence[RFID] = ...,
    ) -> None: ...

class Ranges(_Message):
    """woosh_msgs/Ranges

    # Readings of range sensors.

    Header header
    sensor_msgs/Range[] ranges
    """

    header: _std_msgs.Header
    ranges: list[_sensor_msgs.Range]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        ranges: _Sequence[_sensor_msgs.Range] = ...,
    ) -> None: ...

class RfRemoteController(_Message):
    """woosh_msgs/RfRemoteController

    # Keys of the radio remote control.

    Header header
    uint32 address  # of the remote control
    uint8 keys      # bits of pressed keys
    """

    header: _std_msgs.Header
    address: int
    keys: int
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        address: int = ...,
        keys: int = ...,
    ) -> None: ...

class RobotInfo(_Message):
    """woosh_msgs/RobotInfo

    # Size and sensors of the robot.
    # Units are what names and values suggest; the vendor does not document them.

    float32 length                   # m
    float32 width                    # m
    uint8 laserNum
    uint8 cameraNum
    geometry_msgs/Pose[] beaconPose
    """

    length: float
    width: float
    laserNum: int
    cameraNum: int
    beaconPose: list[_geometry_msgs.Pose]
    def __init__(
        self,
        length: float = ...,
        width: float = ...,
        laserNum: int = ...,
        cameraNum: int = ...,
        beaconPose: _Sequence[_geometry_msgs.Pose] = ...,
    ) -> None: ...

class RobotStatus(_Message):
    """woosh_msgs/RobotStatus

    # Task and robot state, published on /robot_status on change only. Take unknown values as
    # possible.

    uint64 task_id     # of the running task
    int32 task_type    # 0 undefined, 1 pick, 2 park, 3 charge, 4 carry

    # 0 undefined, 3 running, 4 paused, 5 waiting for an action, 7 completed, 8 cancelled, 9 failed;
    # newer robots may send 1 initialising, 2 prepared, 6 waiting for a task
    int8 task_state

    # 0 undefined, 1 navigation, 2 step control, 3 secondary positioning: enter, 4 leave, 5 carry
    # action, 6 wait, 7 charge
    int8 action_type

    # 0 undefined, 1 running, 2 warning, 3 cancelled, 4 completed, 5 failed, 10 paused, 11 held by
    # traffic control
    int8 action_state

    # 0 undefined, 1 not initialised, 2 idle, 3 parking, 4 in a task, 5 warning, 6 fault, 8 charging,
    # 9 mapping; newer robots may send 7 following
    int8 robot_state
    int8 robot_mode    # 0 undefined, 1 automatic, 2 manual, 3 maintenance
    int8 work_mode     # 0 undefined, 1 deployment, 2 task, 3 dispatched by a fleet
    int32 wait_id      # of the action that is waited for
    string dest        # target mark
    string msg         # for a person
    int32 time         # of the last update, s
    """

    task_id: int
    task_type: int
    task_state: int
    action_type: int
    action_state: int
    robot_state: int
    robot_mode: int
    work_mode: int
    wait_id: int
    dest: str
    msg: str
    time: int
    def __init__(
        self,
        task_id: int = ...,
        task_type: int = ...,
        task_state: int = ...,
        action_type: int = ...,
        action_state: int = ...,
        robot_state: int = ...,
        robot_mode: int = ...,
        work_mode: int = ...,
        wait_id: int = ...,
        dest: str = ...,
        msg: str = ...,
        time: int = ...,
    ) -> None: ...

class RollerControlAction(_Message):
    """woosh_msgs/RollerControlAction
    """

    action_goal: RollerControlActionGoal
    action_result: RollerControlActionResult
    action_feedback: RollerControlActionFeedback
    def __init__(
        self,
        action_goal: RollerControlActionGoal = ...,
        action_result: RollerControlActionResult = ...,
        action_feedback: RollerControlActionFeedback = ...,
    ) -> None: ...

class RollerControlActionFeedback(_Message):
    """woosh_msgs/RollerControlActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: RollerControlFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: RollerControlFeedback = ...,
    ) -> None: ...

class RollerControlActionGoal(_Message):
    """woosh_msgs/RollerControlActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: RollerControlGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: RollerControlGoal = ...,
    ) -> None: ...

class RollerControlActionResult(_Message):
    """woosh_msgs/RollerControlActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: RollerControlResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: RollerControlResult = ...,
    ) -> None: ...

class RollerControlFeedback(_Message):
    """woosh_msgs/RollerControlFeedback

    int8 feedback
    uint8 executeMode
    int8 feedbackSlave  # of the other conveyor
    """

    feedback: int
    executeMode: int
    feedbackSlave: int
    def __init__(
        self,
        feedback: int = ...,
        executeMode: int = ...,
        feedbackSlave: int = ...,
    ) -> None: ...

class RollerControlGoal(_Message):
    """woosh_msgs/RollerControlGoal

    # Load or unload with the roller conveyor.

    # mode
    uint8 CANCEL=0
    uint8 EXCUTE=1
    uint8 PAUSE=2
    uint8 RESUM=3

    # executeMode
    uint8 FRONT_LOAD=1
    uint8 FRONT_UNLOAD=2
    uint8 BACK_LOAD=3
    uint8 BACK_UNLOAD=4

    # connectMode
    uint8 NONE=0
    uint8 CHECK=1
    uint8 PROCESSCTRL=2

    uint8 mode            # CANCEL, EXCUTE, PAUSE or RESUM (vendor's spelling)
    uint8 executeMode     # FRONT_LOAD to BACK_UNLOAD
    uint8 connectMode     # NONE, CHECK or PROCESSCTRL
    """

    CANCEL: _ClassVar[int] = 0
    EXCUTE: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    RESUM: _ClassVar[int] = 3
    FRONT_LOAD: _ClassVar[int] = 1
    FRONT_UNLOAD: _ClassVar[int] = 2
    BACK_LOAD: _ClassVar[int] = 3
    BACK_UNLOAD: _ClassVar[int] = 4
    NONE: _ClassVar[int] = 0
    CHECK: _ClassVar[int] = 1
    PROCESSCTRL: _ClassVar[int] = 2
    mode: int
    executeMode: int
    connectMode: int
    def __init__(
        self,
        mode: int = ...,
        executeMode: int = ...,
        connectMode: int = ...,
    ) -> None: ...

class RollerControlResult(_Message):
    """woosh_msgs/RollerControlResult

    int8 result        # 1 success, negative failure
    uint8 executeMode
    """

    result: int
    executeMode: int
    def __init__(
        self,
        result: int = ...,
        executeMode: int = ...,
    ) -> None: ...

class ScannerStatus(_Message):
    """woosh_msgs/ScannerStatus

    # State of a safety scanner.

    Header header
    uint8 seq           # counter
    uint8 safety_case   # active monitoring case
    uint8 cut_off_path
    uint8 status
    """

    header: _std_msgs.Header
    seq: int
    safety_case: int
    cut_off_path: int
    status: int
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        seq: int = ...,
        safety_case: int = ...,
        cut_off_path: int = ...,
        status: int = ...,
    ) -> None: ...

class SecondPositionAction(_Message):
    """woosh_msgs/SecondPositionAction
    """

    action_goal: SecondPositionActionGoal
    action_result: SecondPositionActionResult
    action_feedback: SecondPositionActionFeedback
    def __init__(
        self,
        action_goal: SecondPositionActionGoal = ...,
        action_result: SecondPositionActionResult = ...,
        action_feedback: SecondPositionActionFeedback = ...,
    ) -> None: ...

class SecondPositionActionFeedback(_Message):
    """woosh_msgs/SecondPositionActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: SecondPositionFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: SecondPositionFeedback = ...,
    ) -> None: ...

class SecondPositionActionGoal(_Message):
    """woosh_msgs/SecondPositionActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: SecondPositionGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: SecondPositionGoal = ...,
    ) -> None: ...

class SecondPositionActionResult(_Message):
    """woosh_msgs/SecondPositionActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: SecondPositionResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: SecondPositionResult = ...,
    ) -> None: ...

class SecondPositionFeedback(_Message):
    """woosh_msgs/SecondPositionFeedback

    int8 feedback
    uint8 executeMode
    uint16 rfid
    """

    feedback: int
    executeMode: int
    rfid: int
    def __init__(
        self,
        feedback: int = ...,
        executeMode: int = ...,
        rfid: int = ...,
    ) -> None: ...

class SecondPositionGoal(_Message):
    """woosh_msgs/SecondPositionGoal

    # Position precisely by magnetic strip or RFID.
    # Units are what names and values suggest; the vendor does not document them.

    # mode
    uint8 CANCEL=0
    uint8 EXCUTE=1
    uint8 PAUSE=2
    uint8 RESUM=3

    # executeMode
    uint8 MAG_FRONT=1
    uint8 MAG_BACK=2
    uint8 RFID_FRONT=3
    uint8 RFID_BACK=4

    uint8 mode          # CANCEL, EXCUTE, PAUSE or RESUM (vendor's spelling)
    uint8 executeMode   # MAG_FRONT to RFID_BACK
    uint16 rfid         # tag to stop at
    """

    CANCEL: _ClassVar[int] = 0
    EXCUTE: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    RESUM: _ClassVar[int] = 3
    MAG_FRONT: _ClassVar[int] = 1
    MAG_BACK: _ClassVar[int] = 2
    RFID_FRONT: _ClassVar[int] = 3
    RFID_BACK: _ClassVar[int] = 4
    mode: int
    executeMode: int
    rfid: int
    def __init__(
        self,
        mode: int = ...,
        executeMode: int = ...,
        rfid: int = ...,
    ) -> None: ...

class SecondPositionResult(_Message):
    """woosh_msgs/SecondPositionResult

    int8 result        # 1 success, negative failure
    uint8 executeMode
    uint16 rfid
    float32 distance   # m
    """

    result: int
    executeMode: int
    rfid: int
    distance: float
    def __init__(
        self,
        result: int = ...,
        executeMode: int = ...,
        rfid: int = ...,
        distance: float = ...,
    ) -> None: ...

class StepControl(_Message):
    """woosh_msgs/StepControl

    # One step of a combined move; see the StepControl action.

    uint8 executeMode  # 1 straight, 2 rotate, 3 lateral, 4 oblique

    # 1: + forward, m; 2: + counter-clockwise, rad; 3: + left, m; 4: m. At most 10 m or 62.8318 rad
    float32 data
    float32 speed      # m/s, for 2 rad/s; default 0.2 m/s, 0.1 rad/s
    float32 angle      # direction of an oblique move, + left, rad
    """

    executeMode: int
    data: float
    speed: float
    angle: float
    def __init__(
        self,
        executeMode: int = ...,
        data: float = ...,
        speed: float = ...,
        angle: float = ...,
    ) -> None: ...

class StepControlAction(_Message):
    """woosh_msgs/StepControlAction
    """

    action_goal: StepControlActionGoal
    action_result: StepControlActionResult
    action_feedback: StepControlActionFeedback
    def __init__(
        self,
        action_goal: StepControlActionGoal = ...,
        action_result: StepControlActionResult = ...,
        action_feedback: StepControlActionFeedback = ...,
    ) -> None: ...

class StepControlActionFeedback(_Message):
    """woosh_msgs/StepControlActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: StepControlFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: StepControlFeedback = ...,
    ) -> None: ...

class StepControlActionGoal(_Message):
    """woosh_msgs/StepControlActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: StepControlGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: StepControlGoal = ...,
    ) -> None: ...

class StepControlActionResult(_Message):
    """woosh_msgs/StepControlActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: StepControlResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: StepControlResult = ...,
    ) -> None: ...

class StepControlFeedback(_Message):
    """woosh_msgs/StepControlFeedback

    int8 feedback      # not documented for ROS 1
    uint8 executeMode  # of the current step
    float32 percent    # of the step done
    """

    feedback: int
    executeMode: int
    percent: float
    def __init__(
        self,
        feedback: int = ...,
        executeMode: int = ...,
        percent: float = ...,
    ) -> None: ...

class StepControlGoal(_Message):
    """woosh_msgs/StepControlGoal

    # Precise combined moves, on /cmd_vel_control. After a pause send the remaining steps again.

    # mode
    uint8 CANCEL=0
    uint8 EXCUTE=1
    uint8 PAUSE=2
    uint8 RESUM=3

    # executeMode of a step
    uint8 STRAIGHT=1
    uint8 ROTATE=2
    uint8 LATERAL=3
    uint8 DIAGONALIZE=4

    uint8 mode                 # CANCEL, EXCUTE, PAUSE or RESUM (vendor's spelling)
    bool useAvoid              # true obstacle avoidance on, false off
    StepControl[] stepControl  # the steps, in order
    """

    CANCEL: _ClassVar[int] = 0
    EXCUTE: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    RESUM: _ClassVar[int] = 3
    STRAIGHT: _ClassVar[int] = 1
    ROTATE: _ClassVar[int] = 2
    LATERAL: _ClassVar[int] = 3
    DIAGONALIZE: _ClassVar[int] = 4
    mode: int
    useAvoid: bool
    stepControl: list[StepControl]
    def __init__(
        self,
        mode: int = ...,
        useAvoid: bool = ...,
        stepControl: _Sequence[StepControl] = ...,
    ) -> None: ...

class StepControlResult(_Message):
    """woosh_msgs/StepControlResult

    int8 result        # 1 success, negative failure
    uint8 executeMode  # of the last step
    float32 percent    # of the step done
    """

    result: int
    executeMode: int
    percent: float
    def __init__(
        self,
        result: int = ...,
        executeMode: int = ...,
        percent: float = ...,
    ) -> None: ...

class StepCtrlAvoidObstacleAction(_Message):
    """woosh_msgs/StepCtrlAvoidObstacleAction
    """

    action_goal: StepCtrlAvoidObstacleActionGoal
    action_result: StepCtrlAvoidObstacleActionResult
    action_feedback: StepCtrlAvoidObstacleActionFeedback
    def __init__(
        self,
        action_goal: StepCtrlAvoidObstacleActionGoal = ...,
        action_result: StepCtrlAvoidObstacleActionResult = ...,
        action_feedback: StepCtrlAvoidObstacleActionFeedback = ...,
    ) -> None: ...

class StepCtrlAvoidObstacleActionFeedback(_Message):
    """woosh_msgs/StepCtrlAvoidObstacleActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: StepCtrlAvoidObstacleFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: StepCtrlAvoidObstacleFeedback = ...,
    ) -> None: ...

class StepCtrlAvoidObstacleActionGoal(_Message):
    """woosh_msgs/StepCtrlAvoidObstacleActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: StepCtrlAvoidObstacleGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: StepCtrlAvoidObstacleGoal = ...,
    ) -> None: ...

class StepCtrlAvoidObstacleActionResult(_Message):
    """woosh_msgs/StepCtrlAvoidObstacleActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: StepCtrlAvoidObstacleResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: StepCtrlAvoidObstacleResult = ...,
    ) -> None: ...

class StepCtrlAvoidObstacleFeedback(_Message):
    """woosh_msgs/StepCtrlAvoidObstacleFeedback

    float32 obstacle_distance  # m
    """

    obstacle_distance: float
    def __init__(
        self,
        obstacle_distance: float = ...,
    ) -> None: ...

class StepCtrlAvoidObstacleGoal(_Message):
    """woosh_msgs/StepCtrlAvoidObstacleGoal

    # Move a step and watch for obstacles.
    # Units are what names and values suggest; the vendor does not document them.

    float32 arg     # m or rad, by arg_type; negative is backward
    float32 speed   # m/s or rad/s
    int32 arg_type  # 1 arg is a distance, 2 a rotation
    int32 mode      # 1 the action moves the robot, 2 it only reports the nearest obstacle
    int32 timeout   # wait when an obstacle is met, s
    """

    arg: float
    speed: float
    arg_type: int
    mode: int
    timeout: int
    def __init__(
        self,
        arg: float = ...,
        speed: float = ...,
        arg_type: int = ...,
        mode: int = ...,
        timeout: int = ...,
    ) -> None: ...

class StepCtrlAvoidObstacleResult(_Message):
    """woosh_msgs/StepCtrlAvoidObstacleResult

    int32 result               # 0 success, 1 failure, 2 cancelled
    string err_msg
    float32 obstacle_distance  # m
    """

    result: int
    err_msg: str
    obstacle_distance: float
    def __init__(
        self,
        result: int = ...,
        err_msg: str = ...,
        obstacle_distance: float = ...,
    ) -> None: ...

class TagLocalizationAction(_Message):
    """woosh_msgs/TagLocalizationAction
    """

    action_goal: TagLocalizationActionGoal
    action_result: TagLocalizationActionResult
    action_feedback: TagLocalizationActionFeedback
    def __init__(
        self,
        action_goal: TagLocalizationActionGoal = ...,
        action_result: TagLocalizationActionResult = ...,
        action_feedback: TagLocalizationActionFeedback = ...,
    ) -> None: ...

class TagLocalizationActionFeedback(_Message):
    """woosh_msgs/TagLocalizationActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: TagLocalizationFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: TagLocalizationFeedback = ...,
    ) -> None: ...

class TagLocalizationActionGoal(_Message):
    """woosh_msgs/TagLocalizationActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: TagLocalizationGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: TagLocalizationGoal = ...,
    ) -> None: ...

class TagLocalizationActionResult(_Message):
    """woosh_msgs/TagLocalizationActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: TagLocalizationResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: TagLocalizationResult = ...,
    ) -> None: ...

class TagLocalizationFeedback(_Message):
    """woosh_msgs/TagLocalizationFeedback
    """

    def __init__(self) -> None: ...

class TagLocalizationGoal(_Message):
    """woosh_msgs/TagLocalizationGoal

    # Localise by tags.

    string tag_no
    int32 type     # 1 two tags, triangulation
    float32 theta  # deviation at the target, rad
    """

    tag_no: str
    type: int
    theta: float
    def __init__(
        self,
        tag_no: str = ...,
        type: int = ...,
        theta: float = ...,
    ) -> None: ...

class TagLocalizationResult(_Message):
    """woosh_msgs/TagLocalizationResult

    int32 result    # 0 success, 1 failure, 2 cancelled
    string err_msg
    """

    result: int
    err_msg: str
    def __init__(
        self,
        result: int = ...,
        err_msg: str = ...,
    ) -> None: ...

class TractorControlAction(_Message):
    """woosh_msgs/TractorControlAction
    """

    action_goal: TractorControlActionGoal
    action_result: TractorControlActionResult
    action_feedback: TractorControlActionFeedback
    def __init__(
        self,
        action_goal: TractorControlActionGoal = ...,
        action_result: TractorControlActionResult = ...,
        action_feedback: TractorControlActionFeedback = ...,
    ) -> None: ...

class TractorControlActionFeedback(_Message):
    """woosh_msgs/TractorControlActionFeedback
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    feedback: TractorControlFeedback
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        feedback: TractorControlFeedback = ...,
    ) -> None: ...

class TractorControlActionGoal(_Message):
    """woosh_msgs/TractorControlActionGoal
    """

    header: _std_msgs.Header
    goal_id: _actionlib_msgs.GoalID
    goal: TractorControlGoal
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        goal_id: _actionlib_msgs.GoalID = ...,
        goal: TractorControlGoal = ...,
    ) -> None: ...

class TractorControlActionResult(_Message):
    """woosh_msgs/TractorControlActionResult
    """

    header: _std_msgs.Header
    status: _actionlib_msgs.GoalStatus
    result: TractorControlResult
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: _actionlib_msgs.GoalStatus = ...,
        result: TractorControlResult = ...,
    ) -> None: ...

class TractorControlFeedback(_Message):
    """woosh_msgs/TractorControlFeedback

    int8 feedback
    uint8 executeMode
    """

    feedback: int
    executeMode: int
    def __init__(
        self,
        feedback: int = ...,
        executeMode: int = ...,
    ) -> None: ...

class TractorControlGoal(_Message):
    """woosh_msgs/TractorControlGoal

    # Lock or unlock the tow hook.

    # mode
    uint8 CANCEL=0
    uint8 EXCUTE=1
    uint8 PAUSE=2
    uint8 RESUM=3

    # executeMode
    uint8 LOCK=1
    uint8 UNLOCK=2

    uint8 mode         # CANCEL, EXCUTE, PAUSE or RESUM (vendor's spelling)
    uint8 executeMode  # LOCK or UNLOCK
    """

    CANCEL: _ClassVar[int] = 0
    EXCUTE: _ClassVar[int] = 1
    PAUSE: _ClassVar[int] = 2
    RESUM: _ClassVar[int] = 3
    LOCK: _ClassVar[int] = 1
    UNLOCK: _ClassVar[int] = 2
    mode: int
    executeMode: int
    def __init__(
        self,
        mode: int = ...,
        executeMode: int = ...,
    ) -> None: ...

class TractorControlResult(_Message):
    """woosh_msgs/TractorControlResult

    int8 result        # 1 success, negative failure
    uint8 executeMode
    """

    result: int
    executeMode: int
    def __init__(
        self,
        result: int = ...,
        executeMode: int = ...,
    ) -> None: ...

class Weight(_Message):
    """woosh_msgs/Weight

    # A reading of the scales.
    # Units are what names and values suggest; the vendor does not document them.

    Header header
    bool isOverweighted
    float32 weight       # kg
    """

    header: _std_msgs.Header
    isOverweighted: bool
    weight: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        isOverweighted: bool = ...,
        weight: float = ...,
    ) -> None: ...

class WheelConfig(_Message):
    """woosh_msgs/WheelConfig

    # Wheel geometry.
    # Units are what names and values suggest; the vendor does not document them.

    float32 wheelPerimeter  # m
    float32 wheelDistant    # between the wheels, m
    """

    wheelPerimeter: float
    wheelDistant: float
    def __init__(
        self,
        wheelPerimeter: float = ...,
        wheelDistant: float = ...,
    ) -> None: ...

class WiFiStatus(_Message):
    """woosh_msgs/WiFiStatus

    # State of the Wi-Fi link.

    string data  # for a program, vendor's format
    """

    data: str
    def __init__(
        self,
        data: str = ...,
    ) -> None: ...

class WooshRosbagRecord(_Message):
    """woosh_msgs/WooshRosbagRecord

    # Starts and stops recording on the robot.

    bool startOrstop  # true start, false stop
    bool removeBag    # true delete the recording, false keep it
    """

    startOrstop: bool
    removeBag: bool
    def __init__(
        self,
        startOrstop: bool = ...,
        removeBag: bool = ...,
    ) -> None: ...

class bidirect_path(_Message):
    """woosh_msgs/bidirect_path

    # A path that may be driven in both directions.

    nav_msgs/Path path
    bool allow_avoid    # obstacles may be driven around
    """

    path: _nav_msgs.Path
    allow_avoid: bool
    def __init__(
        self,
        path: _nav_msgs.Path = ...,
        allow_avoid: bool = ...,
    ) -> None: ...

class deployment_marker(_Message):
    """woosh_msgs/deployment_marker

    # A marker found while a site is set up.

    uint32 markerID
    geometry_msgs/Pose pose  # m and rad
    uint16 group             # markers that belong together
    """

    markerID: int
    pose: _geometry_msgs.Pose
    group: int
    def __init__(
        self,
        markerID: int = ...,
        pose: _geometry_msgs.Pose = ...,
        group: int = ...,
    ) -> None: ...

class deployment_markers(_Message):
    """woosh_msgs/deployment_markers

    # Markers found while a site is set up, in the frame of the header.

    Header header
    deployment_marker[] markers
    """

    header: _std_msgs.Header
    markers: list[deployment_marker]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        markers: _Sequence[deployment_marker] = ...,
    ) -> None: ...

class mono_path(_Message):
    """woosh_msgs/mono_path

    # A path that is driven in one direction.
    # Units are what names and values suggest; the vendor does not document them.

    nav_msgs/Path path
    float32 width       # of the lane, m
    bool allow_avoid    # obstacles may be driven around
    """

    path: _nav_msgs.Path
    width: float
    allow_avoid: bool
    def __init__(
        self,
        path: _nav_msgs.Path = ...,
        width: float = ...,
        allow_avoid: bool = ...,
    ) -> None: ...

class reflector_errorID(_Message):
    """woosh_msgs/reflector_errorID

    # Three reflectors that cannot be told from another three.

    uint32 ID1
    uint32 ID2
    uint32 ID3
    """

    ID1: int
    ID2: int
    ID3: int
    def __init__(
        self,
        ID1: int = ...,
        ID2: int = ...,
        ID3: int = ...,
    ) -> None: ...

class reflector_errorID_group(_Message):
    """woosh_msgs/reflector_errorID_group

    # Groups of reflectors that are alike.

    reflector_errorID[] reflector_errorIDs
    """

    reflector_errorIDs: list[reflector_errorID]
    def __init__(
        self,
        reflector_errorIDs: _Sequence[reflector_errorID] = ...,
    ) -> None: ...

class wooshRosbagRecord(_Message):
    """woosh_msgs/wooshRosbagRecord

    # Starts and stops recording on the robot.

    bool startOrstop  # true start, false stop
    bool removeBag    # true delete the recording, false keep it
    """

    startOrstop: bool
    removeBag: bool
    def __init__(
        self,
        startOrstop: bool = ...,
        removeBag: bool = ...,
    ) -> None: ...

_ArTagPose = ArTagPose
