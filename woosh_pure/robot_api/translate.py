"""What ROS 1 and the Robot API say alike, as one table of pairs: a row of ROS 1 and a type of the API. Pure.

Here is what a robot tells; `commands.py` has what it is told. Most fields only have other names. What ROS 1
does not tell is left out, which is the default of the API; a number that the API does not tell is NaN in
ROS 1, which is not known, where the message has such numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import reduce
from operator import attrgetter
from typing import Any, NamedTuple

from rosproto.codec import DynamicMessage
from woosh_pure.enums import RobotMode, RobotState, TaskState, WorkMode
from woosh_pure.faults import FaultLevel, decode_status_code
from woosh_pure.geometry import Pose2D
from woosh_pure.interface.table import row as interface_row
from woosh_pure.robot_api.wire import Values, enum, fields, messages
from woosh_pure.values.messages import message_type, pose_of, stamped_pose

ROBOT = "woosh.robot."
COUNT = "woosh.robot.count."
SECTIONS = {one.key: one.type for one in fields(ROBOT + "RobotInfo") if one.type in messages()}
"""Of RobotInfo; its `state` is a number."""
_NOT_CHARGING, _BY_CABLE, _AT_STATION = 1, 2, 3  # Battery.ChargeState
_NOT_TOLD = (
    "batteryVoltage", "batteryCurrent", "timeRemain", "capacityRemain", "capacityFull", "capacityDesign",
    "cellVoltageMax", "cellVoltageMin",
)  # fmt: skip
_DRIVES = {"differential": 0, "omnidirectional": 2}
"""`driverMethod` by `movebaseType`; other words are not known, and 0 is its default (assumed)."""


class Pair(NamedTuple):
    """A row and a type that say the same.

    Attributes:
        row: The topic, service or action of ROS 1.
        type_name: The type of the Robot API; a row may fill several, and a type come of several.
        names: Fields that are equal: path in the type, path in the message.
        read: The other values of a type, of a message.
        fill: Sets the other fields of a message, of the values of a type.
        poses: Poses in the map, or lists of them, as `names`.
    """

    row: str
    type_name: str
    names: Mapping[str, str] = {}
    read: Callable[[Any], Values] = lambda message: {}
    fill: Callable[[Values, Any], object] = lambda values, message: None
    poses: Mapping[str, str] = {}

    def values(self, message: Any) -> Values:
        """The values that a message gives."""
        found = self.read(message)
        for path, there in self.names.items():
            *outer, name = path.split(".")
            inner = found
            for part in outer:
                inner = inner.setdefault(part, {})
            inner[name] = attrgetter(there)(message)
        for name, there in self.poses.items():
            given = getattr(message, there)
            found[name] = [*map(in_map, given)] if isinstance(given, list) else in_map(given)
        return found

    def fill_in(self, message: Any, values: Values) -> None:
        """Set the fields of a message."""
        for path, there in self.names.items():
            *outer, name = path.split(".")
            inner = reduce(lambda part, key: part.get(key, {}), outer, values)
            if name in inner:  # else the sub-message is absent: all its fields have their defaults
                *parts, field = there.split(".")
                setattr(reduce(getattr, parts, message), field, inner[name])
        for name, there in self.poses.items():
            given = values.get(name, ORIGIN)
            setattr(message, there, [*map(stamped, given)] if isinstance(given, list) else stamped(given))
        self.fill(values, message)


def to_api(row: str, message: Any) -> dict[str, Values]:
    """The values that a message of a row gives, by type: parts of them where a type has several rows."""
    return {pair.type_name: pair.values(message) for pair in PAIRS if pair.row == row}


def to_ros(row: str, values: Mapping[str, Values]) -> Any:
    """The message of a row, of values by type; None while a type that it comes of is not known."""
    pairs = [pair for pair in PAIRS if pair.row == row]
    if any(pair.type_name not in values for pair in pairs):
        return None
    message = message_type(interface_row(row).type)()
    for pair in pairs:
        pair.fill_in(message, values[pair.type_name])
    return message


# -- poses ---------------------------------------------------------------------------------------------------

ORIGIN = {"x": 0.0, "y": 0.0, "theta": 0.0}


def pose_2d(values: Values) -> Pose2D:
    """The pose of a woosh.common.Pose2D."""
    return Pose2D(values["x"], values["y"], values["theta"])


def pose_values(pose: Pose2D) -> Values:
    """The values of a woosh.common.Pose2D."""
    return {"x": pose.x, "y": pose.y, "theta": pose.yaw}


def stamped(values: Values) -> DynamicMessage:
    """geometry_msgs/PoseStamped of a woosh.common.Pose2D.

    Raises:
        ValueError: No map has such a place.
    """
    return stamped_pose(pose_2d(values))


def in_map(message: Any) -> Values:
    """The values of a geometry_msgs/PoseStamped, or of one with covariance.

    Raises:
        ValueError: It is in another frame than the map.
    """
    pose, frame = message.pose, message.header.frame_id
    if frame.lstrip("/") not in ("map", ""):
        raise ValueError(f"the pose is in {frame!r}; the Robot API needs a pose in the map")
    return pose_values(pose_of(getattr(pose, "pose", pose), "map"))  # with covariance it is one deeper


# -- fields that differ --------------------------------------------------------------------------------------


def _task(m: Any) -> Values:
    # The robot's own tasks may have negative numbers.
    return {"robotTaskId": m.task_id - 2**64 if m.task_id >= 2**63 else m.task_id}


def _task_back(values: Values, m: Any) -> None:
    m.task_id = values["robotTaskId"] % 2**64


def _count(limit: int, value: float) -> int:
    return min(max(0, int(value)), limit) if math.isfinite(value) else 0


def _battery(m: Any) -> Values:
    charging = _AT_STATION if m.chargeMode else _BY_CABLE
    known = m.capacityDesign > 0.0 and m.capacityFull >= 0.0
    return {
        "chargeState": charging if m.chargeStatus else _NOT_CHARGING,
        "health": _count(100, 100.0 * m.capacityFull / m.capacityDesign + 0.5) if known else 0,
        "tempMax": max(0, m.tempMax),  # its type has no frost
    }


def _battery_back(values: Values, m: Any) -> None:
    m.chargeStatus = int(values["chargeState"] >= _BY_CABLE)
    m.chargeMode = int(values["chargeState"] == _AT_STATION)
    m.tempMax = m.tempMin = min(values["tempMax"], 127)
    for name in _NOT_TOLD:
        setattr(m, name, math.nan)


def _information_back(values: Values, m: Any) -> None:
    m.movebaseType = {number: word for word, number in _DRIVES.items()}.get(values["driverMethod"], "")


def _status_code(m: Any) -> Values:
    code = decode_status_code(m.data)
    return {"msg": code.english, "level": int(code.level)}


def _path(m: Any) -> Values:
    return {"path": {"poses": [pose_values(pose_of(one.pose, "map")) for one in m.poses]}}


def _path_back(values: Values, m: Any) -> None:
    m.header.frame_id = "map"
    m.poses = [*map(stamped, values.get("path", {}).get("poses", ()))]


def _scan_back(values: Values, m: Any) -> None:
    m.header.frame_id = "laser"


PAIRS = (
    Pair(
        "/robot_status", ROBOT + "TaskProc",
        {
            "type": "task_type", "state": "task_state", "dest": "dest", "msg": "msg", "time": "time",
            "action.type": "action_type", "action.state": "action_state", "action.waitId": "wait_id",
        },
        _task,
        _task_back,
    ),
    Pair("/robot_status", ROBOT + "RobotState", {"state": "robot_state"}),
    Pair("/robot_status", ROBOT + "Mode", {"ctrl": "robot_mode", "work": "work_mode"}),
    Pair("/movebase_pose2d", ROBOT + "PoseSpeed", {f"pose.{name}": name for name in ("x", "y", "theta")}),
    Pair("/odom_twist", ROBOT + "PoseSpeed", {"twist.linear": "linear.x", "twist.angular": "angular.z"}),
    Pair(
        "/odometer", ROBOT + "PoseSpeed", {}, lambda m: {"mileage": _count(2**32 - 1, m.data)},
        lambda values, m: setattr(m, "data", float(values["mileage"])),
    ),
    Pair(
        "/battery", ROBOT + "Battery",
        {"power": "batteryPercentage", "chargeCycle": "chargeCycle", "batteryCycle": "batteryCycle"},
        _battery,
        _battery_back,
    ),
    Pair(
        "/information", ROBOT + "General",
        {"version.system": "hardwareVersion", "version.rc": "softwareVersion"},
        lambda m: {"driverMethod": _DRIVES.get(m.movebaseType, 0)},
        _information_back,
    ),
    Pair("/status_code", COUNT + "StatusCode", {"code": "data"}, _status_code),
    Pair(
        "/scan", ROBOT + "ScannerData",
        {
            "angleMin": "angle_min", "angleMax": "angle_max", "angleIncrement": "angle_increment",
            "timeIncrement": "time_increment", "scanTime": "scan_time", "rangeMin": "range_min",
            "rangeMax": "range_max", "ranges": "ranges",
        },
        fill=_scan_back,
    ),
    Pair("/move_base/global_plan", ROBOT + "NavPath", {}, _path, _path_back),
)  # fmt: skip
"""/robot_status is three types of the API, and PoseSpeed three rows of ROS 1."""


# -- what follows from several rows --------------------------------------------------------------------------


def operation_state(values: Mapping[str, Values], worst: FaultLevel) -> Values | None:
    """OperationState of TaskProc, RobotState and Mode, by type; None while one is not known.

    Only taskable is told, and not while a severe fault lasts: no topic tells the bits of the navigation.
    """
    task, state, mode = (values.get(ROBOT + name) for name in ("TaskProc", "RobotState", "Mode"))
    if task is None or state is None or mode is None:
        return None
    taskable = (
        state["state"] in (RobotState.IDLE, RobotState.CHARGING)
        and (mode["ctrl"], mode["work"]) == (RobotMode.AUTOMATIC, WorkMode.TASK)
        and not TaskState(task["state"]).is_under_way
        and worst < FaultLevel.SEVERE
    )
    return {"robot": enum(ROBOT + "OperationState.RobotBit")["kTaskable"] * taskable}


def path_driven(values: Mapping[str, Values]) -> Values | None:
    """NavPath: the last plan while a task is under way or the robot moves, else an empty path.

    The topic keeps the plan of the goal before; None while nothing tells whether that is over.
    """
    task, speed = values.get(ROBOT + "TaskProc"), values.get(ROBOT + "PoseSpeed")
    if task is None or speed is None:
        return None
    driven = TaskState(task["state"]).is_under_way or any(speed["twist"].values())
    return values.get(ROBOT + "NavPath", {}) if driven else {}
