"""Commands as ROS 1 and the Robot API have them, as one table of pairs, in both directions. Pure.

For an action the type is that of its member of CallAction, which Feedback names. A server makes messages of
requests, a bridge makes requests of messages. What one side cannot express is refused, never left out.
"""

from __future__ import annotations

from typing import Any

from woosh_pure.enums import StepControlMode, TaskCommand
from woosh_pure.interface.table import row as interface_row
from woosh_pure.robot_api import wire
from woosh_pure.robot_api.translate import ORIGIN, ROBOT, Pair, in_map, pose_2d, stamped
from woosh_pure.robot_api.wire import Values, enum
from woosh_pure.values.messages import message_type, pose_with_covariance, require_finite, service_type

ACTION = "woosh.ros.action."
CALL, FEEDBACKS = "woosh.ros.CallAction", "woosh.ros.Feedbacks"
STATES = enum("woosh.ros.State")
"""Of Feedback, by name."""
ENDS = {STATES[f"kRos{name}"] for name in ("Success", "Cancel", "Failure", "ExecuteFailed")}
_MEMBERS = {field.type: field.key for field in wire.fields(CALL)}
_TEST_API, _TEST_ROS = 4, 5  # the mode "test" of the third lift


def row_of(type_name: str) -> str:
    """The topic, service or action that a request, or a member of CallAction, becomes.

    Raises:
        ValueError: There is none.
    """
    if type_name not in _BY_TYPE:
        raise ValueError(f"{type_name} has no counterpart on ROS 1")
    return _BY_TYPE[type_name].row


def to_ros(type_name: str, values: Values) -> tuple[str, Any]:
    """What a request is on ROS 1: the topic, service or action, and the message, request or goal for it.

    ActionOrder names no task: set `task_id` of its message.

    Raises:
        ValueError: ROS 1 cannot express it, or it is out of the interface's limits.
    """
    type_name, values = member_of(type_name, values)
    row = interface_row(row_of(type_name))
    command = _BY_TYPE[type_name]
    if row.kind == "service":
        message = service_type(row.type)._request_class()
    else:
        message = message_type(row.type if row.kind == "topic" else f"{row.type}Goal")()
    command.fill_in(message, values)
    return command.row, require_finite(message, type_name)


def to_api(row: str, message: Any) -> tuple[str, Values]:
    """The request that says what a message, request of a service or goal says on ROS 1.

    Raises:
        KeyError: Nothing of the Robot API does what this row does.
        ValueError: The Robot API cannot express this message.
    """
    require_finite(message, row)
    commands = [command for command in COMMANDS if command.row == row]
    if row == "/exec_task":
        commands = commands[:1] if message.task_exect == TaskCommand.EXECUTE else commands[1:]
    if not commands:
        raise KeyError(row)
    command = commands[0]
    values = command.values(message)
    member = _MEMBERS.get(command.type_name)
    return (command.type_name, values) if member is None else (CALL, {member: values})


def member_of(type_name: str, values: Values) -> tuple[str, Values]:
    """The type and values of the one member of a CallAction; anything else as it is.

    Raises:
        ValueError: It has no member.
    """
    if type_name != CALL:
        return type_name, values
    for kind, key in _MEMBERS.items():
        if key in values:
            return kind, values[key]
    raise ValueError(f"CallAction is empty; expected one of {', '.join(_MEMBERS.values())}")


def told(row: str, part: str, goal: Any, *, done: bool) -> Any:
    """The "Result" or "Feedback" of an action, as the Robot API tells it; it repeats the goal's values."""
    message = message_type(f"{interface_row(row).type}{part}")()
    source = [goal, *getattr(goal, "stepControl", ())][-1]
    known = {"result": 1 if done else -1, "feedback": 1, "percent": 100.0 * done}
    for name in message.__slots__:
        setattr(message, name, known.get(name, getattr(source, name, getattr(message, name))))
    return message


# -- fields that differ --------------------------------------------------------------------------------------


def _fill_initial_pose(values: Values, message: Any) -> None:
    pose = pose_2d(values.get("pose", ORIGIN))
    made = pose_with_covariance(pose, position_deviation=0.25, yaw_deviation=0.26)  # the API has none
    message.header, message.pose = made.header, made.pose


def _fill_task(values: Values, message: Any) -> None:
    segments = values.get("planPath", {}).get("planPath", [])
    if len(segments) > 1 or any(one["wormholeId"] for one in segments):
        raise ValueError("ROS 1 takes a path on one map, as one segment of planPath")
    path = [pose for one in segments for pose in one.get("path", {}).get("poses", [])]
    path = path or [one["target"] for one in segments if "target" in one]
    if bool(values["markNo"]) + ("pose" in values) + bool(path) != 1:
        raise ValueError("a task needs exactly one of markNo, pose, planPath with poses")
    if len(values["custom"]) > 1:
        raise ValueError("custom: ROS 1 takes one byte at most")
    message.task_exect = int(TaskCommand.EXECUTE)
    message.poses = [stamped(pose) for pose in path or [values[key] for key in ("pose",) if key in values]]
    message.custom = int.from_bytes(values["custom"], "big", signed=True)


def _read_task(message: Any) -> Values:
    poses = [*map(in_map, message.poses)]
    if poses and message.mark_no:
        raise ValueError("the Robot API takes a mark or a path, not both")
    found: Values = {"custom": bytes([message.custom & 0xFF]) if message.custom else b""}
    if len(poses) == 1:
        found["pose"] = poses[0]
    elif poses:
        found["planPath"] = {"planPath": [{"path": {"poses": poses}}]}
    return found


def _check_order(values: Values, message: Any) -> None:
    if not 2 <= values["order"] <= 8:
        raise ValueError(f"order {values['order']}: expected 2 to 8")


def _fill_steps(values: Values, message: Any) -> None:
    kind = message_type("woosh_msgs/StepControl")
    message.stepControl = [
        kind(executeMode=s["mode"], data=s["value"], speed=s["speed"], angle=s["angle"])
        for s in values["steps"]
    ]
    message.useAvoid = values["avoid"] == 0


def _read_steps(message: Any) -> Values:
    names = {"mode": "executeMode", "value": "data", "speed": "speed", "angle": "angle"}
    steps = [{key: getattr(step, name) for key, name in names.items()} for step in message.stepControl]
    return {"steps": steps, "avoid": 0 if message.useAvoid else 1}


def _fill_navigation(values: Values, message: Any) -> None:
    if values["action"] != StepControlMode.EXECUTE:
        raise ValueError("a goal of /move_base cannot be paused on ROS 1; cancel it and send it again")
    if "targetPose" not in values and not values["poses"]:
        raise ValueError("moveBase needs targetPose or poses")
    if "targetPose" not in values:
        message.target_pose = message.poses[-1]


def _fill_lift(values: Values, message: Any) -> None:
    mode = values["executeMode"]
    message.execmode = _TEST_ROS if mode == _TEST_API else mode


def _read_lift(message: Any) -> Values:
    return {"executeMode": _TEST_API if message.execmode == _TEST_ROS else message.execmode}


_TWIST = {"linear": "linear.x", "linearY": "linear.y", "angular": "angular.z"}
_TASK = {
    "taskId": "task_id", "type": "task_type", "direction": "direction", "taskTypeNo": "task_type_no",
    "markNo": "mark_no",
}  # fmt: skip
_NAVIGATION = {
    "id": "id", "mode": "navigation_mode", "waitTime": "waiting_timeout", "maxSpeed": "max_speed",
    "permittedPassage": "permitted_passage", "capacity": "capacity",
}  # fmt: skip
_MODE, _HEIGHT = {"action": "mode"}, {"height": "height", "action": "mode"}

COMMANDS = (
    *(Pair(f"/{name}_cmd_vel", ROBOT + "Twist", _TWIST) for name in ("smooth", "base", "key")),
    Pair("/exec_task", ROBOT + "ExecTask", _TASK, _read_task, _fill_task),
    Pair("/exec_task", ROBOT + "ActionOrder", {"order": "task_exect"}, fill=_check_order),
    Pair(
        "/move_base/make_plan", ROBOT + "PlanNavPath", {"tolerance": "tolerance"},
        poses={"start": "start", "end": "goal"},
    ),
    Pair("/initialpose", ROBOT + "SetRobotPose", {}, lambda m: {"pose": in_map(m)}, _fill_initial_pose),
    Pair("/woosh_init", ROBOT + "InitRobot", read=lambda m: {"isRecord": True}),
    Pair("/voice_synthesis", ROBOT + "Speak", {"text": "data"}),
    Pair("/rgbled", ROBOT + "LED", {n: n for n in ("submodule", "urgency", "abnormal", "normal", "color")}),
    Pair("/cmd_vel_control", ACTION + "StepControl", _MODE, _read_steps, _fill_steps),
    Pair(
        "/move_base", ACTION + "MoveBase", {"executionMode": "execution_mode"},
        lambda m: {"action": 1}, _fill_navigation, {"poses": "poses", "targetPose": "target_pose"},
    ),
    Pair("/navigation_mode", ACTION + "NavigationMode", _NAVIGATION),
    Pair("/lift_control", ACTION + "LiftControl", {"executeMode": "executeMode", **_MODE}),
    Pair("/lift_control2", ACTION + "LiftControl2", _HEIGHT),
    Pair("/lift_control3", ACTION + "LiftControl3", {"speed": "speed", **_HEIGHT}, _read_lift, _fill_lift),
)  # fmt: skip
"""Of a type, the first is what a request becomes. The charge control of ROS 1 means something else."""
_BY_TYPE: dict[str, Pair] = {command.type_name: command for command in reversed(COMMANDS)}


def cancel_of(action: str) -> tuple[str, Values]:
    """The request that cancels what an action does; of one that the Robot API lacks, an empty CallAction."""
    kinds = (_MEMBERS.get(command.type_name, "") for command in COMMANDS if command.row == action)
    return CALL, {member: {"action": int(StepControlMode.CANCEL)} for member in kinds if member}
