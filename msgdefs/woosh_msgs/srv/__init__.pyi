# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of woosh_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import TypeAlias as _TypeAlias

import msgdefs.geometry_msgs.msg as _geometry_msgs
import msgdefs.nav_msgs.msg as _nav_msgs
import msgdefs.woosh_msgs.msg as _woosh_msgs
from msgdefs._fields import Float32Array as _Float32Array
from msgdefs._fields import Floats as _Floats
from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType

class AddReflectorsRequest(_Message):
    """woosh_msgs/AddReflectorsRequest

    # Add, use or delete reflectors of the map.

    bool isSave           # true add new reflectors to the map, false localise by them
    bool deleteReflector  # delete reflectors of the map
    uint32 id             # reflector to delete
    """

    isSave: bool
    deleteReflector: bool
    id: int
    def __init__(
        self,
        isSave: bool = ...,
        deleteReflector: bool = ...,
        id: int = ...,
    ) -> None: ...

class AddReflectorsResponse(_Message):
    """woosh_msgs/AddReflectorsResponse
    """

    def __init__(self) -> None: ...

class AddReflectors(_ServiceType):
    """woosh_msgs/AddReflectors
    """

    Request: _TypeAlias = AddReflectorsRequest
    Response: _TypeAlias = AddReflectorsResponse

class AddWiFiRequest(_Message):
    """woosh_msgs/AddWiFiRequest

    # Add a Wi-Fi network.

    string wifi_parameter  # network and password, vendor's format
    bool connect_now
    """

    wifi_parameter: str
    connect_now: bool
    def __init__(
        self,
        wifi_parameter: str = ...,
        connect_now: bool = ...,
    ) -> None: ...

class AddWiFiResponse(_Message):
    """woosh_msgs/AddWiFiResponse

    int32 status
    string message
    """

    status: int
    message: str
    def __init__(
        self,
        status: int = ...,
        message: str = ...,
    ) -> None: ...

class AddWiFi(_ServiceType):
    """woosh_msgs/AddWiFi
    """

    Request: _TypeAlias = AddWiFiRequest
    Response: _TypeAlias = AddWiFiResponse

class ArTrackLocateRequest(_Message):
    """woosh_msgs/ArTrackLocateRequest

    # Locate an AR tag.

    int8 type  # 0 start
    """

    type: int
    def __init__(
        self,
        type: int = ...,
    ) -> None: ...

class ArTrackLocateResponse(_Message):
    """woosh_msgs/ArTrackLocateResponse

    bool success
    string message
    ArTagPose ar_tag_pose
    """

    success: bool
    message: str
    ar_tag_pose: _woosh_msgs.ArTagPose
    def __init__(
        self,
        success: bool = ...,
        message: str = ...,
        ar_tag_pose: _woosh_msgs.ArTagPose = ...,
    ) -> None: ...

class ArTrackLocate(_ServiceType):
    """woosh_msgs/ArTrackLocate
    """

    Request: _TypeAlias = ArTrackLocateRequest
    Response: _TypeAlias = ArTrackLocateResponse

class BeaconListRequest(_Message):
    """woosh_msgs/BeaconListRequest

    # Get or save the list of beacons.

    bool isSave          # true save the list, false get it
    Beacon[] beaconList
    """

    isSave: bool
    beaconList: list[_woosh_msgs.Beacon]
    def __init__(
        self,
        isSave: bool = ...,
        beaconList: _Sequence[_woosh_msgs.Beacon] = ...,
    ) -> None: ...

class BeaconListResponse(_Message):
    """woosh_msgs/BeaconListResponse

    Beacon[] beaconList
    string message
    """

    beaconList: list[_woosh_msgs.Beacon]
    message: str
    def __init__(
        self,
        beaconList: _Sequence[_woosh_msgs.Beacon] = ...,
        message: str = ...,
    ) -> None: ...

class BeaconList(_ServiceType):
    """woosh_msgs/BeaconList
    """

    Request: _TypeAlias = BeaconListRequest
    Response: _TypeAlias = BeaconListResponse

class DeploymentRequest(_Message):
    """woosh_msgs/DeploymentRequest

    # Collect markers while a site is set up.

    int8 type  # 0 beacons, 1 AR tag, 2 reflector
    int8 mode  # 0 start collecting, 1 cancel, 2 check reflectors
    """

    type: int
    mode: int
    def __init__(
        self,
        type: int = ...,
        mode: int = ...,
    ) -> None: ...

class DeploymentResponse(_Message):
    """woosh_msgs/DeploymentResponse

    bool success
    string message
    bool point1Valid
    bool point2Valid
    bool point3Valid
    uint8 collectedNumber                             # samples so far, three are needed
    int8 numberOfFailBeacons
    deployment_markers markers                        # in the map frame
    reflector_errorID_group[] reflector_errorID_groups
    """

    success: bool
    message: str
    point1Valid: bool
    point2Valid: bool
    point3Valid: bool
    collectedNumber: int
    numberOfFailBeacons: int
    markers: _woosh_msgs.deployment_markers
    reflector_errorID_groups: list[_woosh_msgs.reflector_errorID_group]
    def __init__(
        self,
        success: bool = ...,
        message: str = ...,
        point1Valid: bool = ...,
        point2Valid: bool = ...,
        point3Valid: bool = ...,
        collectedNumber: int = ...,
        numberOfFailBeacons: int = ...,
        markers: _woosh_msgs.deployment_markers = ...,
        reflector_errorID_groups: _Sequence[_woosh_msgs.reflector_errorID_group] = ...,
    ) -> None: ...

class Deployment(_ServiceType):
    """woosh_msgs/Deployment
    """

    Request: _TypeAlias = DeploymentRequest
    Response: _TypeAlias = DeploymentResponse

class DisableHotSpotRequest(_Message):
    """woosh_msgs/DisableHotSpotRequest

    # Stop the robot's own Wi-Fi.
    """

    def __init__(self) -> None: ...

class DisableHotSpotResponse(_Message):
    """woosh_msgs/DisableHotSpotResponse

    int32 status
    string message
    """

    status: int
    message: str
    def __init__(
        self,
        status: int = ...,
        message: str = ...,
    ) -> None: ...

class DisableHotSpot(_ServiceType):
    """woosh_msgs/DisableHotSpot
    """

    Request: _TypeAlias = DisableHotSpotRequest
    Response: _TypeAlias = DisableHotSpotResponse

class DriverFreeRequest(_Message):
    """woosh_msgs/DriverFreeRequest

    # Let the wheels turn freely, so that the robot can be pushed.

    uint8 mode   # 0 query, 1 set
    bool status  # true free
    """

    mode: int
    status: bool
    def __init__(
        self,
        mode: int = ...,
        status: bool = ...,
    ) -> None: ...

class DriverFreeResponse(_Message):
    """woosh_msgs/DriverFreeResponse

    bool status
    bool success
    string message
    """

    status: bool
    success: bool
    message: str
    def __init__(
        self,
        status: bool = ...,
        success: bool = ...,
        message: str = ...,
    ) -> None: ...

class DriverFree(_ServiceType):
    """woosh_msgs/DriverFree
    """

    Request: _TypeAlias = DriverFreeRequest
    Response: _TypeAlias = DriverFreeResponse

class EnableHotSpotRequest(_Message):
    """woosh_msgs/EnableHotSpotRequest

    # Start the robot's own Wi-Fi.
    """

    def __init__(self) -> None: ...

class EnableHotSpotResponse(_Message):
    """woosh_msgs/EnableHotSpotResponse

    int32 status
    string message
    """

    status: int
    message: str
    def __init__(
        self,
        status: int = ...,
        message: str = ...,
    ) -> None: ...

class EnableHotSpot(_ServiceType):
    """woosh_msgs/EnableHotSpot
    """

    Request: _TypeAlias = EnableHotSpotRequest
    Response: _TypeAlias = EnableHotSpotResponse

class ExecTaskRequest(_Message):
    """woosh_msgs/ExecTaskRequest

    # Run, pause, resume or cancel a task. The vendor's page spells task_exec and statuscode.

    # 1 execute, 2 pause, 3 resume, 4 cancel, 6 interrupt a wait; newer robots also 5 recover, 7
    # traffic control, 8 release it
    uint8 task_exect
    int64 task_id                      # chosen by the caller
    uint8 task_type                    # 1 pick, 2 park, 3 charge, 4 carry
    uint8 direction                    # 0 undefined, 1 load, 2 unload; 0 unless loading
    uint32 task_type_no                # combination of types for one project, default 0

    # target mark; with it poses may be empty, and a given path must end there
    string mark_no
    geometry_msgs/PoseStamped[] poses  # path in the map frame; one pose alone is a target to plan to
    byte custom                        # for one project
    """

    task_exect: int
    task_id: int
    task_type: int
    direction: int
    task_type_no: int
    mark_no: str
    poses: list[_geometry_msgs.PoseStamped]
    custom: int
    def __init__(
        self,
        task_exect: int = ...,
        task_id: int = ...,
        task_type: int = ...,
        direction: int = ...,
        task_type_no: int = ...,
        mark_no: str = ...,
        poses: _Sequence[_geometry_msgs.PoseStamped] = ...,
        custom: int = ...,
    ) -> None: ...

class ExecTaskResponse(_Message):
    """woosh_msgs/ExecTaskResponse

    bool success
    string message

    # 1 not initialised, 2 idle, 3 parking, 4 in a task, 5 warning, 6 fault, 8 charging, 9 mapping
    uint64 statusCode
    """

    success: bool
    message: str
    statusCode: int
    def __init__(
        self,
        success: bool = ...,
        message: str = ...,
        statusCode: int = ...,
    ) -> None: ...

class ExecTask(_ServiceType):
    """woosh_msgs/ExecTask
    """

    Request: _TypeAlias = ExecTaskRequest
    Response: _TypeAlias = ExecTaskResponse

class FollowCtlRequest(_Message):
    """woosh_msgs/FollowCtlRequest

    # Control following.

    int32 function
    int32 command
    string message
    """

    function: int
    command: int
    message: str
    def __init__(
        self,
        function: int = ...,
        command: int = ...,
        message: str = ...,
    ) -> None: ...

class FollowCtlResponse(_Message):
    """woosh_msgs/FollowCtlResponse

    int32 status
    """

    status: int
    def __init__(
        self,
        status: int = ...,
    ) -> None: ...

class FollowCtl(_ServiceType):
    """woosh_msgs/FollowCtl
    """

    Request: _TypeAlias = FollowCtlRequest
    Response: _TypeAlias = FollowCtlResponse

class ForgetWiFiRequest(_Message):
    """woosh_msgs/ForgetWiFiRequest

    # Remove a Wi-Fi network.

    string ssid
    """

    ssid: str
    def __init__(
        self,
        ssid: str = ...,
    ) -> None: ...

class ForgetWiFiResponse(_Message):
    """woosh_msgs/ForgetWiFiResponse

    int32 status
    string message
    """

    status: int
    message: str
    def __init__(
        self,
        status: int = ...,
        message: str = ...,
    ) -> None: ...

class ForgetWiFi(_ServiceType):
    """woosh_msgs/ForgetWiFi
    """

    Request: _TypeAlias = ForgetWiFiRequest
    Response: _TypeAlias = ForgetWiFiResponse

class GetAvailableWiFiListRequest(_Message):
    """woosh_msgs/GetAvailableWiFiListRequest

    # List the Wi-Fi networks in range.

    int32 timeout  # s
    """

    timeout: int
    def __init__(
        self,
        timeout: int = ...,
    ) -> None: ...

class GetAvailableWiFiListResponse(_Message):
    """woosh_msgs/GetAvailableWiFiListResponse

    int32 status
    string message
    string wifi_list
    """

    status: int
    message: str
    wifi_list: str
    def __init__(
        self,
        status: int = ...,
        message: str = ...,
        wifi_list: str = ...,
    ) -> None: ...

class GetAvailableWiFiList(_ServiceType):
    """woosh_msgs/GetAvailableWiFiList
    """

    Request: _TypeAlias = GetAvailableWiFiListRequest
    Response: _TypeAlias = GetAvailableWiFiListResponse

class GetLastErrorRequest(_Message):
    """woosh_msgs/GetLastErrorRequest

    # Read the last error.

    bool clear  # forget it afterwards
    """

    clear: bool
    def __init__(
        self,
        clear: bool = ...,
    ) -> None: ...

class GetLastErrorResponse(_Message):
    """woosh_msgs/GetLastErrorResponse

    string last_error
    """

    last_error: str
    def __init__(
        self,
        last_error: str = ...,
    ) -> None: ...

class GetLastError(_ServiceType):
    """woosh_msgs/GetLastError
    """

    Request: _TypeAlias = GetLastErrorRequest
    Response: _TypeAlias = GetLastErrorResponse

class InitPoseRequest(_Message):
    """woosh_msgs/InitPoseRequest

    # Set the robot's pose on the map.

    geometry_msgs/PoseWithCovarianceStamped initial_pose
    """

    initial_pose: _geometry_msgs.PoseWithCovarianceStamped
    def __init__(
        self,
        initial_pose: _geometry_msgs.PoseWithCovarianceStamped = ...,
    ) -> None: ...

class InitPoseResponse(_Message):
    """woosh_msgs/InitPoseResponse

    bool success
    """

    success: bool
    def __init__(
        self,
        success: bool = ...,
    ) -> None: ...

class InitPose(_ServiceType):
    """woosh_msgs/InitPose
    """

    Request: _TypeAlias = InitPoseRequest
    Response: _TypeAlias = InitPoseResponse

class PowerOffRequest(_Message):
    """woosh_msgs/PowerOffRequest

    # Switch the robot off.
    """

    def __init__(self) -> None: ...

class PowerOffResponse(_Message):
    """woosh_msgs/PowerOffResponse
    """

    def __init__(self) -> None: ...

class PowerOff(_ServiceType):
    """woosh_msgs/PowerOff
    """

    Request: _TypeAlias = PowerOffRequest
    Response: _TypeAlias = PowerOffResponse

class RebootRequest(_Message):
    """woosh_msgs/RebootRequest

    # Restart the robot.
    """

    def __init__(self) -> None: ...

class RebootResponse(_Message):
    """woosh_msgs/RebootResponse
    """

    def __init__(self) -> None: ...

class Reboot(_ServiceType):
    """woosh_msgs/Reboot
    """

    Request: _TypeAlias = RebootRequest
    Response: _TypeAlias = RebootResponse

class SaveMapRequest(_Message):
    """woosh_msgs/SaveMapRequest

    # Save a map.

    string pathName             # empty for a default
    bool useSavedMap            # publish it as the static map afterwards
    Beacon[] beaconList         # saved with the map
    bool eraseBeaconList        # delete all beacon data; only with an empty beaconList
    string topic                # save the map of this topic; empty: save the field map
    nav_msgs/OccupancyGrid map
    """

    pathName: str
    useSavedMap: bool
    beaconList: list[_woosh_msgs.Beacon]
    eraseBeaconList: bool
    topic: str
    map: _nav_msgs.OccupancyGrid
    def __init__(
        self,
        pathName: str = ...,
        useSavedMap: bool = ...,
        beaconList: _Sequence[_woosh_msgs.Beacon] = ...,
        eraseBeaconList: bool = ...,
        topic: str = ...,
        map: _nav_msgs.OccupancyGrid = ...,
    ) -> None: ...

class SaveMapResponse(_Message):
    """woosh_msgs/SaveMapResponse

    bool success
    string message
    """

    success: bool
    message: str
    def __init__(
        self,
        success: bool = ...,
        message: str = ...,
    ) -> None: ...

class SaveMap(_ServiceType):
    """woosh_msgs/SaveMap
    """

    Request: _TypeAlias = SaveMapRequest
    Response: _TypeAlias = SaveMapResponse

class ScanMatchInfoRequest(_Message):
    """woosh_msgs/ScanMatchInfoRequest

    # Get or store a scan match.

    bool get_scan_match                   # true get, false save or update
    geometry_msgs/PoseStamped match_pose
    """

    get_scan_match: bool
    match_pose: _geometry_msgs.PoseStamped
    def __init__(
        self,
        get_scan_match: bool = ...,
        match_pose: _geometry_msgs.PoseStamped = ...,
    ) -> None: ...

class ScanMatchInfoResponse(_Message):
    """woosh_msgs/ScanMatchInfoResponse

    bool success
    string message
    int32 valid
    float32[] x       # x and y in m, theta in rad
    int32 iterations
    int32 nvalid
    float32 error
    """

    success: bool
    message: str
    valid: int
    x: _Float32Array
    iterations: int
    nvalid: int
    error: float
    def __init__(
        self,
        success: bool = ...,
        message: str = ...,
        valid: int = ...,
        x: _Floats = ...,
        iterations: int = ...,
        nvalid: int = ...,
        error: float = ...,
    ) -> None: ...

class ScanMatchInfo(_ServiceType):
    """woosh_msgs/ScanMatchInfo
    """

    Request: _TypeAlias = ScanMatchInfoRequest
    Response: _TypeAlias = ScanMatchInfoResponse

class SetMapMergeRequest(_Message):
    """woosh_msgs/SetMapMergeRequest

    # Start merging maps.

    bool start_map_merge
    geometry_msgs/Pose initial_pose
    nav_msgs/OccupancyGrid map
    """

    start_map_merge: bool
    initial_pose: _geometry_msgs.Pose
    map: _nav_msgs.OccupancyGrid
    def __init__(
        self,
        start_map_merge: bool = ...,
        initial_pose: _geometry_msgs.Pose = ...,
        map: _nav_msgs.OccupancyGrid = ...,
    ) -> None: ...

class SetMapMergeResponse(_Message):
    """woosh_msgs/SetMapMergeResponse

    bool success
    string message
    """

    success: bool
    message: str
    def __init__(
        self,
        success: bool = ...,
        message: str = ...,
    ) -> None: ...

class SetMapMerge(_ServiceType):
    """woosh_msgs/SetMapMerge
    """

    Request: _TypeAlias = SetMapMergeRequest
    Response: _TypeAlias = SetMapMergeResponse

class SetMapServerRequest(_Message):
    """woosh_msgs/SetMapServerRequest

    # Start or stop publishing the static map.

    bool startMapServer
    string pathName      # of the map's yaml file; empty for the last one
    """

    startMapServer: bool
    pathName: str
    def __init__(
        self,
        startMapServer: bool = ...,
        pathName: str = ...,
    ) -> None: ...

class SetMapServerResponse(_Message):
    """woosh_msgs/SetMapServerResponse

    bool success
    string message
    """

    success: bool
    message: str
    def __init__(
        self,
        success: bool = ...,
        message: str = ...,
    ) -> None: ...

class SetMapServer(_ServiceType):
    """woosh_msgs/SetMapServer
    """

    Request: _TypeAlias = SetMapServerRequest
    Response: _TypeAlias = SetMapServerResponse

class SetSafetyFieldRequest(_Message):
    """woosh_msgs/SetSafetyFieldRequest

    # Choose the field of the safety scanner.

    uint8 safetyField
    """

    safetyField: int
    def __init__(
        self,
        safetyField: int = ...,
    ) -> None: ...

class SetSafetyFieldResponse(_Message):
    """woosh_msgs/SetSafetyFieldResponse

    bool enable
    uint8 safetyField
    bool success
    string message
    """

    enable: bool
    safetyField: int
    success: bool
    message: str
    def __init__(
        self,
        enable: bool = ...,
        safetyField: int = ...,
        success: bool = ...,
        message: str = ...,
    ) -> None: ...

class SetSafetyField(_ServiceType):
    """woosh_msgs/SetSafetyField
    """

    Request: _TypeAlias = SetSafetyFieldRequest
    Response: _TypeAlias = SetSafetyFieldResponse

class TriggerWiFiReconnectRequest(_Message):
    """woosh_msgs/TriggerWiFiReconnectRequest

    # Connect to the Wi-Fi again.

    string parameter
    """

    parameter: str
    def __init__(
        self,
        parameter: str = ...,
    ) -> None: ...

class TriggerWiFiReconnectResponse(_Message):
    """woosh_msgs/TriggerWiFiReconnectResponse

    int32 status
    string message
    """

    status: int
    message: str
    def __init__(
        self,
        status: int = ...,
        message: str = ...,
    ) -> None: ...

class TriggerWiFiReconnect(_ServiceType):
    """woosh_msgs/TriggerWiFiReconnect
    """

    Request: _TypeAlias = TriggerWiFiReconnectRequest
    Response: _TypeAlias = TriggerWiFiReconnectResponse

class WooshInitRequest(_Message):
    """woosh_msgs/WooshInitRequest

    # Initialise the robot.
    """

    def __init__(self) -> None: ...

class WooshInitResponse(_Message):
    """woosh_msgs/WooshInitResponse

    bool success
    string message
    """

    success: bool
    message: str
    def __init__(
        self,
        success: bool = ...,
        message: str = ...,
    ) -> None: ...

class WooshInit(_ServiceType):
    """woosh_msgs/WooshInit
    """

    Request: _TypeAlias = WooshInitRequest
    Response: _TypeAlias = WooshInitResponse

class getRoadMapRequest(_Message):
    """woosh_msgs/getRoadMapRequest

    # Hand over roads.

    geometry_msgs/Point[] one_way   # points of one-way roads, m
    geometry_msgs/Point[] bidirect  # points of two-way roads, m
    """

    one_way: list[_geometry_msgs.Point]
    bidirect: list[_geometry_msgs.Point]
    def __init__(
        self,
        one_way: _Sequence[_geometry_msgs.Point] = ...,
        bidirect: _Sequence[_geometry_msgs.Point] = ...,
    ) -> None: ...

class getRoadMapResponse(_Message):
    """woosh_msgs/getRoadMapResponse
    """

    def __init__(self) -> None: ...

class getRoadMap(_ServiceType):
    """woosh_msgs/getRoadMap
    """

    Request: _TypeAlias = getRoadMapRequest
    Response: _TypeAlias = getRoadMapResponse

class wooshInitRequest(_Message):
    """woosh_msgs/wooshInitRequest

    # Initialise the robot.
    """

    def __init__(self) -> None: ...

class wooshInitResponse(_Message):
    """woosh_msgs/wooshInitResponse

    bool success
    string message
    """

    success: bool
    message: str
    def __init__(
        self,
        success: bool = ...,
        message: str = ...,
    ) -> None: ...

class wooshInit(_ServiceType):
    """woosh_msgs/wooshInit
    """

    Request: _TypeAlias = wooshInitRequest
    Response: _TypeAlias = wooshInitResponse
