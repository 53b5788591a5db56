"""The site of a simulated chassis, whose world tells what ROS 1 does not."""

from __future__ import annotations

from collections.abc import Mapping
from urllib.parse import urlsplit

from woosh_pure.api_server.site import RobotSite
from woosh_pure.enums import TaskCommand, TaskType
from woosh_pure.geometry import Footprint
from woosh_pure.robot_api.wire import Values, enum
from woosh_pure.sim import SimulatedChassis
from woosh_pure.sim.tasks import TaskRequest

LISTS = {1: ("Round", "A1", "B1"), 2: ("Home", "A1", "P1")}
"""The task lists: id -> name and marks."""
_PRESSED = enum("woosh.robot.DeviceState.HardwareBit")["kEmgBtn"]
_LOCATED = enum("woosh.robot.DeviceState.SoftwareBit")["kLocation"]
_FAULT = enum("woosh.robot.HardwareState.State")["kFatal"]
_PARTS = {"motor": [0, 0], "lidar": [0], "camera": [0]}


def simulated_site(sim: SimulatedChassis, robot_id: int = 1) -> RobotSite:
    """The map of a simulated chassis with its marks, the state of its parts, and its task lists."""
    site = sim.world.site
    host = urlsplit(sim.master_uri).hostname or ""

    def facts() -> Mapping[str, Values]:
        with sim.lock:
            world = sim.world
            pressed, located, bumped = world.emergency_stop, world.located, world.bumper
            radius = world.settings.radius
        size = round(2000 * radius)
        outline = [{"x": x, "y": y} for x, y in Footprint.circle(radius, corners=12).points]
        return {
            "woosh.robot.General": {
                "modelData": {"length": size, "width": size},
                "displayModel": "simulated chassis",
                "serialNumber": robot_id,
            },
            "woosh.robot.DeviceState": {"hardware": _PRESSED * pressed, "software": _LOCATED * located},
            "woosh.robot.HardwareState": {**_PARTS, "crash": _FAULT * bumped},
            "woosh.robot.Model": {"model": outline},
            "woosh.task.TaskInfo": stored,
            "woosh.task.RepeatTasks": stored,
            "woosh.task.CallTasks": {},
            "woosh.robot.Network": {"robotIp": host},
            "woosh.robot.Setting": {"identity": {"name": "simulated chassis"}, "allow": {}},
        }

    def start_list(number: int) -> str:
        if number not in LISTS:
            return f"there is no task list {number}"
        tasks = enumerate(LISTS[number][1:], number * 100 + 1)
        with sim.lock:
            return sim.world.tasks.start_list(
                [TaskRequest(TaskCommand.EXECUTE, each, TaskType.PICK, mark) for each, mark in tasks]
            )

    stored = {
        "repeatTasks": [
            {"taskSet": _stored(number)} for number in LISTS if {*LISTS[number][1:]} <= {*site.marks}
        ]
    }
    marks = tuple(site.user_marks().values())
    return RobotSite("simulation", "map", lambda: site.grid, lambda: marks, facts, start_list)


def _stored(number: int) -> Values:
    name, *marks = LISTS[number]
    base = {"type": int(TaskType.PICK)}
    tasks = [{"base": {**base, "id": each, "markNo": mark}} for each, mark in enumerate(marks, 1)]
    return {"base": {"id": number, "name": name}, "tasks": tasks}
