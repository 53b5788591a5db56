"""`commands`: requests of the Robot API as messages, calls and goals of ROS 1, and the other way round."""

from __future__ import annotations

import math
from typing import Any

import pytest

from rosproto.codec import decode, encode
from woosh_pure.enums import TaskCommand
from woosh_pure.interface.table import row as interface_row
from woosh_pure.robot_api import wire
from woosh_pure.robot_api.commands import ACTION, CALL, COMMANDS, member_of, to_api, to_ros, told
from woosh_pure.robot_api.translate import ROBOT
from woosh_pure.values.messages import message_type, service_type

POSE = {"x": 1.5, "y": -0.5, "theta": 0.75}
BODIES: dict[str, wire.Values] = {
    ROBOT + "Twist": {"linear": 0.5, "linearY": -0.25, "angular": 0.125},
    ROBOT + "ActionOrder": {"order": 4},
    ROBOT + "PlanNavPath": {"start": POSE, "end": {"x": 3.0, "y": 1.0, "theta": 0.0}, "tolerance": 0.5},
    ROBOT + "SetRobotPose": {"pose": POSE},
    ROBOT + "InitRobot": {"isRecord": True},
    ROBOT + "Speak": {"text": "你好"},
    ROBOT + "LED": {"submodule": 1, "urgency": 255, "abnormal": 255, "normal": 0xA3, "color": 0xFF8000},
}
TASK = {"taskId": -103, "type": 1, "direction": 2, "taskTypeNo": 7}
TASKS: list[wire.Values] = [
    {**TASK, "markNo": "A1"},
    {**TASK, "pose": POSE, "custom": b"\xfe"},
    {"taskId": 2**62, "planPath": {"planPath": [{"path": {"poses": [POSE, {"x": 2.0, "y": 0.0, "theta": 0.0}]}}]}},
]  # fmt: skip
STEP = {"mode": 1, "value": 0.5, "speed": 0.25, "angle": 0.0}
MEMBERS: list[wire.Values] = [
    {"stepControl": {"steps": [STEP, {**STEP, "mode": 4, "angle": 0.5}], "avoid": 1, "action": 1}},
    {"stepControl": {"steps": [], "avoid": 0, "action": 2}},
    {"moveBase": {"poses": [POSE, POSE], "targetPose": POSE, "executionMode": 1, "action": 1}},
    {"moveBase": {"targetPose": POSE, "action": 1}},
    {
        "navMode": {
            "id": 3,
            "mode": 3,
            "waitTime": 2.5,
            "maxSpeed": 0.5,
            "permittedPassage": True,
            "capacity": 2,
        }
    },
    {"liftControl": {"executeMode": 2, "action": 1}},
    {"liftControl2": {"height": 0.25, "action": 1}},
    {"liftControl3": {"executeMode": 4, "speed": 0.5, "height": 0.25, "action": 1}},
]
CASES = [
    *BODIES.items(),
    *((ROBOT + "ExecTask", body) for body in TASKS),
    *((CALL, body) for body in MEMBERS),
]


def refused(kind: str, body: wire.Values) -> str:
    with pytest.raises(ValueError) as error:
        to_ros(kind, wire.load(kind, body))
    return str(error.value)


@pytest.mark.parametrize(("kind", "body"), CASES, ids=lambda value: value if isinstance(value, str) else "")
def test_there_and_back(kind: str, body: wire.Values) -> None:
    """Request, message on the wire of ROS 1, and the same request again."""
    values = wire.load(kind, body)
    row, message = to_ros(kind, values)
    assert interface_row(row)
    received = decode(type(message), encode(message))
    back = to_api(row, received)
    assert back[0] == kind
    flat = [wire.dump(kind, each) for each in (values, back[1])]
    assert str(flat[0]) == str(flat[1]) or flat[1] == approximately(flat[0])


def approximately(value: Any) -> Any:
    """Equal up to the yaw, which goes through a quaternion."""
    if isinstance(value, dict):
        return {key: approximately(each) for key, each in value.items()}
    if isinstance(value, list):
        return [approximately(each) for each in value]
    return pytest.approx(value, abs=1e-6) if isinstance(value, float) else value


@pytest.mark.parametrize("command", COMMANDS, ids=lambda one: f"{one.type_name} {one.row}")
def test_an_empty_message_of_each_row_fits_its_request(command: Any) -> None:
    """Every field is in both types."""
    row = interface_row(command.row)
    if row.kind == "service":
        message = service_type(row.type)._request_class()
    else:
        message = message_type(row.type if row.kind == "topic" else f"{row.type}Goal")()
    if command.type_name == ROBOT + "ExecTask":
        message.task_exect = 1
    kind, values = to_api(command.row, message)
    assert kind == (CALL if command.type_name.startswith(ACTION) else command.type_name)
    wire.dump(kind, values)


def test_every_request_that_moves_is_in_the_table_or_is_not_expressible() -> None:
    known = {command.type_name for command in COMMANDS}
    moving = {name for name, one in wire.requests().items() if one.kind == "move"}
    without = {ROBOT + n for n in ("ChangeNavMode", "ChangeNavPath", "ExecPreTask", "Follow")}
    assert moving - known == without | {CALL, "woosh.task.RepeatTask"}
    members = {field.type for field in wire.fields(CALL)}
    assert members - known == {ACTION + "ChargeControl", ACTION + "AnyAction"}


def test_a_velocity_of_no_numbers_is_zero() -> None:
    row, message = to_ros(ROBOT + "Twist", wire.load(ROBOT + "Twist", {}))
    assert row == "/smooth_cmd_vel"
    assert encode(message) == bytes(48)


def test_every_velocity_topic_is_a_twist() -> None:
    twist = message_type("geometry_msgs/Twist")()
    twist.linear.x = 0.5
    for row in ("/smooth_cmd_vel", "/base_cmd_vel", "/key_cmd_vel"):
        assert to_api(row, twist) == (ROBOT + "Twist", {"linear": 0.5, "linearY": 0.0, "angular": 0.0})


def test_avoidance_has_the_opposite_sense() -> None:
    for avoid, used in ((0, True), (1, False)):
        _, goal = to_ros(
            CALL, wire.load(CALL, {"stepControl": {"steps": [STEP], "avoid": avoid, "action": 1}})
        )
        assert goal.useAvoid is used


def test_a_task_has_one_target_on_one_map() -> None:
    path = {"planPath": [{"path": {"poses": [POSE]}}]}
    assert "exactly one" in refused(ROBOT + "ExecTask", {"taskId": 1})
    assert "exactly one" in refused(ROBOT + "ExecTask", {"markNo": "A1", "pose": POSE})
    assert "exactly one" in refused(ROBOT + "ExecTask", {"markNo": "A1", "planPath": path})
    assert "one map" in refused(ROBOT + "ExecTask", {"planPath": {"planPath": [*path["planPath"]] * 2}})
    assert "one map" in refused(ROBOT + "ExecTask", {"planPath": {"planPath": [{"wormholeId": 1}]}})
    assert "one byte" in refused(ROBOT + "ExecTask", {"markNo": "A1", "custom": "AAAA"})
    _, message = to_ros(
        ROBOT + "ExecTask", wire.load(ROBOT + "ExecTask", {"planPath": {"planPath": [{"target": POSE}]}})
    )
    assert len(message.poses) == 1


def test_what_the_api_cannot_express_is_refused() -> None:
    request = service_type("woosh_msgs/ExecTask")._request_class()
    request.task_exect, request.mark_no = int(TaskCommand.EXECUTE), "A1"
    request.poses = [message_type("geometry_msgs/PoseStamped")()]
    with pytest.raises(ValueError, match="not both"):
        to_api("/exec_task", request)
    goal = message_type("woosh_msgs/MoveBaseGoal")()
    goal.target_pose.header.frame_id = "odom"
    with pytest.raises(ValueError, match="needs a pose in the map"):
        to_api("/move_base", goal)
    with pytest.raises(KeyError):
        to_api("/battery", message_type("woosh_msgs/Battery")())


@pytest.mark.parametrize(
    ("kind", "body"),
    [
        (ROBOT + "Twist", {"linear": "NaN"}),
        (ROBOT + "Twist", {"angular": "Infinity"}),
        (ROBOT + "SetRobotPose", {"pose": {"x": "NaN"}}),
        (ROBOT + "SetRobotPose", {"pose": {"x": 1e30}}),
        (ROBOT + "ExecTask", {"pose": {"theta": 90.0}}),
        (ROBOT + "PlanNavPath", {"tolerance": "NaN"}),
        (CALL, {"stepControl": {"steps": [{**STEP, "value": "NaN"}], "action": 1}}),
        (CALL, {"moveBase": {"action": 1}}),
        (CALL, {"moveBase": {"targetPose": POSE, "action": 2}}),
        (CALL, {"liftControl2": {"height": "Infinity", "action": 1}}),
        (CALL, {"chargeControl": {"executeMode": 1, "action": 1}}),
        (CALL, {"anyAction": {"type": "x"}}),
        (CALL, {}),
        (ROBOT + "Follow", {"type": True}),
    ],
)
def test_what_ros_cannot_express_or_no_robot_does_is_refused(kind: str, body: wire.Values) -> None:
    assert refused(kind, body)


def test_nothing_not_finite_goes_to_the_robot() -> None:
    twist = message_type("geometry_msgs/Twist")()
    twist.linear.x = math.nan
    with pytest.raises(ValueError, match="finite"):
        to_api("/smooth_cmd_vel", twist)


def test_the_member_of_a_call_names_its_feedback() -> None:
    assert member_of(CALL, {"stepControl": {"action": 0}}) == (ACTION + "StepControl", {"action": 0})
    assert member_of(ROBOT + "Twist", {"linear": 0.0})[0] == ROBOT + "Twist"


def test_results_repeat_what_the_goal_asked_for() -> None:
    _, steps = to_ros(CALL, wire.load(CALL, MEMBERS[0]))
    done = told("/cmd_vel_control", "Result", steps, done=True)
    assert (done.result, done.executeMode, done.percent) == (1, 4, 100.0)
    failed = told("/cmd_vel_control", "Result", steps, done=False)
    assert (failed.result, failed.percent) == (-1, 0.0)
    assert told("/cmd_vel_control", "Feedback", steps, done=False).feedback == 1
    _, lift = to_ros(CALL, wire.load(CALL, {"liftControl2": {"height": 0.25, "action": 1}}))
    assert told("/lift_control2", "Result", lift, done=True).height == 0.25
    assert told("/move_base", "Result", message_type("woosh_msgs/MoveBaseGoal")(), done=True) is not None
