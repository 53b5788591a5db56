"""The rows of `woosh_pure.interface`: every topic, service and action of the chassis, written down once.

Sources: the vendor's public interface page ("page"), and the graph of a real chassis ("seen"). Types are
those of woosh_msgs 1.1.4, which is what is on the wire where the page differs. Node names are those of the
real graph, or assumed (`node_assumed`) where its listing did not show who provides a row. Two services are in
the vendor's message package only ("package"): their names are assumed, and clients find them by their type.
"""

from __future__ import annotations

from woosh_pure.interface.schema import Row

_BASE = "/mobile_base_nodelet_manager"
_RI = "/ros_interface"
_MOVE = "/move_base"
_LOC = "/woosh_localization"


def _read(name: str, type_: str, feed: str, meaning: str, unit: str = "", **more: object) -> Row:
    return Row(name, type_, "topic", "read", meaning, unit, feed=feed, **more)  # type: ignore[arg-type]


def _write(name: str, type_: str, meaning: str, unit: str = "", **more: object) -> Row:
    return Row(name, type_, "topic", "write", meaning, unit, **more)  # type: ignore[arg-type]


def _call(name: str, type_: str, node: str, meaning: str, **more: object) -> Row:
    return Row(name, type_, "service", "call", meaning, providers=(node,), **more)  # type: ignore[arg-type]


def _act(name: str, type_: str, node: str, meaning: str, **more: object) -> Row:
    return Row(name, type_, "action", "act", meaning, providers=(node,), **more)  # type: ignore[arg-type]


_STATUS_NODES = (
    "/woosh_robot_pose_ekf",
    "/woosh_move_with_avoid_node",
    _MOVE,
    _LOC,
    "/woosh_auto_dock_node",
    _BASE,
)
_TF_NODES = (
    "/robot_state_publisher",
    "/woosh_robot_pose_ekf",
    "/woosh_passages_control",
    _LOC,
    "/woosh_auto_dock_guiway",
    _BASE,
    "/woosh_auto_dock_node",
    _MOVE,
)
_LOCAL_FOOTPRINT_NODES = (
    "/woosh_move_with_avoid_node",
    "/woosh_laser_verify_node",
    "/woosh_passages_control",
    _LOC,
    "/woosh_auto_dock_guiway",
    _BASE,
    "/woosh_auto_dock_node",
    _MOVE,
)
_PLAN_NODES = (_MOVE, _RI, "/woosh_move_with_avoid_node", "/woosh_auto_dock_guiway", _BASE)

_PAGE_TOPICS = (
    _read(
        "/robot_status",
        "woosh_msgs/RobotStatus",
        "status",
        "state of the robot and of its task",
        providers=(_RI,),
        on_change=True,
        latched=None,
    ),
    _read(
        "/movebase_pose2d",
        "geometry_msgs/Pose2D",
        "pose",
        "where the robot is in the map",
        "m, rad; map",
        providers=(_MOVE,),
        node_assumed=True,
    ),
    _read(
        "/odometer",
        "std_msgs/Float64",
        "odometer",
        "distance travelled in the robot's life",
        "m",
        listeners=(_RI,),
    ),
    _read(
        "/battery",
        "woosh_msgs/Battery",
        "battery",
        "charge, voltage, current, temperatures, capacities",
        "%, V, A, °C, Ah",
        listeners=(_RI,),
    ),
    _read(
        "/amcl_pose",
        "geometry_msgs/PoseWithCovarianceStamped",
        "localization",
        "pose found by the localisation, with covariance",
        "m, rad; map",
        providers=(_LOC,),
        node_assumed=True,
    ),
    _read(
        "/information",
        "woosh_msgs/Information",
        "information",
        "versions of the controller, base type, parameters",
        node_assumed=True,
    ),
    _read(
        "/driver_base/bms",
        "woosh_msgs/BMS",
        "bms",
        "what the battery management system measures",
        "V, A, °C, Ah",
        node_assumed=True,
    ),
    _read(
        "/driver_base/parameter",
        "woosh_msgs/Parameter",
        "parameters",
        "wheel geometry, reduction ratios, speed limits",
        "m, m/s, rad/s",
        node_assumed=True,
    ),
    _read(
        "/odom_twist",
        "geometry_msgs/Twist",
        "velocity",
        "measured velocity of the base",
        "m/s, rad/s; base_link",
        listeners=(_RI,),
    ),
    _read(
        "/status_code",
        "std_msgs/UInt64",
        "status_code",
        "events and faults as 12-digit codes",
        providers=_STATUS_NODES,
        listeners=(_RI,),
        on_change=True,
    ),
    _read(
        "/scan",
        "sensor_msgs/LaserScan",
        "scan",
        "all lidars fused",
        "m, rad; the scan's own frame",
        providers=("/laser", _BASE),
        listeners=(_RI,),
    ),
    _read(
        "/imu/data_raw",
        "sensor_msgs/Imu",
        "imu",
        "raw inertial measurements",
        "rad/s, m/s²; imu frame",
        node_assumed=True,
    ),
    _read(
        "/odom_raw",
        "nav_msgs/Odometry",
        "odometry_raw",
        "wheel odometry without the IMU",
        "m, rad; odom",
        node_assumed=True,
    ),
    _read(
        "/odom",
        "nav_msgs/Odometry",
        "odometry",
        "odometry fused with the IMU",
        "m, rad; odom",
        providers=("/woosh_robot_pose_ekf",),
        node_assumed=True,
    ),
    _read(
        "/camera_1/color/image_raw",
        "sensor_msgs/Image",
        "camera",
        "colour image",
        providers=("/camera_1",),
        node_assumed=True,
    ),
    _read(
        "/camera_1/depth/image_raw",
        "sensor_msgs/Image",
        "depth",
        "depth image",
        "m or mm by encoding",
        providers=("/camera_1",),
        node_assumed=True,
    ),
    _read(
        "/camera_1/depth/points",
        "sensor_msgs/PointCloud2",
        "points",
        "depth image as a point cloud",
        "m; camera frame",
        providers=("/camera_1",),
        node_assumed=True,
    ),
    _read(
        "/camera_1/depth/cloud_without_planes",
        "sensor_msgs/PointCloud2",
        "obstacle_points",
        "point cloud of obstacles, ground removed",
        "m; camera frame",
        providers=("/woosh_obstacle_detect_camera_1",),
        node_assumed=True,
    ),
    _write(
        "/base_cmd_vel",
        "geometry_msgs/Twist",
        "velocity, obeyed without smoothing",
        "m/s, rad/s; base_link",
        bypasses_protection=True,
        node_assumed=True,
    ),
    _write(
        "/smooth_cmd_vel",
        "geometry_msgs/Twist",
        "velocity, smoothed by the chassis",
        "m/s, rad/s; base_link",
        bypasses_protection=True,
        node_assumed=True,
    ),
    _write("/rgbled", "woosh_msgs/LED", "light strip of the base", written_by=(_RI,)),
    _write(
        "/rgbled_shelf",
        "woosh_msgs/LED",
        "light strip of the shelf",
        node_assumed=True,
        written_by=(_RI,),
        aliases=("/kShelfLedColorPubName",),
    ),
    _write(
        "/move_base/local_costmap/set_footprint",
        "geometry_msgs/Polygon",
        "outline of the robot for avoiding obstacles nearby",
        "m; base_link",
        providers=_LOCAL_FOOTPRINT_NODES,
        written_by=(_RI,),
    ),
    _write(
        "/move_base/global_costmap/set_footprint",
        "geometry_msgs/Polygon",
        "outline of the robot for planning; change both together",
        "m; base_link",
        providers=(_RI, _MOVE),
        written_by=(_RI,),
    ),
)

_PAGE_CALLS = (
    _call("/exec_task", "woosh_msgs/ExecTask", _RI, "run, pause, resume or cancel a task"),
    _call(
        "/start_localization", "std_srvs/SetBool", _LOC, "start or stop the localisation", node_assumed=True
    ),
    _call(
        "/move_base/enable_costmaps",
        "std_srvs/SetBool",
        _MOVE,
        "whether obstacles enter the costmaps",
        node_assumed=True,
    ),
    _call(
        "/aic_map_server/get_map", "nav_msgs/GetMap", "/aic_map_server", "the current map", node_assumed=True
    ),
    _call("/set_map", "nav_msgs/SetMap", _LOC, "replace the map, with the pose in it", node_assumed=True),
    _call(
        "/move_base/make_plan", "nav_msgs/GetPlan", _MOVE, "plan a path without driving it", node_assumed=True
    ),
    _call(
        "/move_base/clear_costmaps",
        "std_srvs/Empty",
        _MOVE,
        "forget the obstacles seen so far",
        node_assumed=True,
    ),
)

_PAGE_ACTIONS = (
    _act(
        "/move_base",
        "woosh_msgs/MoveBase",
        _MOVE,
        "navigate to a pose or along a path",
        listeners=("/woosh_field_detector",),
        moves_base=True,
    ),
    _act(
        "/cmd_vel_control",
        "woosh_msgs/StepControl",
        _BASE,
        "precise straight, turning, lateral and diagonal moves",
        moves_base=True,
    ),
    _act(
        "/navigation_mode",
        "woosh_msgs/NavigationMode",
        _MOVE,
        "what to do about obstacles, and how fast to drive",
    ),
)


def _seen(
    name: str,
    type_: str,
    meaning: str,
    *providers: str,
    feed: str = "",
    listeners: tuple[str, ...] = (_RI,),
    **more: object,
) -> Row:
    nodes = providers or (_BASE,)
    return _read(name, type_, feed, meaning, source="seen", providers=nodes, listeners=listeners, **more)  # type: ignore[arg-type]


def _heard(name: str, type_: str, meaning: str, *listeners: str, **more: object) -> Row:
    return _write(name, type_, meaning, source="seen", providers=listeners, written_by=(_RI,), **more)  # type: ignore[arg-type]


_SEEN_TOPICS = (
    _seen(
        "/localization_state",
        "std_msgs/UInt32",
        "state of the localisation, numbers not documented",
        _LOC,
        feed="localization_state",
    ),
    _seen("/IO_input", "woosh_msgs/IOs", "digital inputs", feed="inputs"),
    _seen("/beacons", "woosh_msgs/Beacons", "reflectors or beacons in view"),
    _seen(
        "/driver_base/rf_remote_controller",
        "woosh_msgs/RfRemoteController",
        "keys of the radio remote control",
    ),
    _seen("/lift", "woosh_msgs/IOModule", "state of the lift"),
    _seen("/roller1", "woosh_msgs/IOModule", "state of the first roller"),
    _seen("/roller2", "woosh_msgs/IOModule", "state of the second roller"),
    _seen("/tractor", "woosh_msgs/IOModule", "state of the towing hook"),
    _seen("/rfid_landmark", "woosh_msgs/RFIDs", "RFID landmarks in reach"),
    _seen("/scanner_status", "woosh_msgs/ScannerStatus", "state of the safety scanners"),
    _seen(
        "/system_agent/wifi/status", "std_msgs/String", "state of the wireless network", "/woosh_system_agent"
    ),
    _seen(
        "/trigger_field", "woosh_msgs/NavMode", "the map field the robot has entered", "/woosh_field_detector"
    ),
    _seen(
        "/volume/percent",
        "woosh_msgs/VolumeCtl",
        "volume of the loudspeaker; its definition is not published",
        "/woosh_volume_control",
        definition_known=False,
        on_change=True,
    ),
    _seen(
        "/woosh_rosbag_record/filename",
        "std_msgs/String",
        "file of the recording",
        "/woosh_rosbag_record_node",
    ),
    _seen(
        "/move_base/global_plan",
        "nav_msgs/Path",
        "the path being driven",
        *_PLAN_NODES,
        feed="plan",
        listeners=(_RI, "/woosh_field_detector"),
    ),
    _seen("/tf", "tf2_msgs/TFMessage", "moving transforms", *_TF_NODES, feed="tf"),
    Row(
        "/tf_static",
        "tf2_msgs/TFMessage",
        "topic",
        "read",
        "fixed transforms",
        source="seen",
        feed="tf_static",
        providers=("/robot_state_publisher",),
        listeners=(_RI,),
        latched=True,
    ),
    _heard(
        "/initialpose",
        "geometry_msgs/PoseWithCovarianceStamped",
        "tells the localisation where the robot is",
        _LOC,
    ),
    _heard("/voice_synthesis", "std_msgs/String", "text that the chassis speaks", "/voice_synthesis"),
    Row(
        "/key_cmd_vel",
        "geometry_msgs/Twist",
        "topic",
        "write",
        "velocity of the robot's own remote control",
        "m/s, rad/s; base_link",
        source="seen",
        written_by=(_RI,),
        bypasses_protection=True,
    ),
    _heard("/charge_cmd", "woosh_msgs/Charge", "manual or automatic charging", _BASE),
    _heard("/manekineko", "woosh_msgs/Manekineko", "the two waving arms", _BASE),
    _heard(
        "/avoid_3d_trigger",
        "std_msgs/Bool",
        "obstacle detection of the camera on or off",
        "/woosh_obstacle_detect_camera_1",
    ),
    _heard(
        "/volume/percentSet",
        "woosh_msgs/VolumeCtl",
        "sets the volume; its definition is not published",
        "/woosh_volume_control",
        definition_known=False,
    ),
    _heard(
        "/woosh_rosbag_record/goal",
        "woosh_msgs/WooshRosbagRecord",
        "starts or stops a recording on the robot",
        "/woosh_rosbag_record_node",
    ),
)


def _seen_action(name: str, type_: str, meaning: str, node: str = _BASE, *, moves_base: bool = False) -> Row:
    return _act(name, type_, node, meaning, source="seen", moves_base=moves_base)


_SEEN_ACTIONS = (
    _seen_action("/charge_control", "woosh_msgs/ChargeControl", "charging contacts"),
    _seen_action(
        "/driver_base/second_position",
        "woosh_msgs/SecondPosition",
        "fine positioning on magnets or RFID",
        moves_base=True,
    ),
    _seen_action("/lift_control", "woosh_msgs/LiftControl", "lift up or down"),
    _seen_action("/lift_control2", "woosh_msgs/LiftControl2", "lift to a height"),
    _seen_action("/lift_control3", "woosh_msgs/LiftControl3", "lift to an absolute or relative height"),
    _seen_action("/roller1_control", "woosh_msgs/RollerControl", "first roller: load or unload"),
    _seen_action("/roller2_control", "woosh_msgs/RollerControl", "second roller: load or unload"),
    _seen_action("/tractor_control", "woosh_msgs/TractorControl", "lock or unlock the towing hook"),
    _seen_action(
        "/woosh_ar_track_charge",
        "woosh_msgs/ArTrackCharge",
        "drive to a charger by its visual tag",
        "/woosh_ar_track_charge",
        moves_base=True,
    ),
    _seen_action(
        "/woosh_auto_dock",
        "woosh_msgs/AutoDock2",
        "dock by lidar features",
        "/woosh_auto_dock_node",
        moves_base=True,
    ),
)

_PACKAGE_CALLS = (
    Row(
        "/init_pose",
        "woosh_msgs/InitPose",
        "service",
        "call",
        "tells the localisation where the robot is, and answers whether it was accepted",
        "m, rad; map",
        source="package",
        providers=(_LOC,),
        node_assumed=True,
        name_assumed=True,
    ),
    Row(
        "/woosh_init",
        "woosh_msgs/WooshInit",
        "service",
        "call",
        "initialises the robot",
        source="package",
        providers=(_RI,),
        node_assumed=True,
        name_assumed=True,
    ),
)

ROWS: tuple[Row, ...] = (
    _PAGE_TOPICS + _PAGE_CALLS + _PAGE_ACTIONS + _SEEN_TOPICS + _SEEN_ACTIONS + _PACKAGE_CALLS
)
"""Every row; names are unique."""
