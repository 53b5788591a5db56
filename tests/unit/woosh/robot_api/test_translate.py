"""`translate`: messages of ROS 1 as values of the Robot API."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from woosh_pure.faults import FaultLevel
from woosh_pure.interface.table import row as interface_row
from woosh_pure.robot_api import wire
from woosh_pure.robot_api.translate import COUNT, PAIRS, ROBOT, operation_state, path_driven, to_api, to_ros
from woosh_pure.values.messages import message_type


def message(row: str, **fields: Any) -> Any:
    made = message_type(interface_row(row).type)()
    for name, value in fields.items():
        setattr(made, name, value)
    return made


@pytest.mark.parametrize("pair", PAIRS, ids=lambda pair: f"{pair.row} {pair.type_name}")
def test_an_empty_message_of_each_row_fits_its_type(pair: Any) -> None:
    """Every row is in the interface's table, every field in the type's."""
    values = to_api(pair.row, message(pair.row))[pair.type_name]
    wire.dump(pair.type_name, values)


def test_the_status_is_three_types() -> None:
    status = message(
        "/robot_status", task_id=2**64 - 103, task_type=1, task_state=3, action_type=1, action_state=11,
        robot_state=4, robot_mode=1, work_mode=2, wait_id=5, dest="A1", msg="on the way", time=1790000000,
    )  # fmt: skip
    assert to_api("/robot_status", status) == {
        ROBOT + "TaskProc": {
            "robotTaskId": -103,
            "type": 1,
            "state": 3,
            "action": {"type": 1, "state": 11, "waitId": 5},
            "dest": "A1",
            "msg": "on the way",
            "time": 1790000000,
        },
        ROBOT + "RobotState": {"state": 4},
        ROBOT + "Mode": {"ctrl": 1, "work": 2},
    }


def test_pose_velocity_and_distance_are_one_type() -> None:
    twist = message("/odom_twist")
    twist.linear.x, twist.angular.z = 0.5, -0.25
    pose = to_api("/movebase_pose2d", message("/movebase_pose2d", x=1.0, y=-2.0, theta=0.5))
    assert pose == {ROBOT + "PoseSpeed": {"pose": {"x": 1.0, "y": -2.0, "theta": 0.5}}}
    assert to_api("/odom_twist", twist) == {ROBOT + "PoseSpeed": {"twist": {"linear": 0.5, "angular": -0.25}}}
    for metres, told in ((5120.9, 5120), (-1.0, 0), (math.nan, 0), (math.inf, 0), (1e300, 2**32 - 1)):
        assert to_api("/odometer", message("/odometer", data=metres)) == {
            ROBOT + "PoseSpeed": {"mileage": told}
        }


@pytest.mark.parametrize(
    ("status", "mode", "state"),
    [(0, 0, 1), (0, 1, 1), (1, 0, 2), (1, 1, 3)],
    ids=["no", "no", "cable", "station"],
)
def test_how_a_battery_is_charged(status: int, mode: int, state: int) -> None:
    battery = message("/battery", batteryPercentage=83, chargeStatus=status, chargeMode=mode, tempMax=-5)
    battery.capacityFull, battery.capacityDesign = 48.5, 50.0
    values = to_api("/battery", battery)[ROBOT + "Battery"]
    assert (values["chargeState"], values["power"], values["health"], values["tempMax"]) == (state, 83, 97, 0)


@pytest.mark.parametrize(
    ("full", "design"),
    [(0.0, 0.0), (math.nan, 50.0), (50.0, math.nan), (-1.0, 50.0), (math.inf, 50.0), (math.inf, math.inf)],
)
def test_a_capacity_that_is_not_known_is_no_health(full: float, design: float) -> None:
    values = to_api("/battery", message("/battery", capacityFull=full, capacityDesign=design))
    assert values[ROBOT + "Battery"]["health"] == 0


def test_a_status_code_has_its_text_and_level() -> None:
    values = to_api("/status_code", message("/status_code", data=110201000013))[COUNT + "StatusCode"]
    assert (values["code"], values["level"]) == (110201000013, 3)
    assert "emergency" in values["msg"].lower()


def test_a_scan_keeps_its_numbers() -> None:
    scan = message("/scan", angle_min=-1.0, range_max=30.0, ranges=np.array([1.0, np.inf], np.float32))
    values = to_api("/scan", scan)[ROBOT + "ScannerData"]
    assert wire.dump(ROBOT + "ScannerData", values)["ranges"] == [1.0, "Infinity"]
    assert values["angleMin"] == -1.0


def test_a_path_has_poses_in_the_plane() -> None:
    plan = message("/move_base/global_plan")
    one = message_type("geometry_msgs/PoseStamped")()
    one.pose.position.x, one.pose.orientation.z, one.pose.orientation.w = 2.0, 1.0, 0.0
    plan.poses = [one]
    (pose,) = to_api("/move_base/global_plan", plan)[ROBOT + "NavPath"]["path"]["poses"]
    assert (pose["x"], pose["y"], abs(pose["theta"])) == (2.0, 0.0, pytest.approx(math.pi))


def state(task: int = 7, robot: int = 2, ctrl: int = 1, work: int = 2) -> dict[str, wire.Values]:
    return {
        ROBOT + "TaskProc": {"state": task},
        ROBOT + "RobotState": {"state": robot},
        ROBOT + "Mode": {"ctrl": ctrl, "work": work},
        ROBOT + "PoseSpeed": {"twist": {"linear": 0.0, "angular": 0.0}},
        ROBOT + "NavPath": {"path": {"poses": [{"x": 1.0}]}},
    }


@pytest.mark.parametrize(
    ("values", "worst", "taskable"),
    [
        (state(), FaultLevel.NORMAL, 1),
        (state(robot=8), FaultLevel.WARNING, 1),
        (state(), FaultLevel.SEVERE, 0),
        (state(task=3), FaultLevel.NORMAL, 0),
        (state(robot=6), FaultLevel.NORMAL, 0),
        (state(ctrl=2), FaultLevel.NORMAL, 0),
        (state(work=1), FaultLevel.NORMAL, 0),
    ],
)
def test_when_the_robot_takes_tasks(values: dict[str, wire.Values], worst: FaultLevel, taskable: int) -> None:
    assert operation_state(values, worst) == {"robot": taskable}


def test_what_was_not_heard_is_not_derived() -> None:
    for name in ("TaskProc", "RobotState", "Mode"):
        assert (
            operation_state(
                {key: one for key, one in state().items() if key != ROBOT + name}, FaultLevel.NORMAL
            )
            is None
        )
    assert path_driven({}) is None


def test_the_plan_of_a_goal_that_is_over_is_no_path() -> None:
    """The topic keeps it."""
    values = state()
    assert path_driven(values) == {}
    assert path_driven(state(task=3)) == values[ROBOT + "NavPath"]
    moving = {**values, ROBOT + "PoseSpeed": {"twist": {"linear": 0.0, "angular": 0.1}}}
    assert path_driven(moving) == values[ROBOT + "NavPath"]


# -- back to ROS 1 -------------------------------------------------------------------------------------------


def test_what_the_api_tells_of_a_row_comes_back_as_it_was() -> None:
    """Each field that has a name on both sides."""
    for name in sorted({pair.row for pair in PAIRS}):
        pairs = [pair for pair in PAIRS if pair.row == name]
        original = message(name)
        for pair in pairs:
            for number, there in enumerate(pair.names.values(), 1):
                *outer, field = there.split(".")
                part = original
                for each in outer:
                    part = getattr(part, each)
                value = getattr(part, field)
                if isinstance(value, np.ndarray):
                    setattr(part, field, np.full(number, number, value.dtype))
                else:
                    setattr(part, field, str(number) if isinstance(value, str) else type(value)(number))
        bodies = {kind: wire.dump(kind, told) for kind, told in to_api(name, original).items()}
        back = to_ros(name, {kind: wire.load(kind, body) for kind, body in bodies.items()})
        assert {kind: wire.dump(kind, told) for kind, told in to_api(name, back).items()} == bodies, name


def test_a_row_of_several_types_needs_them_all() -> None:
    values = {ROBOT + "TaskProc": wire.load(ROBOT + "TaskProc", {"robotTaskId": "-103", "state": 3})}
    assert to_ros("/robot_status", values) is None
    values[ROBOT + "RobotState"], values[ROBOT + "Mode"] = {"state": 4}, {"ctrl": 1, "work": 2}
    status = to_ros("/robot_status", values)
    assert (status.task_id, status.task_state, status.robot_state, status.work_mode) == (2**64 - 103, 3, 4, 2)


def test_what_the_battery_does_not_tell_is_not_a_number() -> None:
    body = {"power": 83, "chargeState": 3, "tempMax": 27}
    battery = to_ros("/battery", {ROBOT + "Battery": wire.load(ROBOT + "Battery", body)})
    assert (battery.batteryPercentage, battery.chargeStatus, battery.chargeMode) == (83, 1, 1)
    assert math.isnan(battery.batteryVoltage)
    assert math.isnan(battery.capacityFull)


def test_a_path_and_versions_come_back() -> None:
    path = {"path": {"poses": [{"x": 1.0, "y": 2.0, "theta": 0.5}]}}
    nav = to_ros("/move_base/global_plan", {ROBOT + "NavPath": wire.load(ROBOT + "NavPath", path)})
    assert nav.header.frame_id == "map"
    assert (nav.poses[0].pose.position.x, nav.poses[0].pose.position.y) == (1.0, 2.0)
    body = {"version": {"rc": "1.1"}, "driverMethod": 2}
    general = to_ros("/information", {ROBOT + "General": wire.load(ROBOT + "General", body)})
    assert (general.softwareVersion, general.movebaseType) == ("1.1", "omnidirectional")
