"""The interface table, the status codes, the values: pure parts."""

from __future__ import annotations

import math
import subprocess
import sys

import pytest

from woosh_pure import interface
from woosh_pure.enums import (
    ActionState,
    ActionType,
    ChargeMode,
    ChargeStatus,
    Direction,
    ExecutionMode,
    LedState,
    NavDirection,
    NavigationMode,
    RobotMode,
    RobotState,
    StepControlMode,
    StepMode,
    TaskCommand,
    TaskState,
    TaskType,
    WorkMode,
)
from woosh_pure.faults import MAX_FAULTS, ActiveFaults, FaultLevel, all_codes, decode_status_code
from woosh_pure.geometry import Footprint, Pose2D, normalize_angle, quaternion_from_yaw, yaw_from_quaternion
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.sim.site import built_in_site

# Transcribed from the vendor's interface page, types as in its message package, in the page's order.
PAGE = """
read /robot_status woosh_msgs/RobotStatus
read /movebase_pose2d geometry_msgs/Pose2D
read /odometer std_msgs/Float64
read /battery woosh_msgs/Battery
read /amcl_pose geometry_msgs/PoseWithCovarianceStamped
read /information woosh_msgs/Information
read /driver_base/bms woosh_msgs/BMS
read /driver_base/parameter woosh_msgs/Parameter
read /odom_twist geometry_msgs/Twist
read /status_code std_msgs/UInt64
read /scan sensor_msgs/LaserScan
read /imu/data_raw sensor_msgs/Imu
read /odom_raw nav_msgs/Odometry
read /odom nav_msgs/Odometry
read /camera_1/color/image_raw sensor_msgs/Image
read /camera_1/depth/image_raw sensor_msgs/Image
read /camera_1/depth/points sensor_msgs/PointCloud2
read /camera_1/depth/cloud_without_planes sensor_msgs/PointCloud2
write /base_cmd_vel geometry_msgs/Twist
write /smooth_cmd_vel geometry_msgs/Twist
write /rgbled woosh_msgs/LED
write /rgbled_shelf woosh_msgs/LED
write /move_base/local_costmap/set_footprint geometry_msgs/Polygon
write /move_base/global_costmap/set_footprint geometry_msgs/Polygon
call /exec_task woosh_msgs/ExecTask
call /start_localization std_srvs/SetBool
call /move_base/enable_costmaps std_srvs/SetBool
call /aic_map_server/get_map nav_msgs/GetMap
call /set_map nav_msgs/SetMap
call /move_base/make_plan nav_msgs/GetPlan
call /move_base/clear_costmaps std_srvs/Empty
act /move_base woosh_msgs/MoveBase
act /cmd_vel_control woosh_msgs/StepControl
act /navigation_mode woosh_msgs/NavigationMode
"""

# The page's numbers, and what is printed for them.
NUMBERS = {
    TaskType: "0 undefined, 1 pick, 2 park, 3 charge, 4 carry",
    # 1, 2, 6, and 7 of the robot's state are in the vendor's other manual only.
    TaskState: "0 undefined, 1 initialising, 2 prepared, 3 running, 4 paused, 5 waiting for action, "
    "6 waiting for task, 7 completed, 8 cancelled, 9 failed",
    ActionType: "0 undefined, 1 navigation, 2 step control, 3 secondary positioning enter, "
    "4 secondary positioning leave, 5 carry action, 6 wait, 7 charge",
    ActionState: "0 undefined, 1 running, 2 warning, 3 cancelled, 4 done, 5 failed, 10 paused, 11 traffic controlled",
    RobotState: "0 undefined, 1 uninitialised, 2 idle, 3 parking, 4 in task, 5 warning, 6 fault, "
    "7 following, 8 charging, 9 mapping",
    RobotMode: "0 undefined, 1 automatic, 2 manual, 3 maintenance",
    WorkMode: "0 undefined, 1 deployment, 2 task, 3 dispatch",
    ChargeMode: "0 manual, 1 automatic",
    ChargeStatus: "0 not charging, 1 charging",
    TaskCommand: "1 execute, 2 pause, 3 resume, 4 cancel, 6 interrupt wait",
    Direction: "0 undefined, 1 load, 2 unload",
    StepMode: "1 straight, 2 rotate, 3 lateral, 4 diagonal",
    StepControlMode: "0 cancel, 1 execute, 2 pause, 3 resume",
    ExecutionMode: "0 free, 1 point by point",
    NavigationMode: "0 fuzzy avoidance, 1 precise avoidance, 2 stop and wait, 3 wait then avoid",
    NavDirection: "0 chassis decides, 1 forward, 2 backward, 3 along path",
}
LED = {
    "NONE": 0x00, "LOW_BATTERY": 0x42, "FOLLOWING": 0x60, "FORWARD": 0x80, "RIGHT_TURN": 0x81, "LEFT_TURN": 0x82,
    "STARTING": 0x83, "STOPPED_WAITING": 0x84, "TRAFFIC_PAUSED": 0x85, "WARNING": 0xA0, "TASK_RUNNING": 0xA1,
    "TASK_PAUSED": 0xA2, "IDLE": 0xA3, "INITIALISING": 0xA4, "OFFLINE": 0xA5, "PICKING": 0xF0, "PICKING_DONE": 0xF1,
    "NORMAL": 0xFF,
}  # fmt: skip


def test_the_rows_of_the_page_are_those_of_the_page():
    rows = [f"{r.flow} {r.name} {r.type}" for r in interface.ROWS if r.source == "page"]
    assert rows == PAGE.split("\n")[1:-1]


@pytest.mark.parametrize("kind", NUMBERS, ids=lambda kind: kind.__name__)
def test_the_numbers_of_the_page_have_its_words(kind):
    assert ", ".join(f"{int(member)} {member}" for member in kind) == NUMBERS[kind]


def test_the_light_states_are_those_of_the_page():
    assert {member.name: int(member) for member in LedState} == LED


def test_names_and_feeds_are_unique():
    names = [r.name for r in interface.ROWS]
    assert len(set(names)) == len(names)
    feeds = [r.feed for r in interface.ROWS if r.feed]
    assert len(set(feeds)) == len(feeds)


def test_several_nodes_publish_where_several_were_seen():
    assert len(interface.row("/status_code").providers) == 6
    assert len(interface.row("/tf").providers) == 8
    assert len(interface.row("/scan").providers) == 2
    assert len(interface.row("/move_base/global_plan").providers) == 5


def test_a_row_is_found_by_alias_and_a_typing_mistake_is_answered_with_near_names():
    assert interface.row("kShelfLedColorPubName").name == "/rgbled_shelf"
    with pytest.raises(KeyError, match="/battery"):
        interface.row("/batery")


def test_every_velocity_topic_says_that_it_bypasses_protection():
    for r in interface.ROWS:
        assert r.bypasses_protection == (r.flow == "write" and r.type == "geometry_msgs/Twist")


def test_every_code_of_the_table_has_both_sentences_and_a_level():
    codes = list(all_codes())
    assert len(codes) == 816
    assert all(c.english and c.chinese and c.identifier for c in codes)
    assert sum(not c.derived for c in codes) == 57


def test_a_code_is_taken_apart_into_its_digits():
    code = decode_status_code(130103000012)
    assert (code.version, code.department, code.module, code.submodule) == (1, 3, 1, 3)
    assert (code.function_state, code.level) == (1, FaultLevel.WARNING)
    assert "lost" in code.english
    assert decode_status_code(131011000012).other_identifiers == ("SYS_FEED_FAILED",)


@pytest.mark.parametrize("code", [0, 1, 7, 2**64 - 1, 999999999999, 130103000019])
def test_any_number_gives_a_value(code):
    decoded = decode_status_code(code)
    assert not decoded.known
    assert str(code) in decoded.english


def test_a_recovered_submodule_clears_its_own_faults_only():
    faults = ActiveFaults()
    faults.receive(110201000013)
    faults.receive(110201000023)
    faults.receive(130103000012)
    assert [f.code for f in faults.active] == [110201000013, 110201000023, 130103000012]
    faults.receive(110201000000)
    assert [f.code for f in faults.active] == [130103000012]


def test_a_robot_that_makes_up_codes_without_end_fills_no_memory_and_hides_no_severe_fault():
    faults = ActiveFaults()
    severe = faults.receive(120201000013)
    assert severe.level is FaultLevel.SEVERE
    for number in range(2 * MAX_FAULTS):
        faults.receive(130000000002 + 10 * number)
    assert len(faults.active) == MAX_FAULTS
    assert faults.active[0] is severe
    assert faults.active[-1].code == 130000000002 + 10 * (2 * MAX_FAULTS - 1)


def test_submodule_00_clears_its_whole_module_and_notices_are_no_faults():
    faults = ActiveFaults()
    faults.receive(140201000022)
    faults.receive(130104000011)
    assert len(faults.active) == 1
    faults.receive(140200000000)
    assert faults.active == ()


def test_unknown_numbers_become_named_members_and_still_compare():
    assert TaskState(42) == 42
    assert not TaskState(42).known
    assert str(RobotState.IN_TASK) == "in task"


@pytest.mark.parametrize("yaw", [0.0, 1.0, -3.0, math.pi])
def test_yaw_survives_the_quaternion(yaw):
    assert yaw_from_quaternion(*quaternion_from_yaw(yaw)) == pytest.approx(yaw)


def test_angles_are_normalised_and_nan_is_refused():
    assert normalize_angle(3 * math.pi) == pytest.approx(math.pi)
    assert normalize_angle(-math.pi) == math.pi
    with pytest.raises(ValueError, match="finite"):
        normalize_angle(math.nan)


def test_poses_of_two_frames_are_not_compared():
    with pytest.raises(ValueError, match="odom"):
        Pose2D(0, 0).distance_to(Pose2D(1, 0, 0, "odom"))


def test_the_vendors_footprint_with_padding():
    corners = [(-0.4, 0.253), (-0.353, 0.3), (0.353, 0.3), (0.4, 0.253), (0.4, -0.253), (0.353, -0.3), (-0.353, -0.3), (-0.4, -0.253)]  # fmt: skip
    footprint = Footprint.from_points(corners, padding=0.1)
    assert footprint.points[0] == pytest.approx((-0.5, 0.353))
    assert footprint.inscribed_radius == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("points", "what"),
    [
        ([(0, 0), (1, 1)], "3 corners"),
        ([(-1, -1), (1, 1), (1, -1), (-1, 1)], "cross"),
        ([(1, 1), (2, 1), (2, 2)], "contain"),
        ([(math.nan, 1), (2, 1), (2, 2)], "finite"),
        ([(1, 1), (1, 1), (-1, -1), (1, -1)], "same point"),
    ],
)
def test_a_bad_footprint_is_refused(points, what):
    with pytest.raises(ValueError, match=what):
        Footprint.from_points(points)


def test_a_map_survives_its_files(tmp_path):
    grid = built_in_site().grid
    yaml_path, image = grid.save(tmp_path / "hall")
    assert image.read_bytes().startswith(b"P5\n# 0.050 m/pix\n240 160\n255\n")
    again = GridMap.load(yaml_path)
    assert (again.cells == grid.cells).all()
    assert (again.resolution, again.origin) == (grid.resolution, grid.origin)
    assert grid.save_png(tmp_path / "hall.png").read_bytes().startswith(b"\x89PNG")


def test_a_broken_map_file_says_what_is_wrong(tmp_path):
    (tmp_path / "m.yaml").write_text("image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n")
    (tmp_path / "m.pgm").write_bytes(b"P5\n10 10\n255\nshort")
    with pytest.raises(ValueError, match="cut short"):
        GridMap.load(tmp_path / "m.yaml")


def test_importing_the_package_loads_neither_numpy_nor_the_network():
    code = (
        "import sys, woosh_pure; print([m for m in ('numpy', 'socket', 'rosproto.node') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert out.stdout.strip() == "[]"


def test_the_chassis_loads_numpy_with_its_first_array_only():
    code = "import sys, woosh_pure.chassis; print('numpy' in sys.modules)"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert out.stdout.strip() == "False"


def test_a_topic_that_lacks_its_slash_is_recognised() -> None:
    """`feed("lift")`: /lift is one, and what is merely near is named with it."""
    with pytest.raises(KeyError, match="/lift is a topic of it"):
        interface.find("lift")
    with pytest.raises(KeyError, match="/roller1"):
        interface.find("roller")
    with pytest.raises(KeyError, match="none is near"):
        interface.find("xyzzy")
