"""What a robot tells by its Robot API, as values: m, rad, s and kg; poses in the map. Pure.

Each value is made from a body that `wire.load` has checked. A pose or polygon with numbers that no map has
(NaN, infinity, kilometres) is None or left out: such a place cannot be shown or driven to.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from rosproto.text import printable
from woosh_pure.enums import RobotMode, RobotState, TaskState, TaskType, WorkMode
from woosh_pure.faults import FaultLevel, decode_status_code
from woosh_pure.geometry import MAX_COORDINATE_METRES, Pose2D, normalize_angle
from woosh_pure.maps.marks import UserMark

Body = Mapping[str, Any]
Point = tuple[float, float]

KINDS_OF_MARKS = {
    "bases": "plain", "racks": "shelf", "parkspots": "parking", "chargers": "charger",
    "palletPlatforms": "pallet_platform", "liftTrolleys": "trolley", "tractorTrailers": "trailer",
    "rollerStations": "roller_station", "armWorktops": "arm_bench",
}  # fmt: skip
"""Kind of a mark, by the list that it is in."""
KINDS_OF_ZONES = {
    "bidirectionWays": "two_way", "singleWays": "single", "oneWays": "one_way", "crossings": "crossing",
    "narrowPassages": "narrow_passage", "locateFields": "localisation", "rampFields": "ramp",
    "odomFields": "odometry_only", "autodoorFields": "automatic_door", "speedLimitFields": "speed_limit",
    "fireFields": "fire", "warnFields": "warning", "guideFields": "guide",
}  # fmt: skip
"""Kind of a zone, by the list that it is in."""
_ZONE_MODES = {
    1: "avoid", 2: "wait", 3: "wait_then_plan", 4: "wait_then_fail", 10: "narrow_passage",
    11: "magnetic_strip", 12: "qr_code",
}  # fmt: skip
_OUTLINES = ("original", "expanded", "spare", "docking")
_BITS = {
    "emergency_stop": ("hardware", 1024), "localised": ("software", 1), "occupied": ("software", 8),
    "taskable": ("robot", 1), "obstructed": ("nav", 8),
}  # fmt: skip
"""The mask and bit of each fact; the first two masks are of DeviceState."""


@dataclass(frozen=True, slots=True)
class RobotMark:
    """A mark of the robot's own map.

    Attributes:
        name, number: Its unique name, which tasks use, and its unique number.
        kind: One of `KINDS_OF_MARKS`.
        pose: Where a drive to it ends (our reading: the place itself where the robot docks, else the docking
            point); None if it is not known.
        dock: Where the robot stops first.
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
        max_speed: m/s; None without a limit of its own.
        mode: What the robot does about obstacles in it; "" if the zone does not say.
    """

    kind: str
    number: int
    polygon: tuple[Point, ...]
    max_speed: float | None
    mode: str
    map: str


@dataclass(frozen=True, slots=True)
class TaskRecord:
    """A task of the robot's history; `time` is that of its last change, seconds since 1970 by its clock."""

    task_id: int
    type: TaskType
    state: TaskState
    destination: str
    message: str
    time: float


@dataclass(frozen=True, slots=True)
class TaskList:
    """A task list that is stored in the robot.

    Attributes:
        tasks: The ids that its tasks have in /robot_status, in their order.
        stoppable: Whether a cancel ends it; else the robot keeps or skips a cancelled task, and goes on.
    """

    id: int
    name: str
    tasks: tuple[int, ...]
    stoppable: bool


@dataclass(frozen=True, slots=True)
class RobotEvent:
    """A status code that the robot has kept.

    Attributes:
        text: The robot's words, in its language; ours if it has none.
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
    """The robot's state in brief; None where it does not say. Occupied: somebody has reserved it."""

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
    """What the robot did in some days. Faults are also warnings; the tasks are counted by their end."""

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
    return [mark for each in _listed(scene, "storages", KINDS_OF_MARKS) if (mark := _mark(*each)).name]


def zones_of(scene: Body) -> list[Zone]:
    """The zones of all maps of a SceneData."""
    return [zone for each in _listed(scene, "fieldInfo", KINDS_OF_ZONES) if (zone := _zone(*each)).polygon]


def _listed(scene: Body, part: str, kinds: Mapping[str, str]) -> Iterator[tuple[Body, str, str]]:
    """Each item of the lists in a part of all maps, with its kind and the name of its map."""
    for each in scene["maps"]:
        for key, kind in kinds.items():
            for item in each.get(part, {}).get(key, ()):
                yield item, kind, each["name"]


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


def _zone(item: Body, kind: str, map_name: str) -> Zone:
    body = item.get("navFiled", {})
    speed, mode = body.get("maxSpeed", 0.0), _ZONE_MODES.get(body.get("navMode", 0), "")
    limit, polygon = speed if 0.0 < speed < math.inf else None, _points(body.get("vertexs", ()))
    return Zone(kind, body.get("id", 0), polygon, limit, mode, map_name)


def scenes_of(listed: Body, current: Scene) -> list[Scene]:
    """The scenes of a SceneList."""
    found = [Scene(each["name"], tuple(each["maps"])) for each in listed["scenes"]]
    return [replace(current, maps=one.maps) if one.name == current.name else one for one in found]


def task_of(body: Body) -> TaskRecord:
    """A task of a TaskHistory."""
    kind, state = TaskType(body["type"]), TaskState(body["state"])
    destination, message = printable(body["dest"]), printable(body["msg"])
    return TaskRecord(body["robotTaskId"], kind, state, destination, message, float(body["time"]))


def task_lists_of(body: Body) -> list[TaskList]:
    """The task lists of a TaskInfo. A task's id is its list's and two digits, with the sign of the list."""
    found = {}
    for each in (*body["repeatTasks"], *body["callTasks"]):
        if "base" in (given := each.get("taskSet", {})):
            list_id, tasks = given["base"]["id"], [task for task in given["tasks"] if "base" in task]
            first, sign = list_id * 100, -1 if list_id < 0 else 1
            ids = tuple((first + sign * task["base"]["id"]) % 2**64 for task in tasks)
            goes_on = any(
                task["base"]["cannotCancel"]
                or any(task.get("consta", {}).get(key) for key in ("cancelNext", "cancelSkip"))
                for task in tasks
            )
            found[list_id] = TaskList(list_id, printable(given["base"]["name"]), ids, not goes_on)
    return [*found.values()]


def event_of(body: Body) -> RobotEvent:
    """A StatusCode; its time is in milliseconds there."""
    text = printable(body["msg"]) or str(decode_status_code(body["code"]))
    level = FaultLevel(body["level"]) if 0 <= body["level"] <= 3 else FaultLevel.WARNING
    return RobotEvent(body["code"], text, level, body["time"] / 1000.0, body["robotTaskId"])


def facts_of(state: Body, mode: Body, device: Body | None, operation: Body) -> DeviceFacts:
    """The facts of four answers; `device` is None where the robot's DeviceState is of an older form."""
    told = {**operation, **(device or {})}
    bits = {name: bool(told[mask] & bit) if mask in told else None for name, (mask, bit) in _BITS.items()}
    return DeviceFacts(RobotState(state["state"]), RobotMode(mode["ctrl"]), WorkMode(mode["work"]), **bits)


def statistics_of(answers: Sequence[Body]) -> Statistics:
    """The sums of the pages of one CountData; the first one has the days."""
    days = answers[0].get("operations", {}).get("ops", ())
    driven = [day["mileage"] for day in days if "mileage" in day]
    switched_on = [time for day in days for time in day["buckets"]]
    metres, seconds = (
        float(sum(max(0, one["end"] - one["start"]) for one in spans)) for spans in (driven, switched_on)
    )
    ends = [task["state"] for page in answers for task in page.get("tasks", {}).get("ts", ())]
    completed, failed, cancelled = (ends.count(state) for state in (1, 2, 3))
    return Statistics(metres, seconds, completed, failed, cancelled, answers[0]["abnormalQty"])


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
