"""What a robot tells by its Robot API, as values: m, rad, s and kg; poses in the map. Pure.

Each value is made from a body that `wire.load` has checked. A pose or polygon with numbers that no map has
(NaN, infinity, kilometres) is None or left out: such a place cannot be shown or driven to.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rosproto.text import printable
from woosh_pure.enums import RobotMode, RobotState, TaskState, TaskType, WorkMode
from woosh_pure.faults import FaultLevel, decode_status_code
from woosh_pure.geometry import MAX_COORDINATE_METRES, Pose2D, normalize_angle
from woosh_pure.maps.marks import UserMark

Body = Mapping[str, Any]
Point = tuple[float, float]

KINDS_OF_MARKS = {
    "bases": "plain",
    "racks": "shelf",
    "parkspots": "parking",
    "chargers": "charger",
    "palletPlatforms": "pallet_platform",
    "liftTrolleys": "trolley",
    "tractorTrailers": "trailer",
    "rollerStations": "roller_station",
    "armWorktops": "arm_bench",
}
"""Kind of a mark, by the list that it is in."""
KINDS_OF_ZONES = {
    "bidirectionWays": "two_way",
    "singleWays": "single",
    "oneWays": "one_way",
    "crossings": "crossing",
    "narrowPassages": "narrow_passage",
    "locateFields": "localisation",
    "rampFields": "ramp",
    "odomFields": "odometry_only",
    "autodoorFields": "automatic_door",
    "speedLimitFields": "speed_limit",
    "fireFields": "fire",
    "warnFields": "warning",
    "guideFields": "guide",
}
"""Kind of a zone, by the list that it is in."""
_ZONE_MODES = {1: "avoid", 2: "wait", 3: "wait_then_plan", 4: "wait_then_fail"}
_ZONE_MODES |= {10: "narrow_passage", 11: "magnetic_strip", 12: "qr_code"}
_OUTLINES = ("original", "expanded", "spare", "docking")
_EMERGENCY_STOP, _LOCALISED, _OCCUPIED, _OBSTRUCTED, _TASKABLE = 1024, 1, 8, 8, 1


@dataclass(frozen=True, slots=True)
class RobotMark:
    """A mark of the robot's own map.

    Attributes:
        name: Its unique name, which tasks use.
        number: Its unique number.
        kind: One of `KINDS_OF_MARKS`.
        pose: Where a drive to it ends (our reading: the place itself where the robot docks, else the docking
            point); None if it is not known.
        dock: Where the robot stops first.
        note: The robot's description of it.
        map: The map of the scene that it is on.
    """

    name: str
    number: int
    kind: str
    pose: Pose2D | None
    dock: Pose2D | None
    note: str
    map: str

    def as_user_mark(self) -> UserMark:
        """The mark as the user's list has them; a goal for it is a task of the chassis."""
        return UserMark(self.name, self.pose, self.note, self.kind == "charger", source="robot")


@dataclass(frozen=True, slots=True)
class Scene:
    """A scene: one or more maps (floors).

    Attributes:
        name: Its name.
        maps: Names of its maps.
        current_map: The map that the robot uses; "" if it uses another scene.
        version: Counts uploads of that map; 0 if it is not in use.
        localised: After `switch_map`: whether the robot knows where it is on it; None if it does not say.
    """

    name: str
    maps: tuple[str, ...] = ()
    current_map: str = ""
    version: int = 0
    localised: bool | None = None


@dataclass(frozen=True, slots=True)
class Zone:
    """An area of a map with rules for driving.

    Attributes:
        kind: One of `KINDS_OF_ZONES`.
        number: Its number.
        polygon: Its corners, m.
        max_speed: m/s; None without a limit of its own.
        mode: What the robot does about obstacles in it; "" if the zone does not say.
        map: The map of the scene that it is on.
    """

    kind: str
    number: int
    polygon: tuple[Point, ...]
    max_speed: float | None
    mode: str
    map: str


@dataclass(frozen=True, slots=True)
class TaskRecord:
    """A task of the robot's history.

    Attributes:
        time: Of its last change, seconds since 1970 by the robot's clock.
    """

    task_id: int
    type: TaskType
    state: TaskState
    destination: str
    message: str
    time: float


@dataclass(frozen=True, slots=True)
class RobotEvent:
    """A status code that the robot has kept.

    Attributes:
        code: As on /status_code.
        text: The robot's words, in its language; ours if it has none.
        level: As the robot says.
        time: Seconds since 1970 by the robot's clock.
        task_id: The task that was running; 0 without one.
    """

    code: int
    text: str
    level: FaultLevel
    time: float
    task_id: int


@dataclass(frozen=True, slots=True)
class DeviceFacts:
    """The robot's state in brief; None where it does not say.

    Attributes:
        emergency_stop: Whether the emergency stop is pressed.
        localised: Whether it knows where it is.
        occupied: Whether somebody has reserved it (SetOccupancy).
        taskable: Whether it would take a task.
        obstructed: Whether an obstacle is in its way.
    """

    robot_state: RobotState
    robot_mode: RobotMode
    work_mode: WorkMode
    emergency_stop: bool | None
    localised: bool | None
    occupied: bool | None
    taskable: bool | None
    obstructed: bool | None


@dataclass(frozen=True, slots=True)
class Statistics:
    """What the robot did in some days.

    Attributes:
        metres: Distance driven.
        seconds_on: Time for which it was switched on.
        completed, failed, cancelled: Tasks by their end.
        faults: Faults and warnings.
    """

    metres: float
    seconds_on: float
    completed: int
    failed: int
    cancelled: int
    faults: int


@dataclass(frozen=True, slots=True)
class RobotIdentity:
    """Which robot it is; m (the interface gives no unit: ours by the size of the numbers)."""

    name: str
    model: str
    serial_number: int
    length: float
    width: float
    height: float
    system: str
    software: str


@dataclass(frozen=True, slots=True)
class Outline:
    """The robot's outline in base_link.

    Attributes:
        points: Corners, m.
        kind: Which of its outlines is in use: original, expanded (loaded), spare or docking.
    """

    points: tuple[Point, ...]
    kind: str


# -- from bodies ---------------------------------------------------------------------------------------------


def marks_of(scene: Body) -> list[RobotMark]:
    """The marks of all maps of a SceneDataEasy."""
    found = []
    for each in scene["maps"]:
        for key, kind in KINDS_OF_MARKS.items():
            found += [_mark(mark, kind, each["name"]) for mark in each.get("storages", {}).get(key, ())]
    return [mark for mark in found if mark.name]


def _mark(body: Body, kind: str, map_name: str) -> RobotMark:
    identity, places = body.get("identity", {}), body.get("pose", {})
    dock, real = _pose(places.get("dock")), _pose(places.get("real"))
    ends = (dock, real) if kind == "plain" else (real, dock)
    pose = next((pose for pose in ends if pose is not None), None)
    name, note = identity.get("no", ""), printable(identity.get("desc", ""))
    return RobotMark(name, identity.get("id", 0), kind, pose, dock, note, map_name)


def _pose(body: Body | None) -> Pose2D | None:
    if body is None or not _sensible((body["x"], body["y"])) or not math.isfinite(body["theta"]):
        return None
    return Pose2D(body["x"], body["y"], normalize_angle(body["theta"]))


def _sensible(numbers: Iterable[float]) -> bool:
    return all(abs(number) <= MAX_COORDINATE_METRES for number in numbers)  # false for NaN


def _points(bodies: Sequence[Body]) -> tuple[Point, ...]:
    """The corners of an area; () if they are none."""
    points = tuple((body["x"], body["y"]) for body in bodies)
    return points if len(points) > 2 and all(map(_sensible, points)) else ()


def zones_of(scene: Body) -> list[Zone]:
    """The zones of all maps of a SceneData."""
    return [
        zone
        for each in scene["maps"]
        for key, kind in KINDS_OF_ZONES.items()
        for body in each.get("fieldInfo", {}).get(key, ())
        if (zone := _zone(body.get("navFiled", {}), kind, each["name"])).polygon
    ]


def _zone(body: Body, kind: str, map_name: str) -> Zone:
    speed = body.get("maxSpeed", 0.0)
    return Zone(
        kind,
        body.get("id", 0),
        _points(body.get("vertexs", ())),
        speed if 0.0 < speed < math.inf else None,
        _ZONE_MODES.get(body.get("navMode", 0), ""),
        map_name,
    )


def scenes_of(listed: Body, current: Scene) -> list[Scene]:
    """The scenes of a SceneList."""
    return [
        Scene(each["name"], tuple(each["maps"]), current.current_map, current.version)
        if each["name"] == current.name
        else Scene(each["name"], tuple(each["maps"]))
        for each in listed["scenes"]
    ]


def task_of(body: Body) -> TaskRecord:
    """A task of a TaskHistory."""
    kind, state = TaskType(body["type"]), TaskState(body["state"])
    destination, message = printable(body["dest"]), printable(body["msg"])
    return TaskRecord(body["robotTaskId"], kind, state, destination, message, float(body["time"]))


def event_of(body: Body) -> RobotEvent:
    """A StatusCode; its time is in milliseconds there."""
    text = printable(body["msg"]) or str(decode_status_code(body["code"]))
    level = FaultLevel(body["level"]) if 0 <= body["level"] <= 3 else FaultLevel.WARNING
    return RobotEvent(body["code"], text, level, body["time"] / 1000.0, body["robotTaskId"])


def facts_of(state: Body, mode: Body, device: Body | None, operation: Body) -> DeviceFacts:
    """The facts of four answers; `device` is None where the robot's DeviceState is of an older form."""
    hardware = None if device is None else device["hardware"]
    software = None if device is None else device["software"]
    return DeviceFacts(
        RobotState(state["state"]),
        RobotMode(mode["ctrl"]),
        WorkMode(mode["work"]),
        None if hardware is None else bool(hardware & _EMERGENCY_STOP),
        None if software is None else bool(software & _LOCALISED),
        None if software is None else bool(software & _OCCUPIED),
        bool(operation["robot"] & _TASKABLE),
        bool(operation["nav"] & _OBSTRUCTED),
    )


def statistics_of(answers: Sequence[Body]) -> Statistics:
    """The sums of the pages of one CountData; the first one has the days."""
    days = answers[0].get("operations", {}).get("ops", ())
    ends = [task["state"] for page in answers for task in page.get("tasks", {}).get("ts", ())]
    completed, failed, cancelled = (ends.count(state) for state in (1, 2, 3))
    driven = (day.get("mileage", {"start": 0, "end": 0}) for day in days)
    return Statistics(
        float(sum(max(0, each["end"] - each["start"]) for each in driven)),
        float(sum(max(0, time["end"] - time["start"]) for day in days for time in day["buckets"])),
        completed,
        failed,
        cancelled,
        answers[0]["abnormalQty"],
    )


def identity_of(general: Body, name: str) -> RobotIdentity:
    """The identity of a General and the name in a Setting."""
    size, version = general.get("modelData", {}), general.get("version", {})
    return RobotIdentity(
        printable(name),
        printable(general["displayModel"]),
        general["serialNumber"],
        *(size.get(key, 0) / 1000.0 for key in ("length", "width", "height")),
        *(printable(version.get(key, "")) for key in ("system", "rc")),
    )


def outline_of(model: Body) -> Outline:
    """The outline of a Model; without points if the robot does not say."""
    kind = _OUTLINES[model["type"]] if 0 <= model["type"] < len(_OUTLINES) else ""
    return Outline(_points(model["model"]), kind)
